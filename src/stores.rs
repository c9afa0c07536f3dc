//! Where a study's folder may be: a path, `file:///path`, or, in a build with the feature `object-store`,
//! `s3://bucket/prefix`.

use anyhow::bail;
use std::path::Path;
use sweep::folder::RECORDS;
use sweep::store::{Local, Store};

/// Does some work in the folder of a study.
///
/// # Errors
/// The place is none, or what the work says.
pub fn within<T>(place: &Path, work: impl FnOnce(&dyn Store) -> anyhow::Result<T>) -> anyhow::Result<T> {
    let Some((scheme, rest)) = place.to_str().and_then(|text| text.split_once("://")) else {
        return work(&Local::new(place, RECORDS));
    };
    match scheme {
        "file" if rest.starts_with('/') => work(&Local::new(Path::new(rest), RECORDS)),
        "file" => bail!("{}: file:///path with the whole path was expected", place.display()),
        "s3" => in_bucket(place, work),
        _ => bail!("{}: a folder, file:///path or s3://bucket/prefix was expected", place.display()),
    }
}

#[cfg(feature = "object-store")]
fn in_bucket<T>(place: &Path, work: impl FnOnce(&dyn Store) -> anyhow::Result<T>) -> anyhow::Result<T> {
    work(&crate::bucket::Bucket::open(place)?)
}

#[cfg(not(feature = "object-store"))]
fn in_bucket<T>(place: &Path, _: impl FnOnce(&dyn Store) -> anyhow::Result<T>) -> anyhow::Result<T> {
    bail!(
        "{}: this build knows folders only; `cargo install --path . --features object-store` builds one that knows s3://",
        place.display()
    )
}
