//! Source of a trace's bytes: its file or, for something readable only once such as a pipe, a copy.

use super::lines::{self, MAX_BYTES};
use crate::error::Error;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a trace.
#[derive(Debug)]
pub enum Content {
    /// The file at the path.
    File,
    /// A copy of its bytes.
    Copy(Vec<u8>),
}

impl Content {
    /// Content that can be read repeatedly: the file itself or, if the path is no regular file, a copy.
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
        // Beyond the limit, [`lines::Lines`] reports that it is too large.
        let read = File::open(path).and_then(|file| file.take(MAX_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(unreadable)?;
        Ok(Self::Copy(bytes))
    }

    /// A reader from the first byte.
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
