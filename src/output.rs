//! Output of results: files written atomically, or standard output for `-`.

use anyhow::{Context, bail};
use chamber::effects::{self, EffectSet};
use records::Rig;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether an output path means standard output.
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Writes `bytes` to the file, atomically, or to standard output for `-`.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    if is_stdout(path) { print(bytes) } else { Ok(records::write_atomically(path, bytes)?) }
}

/// Writes a result for programs as indented JSON.
pub fn write_json(path: &Path, result: &impl serde::Serialize) -> anyhow::Result<()> {
    write(path, (serde_json::to_string_pretty(result)? + "\n").as_bytes())
}

/// Whether standard output is one of the requested outputs.
pub fn is_stdout_taken<const N: usize>(asked: [&Option<PathBuf>; N]) -> bool {
    asked.into_iter().flatten().any(|path| is_stdout(path))
}

/// Refuses, before any work, results that cannot be written: to a protected location, over an input, or two to one file.
pub fn check<'a>(
    results: impl IntoIterator<Item = &'a PathBuf>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> anyhow::Result<()> {
    let inputs: Vec<&Path> = inputs.into_iter().collect();
    if inputs.iter().any(|input| is_stdout(input)) {
        bail!("-: standard input is not read under this name; name a file, or /dev/stdin where the system has it");
    }
    // A device such as /dev/null takes any number of results.
    let is_device = |path: &Path| path.exists() && !path.is_file() && !path.is_dir();
    let results = results.into_iter().filter(|path| !is_device(path));
    let results: Vec<(&Path, PathBuf)> = results.map(|path| (path.as_path(), resolved(path))).collect();
    for (nth, (path, at)) in results.iter().enumerate() {
        if results[..nth].iter().any(|(_, other)| other == at) {
            match is_stdout(path) {
                true => bail!("standard output can take one result only; name a file for the others"),
                false => bail!("{}: two results cannot go to one file", path.display()),
            }
        }
    }
    let inputs: Vec<PathBuf> = inputs.into_iter().map(resolved).collect();
    match results.iter().find(|(_, at)| inputs.contains(at)) {
        Some((path, _)) => {
            bail!("{}: not written, because it is read by this command; name another file", path.display())
        }
        None => results
            .iter()
            .filter(|(path, _)| !is_stdout(path))
            .try_for_each(|(path, _)| Ok(records::check_writable(path)?)),
    }
}

/// The files that a rig consists of.
pub fn files(rig: &Rig) -> impl Iterator<Item = &Path> {
    let traces = rig.experiments.iter().flat_map(|experiment| &experiment.traces);
    std::iter::once(rig.path.as_path()).chain(traces.map(|trace| trace.path.as_path()))
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

/// A unique path for each file, however it is named; also for a new file, if its folder exists.
fn resolved(path: &Path) -> PathBuf {
    let of_folder = || Some(folder(path).canonicalize().ok()?.join(path.file_name()?));
    path.canonicalize().ok().or_else(of_folder).unwrap_or_else(|| path.to_owned())
}

/// Prints a note, which is no error, on standard error.
pub fn note(text: &str) {
    // A closed standard error is ignored.
    let _ = writeln!(io::stderr(), "note: {text}");
}

/// Writes to standard output. Unlike `print!` it does not panic on a closed pipe.
pub fn print(bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes).and_then(|()| out.flush()).context("standard output cannot be written")
}

/// A line about the effects of the model that this use excludes, if any.
pub fn excluded_effects(effects: EffectSet) -> Option<String> {
    let names: Vec<&str> = effects::all().filter(|(index, _)| effects.has(*index)).map(|(_, card)| card.name).collect();
    let reason = "it belongs to a recorded stroke, and here the stroke is exact";
    (!names.is_empty()).then(|| format!("left out of the model: {} ({reason})\n", names.join(", ")))
}
