//! `pneutherm reproduce`: the paper's results from its own tables, as data, figures and a report.

use crate::{output, reproduce};
use std::path::{Path, PathBuf};

/// Files written by no other program: a folder with one of them contains earlier results, at least in part.
const OWN: [&str; 2] = ["model_one_lambda0.toml", "section31.json"];

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

/// Writes the folder and lists its files.
pub fn run(args: &Args) -> anyhow::Result<()> {
    refuse_files_of_others(&args.output)?;
    let files = reproduce::run(&args.output)?;
    let lines: String = files.iter().map(|file| format!("{}\n", file.display())).collect();
    output::print(lines.as_bytes())
}

/// Refuses a folder in which files of other origin would be replaced.
fn refuse_files_of_others(folder: &Path) -> anyhow::Result<()> {
    if OWN.iter().any(|name| folder.join(name).is_file()) {
        return Ok(());
    }
    match reproduce::files().map(|name| folder.join(name)).find(|path| path.is_file()) {
        Some(path) => anyhow::bail!(
            "{}: not written, because a file that `pneutherm reproduce` did not write is there; choose another folder",
            path.display()
        ),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_others_stay_and_what_reproduce_wrote_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| std::fs::write(folder.path().join(name), "").unwrap();
        assert!(refuse_files_of_others(folder.path()).is_ok());
        write("model.toml");
        let refused = refuse_files_of_others(folder.path()).unwrap_err().to_string();
        assert!(refused.contains("model.toml: not written") && refused.contains("choose another folder"), "{refused}");
        write(OWN[0]);
        assert!(refuse_files_of_others(folder.path()).is_ok());
        assert!(OWN.iter().all(|own| reproduce::files().any(|name| name == *own)));
    }
}
