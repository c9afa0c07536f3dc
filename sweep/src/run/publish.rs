//! Parts put in their places by a thread of its own while the next ones are computed: a disk takes its time.

use crate::error::Error;
use crate::folder::Folder;
use crate::folder::record::Record;
use crate::part::new_file::Ended;
use std::sync::mpsc::{SyncSender, sync_channel};

/// A part that has all its contents, and what is to be known of it.
pub struct Finished<'a> {
    /// The folder it belongs to.
    pub folder: &'a Folder<'a>,
    /// Its number among the study's parts, from 0.
    pub part: u64,
    /// What is known of it.
    pub record: Record,
    /// Its file, still under a temporary name; none where the rows are not kept.
    pub file: Option<Ended>,
}

impl Finished<'_> {
    /// Makes the record last, then the part under its name: no part is ever there without its record.
    fn publish(self) -> Result<(), Error> {
        self.folder.write_record(self.part, &self.record)?;
        let name = self.folder.part_file(self.part);
        self.file.map_or(Ok(()), |file| file.publish(self.folder.store(), &name))
    }
}

/// Where parts go that have all their contents.
pub struct Publisher<'a>(SyncSender<Finished<'a>>);

/// Why no further file is to be made.
pub enum Stop {
    /// A part could not be computed or written.
    Failed(Error),
    /// One could not be published: the publisher knows why.
    Unpublished,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Failed(error)
    }
}

impl<'a> Publisher<'a> {
    /// Hands a part over; waits while another one is on its way.
    pub fn send(&self, file: Finished<'a>) -> Result<(), Stop> {
        self.0.send(file).map_err(|_| Stop::Unpublished)
    }
}

/// Lets `make` make files, and returns when all of them are published or something went wrong.
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
