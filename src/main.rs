//! The program `pneutherm`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(pneutherm::run(std::env::args_os()))
}
