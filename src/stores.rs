//! Locations of a study's folder: a path, `file:///path`, or, in a build with the feature `object-store`, `s3://bucket/prefix`.

use anyhow::bail;
use std::path::Path;
use sweep::{Local, Store};

/// Opens the folder of a study.
///
/// # Errors
/// If the location is invalid.
pub fn open(place: &Path) -> anyhow::Result<Box<dyn Store>> {
    let Some((scheme, rest)) = place.to_str().and_then(|text| text.split_once("://")) else {
        return Ok(Box::new(Local::new(place)));
    };
    match scheme {
        "file" if rest.starts_with('/') => Ok(Box::new(Local::new(Path::new(rest)))),
        "file" => bail!("{}: expected file:///path with the whole path", place.display()),
        "s3" => bucket(place),
        _ => bail!("{}: expected a folder, file:///path or s3://bucket/prefix", place.display()),
    }
}

#[cfg(feature = "object-store")]
fn bucket(place: &Path) -> anyhow::Result<Box<dyn Store>> {
    Ok(Box::new(crate::bucket::Bucket::open(place)?))
}

#[cfg(not(feature = "object-store"))]
fn bucket(place: &Path) -> anyhow::Result<Box<dyn Store>> {
    bail!(
        "{}: this build knows folders only; `cargo install --path . --features object-store` builds one that knows s3://",
        place.display()
    )
}
