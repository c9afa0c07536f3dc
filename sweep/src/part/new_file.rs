//! A Parquet file with a temporary name until complete, then synced and renamed.
//!
//! A temporary file is locked while its writer is alive. An unlocked one was left by a killed run.

use super::chunk::Packer;
use super::doubles::Doubles;
use super::encoding;
use super::pages::{self, Collector, Pages, Pieces};
use super::sink::Sink;
use super::texts::Texts;
use crate::error::Error;
use crate::store::{Store, TEMPORARY};
use arrow::array::{ArrayRef, AsArray};
use arrow::datatypes::{Field, SchemaRef};
use arrow::record_batch::RecordBatch;
use parquet::arrow::arrow_writer::{ArrowColumnWriter, ArrowRowGroupWriterFactory, compute_leaves};
use parquet::arrow::{ArrowSchemaConverter, add_encoded_arrow_schema_to_metadata};
use parquet::basic::{Encoding, Type};
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::ColumnDescPtr;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Hash and length of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Digest {
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Length of the file, bytes.
    pub bytes: u64,
}

/// A file being written; removed if dropped before its end.
pub struct NewFile {
    path: PathBuf,
    temporary: Temporary,
    schema: SchemaRef,
    writer: SerializedFileWriter<Sink>,
    factory: ArrowRowGroupWriterFactory,
    collector: Arc<Collector>,
    /// The columns of the open row group, and its number of rows.
    group: Option<(Vec<Column>, usize)>,
    packer: Packer,
    groups: usize,
    rows_of_a_group: usize,
}

/// A column of the open row group: encoded here where that is faster, else by the Parquet library.
enum Column {
    Doubles(Doubles),
    Texts(Texts),
    Other(Box<ArrowColumnWriter>),
}

/// A file in a staging folder: deleted when dropped, unless it was moved to its destination.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

impl NewFile {
    /// Begins the file that is to become `path`; until complete it is in the staging folder.
    pub fn create(
        staging: &Path,
        path: &Path,
        schema: SchemaRef,
        mut properties: WriterProperties,
    ) -> Result<Self, Error> {
        let failed = |source| Error::Write { path: path.to_owned(), source };
        let temporary = Temporary(temporary(staging, path));
        let file = File::create_new(&temporary.0).map_err(failed)?;
        // Some file systems have no locks; their files are written anyway, and never regarded as left behind.
        let _ = file.lock();
        let writing = |error| Error::writing(path, error);
        let rows_of_a_group = properties.max_row_group_row_count().unwrap_or(usize::MAX);
        let columns = ArrowSchemaConverter::new().convert(&schema).map_err(writing)?;
        add_encoded_arrow_schema_to_metadata(&schema, &mut properties);
        let writer = SerializedFileWriter::new(Sink::new(file), columns.root_schema_ptr(), Arc::new(properties))
            .map_err(writing)?;
        let collector = Arc::new(Collector::default());
        let packer = Packer::new(encoding::zstd_level()).map_err(writing)?;
        let factory =
            ArrowRowGroupWriterFactory::new(&writer, schema.clone()).with_page_store_factory(collector.clone());
        #[rustfmt::skip]
        let file = Self {
            path: path.to_owned(), temporary, schema, writer, factory, collector, group: None, packer, groups: 0, rows_of_a_group,
        };
        Ok(file)
    }

    /// Adds rows.
    pub fn write(&mut self, batch: &RecordBatch) -> Result<(), Error> {
        self.append(batch).map_err(|error| Error::writing(&self.path, error))
    }

    fn append(&mut self, batch: &RecordBatch) -> Result<(), ParquetError> {
        let mut begin = 0;
        while begin < batch.num_rows() {
            let (columns, rows) = match &mut self.group {
                Some(group) => group,
                none => none.insert((columns(&self.writer, &self.factory, self.groups)?, 0)),
            };
            let length = (batch.num_rows() - begin).min(self.rows_of_a_group - *rows);
            let piece = batch.slice(begin, length);
            for ((column, field), array) in columns.iter_mut().zip(self.schema.fields()).zip(piece.columns()) {
                column.write(&mut self.packer, field, array)?;
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
        let mut group = self.writer.next_row_group()?;
        for (column, pages) in columns.into_iter().zip(self.collector.take()) {
            let (pieces, close) = column.close(&mut self.packer, &pages)?;
            group.append_column(&pieces, close)?;
        }
        group.close()?;
        self.groups += 1;
        Ok(())
    }

    /// Adds an entry to the file's metadata.
    pub fn note(&mut self, key: &str, value: String) {
        self.writer.append_key_value_metadata(KeyValue::new(key.to_owned(), value));
    }

    /// Completes the file's contents.
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

/// The columns of a new row group.
fn columns(
    writer: &SerializedFileWriter<Sink>,
    factory: &ArrowRowGroupWriterFactory,
    group: usize,
) -> Result<Vec<Column>, ParquetError> {
    let of_library = factory.create_column_writers(group)?.into_iter().zip(writer.schema_descr().columns());
    let column = |(column, described): (ArrowColumnWriter, &ColumnDescPtr)| {
        let encoding = writer.properties().encoding(described.path());
        if encoding == Some(Encoding::BYTE_STREAM_SPLIT) {
            Column::Doubles(Doubles::new(described.clone()))
        } else if described.physical_type() == Type::BYTE_ARRAY {
            Column::Texts(Texts::new(described.clone()))
        } else {
            Column::Other(Box::new(column))
        }
    };
    Ok(of_library.map(column).collect())
}

impl Column {
    fn write(&mut self, packer: &mut Packer, field: &Field, rows: &ArrayRef) -> Result<(), ParquetError> {
        match self {
            Column::Doubles(column) => column.write(packer, rows.as_primitive()),
            Column::Texts(column) => column.write(rows.as_dictionary()),
            Column::Other(column) => compute_leaves(field, rows)?.iter().try_for_each(|leaf| column.write(leaf)),
        }
    }

    /// The column's bytes and its metadata. The pages of the library's writer come from the collector.
    fn close(self, packer: &mut Packer, pages: &Pages) -> Result<(Pieces, ColumnCloseResult), ParquetError> {
        match self {
            Column::Doubles(column) => column.close(packer),
            Column::Texts(column) => column.close(packer),
            Column::Other(column) => pages::with_checksums(column.close()?, pages),
        }
    }
}

/// A complete file without its final name; removed if dropped before it is published.
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

    /// Publishes the file durably under its own name in a store, and waits for that.
    pub fn publish(self, store: &dyn Store, name: &str) -> Result<(), Error> {
        let published = store.publish(&self.file, &self.temporary.0, name);
        published.map_err(|source| Error::Write { path: self.path, source })
    }
}

/// Makes the C library keep freed memory for the next pages; returning it to the system after each one costs more than the pages'
/// compression. glibc keeps blocks up to twice the largest one it has seen freed, up to 32 MiB; other libraries ignore this.
pub fn keep_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
}

/// A unique file name in a folder.
fn temporary(folder: &Path, path: &Path) -> PathBuf {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // The clock distinguishes processes with the same id on different machines.
    let clock = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.subsec_nanos());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    folder.join(format!(".{name}.{}-{clock:x}-{count}{TEMPORARY}", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::random::mix;
    use arrow::array::{DictionaryArray, Float64Array};
    use arrow::datatypes::{Int32Type, Schema};
    use bytes::Bytes;
    use encoding::{PAGE, ROW_GROUP};
    use parquet::arrow::ArrowWriter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::file::metadata::ParquetMetaDataReader;

    /// A column of doubles, one of doubles with nulls, and one of texts with this many different texts.
    fn table(rows: usize, is_null: impl Fn(usize) -> bool, texts: usize) -> RecordBatch {
        let number = |i: usize| match mix(1, i as u64) {
            bits if bits.is_multiple_of(50) => -0.0,
            bits => (bits as i64 as f64) * 1e-12,
        };
        let some = |i: usize| (!is_null(i)).then(|| number(i + 7));
        let names: Vec<String> = (0..texts).map(|i| format!("text {i}")).collect();
        let statuses: DictionaryArray<Int32Type> =
            (0..rows).map(|i| names[mix(2, i as u64) as usize % texts].as_str()).collect();
        let columns: [(&str, bool, ArrayRef); 3] = [
            ("all", false, Arc::new((0..rows).map(number).collect::<Float64Array>())),
            ("some", true, Arc::new((0..rows).map(some).collect::<Float64Array>())),
            ("status", false, Arc::new(statuses)),
        ];
        let fields: Vec<Field> = columns
            .iter()
            .map(|(name, nullable, column)| Field::new(*name, column.data_type().clone(), *nullable))
            .collect();
        let columns = columns.into_iter().map(|(_, _, column)| column).collect();
        RecordBatch::try_new(Arc::new(Schema::new(fields)), columns).unwrap()
    }

    #[test]
    fn columns_encoded_here_are_read_back_and_described_as_by_the_parquet_library() {
        let nulls: [fn(usize) -> bool; 4] =
            [|_| false, |i| mix(3, i as u64).is_multiple_of(3), |i| i >= PAGE, |_| true];
        for (rows, texts) in [(1, 1), (9, 2), (PAGE, 1), (ROW_GROUP + PAGE + 13, 300)] {
            for is_null in nulls {
                let batch = table(rows, is_null, texts);
                let properties = || encoding::of_columns(&batch.schema(), |_| false).build();
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join("file.parquet");
                let mut file = NewFile::create(folder.path(), &path, batch.schema(), properties()).unwrap();
                for begin in (0..rows).step_by(5000) {
                    file.write(&batch.slice(begin, 5000.min(rows - begin))).unwrap();
                }
                let ended = file.end().unwrap();
                let open = || File::open(&ended.temporary.0).unwrap();
                let reader = ParquetRecordBatchReaderBuilder::try_new(open()).unwrap().with_batch_size(rows);
                let read: Vec<RecordBatch> = reader.build().unwrap().collect::<Result<_, _>>().unwrap();
                let mut begin = 0;
                for read in read {
                    assert_eq!(read.columns(), batch.slice(begin, read.num_rows()).columns());
                    begin += read.num_rows();
                }
                assert_eq!(begin, rows);
                let mut library = Vec::new();
                let mut writer = ArrowWriter::try_new(&mut library, batch.schema(), Some(properties())).unwrap();
                writer.write(&batch).unwrap();
                writer.close().unwrap();
                let ours = ParquetMetaDataReader::new().parse_and_finish(&open()).unwrap();
                let theirs = ParquetMetaDataReader::new().parse_and_finish(&Bytes::from(library)).unwrap();
                assert_eq!(ours.num_row_groups(), theirs.num_row_groups());
                for (ours, theirs) in ours.row_groups().iter().zip(theirs.row_groups()) {
                    assert_eq!(ours.num_rows(), theirs.num_rows());
                    for (ours, theirs) in ours.columns().iter().zip(theirs.columns()) {
                        assert_eq!(ours.statistics(), theirs.statistics());
                        assert_eq!(ours.encodings_mask(), theirs.encodings_mask());
                        assert_eq!(ours.num_values(), theirs.num_values());
                        let sizes = [ours, theirs].map(|column| column.compressed_size() as f64);
                        assert!(sizes[0] < 1.02 * sizes[1] + 60.0, "{sizes:?}");
                    }
                }
            }
        }
    }
}
