//! Files that belong to a reference experiment.

/// A file of an experiment.
pub struct Related {
    /// Media type of the file, such as [`CSV`].
    pub media: &'static str,
    /// Name within the layered standard's folder.
    pub name: String,
    /// What it is to the experiment, as FMI-LS-REF names it.
    pub role: &'static str,
    /// What the file holds, in a sentence for people.
    pub description: String,
    /// Its content: XML, or a table with a header line.
    pub text: String,
}

/// Media type of a table.
pub const CSV: &str = "text/csv";
