//! Where a Parquet file's bytes go: to the disk, hashed on the way, its footer mended before its last bytes.
//!
//! The Parquet library orders floating-point statistics by IEEE 754's total order, which readers of today do not know:
//! pyarrow 25 and others then read every row group whatever is asked for. No column holds NaN (nulls stand there), so
//! that the order is also the one that a type has by itself, and the footer says so.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// Bytes that are written together: the Parquet library hands columns over in small pieces.
const BUFFER: usize = 1 << 18;
/// An element of the footer's list of column orders in Thrift's compact protocol: its field 1, an empty structure.
const BY_TYPE: [u8; 3] = [0x1c, 0, 0];
/// The same with field 2: IEEE 754's total order.
const TOTAL: [u8; 3] = [0x2c, 0, 0];
/// Length of the footer's length, and of the file's last word.
const TRAILER: usize = 8;

/// A file that is being written.
pub struct Sink {
    file: BufWriter<File>,
    hash: Sha256,
    bytes: u64,
    /// From when on it is kept: the footer.
    held: Option<Vec<u8>>,
}

impl Sink {
    /// Writes to `file`, which is empty.
    pub fn new(file: File) -> Self {
        Self { file: BufWriter::with_capacity(BUFFER, file), hash: Sha256::new(), bytes: 0, held: None }
    }

    /// Keeps what comes from now on: the footer of that many columns is to be written.
    pub fn hold(&mut self) {
        self.held = Some(Vec::new());
    }

    /// Ends the file: its SHA-256 as hexadecimal digits, its length, and the file, not yet synced.
    ///
    /// # Errors
    /// It cannot be written, or the footer has not the known form.
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

/// Says of each column that its statistics follow the order of its type. The orders are the last of the footer's fields.
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
