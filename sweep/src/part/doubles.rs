//! A column of doubles, byte-stream-split: for each page the first bytes of all values, then the second ones, and so on.
//!
//! Values are split as they arrive, while in a core's cache, with the processor's widest instructions.

use super::chunk::{Chunk, Packer, Page};
use super::encoding::PAGE;
use super::pages::{Pieces, put_varint};
use arrow::array::{Array, BooleanBufferBuilder, Float64Array};
use parquet::basic::Encoding;
use parquet::column::writer::ColumnCloseResult;
use parquet::errors::Result;
use parquet::file::statistics::ValueStatistics;
use parquet::schema::types::ColumnDescPtr;
use pulp::{Arch, Simd, WithSimd};

/// Bytes of a double.
const BYTES: usize = size_of::<f64>();
/// Values split together: they fit into a core's first-level cache.
const BLOCK: usize = 1 << 10;

/// A column of doubles of one row group under construction.
pub struct Doubles {
    chunk: Chunk,
    is_nullable: bool,
    /// The open page: one stream for each byte of a value, with room for a whole page.
    split: Vec<u8>,
    /// Number of values in it.
    values: usize,
    /// Which of its rows have a value.
    valid: BooleanBufferBuilder,
    /// Minimum and maximum, mapped by [`order`].
    extremes: [i64; 2],
    nulls: usize,
    present: Vec<f64>,
}

impl Doubles {
    /// Without values yet.
    pub fn new(column: ColumnDescPtr) -> Self {
        Self {
            is_nullable: column.max_def_level() > 0,
            chunk: Chunk::new(column, Encoding::BYTE_STREAM_SPLIT),
            split: vec![0; BYTES * PAGE],
            values: 0,
            valid: BooleanBufferBuilder::new(PAGE),
            extremes: [i64::MAX, i64::MIN],
            nulls: 0,
            present: Vec::new(),
        }
    }

    /// Adds values.
    pub fn write(&mut self, packer: &mut Packer, values: &Float64Array) -> Result<()> {
        let mut begin = 0;
        while begin < values.len() {
            let length = (values.len() - begin).min(PAGE - self.valid.len());
            self.append(&values.slice(begin, length));
            if self.valid.len() == PAGE {
                self.end_page(packer)?;
            }
            begin += length;
        }
        Ok(())
    }

    /// Appends values that fit into the open page.
    fn append(&mut self, values: &Float64Array) {
        match values.nulls().filter(|nulls| nulls.null_count() > 0) {
            None => {
                self.valid.append_n(values.len(), true);
                self.split(values.values());
            }
            Some(nulls) => {
                self.valid.append_buffer(nulls.inner());
                let mut present = std::mem::take(&mut self.present);
                present.clear();
                present.extend(nulls.valid_indices().map(|index| values.value(index)));
                self.split(&present);
                self.present = present;
            }
        }
    }

    fn split(&mut self, values: &[f64]) {
        let begin = self.values;
        Arch::new().dispatch(Split { values, begin, out: &mut self.split, extremes: &mut self.extremes });
        self.values += values.len();
    }

    fn end_page(&mut self, packer: &mut Packer) -> Result<()> {
        let (rows, values) = (self.valid.len(), self.values);
        if values < PAGE {
            for byte_index in 1..BYTES {
                self.split.copy_within(byte_index * PAGE..byte_index * PAGE + values, byte_index * values);
            }
        }
        let nulls = rows - values;
        let levels = if self.is_nullable { levels(&mut self.valid, nulls) } else { Vec::new() };
        let page = Page { rows, nulls, levels: &levels, values: &self.split[..BYTES * values] };
        self.chunk.page(packer, &page)?;
        self.nulls += nulls;
        self.values = 0;
        self.valid.truncate(0);
        Ok(())
    }

    /// The column's bytes and its metadata.
    pub fn close(mut self, packer: &mut Packer) -> Result<(Pieces, ColumnCloseResult)> {
        if !self.valid.is_empty() {
            self.end_page(packer)?;
        }
        let has_some = self.extremes[0] <= self.extremes[1];
        let [least, largest] = self.extremes.map(|key| has_some.then(|| f64::from_bits(order(key) as u64)));
        let statistics = ValueStatistics::new(least, largest, None, Some(self.nulls as u64), false);
        // The order of doubles is also that of their signed bits.
        let statistics = statistics.with_nan_count(has_some.then_some(0)).with_backwards_compatible_min_max(true);
        self.chunk.close(packer, statistics.into())
    }
}

/// Definition levels of a page with nulls: a run if all are equal, or one bit each.
fn levels(valid: &mut BooleanBufferBuilder, nulls: usize) -> Vec<u8> {
    let rows = valid.len();
    let is_mixed = nulls > 0 && nulls < rows;
    let mut out = Vec::new();
    put_varint(if is_mixed { rows.div_ceil(8) << 1 | 1 } else { rows << 1 }, &mut out);
    if is_mixed {
        out.extend_from_slice(valid.as_slice());
    } else {
        out.push(u8::from(nulls == 0));
    }
    out
}

/// Maps the bits of a number other than NaN to an integer in the same order, and back.
#[inline(always)]
fn order(bits: i64) -> i64 {
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

/// Splits values into byte streams.
struct Split<'a> {
    values: &'a [f64],
    /// Number of values already in the page.
    begin: usize,
    /// Room for the byte streams of a page.
    out: &'a mut [u8],
    extremes: &'a mut [i64; 2],
}

impl WithSimd for Split<'_> {
    type Output = ();

    // Index loops: iterator code is not inlined into a function compiled for more instructions than the crate.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { values, begin, out, extremes } = self;
        let [mut least, mut largest] = *extremes;
        let mut at = 0;
        while at < values.len() {
            let block = &values[at..(at + BLOCK).min(values.len())];
            let mut i = 0;
            while i < block.len() {
                let key = order(block[i].to_bits() as i64);
                least = if key < least { key } else { least };
                largest = if key > largest { key } else { largest };
                i += 1;
            }
            let mut byte_index = 0;
            while byte_index < BYTES {
                let from = byte_index * PAGE + begin + at;
                let bytes = &mut out[from..from + block.len()];
                let mut i = 0;
                while i < block.len() {
                    bytes[i] = (block[i].to_bits() >> (8 * byte_index)) as u8;
                    i += 1;
                }
                byte_index += 1;
            }
            at += block.len();
        }
        *extremes = [least, largest];
    }
}
