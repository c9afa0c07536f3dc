//! `pneutherm man`: the manual pages, from the same definitions as the help.

use crate::output;
use anyhow::Context;
use clap::CommandFactory;

/// Print the manual page of the program or of one command
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm man simulate | man -l -
  pneutherm man > ~/.local/share/man/man1/pneutherm.1")]
pub struct Args {
    /// The command; without it, the page of the program
    command: Option<String>,
}

/// Prints the page as roff.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut program = crate::Cli::command();
    // Sets each command's full name, `pneutherm simulate`.
    program.build();
    let command = match &args.command {
        None => program,
        Some(name) => find(&program, name)?,
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).source(concat!("pneutherm ", env!("CARGO_PKG_VERSION"))).render(&mut page)?;
    output::print(&page)
}

fn find(program: &clap::Command, name: &str) -> anyhow::Result<clap::Command> {
    let names = || program.get_subcommands().map(clap::Command::get_name);
    let command = program.find_subcommand(name).with_context(|| match records::nearest(name, names()) {
        Some(near) => format!("there is no command `{name}`; did you mean `{near}`?"),
        None => format!("there is no command `{name}`; the commands are {}", names().collect::<Vec<_>>().join(", ")),
    })?;
    Ok(command.clone())
}
