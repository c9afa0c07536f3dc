//! The start values inside the library: a marked block of data that the packager overwrites.
//!
//! Importers differ in whether they set start values, and in how they specify the path of the FMU's resources. Values stored in
//! the library need neither: description and library stay consistent, since both contain the guid derived from the description.
//!
//! magic (16) · fingerprint of the table of variables (8) · CRC-32 of all that follows (4) · 0 (4) · guid (40) · choices · inputs
//! · real parameters, little-endian doubles. As compiled, everything after the fingerprint is zero: the reference chamber with
//! the guid of `modelDescription/modelDescription.xml`.

use crate::plant::values::{Choice, INPUTS, REALS, Starts};
use crate::table::admits;
use chamber::effects::CARDS;
use thiserror::Error;

/// Length of the block in bytes.
pub const LENGTH: usize = VALUES + 8 * (CHOICES + INPUTS + REALS);
const MAGIC_LENGTH: usize = 16;
const CHECKSUM: usize = 24;
const GUID: usize = 32;
/// Bytes of a guid, including zero padding.
pub const GUID_LENGTH: usize = 40;
const VALUES: usize = GUID + GUID_LENGTH;
const CHOICES: usize = Choice::ALL.len();

/// First half of the mark; the second half is its complement, so that the mark occurs only in the block.
const MARK: [u8; 8] = *b"pntChmb1";

/// The guid of the reviewed description, which belongs to the block as compiled.
pub const REFERENCE_GUID: &str = include_str!("../../modelDescription/guid.txt").trim_ascii_end();

/// The block as compiled.
pub const AS_BUILT: [u8; LENGTH] = {
    let mut block = [0; LENGTH];
    let print = fingerprint().to_le_bytes();
    let mut i = 0;
    while i < 8 {
        block[i] = MARK[i];
        block[8 + i] = !MARK[i];
        block[MAGIC_LENGTH + i] = print[i];
        i += 1;
    }
    block
};

/// Depends on the program's version and on the names of all effects and parameters, which define the meaning of each value's
/// index.
const fn fingerprint() -> u64 {
    let mut hash = mix(0xcbf2_9ce4_8422_2325, env!("CARGO_PKG_VERSION").as_bytes());
    let mut i = 0;
    while i < CARDS.len() {
        hash = mix(hash, CARDS[i].name.as_bytes());
        let mut j = 0;
        while j < CARDS[i].parameters.len() {
            hash = mix(hash, CARDS[i].parameters[j].name.as_bytes());
            j += 1;
        }
        i += 1;
    }
    hash
}

/// Extends an FNV-1a hash over more bytes.
const fn mix(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// Why start values cannot be written into a library.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BlockError {
    /// The mark is missing.
    #[error("it holds no block of start values: it is not the library of this FMU")]
    Missing,
    /// A library of another version.
    #[error("it was built from another version of the program: build it again")]
    OtherVersion,
    /// It already contains values.
    #[error("it has start values already: take the library as it was built")]
    Taken,
}

/// Start values and guid of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Start values of inputs and parameters, SI units.
    pub starts: Starts,
    /// The description's guid.
    pub guid: String,
}

impl Block {
    /// The reference chamber.
    pub fn reference() -> Self {
        Self { starts: Starts::default(), guid: REFERENCE_GUID.into() }
    }

    /// The block as bytes of the library's file: marks, checksum, guid, values.
    pub fn encode(&self) -> [u8; LENGTH] {
        let mut out = AS_BUILT;
        out[GUID..VALUES].copy_from_slice(&padded(&self.guid));
        let choices = Choice::ALL.map(|choice| f64::from(self.starts.parameters.choices.get(choice)));
        let values = choices.into_iter().chain(self.starts.inputs).chain(self.starts.parameters.real);
        for (to, value) in out[VALUES..].chunks_exact_mut(8).zip(values) {
            to.copy_from_slice(&value.to_le_bytes());
        }
        let checksum = crc32fast::hash(&out[GUID..]);
        out[CHECKSUM..CHECKSUM + 4].copy_from_slice(&checksum.to_le_bytes());
        out
    }

    /// Decodes the block's bytes; `None` if damaged.
    pub fn decode(bytes: &[u8; LENGTH]) -> Option<Self> {
        // Not compared with `AS_BUILT`, which would put a second copy of the mark into the library.
        if bytes[CHECKSUM..].iter().all(|b| *b == 0) {
            return Some(Self::reference());
        }
        if bytes[CHECKSUM..CHECKSUM + 4] != crc32fast::hash(&bytes[GUID..]).to_le_bytes() {
            return None;
        }
        let guid = std::str::from_utf8(&bytes[GUID..VALUES]).ok()?.trim_end_matches('\0').to_owned();
        let mut values = bytes[VALUES..].as_chunks::<8>().0.iter().map(|chunk| f64::from_le_bytes(*chunk));
        let mut starts = Starts::default();
        for choice in Choice::ALL {
            starts.parameters.choices = starts.parameters.choices.with(choice, values.next()? as i32)?;
        }
        starts
            .inputs
            .iter_mut()
            .chain(&mut starts.parameters.real)
            .for_each(|to| *to = values.next().unwrap_or(f64::NAN));
        admits(&starts).then_some(Self { starts, guid })
    }

    /// Writes the block into a library as compiled, at each occurrence (a universal binary has two); returns the offsets.
    ///
    /// # Errors
    /// If the library has no block, or that of another version.
    pub fn write_into(&self, library: &mut [u8]) -> Result<Vec<usize>, BlockError> {
        let magic = &AS_BUILT[..MAGIC_LENGTH];
        let offsets: Vec<usize> = memmem(library, magic).filter(|&at| at + LENGTH <= library.len()).collect();
        if offsets.is_empty() {
            return Err(BlockError::Missing);
        }
        for &at in &offsets {
            if library[at..at + GUID - 8] != AS_BUILT[..GUID - 8] {
                return Err(BlockError::OtherVersion);
            }
            if library[at..at + LENGTH] != AS_BUILT {
                return Err(BlockError::Taken);
            }
            library[at..at + LENGTH].copy_from_slice(&self.encode());
        }
        Ok(offsets)
    }
}

/// A guid, zero-padded.
pub fn padded(guid: &str) -> [u8; GUID_LENGTH] {
    let mut out = [0; GUID_LENGTH];
    out.iter_mut().zip(guid.bytes()).for_each(|(to, from)| *to = from);
    out
}

/// Offsets of `needle` in `hay`.
fn memmem(hay: &[u8], needle: &[u8]) -> impl Iterator<Item = usize> {
    hay.windows(needle.len()).enumerate().filter(move |(_, window)| *window == needle).map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block() -> Block {
        let mut starts = Starts::default();
        starts.parameters.real[0] = 0.032;
        starts.parameters.choices.area_law = chamber::AreaLaw::Swept;
        starts.inputs[0] = 0.25;
        Block { starts, guid: "{12345678-0000-0000-0000-000000000000}".into() }
    }

    #[test]
    fn a_block_decodes_to_what_was_written() {
        assert_eq!(Block::decode(&block().encode()), Some(block()));
        assert_eq!(Block::decode(&AS_BUILT), Some(Block::reference()));
    }

    #[test]
    fn a_damaged_block_is_none() {
        for index in GUID..LENGTH {
            let mut bytes = block().encode();
            bytes[index] ^= 4;
            assert_eq!(Block::decode(&bytes), None, "{index}");
        }
    }

    #[test]
    fn libraries_without_a_free_block_of_this_version_are_refused() {
        let mut library = vec![7u8; 300];
        assert_eq!(block().write_into(&mut library), Err(BlockError::Missing));
        library.extend(AS_BUILT);
        library.extend([1; 10]);
        assert_eq!(block().write_into(&mut library.clone()), Ok(vec![300]));
        library[300 + MAGIC_LENGTH] ^= 1;
        assert_eq!(block().write_into(&mut library.clone()), Err(BlockError::OtherVersion));
        library[300 + MAGIC_LENGTH] ^= 1;
        block().write_into(&mut library).unwrap();
        assert_eq!(block().write_into(&mut library), Err(BlockError::Taken));
    }
}
