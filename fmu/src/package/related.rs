//! Files of a reference experiment.

/// A file of an experiment.
pub struct Related {
    /// Media type of the file, such as [`CSV`].
    pub media: &'static str,
    /// Name within the layered standard's folder.
    pub name: String,
    /// Its role in the experiment, as named by FMI-LS-REF.
    pub role: &'static str,
    /// What the file contains, as a sentence.
    pub description: String,
    /// Its content: XML, or a table with a header line.
    pub text: String,
}

/// Media type of a table.
pub const CSV: &str = "text/csv";
