//! Whether a finished study's folder holds what its manifest says, byte for byte.

use super::file_names::{MANIFEST, ROWS};
use super::store::Store;
use crate::error::Error;
use crate::part::new_file::Digest;
use rayon::prelude::*;
use serde::Deserialize;
use std::io;

/// How a folder compares with its manifest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Parts that the manifest names.
    pub parts: usize,
    /// Bytes of these parts.
    pub bytes: u64,
    /// Rows that the manifest names.
    pub rows: u64,
    /// Files that are missing or not what the manifest says, with the difference.
    pub wrong: Vec<String>,
    /// Files beside the parts that the manifest does not name and readers of the folder would take for parts.
    pub foreign: Vec<String>,
}

#[derive(Deserialize)]
struct Manifest {
    rows: u64,
    parts: Vec<Part>,
}

#[derive(Deserialize)]
struct Part {
    file: String,
    #[serde(flatten)]
    digest: Digest,
    rows: u64,
}

/// Reads every part that the manifest names, on the threads of the current pool.
///
/// # Errors
/// The manifest is missing or is none.
pub fn verify(store: &dyn Store) -> Result<Report, Error> {
    let path = store.place().join(MANIFEST);
    let text = store
        .read(MANIFEST)
        .and_then(|text| text.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "it is not there")));
    let text = text.map_err(|source| Error::Read { path: path.clone(), source })?;
    let manifest: Manifest = serde_json::from_slice(&text).map_err(|error| {
        let reason = error.to_string();
        Error::Option(format!(
            "{}: cannot be read as a manifest ({reason}); expected the folder of a finished study",
            path.display()
        ))
    })?;
    let mut wrong: Vec<String> = manifest.parts.par_iter().filter_map(|part| difference(store, part)).collect();
    let (rows, has_parts) = (manifest.parts.iter().map(|part| part.rows).sum::<u64>(), !manifest.parts.is_empty());
    if has_parts && rows != manifest.rows {
        wrong.push(format!("{MANIFEST}: its parts have {rows} rows, the study {}", manifest.rows));
    }
    Ok(Report {
        parts: manifest.parts.len(),
        bytes: manifest.parts.iter().map(|part| part.digest.bytes).sum(),
        rows: manifest.rows,
        wrong,
        foreign: foreign(store, &manifest.parts)?,
    })
}

/// Files among the parts that are none. Readers pass over names that begin with a dot or an underscore.
fn foreign(store: &dyn Store, parts: &[Part]) -> Result<Vec<String>, Error> {
    let names = store.names(ROWS).map_err(|source| Error::Read { path: store.place().join(ROWS), source })?;
    let seen = names.into_iter().filter(|name| !name.starts_with(['.', '_'])).map(|name| format!("{ROWS}/{name}"));
    Ok(seen.filter(|name| parts.iter().all(|part| part.file != *name)).collect())
}

/// How a part differs from what the manifest says.
fn difference(store: &dyn Store, part: &Part) -> Option<String> {
    let length = match store.length(&part.file) {
        Ok(Some(length)) => length,
        Ok(None) => return Some(format!("{}: it is not there", part.file)),
        Err(error) => return Some(format!("{}: {error}", part.file)),
    };
    if length != part.digest.bytes {
        return Some(format!("{}: {length} bytes, not {}", part.file, part.digest.bytes));
    }
    match store.sha256(&part.file) {
        Ok(sha256) if sha256 == part.digest.sha256 => None,
        Ok(_) => Some(format!("{}: its SHA-256 differs", part.file)),
        Err(error) => Some(format!("{}: {error}", part.file)),
    }
}
