//! Errors in files, as sentences: where, what, what to do.

pub mod trace;

use crate::key::KeyProblem;
use std::io;
use std::path::{Path, PathBuf};
use trace::TraceProblem;

/// Why a file was refused or could not be written: its path as given, lines and columns counted from 1.
#[allow(missing_docs)]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    /// A trace was given in place of another file.
    #[error("{}: this looks like a trace; {expected}", path.display())]
    IsTrace {
        path: PathBuf,
        /// What is expected instead, in words.
        expected: &'static str,
    },
    /// A folder given in place of a rig file contains none.
    #[error("{}: this folder has no rig.toml; `pneutherm look TRACE -o rig.toml` writes one", folder.display())]
    NoRig { folder: PathBuf },
    /// The file cannot be written; an existing file is unchanged.
    #[error("{}: cannot be written: {source}", path.display())]
    Write { path: PathBuf, source: io::Error },
    /// The file is not TOML.
    #[error("{}: line {line}, column {column}: not valid TOML: {message}", path.display())]
    Syntax {
        path: PathBuf,
        line: usize,
        /// Counted from 1, in characters.
        column: usize,
        message: String,
    },
    /// Something is wrong with a key of a TOML file.
    #[error("{}: {}{key}: {problem}", path.display(), line_prefix(*line))]
    Key {
        path: PathBuf,
        /// The key's line, or that of the table it is missing from; counted from 1, 0 for content without a file.
        line: usize,
        key: String,
        problem: Box<KeyProblem>,
    },
    /// Something is wrong with a trace.
    #[error("{}: {problem}", path.display())]
    Trace { path: PathBuf, problem: Box<TraceProblem> },
    /// A model cannot be expressed in a model file.
    #[error("the model cannot be written: {0}")]
    Unwritable(String),
}

impl Error {
    /// An error in the trace at `path`.
    pub(crate) fn trace(path: &Path, problem: TraceProblem) -> Self {
        Error::Trace { path: path.to_owned(), problem: Box::new(problem) }
    }
}

fn line_prefix(line: usize) -> String {
    if line == 0 { String::new() } else { format!("line {line}: ") }
}
