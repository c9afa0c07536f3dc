//! `pneutherm`: heat transfer in pneumatic cylinder chambers, from the command line.
//!
//! One file a command in `commands/`; `output` is how results leave the program, `failure` how errors do.

mod commands;
mod failure;
mod output;
mod reproduce;

use clap::Parser;
use std::process::ExitCode;

/// Heat transfer between the air in a pneumatic cylinder chamber and its wall: identified from a push-and-hold test,
/// delivered as a model, an FMU, a Parquet study and a diagnosis.
#[derive(Parser)]
#[command(name = "pneutherm", version, arg_required_else_help = true, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
}

const AFTER_HELP: &str = "\
Files: traces are CSV, rigs, models and studies are TOML; `-` means standard output where a file is written.
Exit code: 0 done, 1 the input is wrong or the work failed (one sentence on standard error), 2 wrong usage.";

fn main() -> ExitCode {
    match Cli::parse().command.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => failure::report(&error),
    }
}
