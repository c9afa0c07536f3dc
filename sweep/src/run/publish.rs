//! Publishes parts on a separate thread while the next ones are computed, because a disk is slow.

use crate::error::Error;
use crate::folder::Folder;
use crate::folder::record::Record;
use crate::part::new_file::Ended;
use std::sync::mpsc::{SyncSender, sync_channel};

/// A part with complete contents, and its record.
pub struct Finished<'a> {
    /// The folder it belongs to.
    pub folder: &'a Folder<'a>,
    /// Its index among the study's parts, from 0.
    pub part: u64,
    /// What the run writes down of this part.
    pub record: Record,
    /// Its file, still with a temporary name; `None` if the rows are not kept.
    pub file: Option<Ended>,
}

impl Finished<'_> {
    /// Writes the record durably, then publishes the part: no part ever exists without its record.
    fn publish(self) -> Result<(), Error> {
        self.folder.write_record(self.part, &self.record)?;
        let name = self.folder.part_file(self.part);
        self.file.map_or(Ok(()), |file| file.publish(self.folder.store(), &name))
    }
}

/// Receives complete parts.
pub struct Publisher<'a>(SyncSender<Finished<'a>>);

/// Why no further file should be made.
pub enum Stop {
    /// A part could not be computed or written.
    Failed(Error),
    /// A part could not be published: the publisher has the error.
    Unpublished,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Failed(error)
    }
}

impl<'a> Publisher<'a> {
    /// Hands over a part; waits while another one is being published.
    pub fn send(&self, file: Finished<'a>) -> Result<(), Stop> {
        self.0.send(file).map_err(|_| Stop::Unpublished)
    }
}

/// Runs `make`, which makes files, and returns when all of them are published or an error occurred.
pub fn publishing<'a>(make: impl FnOnce(&Publisher<'a>) -> Result<(), Stop>) -> Result<(), Error> {
    std::thread::scope(|scope| {
        let (sender, files) = sync_channel::<Finished<'a>>(1);
        let published = scope.spawn(|| files.into_iter().try_for_each(Finished::publish));
        let publisher = Publisher(sender);
        let made = make(&publisher);
        drop(publisher);
        published.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        match made {
            Err(Stop::Failed(error)) => Err(error),
            Ok(()) | Err(Stop::Unpublished) => Ok(()),
        }
    })
}
