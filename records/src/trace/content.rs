//! Where the bytes of a trace come from: its file or, of what can be read only once, as a pipe, a copy.

use super::lines::{self, MAX_BYTES};
use crate::error::Error;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a trace.
#[derive(Debug)]
pub enum Content {
    /// What the path leads to.
    File,
    /// A copy of it.
    Copy(Vec<u8>),
}

impl Content {
    /// What can be read more than once: the file itself or, where the path leads to no file, a copy.
    ///
    /// # Errors
    /// [`Error::Read`].
    pub fn lasting(path: &Path) -> Result<Self, Error> {
        let unreadable = |source| Error::Read { path: path.to_owned(), source };
        let facts = std::fs::metadata(path).map_err(unreadable)?;
        if facts.is_file() || facts.is_dir() {
            return Ok(Self::File);
        }
        let mut bytes = Vec::new();
        // Of more, [`lines::Lines`] says that it is too much.
        let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(unreadable)?;
        Ok(Self::Copy(bytes))
    }

    /// The bytes from the first on.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::Trace`] for a file that is too large.
    pub fn open(&self, path: &Path) -> Result<Box<dyn Read + '_>, Error> {
        let unreadable = |source| Error::Read { path: path.to_owned(), source };
        if let Self::Copy(bytes) = self {
            return Ok(Box::new(&bytes[..]));
        }
        let facts = std::fs::metadata(path).map_err(unreadable)?;
        if facts.is_dir() {
            let reason = "it is a folder, a trace file is expected";
            return Err(unreadable(io::Error::new(io::ErrorKind::IsADirectory, reason)));
        }
        if facts.len() > MAX_BYTES {
            return Err(Error::trace(path, lines::too_large(&format!("{} MB", facts.len() >> 20))));
        }
        Ok(Box::new(File::open(path).map_err(unreadable)?))
    }
}
