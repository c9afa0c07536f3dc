//! A column of one row group as pages encoded by this program: compressed, each with a checksum.
//!
//! The Parquet library encodes any column; it copies doubles together, splits them byte by byte and looks up each text of a
//! dictionary by its hash, which takes a quarter of the time of a study of sealed tests. See [`super::doubles`] and
//! [`super::texts`].
//! Format: <https://github.com/apache/parquet-format>, `README.md`, `Encodings.md` and `src/main/thrift/parquet.thrift`.

use super::pages::{Pieces, put_i32};
use parquet::basic::{Compression, Encoding, PageType, ZstdLevel};
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::{ColumnChunkMetaData, PageEncodingStats};
use parquet::file::page_index::offset_index::{OffsetIndexMetaData, PageLocation};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescPtr;
use std::io::Cursor;
use zstd::bulk::Compressor;
use zstd::zstd_safe::compress_bound;

/// Compresses pages.
pub struct Packer {
    level: ZstdLevel,
    compressor: Compressor<'static>,
}

impl Packer {
    /// Uses the given zstd level.
    pub fn new(level: ZstdLevel) -> Result<Self> {
        Ok(Self { level, compressor: Compressor::new(level.compression_level())? })
    }

    /// Appends bytes, compressed.
    fn pack(&mut self, bytes: &[u8], out: &mut Vec<u8>) -> Result<()> {
        out.reserve(compress_bound(bytes.len()));
        let end = out.len() as u64;
        let mut out = Cursor::new(out);
        out.set_position(end);
        self.compressor.compress_to_buffer(bytes, &mut out)?;
        Ok(())
    }
}

/// Some rows of a column, encoded.
pub struct Page<'a> {
    /// Number of rows.
    pub rows: usize,
    /// Number of nulls among them.
    pub nulls: usize,
    /// Definition levels, which mark the nulls, run-length encoded; empty if the column has no nulls.
    pub levels: &'a [u8],
    /// Values of the other rows.
    pub values: &'a [u8],
}

/// A column chunk under construction.
pub struct Chunk {
    column: ColumnDescPtr,
    encoding: Encoding,
    pieces: Pieces,
    uncompressed: usize,
    rows: usize,
    /// Whether the first page is a dictionary.
    has_dictionary: bool,
    pages: Vec<PageLocation>,
}

/// Type of a structure in Thrift's compact protocol, combined with the increment of the field number.
const STRUCTURE: u8 = 12;
/// The end of a structure.
const END: u8 = 0;

impl Chunk {
    /// Without pages yet; `encoding` is that of its values.
    pub fn new(column: ColumnDescPtr, encoding: Encoding) -> Self {
        let pieces = Pieces::default();
        Self { column, encoding, pieces, uncompressed: 0, rows: 0, has_dictionary: false, pages: Vec::new() }
    }

    /// Adds a page of `count` values that later pages refer to by index. It must come first.
    pub fn dictionary(&mut self, packer: &mut Packer, count: usize, values: &[u8]) -> Result<()> {
        let mut data = Vec::new();
        packer.pack(values, &mut data)?;
        let mut header = begun(PageType::DICTIONARY_PAGE, values.len(), &data);
        header.push(3 << 4 | STRUCTURE);
        for number in [count as i32, Encoding::PLAIN as i32] {
            put_i32(number, &mut header);
        }
        header.extend([END; 2]);
        self.uncompressed += header.len() + values.len();
        self.pieces.push(header, data);
        self.has_dictionary = true;
        Ok(())
    }

    /// Adds a page.
    pub fn page(&mut self, packer: &mut Packer, page: &Page<'_>) -> Result<()> {
        let &Page { rows, nulls, levels, values } = page;
        let mut data = Vec::with_capacity(levels.len() + compress_bound(values.len()));
        data.extend_from_slice(levels);
        packer.pack(values, &mut data)?;
        let uncompressed = levels.len() + values.len();
        let is_packed = data.len() < uncompressed;
        if !is_packed {
            data.truncate(levels.len());
            data.extend_from_slice(values);
        }
        let mut header = begun(PageType::DATA_PAGE_V2, uncompressed, &data);
        header.push(4 << 4 | STRUCTURE);
        for number in [rows, nulls, rows, self.encoding as usize, levels.len(), 0] {
            put_i32(number as i32, &mut header);
        }
        header.extend([1 << 4 | if is_packed { 1 } else { 2 }, END, END]);
        self.uncompressed += header.len() + uncompressed;
        self.pages.push(PageLocation {
            offset: self.pieces.length() as i64,
            compressed_page_size: (header.len() + data.len()) as i32,
            first_row_index: self.rows as i64,
        });
        self.pieces.push(header, data);
        self.rows += rows;
        Ok(())
    }

    /// The chunk's bytes and its metadata.
    ///
    /// # Errors
    /// The library rejects the metadata.
    pub fn close(self, packer: &Packer, statistics: Statistics) -> Result<(Pieces, ColumnCloseResult)> {
        let Self { column, encoding, pieces, uncompressed, rows, has_dictionary, pages } = self;
        let first = pages.first().ok_or_else(|| ParquetError::General("a column without pages".into()))?.offset;
        let of_values = PageEncodingStats { page_type: PageType::DATA_PAGE_V2, encoding, count: pages.len() as i32 };
        let of_dictionary =
            PageEncodingStats { page_type: PageType::DICTIONARY_PAGE, encoding: Encoding::PLAIN, count: 1 };
        let kinds: Vec<_> = has_dictionary.then_some(of_dictionary).into_iter().chain([of_values]).collect();
        let metadata = ColumnChunkMetaData::builder(column)
            .set_compression(Compression::ZSTD(packer.level))
            .set_encodings([Encoding::RLE].into_iter().chain(kinds.iter().map(|kind| kind.encoding)).collect())
            .set_page_encoding_stats(kinds)
            .set_total_compressed_size(pieces.length() as i64)
            .set_total_uncompressed_size(uncompressed as i64)
            .set_num_values(rows as i64)
            .set_dictionary_page_offset(has_dictionary.then_some(0))
            .set_data_page_offset(first)
            .set_statistics(statistics)
            .build()?;
        let close = ColumnCloseResult {
            bytes_written: pieces.length() as u64,
            rows_written: rows as u64,
            metadata,
            bloom_filter: None,
            column_index: None,
            offset_index: Some(OffsetIndexMetaData { page_locations: pages, unencoded_byte_array_data_bytes: None }),
        };
        Ok((pieces, close))
    }
}

/// Start of a page's header: its type, its lengths before and after compression, and the checksum of its bytes.
fn begun(kind: PageType, uncompressed: usize, data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for number in [kind as i32, uncompressed as i32, data.len() as i32, crc32fast::hash(data) as i32] {
        put_i32(number, &mut header);
    }
    header
}
