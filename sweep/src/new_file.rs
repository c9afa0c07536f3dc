//! A Parquet file under a temporary name until it is whole: then synced, then renamed.
//!
//! A temporary file is locked while its writer lives. One that is not locked was left by a run that was killed.

use crate::error::Error;
use arrow::datatypes::SchemaRef;
use arrow::record_batch::RecordBatch;
use parquet::arrow::ArrowWriter;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Ending of temporary files; they begin with a dot and the name they are meant to have.
pub const TEMPORARY: &str = ".tmp";

/// Bytes that are written together at least: pages are larger, and go to the file as they are.
const BUFFER: usize = 1 << 16;

/// A file that is being written; removed when dropped before its end.
pub struct NewFile {
    path: PathBuf,
    temporary: Temporary,
    writer: ArrowWriter<BufWriter<File>>,
}

struct Temporary {
    path: PathBuf,
    finished: bool,
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.finished {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

impl NewFile {
    /// Begins the file that is to be at `path`.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn create(path: &Path, schema: SchemaRef, properties: WriterProperties) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_owned(), source };
        let temporary = Temporary { path: temporary_beside(path), finished: false };
        let file = File::create_new(&temporary.path).map_err(failed)?;
        file.lock().map_err(failed)?;
        let buffer = BufWriter::with_capacity(BUFFER, file);
        let writer =
            ArrowWriter::try_new(buffer, schema, Some(properties)).map_err(|error| Error::writing(path, error))?;
        Ok(Self { path: path.to_owned(), temporary, writer })
    }

    /// Adds rows.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&mut self, batch: &RecordBatch) -> Result<(), Error> {
        self.writer.write(batch).map_err(|error| Error::writing(&self.path, error))
    }

    /// Adds an entry to the file's metadata.
    pub fn note(&mut self, key: &str, value: String) {
        self.writer.append_key_value_metadata(KeyValue::new(key.to_owned(), value));
    }

    /// Ends the file's contents.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn end(self) -> Result<Ended, Error> {
        let failed = |source| Error::Write { path: self.path.clone(), source };
        let buffer = self.writer.into_inner().map_err(|error| Error::writing(&self.path, error))?;
        let file = buffer.into_inner().map_err(|e| failed(e.into_error()))?;
        Ok(Ended { path: self.path, temporary: self.temporary, file })
    }
}

/// A file that has all its contents, but not yet its own name; removed when dropped before it got that.
#[must_use]
pub struct Ended {
    path: PathBuf,
    temporary: Temporary,
    file: File,
}

impl Ended {
    /// Makes the file last under its own name. Waits for the disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn publish(mut self) -> Result<(), Error> {
        let failed = |source| Error::Write { path: self.path.clone(), source };
        self.file.sync_all().map_err(failed)?;
        std::fs::rename(&self.temporary.path, &self.path).map_err(failed)?;
        self.temporary.finished = true;
        sync_folder_of(&self.path).map_err(failed)
    }
}

/// Makes a new name in a folder last; a system whose folders cannot be synced needs no such thing.
fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

/// A name that no other file has, in the folder of `path`.
fn temporary_beside(path: &Path) -> PathBuf {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // The clock tells apart processes of the same number on different machines.
    let clock = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.subsec_nanos());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{clock:x}-{count}{TEMPORARY}", std::process::id()))
}
