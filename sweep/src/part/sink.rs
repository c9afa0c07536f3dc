//! Destination of a Parquet file's bytes: written to disk and hashed on the way, with a corrected footer.
//!
//! The Parquet library orders floating-point statistics by IEEE 754's total order, which current readers do not know: pyarrow 25
//! and others then read every row group regardless of the filter. No column contains NaN (nulls are used instead), so this order
//! equals the type's own order, and the footer states the latter.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Bytes written together: the Parquet library passes columns in small pieces.
const BUFFER: usize = 1 << 18;
/// An element of the footer's list of column orders in Thrift's compact protocol, for the type's own order: field 1, an empty
/// structure.
const BY_TYPE: [u8; 3] = [0x1c, 0, 0];
/// The same for IEEE 754's total order: field 2.
const TOTAL: [u8; 3] = [0x2c, 0, 0];
/// Bytes of the footer's length and the file's magic number.
const TRAILER: usize = 8;

/// A file being written.
pub struct Sink {
    file: BufWriter<File>,
    hash: Sha256,
    bytes: u64,
    /// The footer, held back from when it begins.
    held: Option<Vec<u8>>,
}

impl Sink {
    /// Writes to `file`, which is empty.
    pub fn new(file: File) -> Self {
        Self { file: BufWriter::with_capacity(BUFFER, file), hash: Sha256::new(), bytes: 0, held: None }
    }

    /// Holds back the bytes from here on, which are the footer.
    pub fn hold(&mut self) {
        self.held = Some(Vec::new());
    }

    /// Ends the file: returns its SHA-256 in hexadecimal digits, its length, and the file, not yet synced.
    ///
    /// # Errors
    /// It cannot be written, or the footer has an unknown form.
    pub fn finish(mut self, columns: usize) -> io::Result<(String, u64, File)> {
        if let Some(mut footer) = self.held.take() {
            order_by_type(&mut footer, columns)
                .ok_or_else(|| io::Error::other("the Parquet library made a footer of unknown form"))?;
            self.write_all(&footer)?;
        }
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok((crate::hash::hex(&self.hash.finalize()), self.bytes, file))
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.write_all(bytes)?;
        Ok(bytes.len())
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        if let Some(held) = &mut self.held {
            held.extend_from_slice(bytes);
            return Ok(());
        }
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Marks each column's statistics as ordered by its type. The orders are the last field of the footer.
fn order_by_type(footer: &mut [u8], columns: usize) -> Option<()> {
    let end = footer.len().checked_sub(TRAILER + 1)?;
    let orders = footer.get_mut(end.checked_sub(3 * columns)?..end)?;
    let (orders, _) = orders.as_chunks_mut::<3>();
    for order in orders {
        if *order != BY_TYPE && *order != TOTAL {
            return None;
        }
        *order = BY_TYPE;
    }
    Some(())
}
