//! Parts put in their places by threads of their own while the next ones are computed: a disk takes its time, and less of it
//! for two parts at once than for one after the other.

use crate::error::Error;
use crate::folder::Folder;
use crate::folder::record::Record;
use crate::part::new_file::Ended;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};

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
    /// Makes the record last and at the same time the part's contents, then the part under its name: no part is ever there
    /// without its record.
    fn publish(self) -> Result<(), Error> {
        let Self { folder, part, record, file } = &self;
        std::thread::scope(|scope| {
            let settled = file.as_ref().map(|file| scope.spawn(|| file.settle(folder.store())));
            folder.write_record(*part, record)?;
            settled.map_or(Ok(()), |thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        })?;
        let name = folder.part_file(*part);
        let store = folder.store();
        self.file.map_or(Ok(()), |file| file.publish(store, &name))
    }
}

/// Where parts go that have all their contents.
pub struct Publisher<'a>(SyncSender<Finished<'a>>);

/// Parts that are put in their places at the same time.
const TOGETHER: usize = 2;

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
    let (sender, files) = sync_channel::<Finished<'a>>(1);
    // None after a failure: what is then sent is refused.
    let files = Mutex::new(Some(files));
    let lock = || files.lock().unwrap_or_else(PoisonError::into_inner);
    let next = || lock().as_ref()?.recv().ok();
    let publish = || {
        let published = std::iter::from_fn(next).try_for_each(Finished::publish);
        published.inspect_err(|_| *lock() = None)
    };
    std::thread::scope(|scope| {
        let publishers = [(); TOGETHER].map(|()| scope.spawn(publish));
        let made = make(&Publisher(sender));
        let published = publishers.map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        published.into_iter().collect::<Result<(), Error>>()?;
        match made {
            Err(Stop::Failed(error)) => Err(error),
            Ok(()) | Err(Stop::Unpublished) => Ok(()),
        }
    })
}
