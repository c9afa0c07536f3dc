//! A study carried out: whole or a shard of it into a folder, or all of it into one file or into memory.

use crate::error::Error;
use crate::folder::{Folder, Part};
use crate::new_file::Ended;
use crate::part::{self, OnRows, StatusCounts, Workers};
use crate::sensitivity;
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use rayon::prelude::*;
use std::path::Path;
use std::sync::mpsc::{SyncSender, sync_channel};

/// Which of a study's parts a run writes: those whose number leaves `index` when divided by `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0 to `count` − 1.
    pub index: u64,
    /// How many shards share the study.
    pub count: u64,
}

impl Shard {
    /// All parts.
    pub const WHOLE: Shard = Shard { index: 0, count: 1 };

    /// Whether a part is this shard's.
    pub fn has(self, part: u64) -> bool {
        part % self.count == self.index
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match numbers {
            Some((index, count)) if index < count => Ok(Shard { index, count }),
            _ => Err(format!("`{text}` is no shard: I/N with I from 0 to N-1 was expected, such as 0/16")),
        }
    }
}

/// What a run did and what it found done.
#[derive(Clone, Debug)]
pub struct Report {
    /// Parts this run wrote.
    pub parts_written: u64,
    /// Parts of this shard that were there already.
    pub parts_found: u64,
    /// Rows this run computed.
    pub rows_written: u64,
    /// Bytes of this shard's parts.
    pub bytes: u64,
    /// Rows of this shard's parts by status.
    pub statuses: StatusCounts,
    /// Whether all parts of the study are in the folder now and the manifest is written.
    pub complete: bool,
}

/// Carries out a shard of a study into a folder. Parts that are there and whole stay; when all parts of the study are
/// there in the end, the manifest is written. May be repeated, interrupted, and run beside other shards.
///
/// Threads are those of the current rayon pool; memory grows with their number, not with the study's rows.
///
/// # Errors
/// The folder is another study's or cannot be written. Parts finished before stay.
pub fn run(study: &Study, folder: &Path, shard: Shard, on_rows: OnRows<'_>) -> Result<Report, Error> {
    let folder = Folder::open(study, folder)?;
    folder.clean(|part| shard.has(part))?;
    let mine: Vec<u64> = (0..study.parts).filter(|part| shard.has(*part)).collect();
    let (found, missing): (Vec<u64>, Vec<u64>) = mine.iter().partition(|part| folder.finished(**part).is_some());
    for part in &found {
        let rows = study.rows_of(*part);
        on_rows(rows.end - rows.start);
    }
    if !missing.is_empty() {
        folder.remove_manifest()?;
    }
    keep_memory();
    // Fewer files than threads: the threads share each file's rows.
    let workers = if missing.len() < rayon::current_num_threads() { Workers::All } else { Workers::One };
    let one = |part: &u64| {
        let extra = [("shard", shard.to_string()), ("part", part.to_string())];
        let path = folder.part_path(*part);
        part::write(study, study.rows_of(*part), &path, &extra, workers, on_rows).map(|(file, _)| file)
    };
    publishing(|publish| match workers {
        Workers::All => missing.iter().try_for_each(|part| publish.send(one(part)?)),
        Workers::One => missing.par_iter().with_max_len(1).try_for_each(|part| publish.send(one(part)?)),
    })?;
    let parts: Vec<Part> = mine.iter().filter_map(|part| folder.finished(*part)).collect();
    let mut statuses = StatusCounts::new();
    for (status, count) in parts.iter().flat_map(|part| &part.statuses) {
        *statuses.entry(status.clone()).or_default() += count;
    }
    let all = folder.all_finished();
    if let Some(all) = &all {
        if let Some(indices) = sensitivity::of_study(study, |part| folder.part_path(part))? {
            folder.write_json(sensitivity::FILE, &indices)?;
        }
        folder.write_manifest(all)?;
    }
    Ok(Report {
        parts_written: missing.len() as u64,
        parts_found: found.len() as u64,
        rows_written: missing.iter().map(|part| study.rows_of(*part)).map(|rows| rows.end - rows.start).sum(),
        bytes: parts.iter().map(|part| part.bytes).sum(),
        statuses,
        complete: all.is_some(),
    })
}

/// Lets the C library keep freed memory for the next pages instead of giving it back to the system after each one, which
/// costs more than the pages' compression. glibc keeps blocks up to twice the size of the largest one that it has seen
/// freed, up to 32 MiB; others take no notice.
fn keep_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
}

/// Where files go that have all their contents: a thread of its own publishes them, since a disk takes its time.
struct Publisher(SyncSender<Ended>);

/// Why no further file is to be made.
enum Stop {
    /// One could not be made.
    Failed(Error),
    /// One could not be published: the publisher knows why.
    Unpublished,
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Failed(error)
    }
}

impl Publisher {
    fn send(&self, file: Ended) -> Result<(), Stop> {
        self.0.send(file).map_err(|_| Stop::Unpublished)
    }
}

/// Lets `make` make files, and returns when all of them are published or something went wrong.
fn publishing(make: impl FnOnce(&Publisher) -> Result<(), Stop>) -> Result<(), Error> {
    std::thread::scope(|scope| {
        let (sender, files) = sync_channel::<Ended>(1);
        let published = scope.spawn(|| files.into_iter().try_for_each(Ended::publish));
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

/// Carries out a whole study into one Parquet file, which appears when it is whole; returns its rows by status.
///
/// # Errors
/// The file cannot be written; nothing remains then.
pub fn run_to_file(study: &Study, path: &Path, on_rows: OnRows<'_>) -> Result<StatusCounts, Error> {
    let extra = [("shard", Shard::WHOLE.to_string()), ("part", "0".to_owned())];
    keep_memory();
    let (file, counts) = part::write(study, 0..study.rows, path, &extra, Workers::All, on_rows)?;
    file.publish()?;
    Ok(counts)
}

/// Carries out a whole study in memory.
///
/// # Errors
/// A table of points cannot be read.
pub fn run_in_memory(study: &Study) -> Result<Vec<RecordBatch>, Error> {
    let chunks: Vec<u64> = (0..study.rows.div_ceil(part::CHUNK)).collect();
    let rows = |chunk: u64| chunk * part::CHUNK..study.rows.min((chunk + 1) * part::CHUNK);
    chunks.into_par_iter().map(|chunk| part::batch(study, rows(chunk))).collect()
}
