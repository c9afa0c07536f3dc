//! The commands. A new one needs its file here, a `mod` line, a variant of [`Command`] and an arm of [`Command::run`].
//!
//! A command's file contains `Args` (for clap, with an example in `after_help`) and `run(&Args) -> anyhow::Result<()>`.

mod completions;
mod diagnose;
mod estimates;
pub mod fmu;
mod identify;
mod look;
mod man;
mod progress;
mod reproduce;
mod simulate;
mod sweep;
mod validate;

use clap::Subcommand;

/// What the program does, in the order of its help.
#[derive(Subcommand)]
pub enum Command {
    Reproduce(reproduce::Args),
    Look(look::Args),
    Simulate(simulate::Args),
    Identify(identify::Args),
    Diagnose(diagnose::Args),
    Validate(validate::Args),
    Fmu(fmu::Args),
    Sweep(sweep::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Command {
    /// Runs the command and prints its results.
    pub fn run(&self) -> anyhow::Result<()> {
        match self {
            Command::Reproduce(args) => reproduce::run(args),
            Command::Look(args) => look::run(args),
            Command::Simulate(args) => simulate::run(args),
            Command::Identify(args) => identify::run(args),
            Command::Diagnose(args) => diagnose::run(args),
            Command::Validate(args) => validate::run(args),
            Command::Fmu(args) => fmu::run(args),
            Command::Sweep(args) => sweep::run(args),
            Command::Completions(args) => completions::run(args),
            Command::Man(args) => man::run(args),
        }
    }
}
