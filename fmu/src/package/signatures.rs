//! Re-signs a macOS library after its start values were written.
//!
//! Apple silicon runs no code without a signature. The linker gives each library an anonymous ("ad hoc") one: a code directory
//! with the SHA-256 of every page of the file. Writing start values changes one or two pages; replacing their hashes here is
//! equivalent to signing the library again. Source: Apple's `cs_blobs.h` and `mach-o/loader.h`; numbers of the signature are
//! big-endian, those of the library little-endian.

use sha2::{Digest, Sha256};
use std::ops::Range;
use thiserror::Error;

const UNIVERSAL: u32 = 0xcafe_babe;
const LIBRARY_64: u32 = 0xfeed_facf;
const HEADER_LENGTH: usize = 32;
const LOAD_SIGNATURE: u32 = 0x1d;
const SUPER_BLOB: u32 = 0xfade_0cc0;
const CODE_DIRECTORY: u32 = 0xfade_0c02;
const CMS_SIGNATURE: u32 = 0xfade_0b01;
const SHA256: u8 = 2;
const HASH_LENGTH: usize = 32;

/// Why a library cannot be re-signed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum SignatureError {
    /// A structure is missing or out of place.
    #[error("its code signature cannot be read: the file is damaged")]
    Damaged,
    /// A signature with a certificate, which only its owner can renew.
    #[error(
        "it is signed with a certificate or with other hashes than SHA-256: take the library as the linker made it"
    )]
    NotAdHoc,
}

/// Renews the hashes of the pages with a change of `length` bytes at each of the offsets, for every architecture of the library.
/// A file that is no Mach-O library, or has no signature, is unchanged.
///
/// # Errors
/// A signature that is damaged or not of the linker's kind.
pub fn sign(library: &mut [u8], offsets: &[usize], length: usize) -> Result<(), SignatureError> {
    for slice in slices(library)? {
        let part = library.get_mut(slice.clone()).ok_or(SignatureError::Damaged)?;
        let Some(directory) = CodeDirectory::of(part)? else { continue };
        for offset in offsets.iter().filter(|&&offset| slice.start <= offset && offset + length <= slice.end) {
            let begin = offset - slice.start;
            for page in begin / directory.page..(begin + length).div_ceil(directory.page) {
                directory.renew(part, page)?;
            }
        }
    }
    Ok(())
}

/// Ranges of the architectures' libraries in the file.
fn slices(file: &[u8]) -> Result<Vec<Range<usize>>, SignatureError> {
    if file.len() < HEADER_LENGTH {
        return Ok(Vec::new());
    }
    if little(file, 0)? == LIBRARY_64 {
        return Ok(std::iter::once(0..file.len()).collect());
    }
    if big(file, 0)? != UNIVERSAL {
        return Ok(Vec::new());
    }
    (0..big(file, 4)? as usize)
        .map(|i| {
            let entry = 8 + 20 * i;
            let (at, length) = (big(file, entry + 8)? as usize, big(file, entry + 12)? as usize);
            Ok(at..at + length)
        })
        .collect()
}

/// The linker's code directory in one architecture's library.
struct CodeDirectory {
    /// Offset of the first page's hash.
    hashes: usize,
    /// Page size, bytes.
    page: usize,
    /// Number of bytes hashed: all before the signature.
    limit: usize,
}

impl CodeDirectory {
    fn of(library: &[u8]) -> Result<Option<Self>, SignatureError> {
        let Some(signature) = signature(library)? else { return Ok(None) };
        if big(library, signature)? != SUPER_BLOB {
            return Err(SignatureError::Damaged);
        }
        let mut found = None;
        for i in 0..big(library, signature + 8)? as usize {
            let blob = signature + big(library, signature + 12 + 8 * i + 4)? as usize;
            match big(library, blob)? {
                CODE_DIRECTORY if found.is_none() => found = Some(Self::at(library, blob)?),
                CODE_DIRECTORY => return Err(SignatureError::NotAdHoc),
                // codesign adds an empty one when signing ad hoc.
                CMS_SIGNATURE if big(library, blob + 4)? > 8 => return Err(SignatureError::NotAdHoc),
                _ => {}
            }
        }
        found.map(Some).ok_or(SignatureError::Damaged)
    }

    fn at(library: &[u8], blob: usize) -> Result<Self, SignatureError> {
        let [size, kind, _, page] = bytes(library, blob + 36)?;
        if kind != SHA256 || usize::from(size) != HASH_LENGTH {
            return Err(SignatureError::NotAdHoc);
        }
        let page = 1_usize.checked_shl(page.into()).ok_or(SignatureError::Damaged)?;
        let (hashes, limit) = (blob + big(library, blob + 16)? as usize, big(library, blob + 32)? as usize);
        let count = big(library, blob + 28)? as usize;
        let fits = limit <= blob && limit.div_ceil(page) == count && hashes + count * HASH_LENGTH <= library.len();
        if fits { Ok(Self { hashes, page, limit }) } else { Err(SignatureError::Damaged) }
    }

    /// Replaces the hash of a page.
    fn renew(&self, library: &mut [u8], page: usize) -> Result<(), SignatureError> {
        let begin = page * self.page;
        let content = library.get(begin..self.limit.min(begin + self.page)).ok_or(SignatureError::Damaged)?;
        let hash = Sha256::digest(content);
        let offset = self.hashes + page * HASH_LENGTH;
        let slot = library.get_mut(offset..offset + HASH_LENGTH).filter(|_| begin < self.limit);
        slot.ok_or(SignatureError::Damaged)?.copy_from_slice(&hash);
        Ok(())
    }
}

/// Offset of the signature in a library, from its load commands.
fn signature(library: &[u8]) -> Result<Option<usize>, SignatureError> {
    let mut command = HEADER_LENGTH;
    for _ in 0..little(library, 16)? {
        if little(library, command)? == LOAD_SIGNATURE {
            return Ok(Some(little(library, command + 8)? as usize));
        }
        command += little(library, command + 4)? as usize;
    }
    Ok(None)
}

fn bytes(file: &[u8], at: usize) -> Result<[u8; 4], SignatureError> {
    file.get(at..).and_then(|rest| rest.first_chunk()).copied().ok_or(SignatureError::Damaged)
}

fn little(file: &[u8], at: usize) -> Result<u32, SignatureError> {
    bytes(file, at).map(u32::from_le_bytes)
}

fn big(file: &[u8], at: usize) -> Result<u32, SignatureError> {
    bytes(file, at).map(u32::from_be_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: usize = 4096;

    /// A library of `code` bytes, signed as by the linker: header, one load command, code, signature.
    fn signed(code: usize) -> Vec<u8> {
        let mut file: Vec<u8> = (0..code).map(|i| (i * i % 251) as u8).collect();
        let count = code.div_ceil(PAGE);
        for (offset, value) in [(0, LIBRARY_64), (16, 1), (32, LOAD_SIGNATURE), (36, 16), (40, code as u32)] {
            file[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        }
        let hashes = 44 + 8;
        let length = hashes + count * HASH_LENGTH;
        let words = [SUPER_BLOB, 20 + length as u32, 1, 0, 20, CODE_DIRECTORY, length as u32, 0x2_0400, 0x2_0002];
        let rest = [hashes as u32, 44, 0, count as u32, code as u32, 0x2002_000c, 0, u32::from_be_bytes(*b"Cham")];
        let words = words.iter().chain(&rest).chain(&[0, 0]);
        let mut signature: Vec<u8> = words.flat_map(|word| word.to_be_bytes()).collect();
        signature.truncate(20 + hashes);
        signature.extend(file.chunks(PAGE).flat_map(|page| Sha256::digest(page).to_vec()));
        file.extend(signature);
        file
    }

    #[test]
    fn a_library_changed_and_signed_anew_is_the_changed_one_signed() {
        let mut library = signed(3 * PAGE + 100);
        let fresh = library.clone();
        let hashes = 3 * PAGE + 100 + 20 + 52;
        // Across a page boundary, and in the last page, which is partial.
        for change in [PAGE - 3..PAGE + 3, 3 * PAGE + 90..3 * PAGE + 100] {
            library[change.clone()].fill(1);
            sign(&mut library, &[change.start], change.len()).unwrap();
        }
        for (page, content) in library[..3 * PAGE + 100].chunks(PAGE).enumerate() {
            let offset = hashes + page * HASH_LENGTH;
            assert_eq!(library[offset..offset + HASH_LENGTH], *Sha256::digest(content), "page {page}");
            assert_eq!(
                library[offset..offset + HASH_LENGTH] == fresh[offset..offset + HASH_LENGTH],
                page == 2,
                "page {page}"
            );
        }
    }

    #[test]
    fn each_architecture_of_a_universal_library_is_signed() {
        let parts = [signed(PAGE + 7), signed(2 * PAGE)];
        let mut file = [UNIVERSAL, 2].map(u32::to_be_bytes).concat();
        let mut at = PAGE;
        for part in &parts {
            file.extend([7, 3, at as u32, part.len() as u32, 12].map(u32::to_be_bytes).concat());
            at += 4 * PAGE;
        }
        let mut changed = Vec::new();
        let mut expected = Vec::new();
        for (i, mut part) in parts.into_iter().enumerate() {
            let at = PAGE + 4 * PAGE * i;
            file.resize(at, 0);
            file.extend(&part);
            file[at + PAGE] ^= 1;
            changed.push(at + PAGE);
            part[PAGE] ^= 1;
            sign(&mut part, &[PAGE], 1).unwrap();
            expected.push((at, part));
        }
        sign(&mut file, &changed, 1).unwrap();
        for (at, part) in expected {
            assert_eq!(file[at..at + part.len()], part);
        }
    }

    #[test]
    fn other_files_and_unsigned_libraries_stay_as_they_are() {
        let mut unsigned = signed(PAGE);
        unsigned[32] = 0x19;
        for mut file in [b"\x7fELF and more than a header's length of it".to_vec(), vec![], unsigned] {
            let before = file.clone();
            sign(&mut file, &[0], 1).unwrap();
            assert_eq!(file, before);
        }
    }

    #[test]
    fn a_damaged_signature_is_refused() {
        let whole = signed(2 * PAGE);
        for length in [40, 2 * PAGE + 10, 2 * PAGE + 60, whole.len() - 1] {
            assert_eq!(sign(&mut whole[..length].to_vec(), &[50], 10), Err(SignatureError::Damaged), "{length}");
        }
        let mut other = whole;
        other[2 * PAGE + 20 + 37] = 1;
        assert_eq!(sign(&mut other, &[50], 10), Err(SignatureError::NotAdHoc));
    }
}
