//! Locations of a study's folder: a path, `file:///path`, or, in a build with the feature `object-store`, `s3://bucket/prefix`.

use anyhow::bail;
use std::path::Path;
use sweep::{Local, Store};

/// Opens the folder of a study.
///
/// # Errors
/// If the location is invalid.
pub fn open(location: &Path) -> anyhow::Result<Box<dyn Store>> {
    let Some((scheme, rest)) = location.to_str().and_then(|text| text.split_once("://")) else {
        return Ok(Box::new(Local::new(location)));
    };
    match scheme {
        "file" if rest.starts_with('/') => Ok(Box::new(Local::new(Path::new(rest)))),
        "file" => bail!("{}: expected file:///path with the whole path", location.display()),
        "s3" => bucket(location),
        _ => bail!("{}: expected a folder, file:///path or s3://bucket/prefix", location.display()),
    }
}

#[cfg(feature = "object-store")]
fn bucket(location: &Path) -> anyhow::Result<Box<dyn Store>> {
    Ok(Box::new(crate::bucket::Bucket::open(location)?))
}

#[cfg(not(feature = "object-store"))]
fn bucket(location: &Path) -> anyhow::Result<Box<dyn Store>> {
    bail!(
        "{}: this build knows folders only; `cargo install --path . --features object-store` builds one that knows s3://",
        location.display()
    )
}
