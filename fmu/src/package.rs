//! The FMU as a file: a zip of description, documentation, icon, licences and the library of each platform at hand.
//! The same inputs give the same bytes.

use crate::block::{self, Block, BlockError};
use crate::description::{self, MODEL_IDENTIFIER};
use crate::documentation;
use crate::mach_o::{self, SignatureError};
use crate::variables::{Role, Starts, table};
use std::io::{Cursor, Write};
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// A library as built, for one platform.
#[derive(Clone, Copy, Debug)]
pub struct Library<'a> {
    /// Folder under `binaries/`: `linux64`, `win64`, …
    pub platform: &'a str,
    /// File name extension without the dot.
    pub extension: &'a str,
    /// The file.
    pub bytes: &'a [u8],
}

/// What goes into an FMU.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// Start values.
    pub starts: &'a Starts,
    /// UTC time of generation, as in 2026-01-31T12:00:00Z.
    pub generated: Option<&'a str>,
    /// The model file it is made from, kept in the FMU's resources.
    pub model_file: Option<&'a [u8]>,
    /// Libraries, at least one.
    pub libraries: &'a [Library<'a>],
}

/// Why no FMU could be made.
#[derive(Debug, Error)]
pub enum PackageError {
    /// A start value that the FMU itself would refuse.
    #[error("{name} = {value} {unit} cannot be a start value: it must lie within {min} to {max} {unit}")]
    StartValue {
        /// The variable.
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// Nothing to run.
    #[error("no library for any platform is at hand")]
    NoLibrary,
    /// A library that cannot take start values.
    #[error("the library for {platform}: {cause}")]
    Library {
        /// Its platform.
        platform: String,
        /// Why.
        cause: BlockError,
    },
    /// A library that cannot be signed anew.
    #[error("the library for {platform}: {cause}")]
    Signature {
        /// Its platform.
        platform: String,
        /// Why.
        cause: SignatureError,
    },
    /// Writing the archive.
    #[error("the FMU's archive could not be written: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// Writing the archive.
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
    let description = description::render(contents.starts, contents.generated);
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
    add("model.png", documentation::ICON, 0o644)?;
    for (name, bytes) in documentation::files() {
        add(&format!("documentation/{name}"), &bytes, 0o644)?;
    }
    for library in contents.libraries {
        let mut bytes = library.bytes.to_vec();
        let platform = || library.platform.to_owned();
        let places =
            block.write_into(&mut bytes).map_err(|cause| PackageError::Library { platform: platform(), cause })?;
        mach_o::sign(&mut bytes, &places, block::LENGTH)
            .map_err(|cause| PackageError::Signature { platform: platform(), cause })?;
        add(&format!("binaries/{}/{MODEL_IDENTIFIER}.{}", library.platform, library.extension), &bytes, 0o755)?;
    }
    if let Some(model) = contents.model_file {
        add("resources/model.toml", model, 0o644)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn check(starts: &Starts) -> Result<(), PackageError> {
    for variable in table() {
        let value = match variable.role {
            Role::Input(i) => starts.inputs[i],
            Role::Parameter(i) => starts.parameters.real[i],
            _ => continue,
        };
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
