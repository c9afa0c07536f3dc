//! Errors in a study, its folder or its files, as sentences: where, what, what to do.

use arrow::error::ArrowError;
use parquet::errors::ParquetError;
use std::io;
use std::path::{Path, PathBuf};

/// Why a study was refused or could not be carried out. Paths are as given.
#[allow(missing_docs)]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The study file, its model or another record was refused.
    #[error(transparent)]
    Record(records::Error),
    /// A file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {source}{}", path.display(), advice(source))]
    Write { path: PathBuf, source: io::Error },
    /// An unusable table of points.
    #[error("{}: {message}", path.display())]
    Table { path: PathBuf, message: String },
    /// An invalid option of the run.
    #[error("{0}")]
    Option(String),
    /// A damaged file of the folder that identifies its study.
    #[error("{}: the file is damaged; remove it and run the sweep again: parts that are whole are kept", file.display())]
    Damaged { file: PathBuf },
    /// The folder belongs to another study.
    #[error("{}: the folder holds another study: {difference}; choose another folder or empty this one", folder.display())]
    OtherStudy { folder: PathBuf, difference: String },
    /// A smaller study that this one does not continue.
    #[error("{}: cannot be continued: {why}", folder.display())]
    NotContinued { folder: PathBuf, why: String },
    /// A Parquet file that cannot be written or read.
    #[error("{}: {source}", path.display())]
    Parquet { path: PathBuf, source: ParquetError },
}

/// Advice on the most common causes of a failed write.
fn advice(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; finished parts are kept: make room and run the same command again"
        }
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => "; choose a folder you may write to",
        _ => "",
    }
}

impl From<records::Error> for Error {
    fn from(error: records::Error) -> Self {
        match error {
            records::Error::Write { path, source } => Error::Write { path, source },
            other => Error::Record(other),
        }
    }
}

impl Error {
    /// A read error of `path`, with the system's reason.
    pub(crate) fn reading(path: &Path) -> impl Fn(io::Error) -> Self {
        move |source| Error::Read { path: path.to_owned(), source }
    }

    /// The Parquet library's error on the file at `path`.
    pub(crate) fn parquet(path: &Path) -> impl Fn(ParquetError) -> Self {
        move |source| Error::Parquet { path: path.to_owned(), source }
    }

    /// An error in the table of points at `path`.
    pub(crate) fn table(path: &Path, message: impl Into<String>) -> Self {
        Error::Table { path: path.to_owned(), message: message.into() }
    }

    /// The Parquet library's error while writing `path`: the system's reason if there is one.
    pub(crate) fn writing(path: &Path, error: ParquetError) -> Self {
        match error {
            ParquetError::External(inner) => match inner.downcast::<io::Error>() {
                Ok(source) => Error::Write { path: path.to_owned(), source: *source },
                Err(inner) => Error::Parquet { path: path.to_owned(), source: ParquetError::External(inner) },
            },
            source => Error::Parquet { path: path.to_owned(), source },
        }
    }

    /// The Arrow library's error on data from or for `path`.
    pub(crate) fn arrow(path: &Path, error: ArrowError) -> Self {
        match error {
            ArrowError::IoError(_, source) => Error::Read { path: path.to_owned(), source },
            other => Error::Parquet { path: path.to_owned(), source: ParquetError::ArrowError(other.to_string()) },
        }
    }
}
