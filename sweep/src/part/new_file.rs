//! A Parquet file under a temporary name until it is whole: then synced, then renamed.
//!
//! A temporary file is locked while its writer lives. One that is not locked was left by a run that was killed.

use super::pages::{self, Collector};
use super::sink::Sink;
use crate::error::Error;
use crate::folder::store::{Store, TEMPORARY};
use arrow::datatypes::SchemaRef;
use arrow::record_batch::RecordBatch;
use parquet::arrow::arrow_writer::{ArrowColumnWriter, ArrowRowGroupWriterFactory, compute_leaves};
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a file holds, as far as can be said without its contents.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Digest {
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Length of the file, bytes.
    pub bytes: u64,
}

/// A file that is being written; removed when dropped before its end.
pub struct NewFile {
    path: PathBuf,
    temporary: Temporary,
    schema: SchemaRef,
    writer: SerializedFileWriter<Sink>,
    factory: ArrowRowGroupWriterFactory,
    collector: Arc<Collector>,
    /// The columns of the row group that is open, and its rows.
    group: Option<(Vec<ArrowColumnWriter>, usize)>,
    groups: usize,
    rows_of_a_group: usize,
}

/// A file in a staging folder: no longer there when dropped, unless it was moved to its place.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

impl NewFile {
    /// Begins the file that is to be at `path`; until it is whole it is in the staging folder.
    ///
    /// # Errors
    /// The staging folder cannot be written.
    pub fn create(
        staging: &Path,
        path: &Path,
        schema: SchemaRef,
        mut properties: WriterProperties,
    ) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_owned(), source };
        let temporary = Temporary(temporary(staging, path));
        let file = File::create_new(&temporary.0).map_err(failed)?;
        // Some file systems know no locks; their files are written all the same, and never taken for left behind.
        let _ = file.lock();
        let writing = |error| Error::writing(path, error);
        let rows_of_a_group = properties.max_row_group_row_count().unwrap_or(usize::MAX);
        let columns = ArrowSchemaConverter::new().convert(&schema).map_err(writing)?;
        add_encoded_arrow_schema_to_metadata(&schema, &mut properties);
        let writer = SerializedFileWriter::new(Sink::new(file), columns.root_schema_ptr(), Arc::new(properties))
            .map_err(writing)?;
        let collector = Arc::new(Collector::default());
        let factory =
            ArrowRowGroupWriterFactory::new(&writer, schema.clone()).with_page_store_factory(collector.clone());
        #[rustfmt::skip]
        let file = Self {
            path: path.to_owned(), temporary, schema, writer, factory, collector, group: None, groups: 0, rows_of_a_group,
        };
        Ok(file)
    }

    /// Adds rows.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn write(&mut self, batch: &RecordBatch) -> Result<(), Error> {
        self.append(batch).map_err(|error| Error::writing(&self.path, error))
    }

    fn append(&mut self, batch: &RecordBatch) -> Result<(), ParquetError> {
        let mut begin = 0;
        while begin < batch.num_rows() {
            let (columns, rows) = match &mut self.group {
                Some(group) => group,
                none => none.insert((self.factory.create_column_writers(self.groups)?, 0)),
            };
            let length = (batch.num_rows() - begin).min(self.rows_of_a_group - *rows);
            let piece = batch.slice(begin, length);
            for ((column, field), array) in columns.iter_mut().zip(self.schema.fields()).zip(piece.columns()) {
                for leaf in compute_leaves(field, array)? {
                    column.write(&leaf)?;
                }
            }
            begin += length;
            *rows += length;
            if *rows == self.rows_of_a_group {
                self.end_group()?;
            }
        }
        Ok(())
    }

    /// Writes the columns of the open row group.
    fn end_group(&mut self) -> Result<(), ParquetError> {
        let Some((columns, _)) = self.group.take() else { return Ok(()) };
        let chunks = columns.into_iter().map(ArrowColumnWriter::close).collect::<Result<Vec<_>, _>>()?;
        let mut group = self.writer.next_row_group()?;
        for (chunk, pages) in chunks.into_iter().zip(self.collector.take()) {
            let (bytes, close) = pages::with_checksums(chunk, &pages)?;
            group.append_column(&bytes, close)?;
        }
        group.close()?;
        self.groups += 1;
        Ok(())
    }

    /// Adds an entry to the file's metadata.
    pub fn note(&mut self, key: &str, value: String) {
        self.writer.append_key_value_metadata(KeyValue::new(key.to_owned(), value));
    }

    /// Ends the file's contents.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn end(mut self) -> Result<Ended, Error> {
        self.end_group().map_err(|error| Error::writing(&self.path, error))?;
        self.writer.flush().map_err(|source| Error::Write { path: self.path.clone(), source })?;
        self.writer.inner_mut().hold();
        let sink = self.writer.into_inner().map_err(|error| Error::writing(&self.path, error))?;
        let finished = sink.finish(self.schema.fields().len());
        let (sha256, bytes, file) = finished.map_err(|source| Error::Write { path: self.path.clone(), source })?;
        Ok(Ended { path: self.path, temporary: self.temporary, file, digest: Digest { sha256, bytes } })
    }
}

/// A file that has all its contents, but not yet its own name; removed when dropped before it got that.
#[must_use]
pub struct Ended {
    path: PathBuf,
    temporary: Temporary,
    file: File,
    digest: Digest,
}

impl Ended {
    /// SHA-256 and length of the file.
    pub fn digest(&self) -> &Digest {
        &self.digest
    }

    /// Makes the file last under its own name in a store. Waits for that.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn publish(self, store: &dyn Store, name: &str) -> Result<(), Error> {
        let published = store.publish(&self.file, &self.temporary.0, name);
        published.map_err(|source| Error::Write { path: self.path, source })
    }
}

/// Lets the C library keep freed memory for the next pages instead of giving it back to the system after each one, which
/// costs more than the pages' compression. glibc keeps blocks up to twice the size of the largest one that it has seen
/// freed, up to 32 MiB; others take no notice.
pub fn keep_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
}

/// A name in a folder that no other file has.
fn temporary(folder: &Path, path: &Path) -> PathBuf {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // The clock tells apart processes of the same number on different machines.
    let clock = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.subsec_nanos());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    folder.join(format!(".{name}.{}-{clock:x}-{count}{TEMPORARY}", std::process::id()))
}
