//! `pneutherm`: heat transfer in pneumatic cylinder chambers, from the command line.
//!
//! A library, so that Python, tests and the guide's reference pages can use the program's parts.
//! One file per command in `commands/`; `output` writes results, `failure` reports errors, `pages` makes the reports.

#[cfg(feature = "object-store")]
mod bucket;
mod commands;
pub mod evaluation;
mod failure;
mod fmu_of_model;
pub mod interrupt;
mod measured;
mod other_rig;
pub mod output;
mod pages;
#[cfg(test)]
mod reference;
mod reproduce;
pub mod settings;
pub mod simulation;
pub mod stores;
pub mod study_pictures;

pub use failure::error_message;

use clap::Parser;
use std::ffi::OsString;

/// Heat transfer in pneumatic cylinder chambers: identifies the coefficient from push-and-hold tests, diagnoses missing
/// effects, and exports models, FMUs and parameter studies.
#[derive(Parser)]
#[command(name = "pneutherm", version, arg_required_else_help = true, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
}

const AFTER_HELP: &str = "\
From a record to an FMU:
  pneutherm identify examples/cylinder                  coefficient, dead volume, mass
  pneutherm diagnose examples/cylinder -o model.toml    the missing effect, and the model that includes it
  pneutherm fmu model.toml -o Chamber.fmu               FMI 2.0: Model Exchange and co-simulation

Files: traces are CSV; rigs, models and studies are TOML. For an output file, `-` means standard output.

Exit codes: 0 success; 1 wrong input or failure, with one sentence on standard error; 2 wrong usage.";

/// Runs the program with these arguments, its name first, and returns the exit code: 0, 1 or 2 as in the help.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    match Cli::try_parse_from(arguments) {
        Ok(cli) => match cli.command.run() {
            Ok(()) => 0,
            Err(error) => failure::report(&error),
        },
        Err(usage) => {
            // Help and version also end up here, with exit code 0. A closed output is ignored.
            let _ = usage.print();
            u8::try_from(usage.exit_code()).unwrap_or(2)
        }
    }
}
