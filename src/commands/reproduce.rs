//! `pneutherm reproduce`: the paper's results from its own tables, as data, figures and a report.

use crate::{output, reproduce};
use std::path::PathBuf;

/// Reproduce the paper's results from its own tables: data, figures and a report
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm reproduce -o results     # then open results/report.html")]
pub struct Args {
    /// Folder to write to; created if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "results")]
    output: PathBuf,
}

/// Writes the folder and lists what is in it.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let files = reproduce::run(&args.output)?;
    let lines: String = files.iter().map(|file| format!("{}\n", file.display())).collect();
    output::print(lines.as_bytes())
}
