//! Growing a study: the rows of a smaller study of the same sequence are taken from its folder, the others are solved. The result
//! equals the study made in one run, byte for byte.
//!
//! A design can grow if its first rows stay unchanged: more samples of a Sobol' sequence or more blocks of a Saltelli design,
//! further values of the first axis of a factorial design, further rows of a table. A Latin hypercube cannot.

mod rows;

pub use rows::EarlierReader;

use crate::design::Design;
use crate::error::Error;
use crate::file_names::{self, MANIFEST, RECORDS, ROWS, STUDY};
use crate::folder::differing::differing;
use crate::folder::record;
use crate::hash;
use crate::part::reader;
use crate::store::{LocalFile, Store};
use crate::study::Study;
use arrow::array::AsArray;
use rayon::prelude::*;
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Keys of a study's JSON that may differ from the smaller study's; `vary` and `table` are compared by their points.
const MAY_DIFFER: [&str; 6] = ["name", "samples", "rows", "parts", "vary", "table"];

/// The folder of a smaller study.
#[derive(Debug)]
pub struct Earlier {
    folder: PathBuf,
    parts: Vec<Part>,
    /// Number of parts that do not match their records: their rows are solved again.
    pub damaged: u64,
}

/// A complete part of the earlier study.
#[derive(Debug)]
struct Part {
    file: LocalFile,
    rows: Range<u64>,
}

impl Earlier {
    /// Examines the folder of a smaller study, which need not be finished; reads each of its parts and compares it with its hash,
    /// on the threads of the current pool.
    ///
    /// # Errors
    /// Why this study does not continue that one.
    pub fn open(study: &Study, store: &dyn Store) -> Result<Self, Error> {
        let folder = store.location();
        let refuse = |why: String| Error::NotContinued { folder: folder.to_owned(), why };
        let reading = Error::reading(folder);
        let text = match store.read(&format!("{RECORDS}/{STUDY}")).map_err(&reading)? {
            None => store.read(MANIFEST).map_err(&reading)?,
            text => text,
        };
        let text = text.ok_or_else(|| refuse(format!("it holds no study ({RECORDS}/{STUDY} is missing)")))?;
        let found: Value =
            serde_json::from_slice(&text).map_err(|_| refuse(format!("its {RECORDS}/{STUDY} cannot be read")))?;
        let rows = continues(study, &found).map_err(refuse)?;
        let identity = found["study_sha256"].as_str().unwrap_or_default();
        let parts = found["study"]["parts"].as_u64().unwrap_or(0);
        let look = |part: u64| {
            let name = file_names::part(part, parts);
            let record = record::read(store, &name).filter(|record| record.study_sha256 == identity)?;
            let digest = record.file?;
            let name = format!("{ROWS}/{name}");
            store.length(&name).ok().flatten()?;
            let whole = |file: &LocalFile| hash::of_file(file.path()).is_ok_and(|sha256| sha256 == digest.sha256);
            let rows = record.first_row..record.first_row + record.rows;
            Some(store.local(&name).ok().filter(whole).map(|file| Part { file, rows }).ok_or(()))
        };
        let looked: Vec<Result<Part, ()>> = (0..parts).into_par_iter().filter_map(look).collect();
        let damaged = looked.iter().filter(|part| part.is_err()).count() as u64;
        let parts: Vec<Part> = looked.into_iter().flatten().collect();
        if parts.is_empty() {
            return Err(refuse("it has no rows to take: it kept none, or none of its parts is complete".into()));
        }
        if rows > study.rows {
            let ours = study.rows;
            return Err(refuse(format!(
                "it has {rows} rows, this study only {ours}: a study can only be extended to more rows"
            )));
        }
        let earlier = Self { folder: folder.to_owned(), parts, damaged };
        if matches!(study.design, Design::Factorial(_) | Design::Table(_)) {
            earlier.parts.par_iter().try_for_each(|part| earlier.compare(study, part))?;
        }
        Ok(earlier)
    }

    /// Folder of the earlier study.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a part's points agree with this study's.
    fn compare(&self, study: &Study, part: &Part) -> Result<(), Error> {
        let names: Vec<&str> = study.varied.iter().map(|varied| varied.column.as_str()).collect();
        let mut at = part.rows.start;
        let mut points = vec![Vec::new(); names.len()];
        for batch in reader::read(part.file.path(), Some(&names), 0)? {
            let batch = batch.map_err(|error| Error::arrow(part.file.path(), error))?;
            study.design.fill(at..at + batch.num_rows() as u64, &mut points)?;
            for ((name, ours), array) in names.iter().zip(&points).zip(batch.columns()) {
                let theirs = reader::numbers(array.as_primitive());
                if let Some(i) = theirs.iter().zip(ours).position(|(theirs, ours)| theirs != ours) {
                    let (row, theirs, ours) = (at + i as u64, theirs[i], ours[i]);
                    let why = format!("its row {row} is at {name} = {theirs}, this study's at {ours}");
                    return Err(Error::NotContinued { folder: self.folder.clone(), why });
                }
            }
            at += batch.num_rows() as u64;
        }
        Ok(())
    }

    /// Number of these rows that exist in the folder.
    pub fn count(&self, rows: &Range<u64>) -> u64 {
        let common = |part: &Part| part.rows.end.min(rows.end).saturating_sub(part.rows.start.max(rows.start));
        self.parts.iter().map(common).sum()
    }

    /// Splits rows into pieces, each from one part of this folder or missing from it.
    fn pieces(&self, rows: Range<u64>) -> Vec<(Option<usize>, Range<u64>)> {
        let mut pieces = Vec::new();
        let mut at = rows.start;
        for (index, part) in self.parts.iter().enumerate() {
            let (begin, end) = (part.rows.start.max(at), part.rows.end.min(rows.end));
            if begin < end {
                if at < begin {
                    pieces.push((None, at..begin));
                }
                pieces.push((Some(index), begin..end));
                at = end;
            }
        }
        if at < rows.end {
            pieces.push((None, at..rows.end));
        }
        pieces
    }
}

/// Checks that this study continues the given one, and returns the latter's number of rows.
fn continues(study: &Study, found: &Value) -> Result<u64, String> {
    let (ours, theirs) = (study.json(), &found["study"]);
    if found["program_version"] != env!("CARGO_PKG_VERSION") {
        let (version, ours) = (&found["program_version"], env!("CARGO_PKG_VERSION"));
        return Err(format!("version {version} of the program wrote it, this is version {ours}; expected the same"));
    }
    if theirs["design"] != ours["design"] {
        return Err(format!("its design is {}, this study's {}", theirs["design"], ours["design"]));
    }
    if let Design::LatinHypercube(_) = study.design
        && theirs["samples"] != ours["samples"]
    {
        return Err(
            "a Latin hypercube of more samples has other rows from the first one on; design = \"sobol\" can be extended".into()
        );
    }
    let keys = |value: &Value| value.as_object().map_or(Vec::new(), |map| map.keys().cloned().collect());
    let by_points = matches!(study.design, Design::Factorial(_) | Design::Table(_));
    let names = |value: &Value| match value.as_array() {
        Some(list) => list.iter().map(|name| name.as_str().unwrap_or_default().to_owned()).collect(),
        None => keys(value),
    };
    if !by_points && theirs["vary"] != ours["vary"] || names(&theirs["vary"]) != names(&ours["vary"]) {
        return Err(difference("vary", &theirs["vary"], &ours["vary"]));
    }
    let (first, second): (Vec<String>, Vec<String>) = (keys(&ours), keys(theirs));
    let all = first.iter().chain(second.iter().filter(|key| !first.contains(key)));
    let mut different = all.filter(|key| !MAY_DIFFER.contains(&key.as_str()) && ours[*key] != theirs[*key]);
    if let Some(key) = different.next() {
        return Err(difference(key, &theirs[key], &ours[key]));
    }
    theirs["rows"].as_u64().ok_or_else(|| "it does not say how many rows it has".into())
}

/// Describes the difference in a key of the study, down to the differing entry.
fn difference(key: &str, theirs: &Value, ours: &Value) -> String {
    let text = |value: &Value| if value.is_null() { "nothing".to_owned() } else { value.to_string() };
    let entry = if theirs.is_object() && ours.is_object() { differing(theirs, ours).next() } else { None };
    let (name, [theirs, ours]) = entry.map_or((key, [theirs, ours]), |(name, both)| (name.as_str(), both));
    format!("its {name} is {}, this study's {}", text(theirs), text(ours))
}
