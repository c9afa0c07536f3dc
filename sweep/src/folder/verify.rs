//! Verifies that a finished study's folder matches its manifest, byte for byte.

use super::record;
use crate::error::Error;
use crate::file_names::{self, MANIFEST, RECORDS, RESULTS, ROWS, STUDY};
use crate::part::new_file::Digest;
use crate::store::Store;
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;

/// Result of comparing a folder with its manifest.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Number of parts in the manifest.
    pub parts: usize,
    /// Total bytes of these parts.
    pub bytes: u64,
    /// Number of rows in the manifest.
    pub rows: u64,
    /// Parts that are missing or differ from the manifest, with the difference.
    pub wrong: Vec<String>,
    /// Results alongside the parts in the manifest.
    pub results: Vec<String>,
    /// Those of the results that are missing or differ, with the difference.
    pub wrong_results: Vec<String>,
    /// Existing results not in the manifest: it is older than they are, or than this program.
    pub not_covered: Vec<&'static str>,
    /// Files among the parts that are not in the manifest and that readers of the folder would take for parts.
    pub foreign: Vec<String>,
}

#[derive(Deserialize)]
struct Manifest {
    rows: u64,
    parts: Vec<Part>,
    #[serde(default)]
    results: Vec<Named>,
}

#[derive(Deserialize)]
struct Part {
    #[serde(flatten)]
    named: Named,
    rows: u64,
}

/// A file as listed in the manifest.
#[derive(Deserialize)]
struct Named {
    file: String,
    #[serde(flatten)]
    digest: Digest,
}

/// Reads every part and result listed in the manifest, on the threads of the current pool.
///
/// # Errors
/// The study is not finished, or the manifest cannot be read or is invalid.
pub fn verify(store: &dyn Store) -> Result<Report, Error> {
    let path = store.location().join(MANIFEST);
    let text = store.read(MANIFEST).map_err(Error::reading(&path))?;
    let text = text.ok_or_else(|| not_finished(store))?;
    let manifest: Manifest = serde_json::from_slice(&text).map_err(|error| {
        let reason = error.to_string();
        Error::Option(format!(
            "{}: cannot be read as a manifest ({reason}); expected the folder of a finished study",
            path.display()
        ))
    })?;
    let Manifest { rows, parts, results } = manifest;
    let mut wrong: Vec<String> = parts.par_iter().filter_map(|part| difference(store, &part.named)).collect();
    let rows_of_parts = parts.iter().map(|part| part.rows).sum::<u64>();
    if !parts.is_empty() && rows_of_parts != rows {
        wrong.push(format!("{MANIFEST}: its parts have {rows_of_parts} rows, the study {rows}"));
    }
    Ok(Report {
        parts: parts.len(),
        bytes: parts.iter().map(|part| part.named.digest.bytes).sum(),
        rows,
        wrong,
        wrong_results: results.iter().filter_map(|result| difference(store, result)).collect(),
        not_covered: not_covered(store, &results)?,
        results: results.into_iter().map(|result| result.file).collect(),
        foreign: foreign(store, &parts)?,
    })
}

/// Why there is no manifest: parts are missing, or the folder contains no study.
fn not_finished(store: &dyn Store) -> Error {
    let folder = store.location().display();
    let study = store.read(&format!("{RECORDS}/{STUDY}")).ok().flatten();
    let study = study.and_then(|text| serde_json::from_slice::<Value>(&text).ok());
    let Some(parts) = study.and_then(|study| study["study"]["parts"].as_u64()) else {
        return Error::Option(format!("{folder}: holds no {MANIFEST}; expected the folder of a finished study"));
    };
    let there = (0..parts).into_par_iter().filter(|part| is_there(store, &file_names::part(*part, parts))).count();
    let how_far = if there as u64 == parts {
        format!("all parts are there ({parts}), but {MANIFEST} is not")
    } else {
        format!("{there} of its {parts} parts are there")
    };
    Error::Option(format!("{folder}: the study is not complete: {how_far}; run it to its end, then verify it"))
}

/// Whether the part with that name exists or, if no rows are kept, its record.
fn is_there(store: &dyn Store, part: &str) -> bool {
    record::read(store, part).is_some_and(|record| {
        record.file.is_none() || store.length(&format!("{ROWS}/{part}")).is_ok_and(|length| length.is_some())
    })
}

/// Existing results that are not listed.
fn not_covered(store: &dyn Store, named: &[Named]) -> Result<Vec<&'static str>, Error> {
    let mut found = Vec::new();
    for path in RESULTS.into_iter().filter(|path| named.iter().all(|named| named.file != *path)) {
        if store.length(path).map_err(Error::reading(&store.location().join(path)))?.is_some() {
            found.push(path);
        }
    }
    Ok(found)
}

/// Files among the parts that are not parts. Readers skip names that begin with a dot or an underscore.
fn foreign(store: &dyn Store, parts: &[Part]) -> Result<Vec<String>, Error> {
    let names = store.names(ROWS).map_err(Error::reading(&store.location().join(ROWS)))?;
    let seen = names.into_iter().filter(|name| !name.starts_with(['.', '_'])).map(|name| format!("{ROWS}/{name}"));
    Ok(seen.filter(|name| parts.iter().all(|part| part.named.file != *name)).collect())
}

/// How a file differs from the manifest.
fn difference(store: &dyn Store, Named { file, digest }: &Named) -> Option<String> {
    let length = match store.length(file) {
        Ok(Some(length)) => length,
        Ok(None) => return Some(format!("{file}: it is not there")),
        Err(error) => return Some(format!("{file}: {error}")),
    };
    if length != digest.bytes {
        return Some(format!("{file}: {length} bytes, not {}", digest.bytes));
    }
    match store.sha256(file) {
        Ok(sha256) if sha256 == digest.sha256 => None,
        Ok(_) => Some(format!("{file}: its SHA-256 differs")),
        Err(error) => Some(format!("{file}: {error}")),
    }
}
