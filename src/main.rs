//! The program `pneutherm`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pneutherm::interrupt::ends_the_program(None);
    ExitCode::from(pneutherm::run(std::env::args_os()))
}
