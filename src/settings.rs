//! Settings of a rig, model, study or motion layout as given from Python: a file, its content, or a file with parts replaced.

use anyhow::{Context, bail};
use records::{Document, RigFile};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// A file, its content, or both.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Source file of the settings, if any.
    pub path: Option<PathBuf>,
    /// Tables as JSON, with the names used in files. They replace the file's entries, key by key.
    pub json: Option<String>,
}

impl Settings {
    /// The content of a model file; `None` if not given.
    ///
    /// # Errors
    /// If the file cannot be read, or the content is not a table.
    pub fn model(&self) -> anyhow::Result<Option<Document>> {
        self.document("model", Document::read)
    }

    /// The content of a rig file; `None` if not given.
    ///
    /// # Errors
    /// As [`Settings::model`].
    pub fn rig(&self) -> anyhow::Result<Option<Document>> {
        self.document("rig", RigFile::document)
    }

    /// The content of a study file; `None` if not given.
    ///
    /// # Errors
    /// As [`Settings::model`].
    pub fn study(&self) -> anyhow::Result<Option<Document>> {
        self.document("study", Document::read)
    }

    fn document(
        &self,
        name: &str,
        read: impl Fn(&Path) -> Result<Document, records::Error>,
    ) -> anyhow::Result<Option<Document>> {
        let file = self.path.as_deref().map(read).transpose()?;
        let Some(json) = &self.json else { return Ok(file) };
        let content: Map<String, Value> = serde_json::from_str(json).with_context(|| name.to_owned())?;
        let content = table(content, &format!("{name}: "))?;
        let (path, mut table) = match &file {
            Some(file) => (file.path(), toml::from_str(file.text())?),
            None => (Path::new(name), toml::Table::new()),
        };
        replace(&mut table, content);
        Ok(Some(Document::from_table(path, &table)))
    }
}

/// JSON as TOML; `key_path` is its location, for error messages: `rig: `, `rig: cylinder`.
fn table(entries: Map<String, Value>, key_path: &str) -> anyhow::Result<toml::Table> {
    let dot = if key_path.ends_with(' ') { "" } else { "." };
    let entry = |(key, value): (String, Value)| {
        let value = toml_value(value, &format!("{key_path}{dot}{key}"))?;
        Ok((key, value))
    };
    entries.into_iter().map(entry).collect()
}

fn toml_value(value: Value, key_path: &str) -> anyhow::Result<toml::Value> {
    Ok(match value {
        Value::Null => bail!("{key_path}: has no value (None)"),
        Value::Bool(flag) => flag.into(),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().unwrap_or(f64::NAN).into(),
        },
        Value::String(text) => text.into(),
        Value::Array(items) => {
            let items = items.into_iter().map(|item| toml_value(item, key_path));
            toml::Value::Array(items.collect::<anyhow::Result<_>>()?)
        }
        Value::Object(entries) => table(entries, key_path)?.into(),
    })
}

/// Replaces entries of the same name; tables are merged entry by entry.
fn replace(table: &mut toml::Table, entries: toml::Table) {
    for (key, value) in entries {
        match (table.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(entries)) => replace(inner, entries),
            (_, value) => {
                table.insert(key, value);
            }
        }
    }
}
