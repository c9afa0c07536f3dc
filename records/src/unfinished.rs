//! Files being written: an interrupted program removes them.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A list of files being written.
#[derive(Debug)]
pub struct Unfinished(Mutex<Vec<PathBuf>>);

/// A file that stays on the list during this entry's lifetime.
#[derive(Debug)]
pub struct Entry<'a> {
    list: &'a Unfinished,
    path: &'a Path,
}

impl Unfinished {
    /// An empty list.
    pub const fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Puts a file on the list.
    pub fn begin<'a>(&'a self, path: &'a Path) -> Entry<'a> {
        if let Ok(mut list) = self.0.lock() {
            list.push(path.to_owned());
        }
        Entry { list: self, path }
    }

    /// Removes all files on the list.
    pub fn remove(&self) {
        if let Ok(mut list) = self.0.lock() {
            // A file that cannot be removed is left to a later cleanup of the folder.
            list.drain(..).for_each(|path| drop(std::fs::remove_file(path)));
        }
    }
}

impl Drop for Entry<'_> {
    fn drop(&mut self) {
        if let Ok(mut list) = self.list.0.lock() {
            list.retain(|path| path != self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_half_written_is_removed_and_what_is_whole_stays() {
        let folder = tempfile::tempdir().unwrap();
        let [half, whole] = ["half", "whole"].map(|name| folder.path().join(name));
        std::fs::write(&half, "ha").unwrap();
        std::fs::write(&whole, "whole").unwrap();
        let list = Unfinished::new();
        drop(list.begin(&whole));
        let _half = list.begin(&half);
        list.remove();
        assert!(!half.exists() && whole.exists());
    }
}
