//! Contents of a parsed TOML file: keys with their values, each with its line.

/// A key with its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key: String,
    /// The key with its enclosing tables, dotted.
    pub name: String,
    /// Counted from 1; 0 in a document without lines.
    pub line: usize,
    pub value: Value,
}

/// A value of a document.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
    Date(String),
    List(Vec<(usize, Value)>),
    Table(Vec<Entry>),
}
