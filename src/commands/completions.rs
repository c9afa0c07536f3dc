//! `pneutherm completions`: tab completion for a shell, from the same definitions as the help.

use crate::output;
use clap::CommandFactory;
use clap_complete::Shell;

/// Print the tab completion script for a shell
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm completions bash > ~/.local/share/bash-completion/completions/pneutherm")]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Prints the script.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::Cli::command(), "pneutherm", &mut script);
    output::print(&script)
}
