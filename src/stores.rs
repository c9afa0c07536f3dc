//! Where a study's folder may be: a path or `file:///path`.

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
        _ => bail!("{}: a folder or file:///path was expected", place.display()),
    }
}
