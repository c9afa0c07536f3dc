//! A column of few different texts: a dictionary, and each row's index in it, with the minimum number of bits.

use super::chunk::{Chunk, Packer, Page};
use super::encoding::PAGE;
use super::pages::{Pieces, put_varint};
use arrow::array::{Array, DictionaryArray, StringArray};
use arrow::datatypes::Int32Type;
use parquet::basic::Encoding;
use parquet::column::writer::ColumnCloseResult;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescPtr;

/// A column of texts of one row group under construction.
pub struct Texts {
    chunk: Chunk,
    /// The texts encountered, in order.
    dictionary: Vec<String>,
    /// Each row's index in it.
    rows: Vec<u16>,
}

impl Texts {
    /// Without rows yet.
    pub fn new(column: ColumnDescPtr) -> Self {
        Self { chunk: Chunk::new(column, Encoding::RLE_DICTIONARY), dictionary: Vec::new(), rows: Vec::new() }
    }

    /// Adds rows, none of them null.
    pub fn write(&mut self, rows: &DictionaryArray<Int32Type>) -> Result<()> {
        let texts = rows.values().as_any().downcast_ref::<StringArray>();
        let texts = texts.ok_or_else(|| ParquetError::General("a dictionary of something else than texts".into()))?;
        // For each key its index here, once encountered.
        let mut indices: Vec<Option<u16>> = vec![None; texts.len()];
        self.rows.reserve(rows.len());
        for key in rows.keys().values() {
            let index = indices[*key as usize].get_or_insert_with(|| self.intern(texts.value(*key as usize)));
            self.rows.push(*index);
        }
        Ok(())
    }

    fn intern(&mut self, text: &str) -> u16 {
        let known = self.dictionary.iter().position(|known| known == text);
        known.unwrap_or_else(|| {
            self.dictionary.push(text.to_owned());
            self.dictionary.len() - 1
        }) as u16
    }

    /// The column's bytes and its metadata.
    pub fn close(self, packer: &mut Packer) -> Result<(Pieces, ColumnCloseResult)> {
        let Self { mut chunk, dictionary, rows } = self;
        let mut texts = Vec::new();
        for text in &dictionary {
            texts.extend((text.len() as u32).to_le_bytes());
            texts.extend(text.bytes());
        }
        chunk.dictionary(packer, dictionary.len(), &texts)?;
        let bits = (usize::BITS - dictionary.len().saturating_sub(1).leading_zeros()).max(1) as usize;
        for rows in rows.chunks(PAGE) {
            let mut values = vec![bits as u8];
            put_packed(rows, bits, &mut values);
            chunk.page(packer, &Page { rows: rows.len(), nulls: 0, levels: &[], values: &values })?;
        }
        let text = |text: Option<&String>| text.map(|text| ByteArray::from(text.as_str()));
        let (least, largest) = (text(dictionary.iter().min()), text(dictionary.iter().max()));
        chunk.close(packer, Statistics::byte_array(least, largest, None, Some(0), false))
    }
}

/// Appends small numbers of this many bits each, in groups of eight.
fn put_packed(numbers: &[u16], bits: usize, out: &mut Vec<u8>) {
    put_varint(numbers.len().div_ceil(8) << 1 | 1, out);
    for eight in numbers.chunks(8) {
        let packed = eight.iter().rev().fold(0u128, |packed, number| packed << bits | u128::from(*number));
        out.extend_from_slice(&packed.to_le_bytes()[..bits]);
    }
}
