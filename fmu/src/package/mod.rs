//! The FMU as a file: a zip of description, documentation, icon, licences and the library of each available platform.
//! The same inputs give the same bytes.

pub mod documentation;
pub mod experiment;
pub mod related;
pub mod signatures;
pub mod validation;

use crate::description::Description;
use crate::fmi2;
use crate::fmi3;
use crate::identity::Identity;
use crate::plant::values::Starts;
use crate::start_values::{self, Block, BlockError};
use crate::table::units::unit_suffix;
use crate::table::{settable, table};
use documentation::About;
use signatures::SignatureError;
use std::io::{Cursor, Write};
use thiserror::Error;
use validation::Validation;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// A compiled library for one platform.
#[derive(Clone, Copy, Debug)]
pub struct Library<'a> {
    /// Folder under `binaries/`: `linux64`, `win64`, …
    pub platform: &'a str,
    /// File name extension without the dot.
    pub extension: &'a str,
    /// The complete library, with its block of start values as compiled.
    pub bytes: &'a [u8],
}

/// FMI version of an FMU; one library serves both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.5, which most tools import.
    Two,
    /// FMI 3.0.2, with terminals and early return at events.
    Three,
}

impl Version {
    /// The description of an FMU of this version.
    fn describe(self, identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
        match self {
            Version::Two => fmi2::description::render(identity, starts, generated),
            Version::Three => fmi3::description::render(identity, starts, generated),
        }
    }

    /// Folder of a platform under `binaries/`, given its name in FMI 2.0.
    fn folder(self, platform: &str) -> String {
        let tuple = match (self, platform) {
            (Version::Two, _) => return platform.to_owned(),
            (_, "linux64") => "x86_64-linux",
            (_, "win64") => "x86_64-windows",
            (_, "darwin64") => "x86_64-darwin",
            (_, other) => other,
        };
        tuple.to_owned()
    }
}

/// Contents of an FMU.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// FMI version.
    pub version: Version,
    /// Identity of the model.
    pub identity: &'a Identity,
    /// Origin of the numbers, for the documentation.
    pub about: &'a About,
    /// Start values of inputs and parameters, SI units.
    pub starts: &'a Starts,
    /// Measured records for the model, as reference experiments.
    pub validations: &'a [Validation],
    /// UTC time of generation, such as 2026-01-31T12:00:00Z.
    pub generated: Option<&'a str>,
    /// The model file it is made from, stored in the FMU's resources.
    pub model_file: Option<&'a [u8]>,
    /// Libraries, at least one.
    pub libraries: &'a [Library<'a>],
}

/// Why packaging an FMU failed. Values are in the SI unit; a platform is its folder under `binaries/`.
#[allow(missing_docs)]
#[derive(Debug, Error)]
pub enum PackageError {
    /// A start value that the FMU would refuse.
    #[error("{name} = {value}{of} cannot be a start value: it must lie within {min} to {max}{of}", of = unit_suffix(unit))]
    StartValue {
        name: &'static str,
        value: f64,
        unit: &'static str,
        /// Lower bound of `fmi2SetReal`.
        min: f64,
        max: f64,
    },
    /// No library is available.
    #[error("no library for any platform is at hand")]
    NoLibrary,
    /// A library whose start values cannot be written.
    #[error("the library for {platform}: {cause}")]
    Library { platform: String, cause: BlockError },
    /// A library that cannot be re-signed.
    #[error("the library for {platform}: {cause}")]
    Signature { platform: String, cause: SignatureError },
    /// The zip cannot hold an entry.
    #[error("the FMU's archive could not be written: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// An entry's bytes cannot be written.
    #[error("the FMU's archive could not be written: {0}")]
    Io(#[from] std::io::Error),
}

/// The FMU's bytes.
///
/// # Errors
/// Start values out of bounds; libraries that are missing or of another version.
pub fn package(contents: &Contents<'_>) -> Result<Vec<u8>, PackageError> {
    check(contents.starts)?;
    if contents.libraries.is_empty() {
        return Err(PackageError::NoLibrary);
    }
    let version = contents.version;
    let description = version.describe(contents.identity, contents.starts, contents.generated);
    let block = Block { starts: *contents.starts, guid: description.guid };
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, bytes: &[u8], mode: u32| -> Result<(), PackageError> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(mode);
        zip.start_file(name, options)?;
        zip.write_all(bytes)?;
        Ok(())
    };
    add("modelDescription.xml", description.xml.as_bytes(), 0o644)?;
    match version {
        Version::Two => add("model.png", documentation::ICON, 0o644)?,
        Version::Three => {
            add("terminalsAndIcons/terminalsAndIcons.xml", fmi3::terminals::render().as_bytes(), 0o644)?;
            add("terminalsAndIcons/icon.png", documentation::ICON, 0o644)?;
            add("terminalsAndIcons/terminal.png", documentation::TERMINAL, 0o644)?;
        }
    }
    for (name, bytes) in documentation::files(documentation::page(
        contents.identity, contents.starts, contents.about, contents.validations,
    )) {
        add(&format!("documentation/{name}"), &bytes, 0o644)?;
    }
    for library in contents.libraries {
        let mut bytes = library.bytes.to_vec();
        let platform = || library.platform.to_owned();
        let offsets =
            block.write_into(&mut bytes).map_err(|cause| PackageError::Library { platform: platform(), cause })?;
        signatures::sign(&mut bytes, &offsets, start_values::LENGTH)
            .map_err(|cause| PackageError::Signature { platform: platform(), cause })?;
        add(
            &format!(
                "binaries/{}/{}.{}",
                version.folder(library.platform),
                contents.identity.identifier,
                library.extension
            ),
            &bytes,
            0o755,
        )?;
    }
    for (name, text) in experiment::files(contents.starts, contents.validations) {
        add(&format!("{}/{name}", experiment::FOLDER), text.as_bytes(), 0o644)?;
    }
    if let Some(model) = contents.model_file {
        add("resources/model.toml", model, 0o644)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn check(starts: &Starts) -> Result<(), PackageError> {
    for variable in table() {
        let Some(value) = settable(starts, variable.role) else { continue };
        if !value.is_finite() || !variable.admits(value) {
            let (min, max) = (variable.min.unwrap_or(f64::MIN), variable.max.unwrap_or(f64::MAX));
            return Err(PackageError::StartValue {
                name: &variable.name,
                value,
                unit: variable.quantity.unit,
                min,
                max,
            });
        }
    }
    Ok(())
}
