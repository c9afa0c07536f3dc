//! A study's folder: existing parts, leftovers of an interrupted run, and the manifest.
//!
//! A part's record is written before the part, so that no part lacks its hash.
//!
//! | module | holds |
//! |---|---|
//! | `record` | what is recorded about a part |
//! | `differing` | entries in which two studies differ |
//! | [`earlier`] | rows that a smaller study has already solved |
//! | [`verify`] | check against the manifest |

mod differing;
pub mod earlier;
pub(crate) mod record;
pub mod verify;

use crate::error::Error;
use crate::file_names::{self, MANIFEST, OF_THE_STUDY, RECORDS, ROWS, STUDY};
use crate::hash;
use crate::part::columns;
use crate::part::new_file::Digest;
use crate::part::status_column::StatusCounts;
use crate::statistics::State;
use crate::store::{LocalFile, Store};
use crate::study::Study;
use differing::differing;
use record::{Record, statuses_of};
use serde_json::{Value, json};
use std::io;
use std::path::PathBuf;

/// A study's folder.
pub struct Folder<'a> {
    study: &'a Study,
    store: &'a dyn Store,
    identity: String,
}

/// State of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// The part, as its record describes it.
    Whole(Record),
    /// A file that differs from its record in length or contents.
    Damaged,
    /// Neither file nor record, or a record without its file.
    Nothing,
}

impl Found {
    /// The part's record, if it is whole.
    pub fn whole(self) -> Option<Record> {
        match self {
            Found::Whole(record) => Some(record),
            Found::Damaged | Found::Nothing => None,
        }
    }
}

/// How thoroughly to check a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Compares the length of the file with the record.
    Length,
    /// Compares the SHA-256 of the file with the record.
    Contents,
}

impl<'a> Folder<'a> {
    /// Opens a folder that is the study's or does not exist yet, without writing anything.
    ///
    /// # Errors
    /// It cannot be read, or belongs to another study.
    pub fn open(study: &'a Study, store: &'a dyn Store) -> Result<Self, Error> {
        let folder = Self { study, store, identity: study.identity() };
        folder.refuse_another_study()?;
        Ok(folder)
    }

    /// The store that holds the folder.
    pub fn store(&self) -> &'a dyn Store {
        self.store
    }

    /// Marks the folder as the study's.
    pub fn prepare(&self) -> Result<(), Error> {
        let name = format!("{RECORDS}/{STUDY}");
        if self.store.length(&name).map_err(self.reading(&name))?.is_some() {
            return Ok(());
        }
        let mut study = self.about();
        study["columns"] = self.columns();
        self.store.write(&name, pretty(&study).as_bytes()).map_err(self.writing(&name))
    }

    /// Folder for files being written.
    pub fn staging(&self) -> Result<PathBuf, Error> {
        self.store.staging().map_err(self.writing(""))
    }

    /// Turns a system error into an error about a file of this folder.
    fn reading(&self, name: &str) -> impl FnOnce(io::Error) -> Error + use<> {
        let path = self.path(name);
        move |source| Error::Read { path, source }
    }

    fn writing(&self, name: &str) -> impl FnOnce(io::Error) -> Error + use<> {
        let path = self.path(name);
        move |source| Error::Write { path, source }
    }

    /// Path of a file of this folder, for display.
    pub fn path(&self, name: &str) -> PathBuf {
        if name.is_empty() { self.store.location().to_owned() } else { self.store.location().join(name) }
    }

    /// A part's path in the folder.
    pub fn part_file(&self, part: u64) -> String {
        format!("{ROWS}/{}", self.study.part_name(part))
    }

    /// A part on the local disk.
    pub fn local_part(&self, part: u64) -> Result<LocalFile, Error> {
        let name = self.part_file(part);
        self.store.local(&name).map_err(self.reading(&name))
    }

    /// Path of a part's record in the folder.
    fn record_file(&self, part: u64) -> String {
        record::file(&self.study.part_name(part))
    }

    /// A part's record, to be written before the part is published.
    pub fn record(&self, part: u64, statuses: StatusCounts, file: Option<Digest>, statistics: Option<State>) -> Record {
        let rows = self.study.rows_of(part);
        let (first_row, rows) = (rows.start, rows.end - rows.start);
        Record { study_sha256: self.identity.clone(), first_row, rows, statuses, file, statistics }
    }

    /// Writes a part's record durably.
    pub fn write_record(&self, part: u64, record: &Record) -> Result<(), Error> {
        let text = serde_json::to_string(record).unwrap_or_default() + "\n";
        let name = self.record_file(part);
        self.store.write(&name, text.as_bytes()).map_err(self.writing(&name))
    }

    fn names(&self, folder: &str) -> Result<Vec<String>, Error> {
        self.store.names(folder).map_err(self.reading(folder))
    }

    fn refuse_another_study(&self) -> Result<(), Error> {
        let other = |difference: String| Err(Error::OtherStudy { folder: self.path(""), difference });
        let mut is_known = false;
        for name in [format!("{RECORDS}/{STUDY}"), MANIFEST.to_owned()] {
            let Some(text) = self.store.read(&name).map_err(self.reading(&name))? else { continue };
            let Ok(found) = serde_json::from_slice::<Value>(&text) else {
                return Err(Error::Damaged { file: self.path(&name) });
            };
            if found["study_sha256"] != json!(self.identity) {
                return other(format!("{name} is {}", self.described(&found)));
            }
            is_known = true;
        }
        if let Some(name) = self.names("")?.iter().find(|name| name.ends_with(".parquet")) {
            return other(format!("{name} is not in {ROWS}/"));
        }
        let parts = self.names(ROWS)?;
        if let Some(name) = parts.iter().find(|name| !self.is_part(name)) {
            return other(format!("{ROWS}/{name} is none of its {} parts", self.study.parts));
        }
        if !parts.is_empty() && !is_known {
            return other(format!("{ROWS}/ holds parts, but {RECORDS}/{STUDY}, which says whose, is missing"));
        }
        Ok(())
    }

    /// Whether a file is named like one of the study's parts.
    fn is_part(&self, name: &str) -> bool {
        let number = name.strip_prefix("part-").and_then(|rest| rest.split('-').next()?.parse().ok());
        number.is_some_and(|part| part < self.study.parts && self.study.part_name(part) == name)
    }

    /// Brief description of how another study differs.
    fn described(&self, found: &Value) -> String {
        let (theirs, ours) = (&found["study"], self.study.json());
        if found["program_version"] != json!(env!("CARGO_PKG_VERSION")) {
            return format!(
                "version {} of the program wrote it, this is version {}",
                found["program_version"],
                env!("CARGO_PKG_VERSION")
            );
        }
        let keys = ours.as_object().map(|map| map.keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
        let differences = keys.into_iter().filter(|key| theirs[key] != ours[key]).flat_map(|key| match key.as_str() {
            "fixed" => differing(&theirs[&key], &ours[&key])
                .map(|(name, [theirs, ours])| format!("{name} ({theirs} there, {ours} here)"))
                .collect(),
            _ => vec![key],
        });
        format!("{}, which differs in {}", theirs["name"], differences.collect::<Vec<_>>().join(", "))
    }

    /// The statistics in a part's record. [`Folder::find`] omits them: those of all parts of a large study exceed its memory.
    pub fn statistics(&self, part: u64) -> Option<State> {
        record::read(self.store, &self.study.part_name(part))?.statistics
    }

    /// Looks for a part; with `rows` its file must exist too.
    pub fn find(&self, part: u64, rows: bool, look: Look) -> Found {
        let rows_of = self.study.rows_of(part);
        let record =
            record::read(self.store, &self.study.part_name(part)).map(|record| Record { statistics: None, ..record });
        let name = self.part_file(part);
        let length = self.store.length(&name).ok().flatten();
        let Some(record) = record else {
            return if length.is_some() { Found::Damaged } else { Found::Nothing };
        };
        let its = record.study_sha256 == self.identity
            && (record.first_row, record.rows) == (rows_of.start, rows_of.end - rows_of.start);
        if !its {
            return Found::Damaged;
        }
        match (&record.file, length) {
            (None, _) if rows => Found::Nothing,
            (None, _) => Found::Whole(record),
            (Some(_), None) => Found::Nothing,
            (Some(digest), Some(length)) => {
                let same = length == digest.bytes
                    && (look == Look::Length || self.store.sha256(&name).is_ok_and(|sha256| sha256 == digest.sha256));
                if same { Found::Whole(record) } else { Found::Damaged }
            }
        }
    }

    /// Removes temporary files of killed runs, which nobody has locked, for the parts selected by `mine`.
    pub fn clean(&self, mine: impl Fn(u64) -> bool) -> Result<(), Error> {
        let parts = (0..self.study.parts).filter(|part| mine(*part)).map(|part| self.study.part_name(part));
        let mut names: Vec<String> = parts.flat_map(|part| [record::file_name(&part), part]).collect();
        if mine(0) {
            names.extend(OF_THE_STUDY.map(str::to_owned));
        }
        self.store.clean(&names).map_err(self.reading(""))
    }

    /// Removes a manifest that lists more than exists.
    pub fn remove_manifest(&self) -> Result<(), Error> {
        self.store.remove(MANIFEST).map_err(self.writing(MANIFEST))
    }

    /// The records of all parts, if all are complete.
    pub fn all_finished(&self, rows: bool) -> Option<Vec<Record>> {
        (0..self.study.parts).map(|part| self.find(part, rows, Look::Length).whole()).collect()
    }

    /// Writes a JSON file alongside the parts, unless it is unchanged.
    pub fn write_json(&self, name: &str, value: &Value) -> Result<(), Error> {
        self.write_changed(name, &pretty(value))
    }

    /// Writes a text unless the file already contains it.
    fn write_changed(&self, name: &str, text: &str) -> Result<(), Error> {
        if self.store.read(name).is_ok_and(|found| found.as_deref() == Some(text.as_bytes())) {
            return Ok(());
        }
        self.store.write(name, text.as_bytes()).map_err(self.writing(name))
    }

    /// Writes a JSON result alongside the parts, after its record.
    pub fn write_result(&self, name: &str, value: &Value) -> Result<(), Error> {
        let text = pretty(value);
        self.record_result(name, &Digest { sha256: hash::of_bytes(text.as_bytes()), bytes: text.len() as u64 })?;
        self.write_changed(name, &text)
    }

    /// Writes a result's record durably, before the result itself.
    pub fn record_result(&self, path: &str, digest: &Digest) -> Result<(), Error> {
        self.write_json(&file_names::record_of_result(path), &json!(digest))
    }

    /// The existing results alongside the parts, as described by their records.
    fn results(&self) -> Result<Vec<Value>, Error> {
        let mut found = Vec::new();
        for path in file_names::RESULTS {
            let record = file_names::record_of_result(path);
            let text = self.store.read(&record).map_err(self.reading(&record))?;
            let digest: Option<Digest> = text.and_then(|text| serde_json::from_slice(&text).ok());
            let is_there = self.store.length(path).map_err(self.reading(path))?.is_some();
            if let Some(Digest { sha256, bytes }) = digest.filter(|_| is_there) {
                found.push(json!({ "file": path, "bytes": bytes, "sha256": sha256 }));
            }
        }
        Ok(found)
    }

    /// Updates the results in an existing manifest; if there is none, the run that finishes the study writes it.
    pub fn renew_manifest(&self) -> Result<(), Error> {
        let Some(text) = self.store.read(MANIFEST).map_err(self.reading(MANIFEST))? else { return Ok(()) };
        let Ok(mut manifest) = serde_json::from_slice::<Value>(&text) else { return Ok(()) };
        manifest["results"] = json!(self.results()?);
        self.write_json(MANIFEST, &manifest)
    }

    /// Writes the manifest: the study, its columns, its parts and its results.
    pub fn write_manifest(&self, parts: &[Record]) -> Result<(), Error> {
        let total = statuses_of(parts);
        let files = parts.iter().enumerate().filter_map(|(i, part)| {
            let file = part.file.as_ref()?;
            Some(json!({
                "file": self.part_file(i as u64),
                "first_row": part.first_row,
                "rows": part.rows,
                "bytes": file.bytes,
                "sha256": file.sha256,
                "statuses": part.statuses,
            }))
        });
        let files: Vec<_> = files.collect();
        let mut manifest = self.about();
        manifest["rows"] = json!(self.study.rows);
        manifest["statuses"] = json!(total);
        manifest["columns"] = self.columns();
        manifest["parts"] = json!(files);
        manifest["results"] = json!(self.results()?);
        self.write_json(MANIFEST, &manifest)
    }

    /// Content of the file that identifies the folder's study.
    fn about(&self) -> Value {
        json!({
            "program": "pneutherm",
            "program_version": env!("CARGO_PKG_VERSION"),
            "study_sha256": self.identity,
            "study": self.study.json(),
        })
    }

    fn columns(&self) -> Value {
        let schema = columns::schema(self.study);
        let column = |field: &arrow::datatypes::FieldRef| {
            let metadata = field.metadata();
            json!({ "name": field.name(), "unit": metadata["unit"], "description": metadata["description"] })
        };
        schema.fields().iter().map(column).collect()
    }
}

/// JSON as written to files.
fn pretty(value: &Value) -> String {
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}
