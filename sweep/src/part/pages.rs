//! Pages with checksums: each page's header contains the CRC-32 of its bytes, so that readers detect a damaged page (pyarrow's
//! `page_checksum_verification`, Spark, DuckDB).
//!
//! The Parquet library writes headers without it. A column's pages are collected as they are made, each header followed by its
//! data; the checksum is inserted into the header, and the column's offsets and lengths are adjusted.
//! Header: <https://github.com/apache/parquet-format/blob/master/src/main/thrift/parquet.thrift>, `PageHeader`, field 4.

use bytes::{Buf, Bytes};
use parquet::arrow::arrow_writer::ArrowColumnChunk;
use parquet::column::page_store::{PageKey, PageStore, PageStoreArgs, PageStoreFactory};
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};
use std::collections::VecDeque;
use std::io::{self, Read};
use std::sync::{Arc, Mutex, PoisonError};

/// Pages of one column, header and data alternating.
pub type Pages = Arc<Mutex<Vec<Bytes>>>;

/// Creates a collection for each column, and keeps a handle to it.
#[derive(Debug, Default)]
pub struct Collector(Mutex<Vec<Pages>>);

impl Collector {
    /// The collections since the last call, in column order.
    pub fn take(&self) -> Vec<Pages> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl PageStoreFactory for Collector {
    fn create(&self, _: &PageStoreArgs<'_>) -> Result<Box<dyn PageStore>> {
        let pages = Pages::default();
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(pages.clone());
        Ok(Box::new(ColumnPages(pages)))
    }
}

/// The pages of one column, as stored by the Parquet library.
struct ColumnPages(Pages);

impl PageStore for ColumnPages {
    fn put(&mut self, value: Bytes) -> Result<PageKey> {
        let mut pages = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pages.push(value);
        Ok(PageKey::new(pages.len() as u64 - 1))
    }

    fn take(&mut self, _: PageKey) -> Result<Bytes> {
        Err(ParquetError::General("pages are taken by `with_checksums` only".into()))
    }
}

/// The bytes of a column chunk in the pieces they were made in: header and data of each page.
#[derive(Clone, Default)]
pub struct Pieces(VecDeque<Bytes>);

impl Pieces {
    /// Adds a page.
    pub fn push(&mut self, header: impl Into<Bytes>, data: impl Into<Bytes>) {
        self.0.extend([header.into(), data.into()]);
    }

    /// Total number of bytes.
    pub fn length(&self) -> usize {
        self.0.iter().map(Bytes::len).sum()
    }
}

impl Read for Pieces {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while self.0.front().is_some_and(Bytes::is_empty) {
            self.0.pop_front();
        }
        let Some(piece) = self.0.front_mut() else { return Ok(0) };
        let length = piece.len().min(out.len());
        piece.copy_to_slice(&mut out[..length]);
        Ok(length)
    }
}

impl Length for Pieces {
    fn len(&self) -> u64 {
        self.length() as u64
    }
}

/// The form in which the library takes a column chunk: read from its beginning, at 0.
impl ChunkReader for Pieces {
    type T = Self;

    fn get_read(&self, _: u64) -> Result<Self> {
        Ok(self.clone())
    }

    fn get_bytes(&self, _: u64, _: usize) -> Result<Bytes> {
        Err(ParquetError::General("a column chunk is read from its beginning on only".into()))
    }
}

/// A column chunk's bytes with a checksum in each page's header, and its adjusted metadata.
///
/// # Errors
/// The library made a header of unknown form.
pub fn with_checksums(mut chunk: ArrowColumnChunk, pages: &Pages) -> Result<(Pieces, ColumnCloseResult)> {
    let pages = std::mem::take(&mut *pages.lock().unwrap_or_else(PoisonError::into_inner));
    let (pairs, _) = pages.as_chunks::<2>();
    // The dictionary is made last but comes first in the file.
    let (dictionary, data): (Vec<_>, Vec<_>) = pairs.iter().partition(|[header, _]| header.get(1) == Some(&DICTIONARY));
    let mut out = Pieces::default();
    let mut append = |[header, data]: &[Bytes; 2]| -> Result<(usize, usize)> {
        let (begin, header) = (out.length(), with_checksum(header, crc32fast::hash(data))?);
        out.push(header, data.clone());
        Ok((begin, out.length() - begin))
    };
    for page in &dictionary {
        append(page)?;
    }
    let extents: Vec<(usize, usize)> = data.into_iter().map(append).collect::<Result<_>>()?;
    let added = (out.length() - pages.iter().map(Bytes::len).sum::<usize>()) as i64;
    let close = chunk.close_mut();
    let first = extents.first().map_or(0, |(begin, _)| *begin as i64);
    let metadata = close.metadata.clone();
    let (compressed, uncompressed) = (metadata.compressed_size() + added, metadata.uncompressed_size() + added);
    let metadata = metadata
        .into_builder()
        .set_total_compressed_size(compressed)
        .set_total_uncompressed_size(uncompressed)
        .set_dictionary_page_offset((!dictionary.is_empty()).then_some(0))
        .set_data_page_offset(first)
        .build()?;
    let mut offset_index = close.offset_index.take();
    for (location, (begin, length)) in offset_index.iter_mut().flat_map(|index| &mut index.page_locations).zip(extents)
    {
        location.offset = begin as i64;
        location.compressed_page_size = length as i32;
    }
    let close = ColumnCloseResult {
        bytes_written: compressed as u64,
        rows_written: close.rows_written,
        metadata,
        bloom_filter: close.bloom_filter.take(),
        column_index: close.column_index.take(),
        offset_index,
    };
    Ok((out, close))
}

/// Second byte of a dictionary page's header: its type, 2, zigzag-encoded.
const DICTIONARY: u8 = 4;
/// First byte of an i32 in Thrift's compact protocol, one field after the previous: `1 << 4 | i32`.
const NEXT_I32: u8 = 0x15;

/// Appends a varint: seven bits per byte.
pub fn put_varint(mut number: usize, out: &mut Vec<u8>) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

/// Appends an i32 to a structure in Thrift's compact protocol, as the next field.
pub fn put_i32(number: i32, out: &mut Vec<u8>) {
    out.push(NEXT_I32);
    put_varint(((number << 1) ^ (number >> 31)) as u32 as usize, out);
}

/// The header with the checksum inserted as field 4, after fields 1 to 3.
fn with_checksum(header: &[u8], checksum: u32) -> Result<Vec<u8>> {
    let unknown = || ParquetError::General("the Parquet library made a page header of unknown form".into());
    let mut at = 0;
    for _ in 0..3 {
        if header.get(at) != Some(&NEXT_I32) {
            return Err(unknown());
        }
        // A varint ends with the first byte below 128.
        at += 1 + header[at + 1..].iter().position(|byte| *byte < 0x80).ok_or_else(unknown)? + 1;
    }
    let next = *header.get(at).filter(|next| **next >> 4 >= 2).ok_or_else(unknown)?;
    let mut out = header[..at].to_vec();
    put_i32(checksum as i32, &mut out);
    // The next field's number is relative to this one's.
    out.push(next - (1 << 4));
    out.extend_from_slice(&header[at + 1..]);
    Ok(out)
}
