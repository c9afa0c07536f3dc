//! A study's folder: which parts are there, what an interrupted run left behind, and the manifest.

use crate::columns;
use crate::error::Error;
use crate::new_file::TEMPORARY;
use crate::part::StatusCounts;
use crate::study::Study;
use crate::traces;
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::{Value, json};
use std::fs::File;
use std::path::{Path, PathBuf};

/// Name of the file that says that all parts are there.
pub const MANIFEST: &str = "manifest.json";
/// What every part's name begins with.
const PART: &str = "part-";

/// A study's folder.
pub struct Folder<'a> {
    study: &'a Study,
    path: &'a Path,
    identity: String,
}

/// A part that is there and whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its rows by status.
    pub statuses: StatusCounts,
    /// Its size, bytes.
    pub bytes: u64,
}

impl<'a> Folder<'a> {
    /// Makes the folder where it is absent and refuses one that holds another study.
    ///
    /// # Errors
    /// The folder cannot be made or read, or is another study's.
    pub fn open(study: &'a Study, path: &'a Path) -> Result<Self, Error> {
        std::fs::create_dir_all(path).map_err(|source| Error::Write { path: path.to_owned(), source })?;
        let folder = Self { study, path, identity: study.identity() };
        folder.refuse_another_study()?;
        Ok(folder)
    }

    /// Path of the table of traces.
    pub fn traces_path(&self) -> PathBuf {
        self.path.join(traces::FILE)
    }

    /// Path of a part.
    pub fn part_path(&self, part: u64) -> PathBuf {
        self.path.join(self.study.part_name(part))
    }

    fn names(&self) -> Result<Vec<String>, Error> {
        let read = |source| Error::Read { path: self.path.to_owned(), source };
        let entries = std::fs::read_dir(self.path).map_err(read)?;
        let names: Result<Vec<_>, _> =
            entries.map(|e| e.map(|e| e.file_name().to_string_lossy().into_owned())).collect();
        let mut names = names.map_err(read)?;
        names.sort();
        Ok(names)
    }

    fn refuse_another_study(&self) -> Result<(), Error> {
        let other = |difference: String| Err(Error::OtherStudy { folder: self.path.to_owned(), difference });
        let manifest = self.path.join(MANIFEST);
        if let Ok(text) = std::fs::read_to_string(&manifest) {
            let found: Value = serde_json::from_str(&text).unwrap_or(Value::Null);
            if found["study_sha256"] != json!(self.identity) {
                return other(format!("{MANIFEST} is {}", self.described(&found)));
            }
        }
        for name in self.names()?.iter().filter(|name| name.starts_with(PART) || name.ends_with(".parquet")) {
            if !self.is_part(name) && name != traces::FILE {
                return other(format!("{name} is none of its {} parts", self.study.parts));
            }
            match Footer::read(&self.path.join(name)) {
                Some(footer) if footer.get("study_sha256") != Some(self.identity.as_str()) => {
                    let text = footer.get("study").unwrap_or("null");
                    let study: Value = serde_json::from_str(text).unwrap_or(Value::Null);
                    let found = json!({ "study": study, "program_version": footer.get("program_version") });
                    return other(format!("{name} is {}", self.described(&found)));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Whether a file has the name of one of the study's parts.
    fn is_part(&self, name: &str) -> bool {
        let number = name.strip_prefix(PART).and_then(|rest| rest.split('-').next()?.parse().ok());
        number.is_some_and(|part| part < self.study.parts && self.study.part_name(part) == name)
    }

    /// What another study differs in, as far as that can be said in a few words.
    fn described(&self, found: &Value) -> String {
        let (theirs, ours) = (&found["study"], self.study.json());
        if found["program_version"] != json!(env!("CARGO_PKG_VERSION")) {
            return format!("of program version {}, this is {}", found["program_version"], env!("CARGO_PKG_VERSION"));
        }
        let keys = ours.as_object().map(|map| map.keys().cloned().collect::<Vec<_>>()).unwrap_or_default();
        let different: Vec<_> = keys.into_iter().filter(|key| theirs[key] != ours[key]).collect();
        format!("of study {}, which differs in {}", theirs["name"], different.join(", "))
    }

    /// The part, if it is there and whole.
    pub fn finished(&self, part: u64) -> Option<Part> {
        let path = self.part_path(part);
        let footer = Footer::read(&path)?;
        let rows = self.study.rows_of(part);
        let whole = footer.rows == rows.end - rows.start && footer.get("study_sha256") == Some(&self.identity);
        let statuses = serde_json::from_str(footer.get("status_counts")?).ok()?;
        whole.then_some(Part { statuses, bytes: footer.bytes })
    }

    /// Removes what killed runs left of the parts that `mine` says yes to: temporary files that nobody has locked.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn clean(&self, mine: impl Fn(u64) -> bool) -> Result<(), Error> {
        let mut prefixes: Vec<String> = (0..self.study.parts)
            .filter(|part| mine(*part))
            .map(|part| format!(".{}.", self.study.part_name(part)))
            .collect();
        if mine(0) {
            prefixes.push(format!(".{}.", traces::FILE));
        }
        for name in self.names()? {
            if name.ends_with(TEMPORARY) && prefixes.iter().any(|prefix| name.starts_with(prefix.as_str())) {
                let path = self.path.join(&name);
                let abandoned = File::open(&path).is_ok_and(|file| file.try_lock().is_ok());
                if abandoned {
                    let _ = std::fs::remove_file(&path);
                }
            }
        }
        Ok(())
    }

    /// Removes a manifest that says more than is there.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove_manifest(&self) -> Result<(), Error> {
        let path = self.path.join(MANIFEST);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(Error::Write { path, source }),
            _ => Ok(()),
        }
    }

    /// Every part, if all are there.
    pub fn all_finished(&self) -> Option<Vec<Part>> {
        (0..self.study.parts).map(|part| self.finished(part)).collect()
    }

    /// Writes a result for programs beside the parts.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_json(&self, name: &str, value: &Value) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(value).unwrap_or_default() + "\n";
        Ok(records::write_atomically(&self.path.join(name), text.as_bytes())?)
    }

    /// Writes the manifest: the study, its columns and its parts. The same study gives the same manifest.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_manifest(&self, parts: &[Part]) -> Result<(), Error> {
        let mut total = StatusCounts::new();
        for (status, count) in parts.iter().flat_map(|part| &part.statuses) {
            *total.entry(status.clone()).or_default() += count;
        }
        let schema = columns::schema(self.study);
        let columns = schema.fields().iter().map(|field| {
            let metadata = field.metadata();
            json!({ "name": field.name(), "unit": metadata["unit"], "description": metadata["description"] })
        });
        let files = parts.iter().enumerate().map(|(i, part)| {
            let rows = self.study.rows_of(i as u64);
            json!({
                "file": self.study.part_name(i as u64),
                "first_row": rows.start,
                "rows": rows.end - rows.start,
                "bytes": part.bytes,
                "statuses": part.statuses,
            })
        });
        let manifest = json!({
            "program": "pneutherm",
            "program_version": env!("CARGO_PKG_VERSION"),
            "study_sha256": self.identity,
            "study": self.study.json(),
            "rows": self.study.rows,
            "statuses": total,
            "columns": columns.collect::<Vec<_>>(),
            "parts": files.collect::<Vec<_>>(),
        });
        self.write_json(MANIFEST, &manifest)
    }
}

/// What a Parquet file's footer says.
struct Footer {
    rows: u64,
    bytes: u64,
    entries: Vec<(String, String)>,
}

impl Footer {
    /// `None` where the file is absent or not a whole Parquet file.
    fn read(path: &Path) -> Option<Self> {
        let file = File::open(path).ok()?;
        let bytes = file.metadata().ok()?.len();
        let reader = SerializedFileReader::new(file).ok()?;
        let metadata = reader.metadata().file_metadata();
        let entries = metadata.key_value_metadata().into_iter().flatten();
        let entries = entries.map(|entry| (entry.key.clone(), entry.value.clone().unwrap_or_default())).collect();
        Some(Self { rows: metadata.num_rows() as u64, bytes, entries })
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.entries.iter().find(|(k, _)| k == key).map(|(_, value)| value.as_str())
    }
}
