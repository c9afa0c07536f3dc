//! How results leave the program: files that appear whole, or standard output for `-`.

use chamber::effects::{self, EffectSet};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Whether a path given for output means standard output.
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Writes `bytes` to the file, atomically, or to standard output for `-`.
pub fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    if is_stdout(path) { print(bytes) } else { Ok(records::write_atomically(path, bytes)?) }
}

/// Writes a result for programs: JSON in lines.
pub fn write_json(path: &Path, result: &impl serde::Serialize) -> anyhow::Result<()> {
    write(path, (serde_json::to_string_pretty(result)? + "\n").as_bytes())
}

/// Whether standard output is one of the places for output that were asked for.
pub fn is_stdout_taken<const N: usize>(asked: [&Option<PathBuf>; N]) -> bool {
    asked.into_iter().flatten().any(|path| is_stdout(path))
}

/// Tells something that is no error, on standard error.
pub fn note(text: &str) {
    // When standard error is gone there is nobody to tell.
    let _ = writeln!(io::stderr(), "note: {text}");
}

/// Writes to standard output. Unlike `print!` it does not panic when the reader has gone.
pub fn print(bytes: &[u8]) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// A line on the effects of a model that a use of it leaves out, if there are any.
pub fn left_out(effects: EffectSet) -> Option<String> {
    let names: Vec<&str> = effects::all().filter(|(place, _)| effects.has(*place)).map(|(_, card)| card.name).collect();
    let reason = "it belongs to a recorded stroke, and here the stroke is exact";
    (!names.is_empty()).then(|| format!("left out of the model: {} ({reason})\n", names.join(", ")))
}
