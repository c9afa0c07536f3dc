//! A study carried out: whole or a shard of it into a folder, or all of it into one file or into memory.

use crate::chunk::{CHUNK, chunks};
use crate::earlier::Earlier;
use crate::error::Error;
use crate::file_names::{SENSITIVITY, STATISTICS};
use crate::folder::{Folder, Found, Look};
use crate::new_file::Ended;
use crate::part::{self, Place, Work, Workers};
use crate::progress::Progress;
use crate::record::{Record, statuses_of};
use crate::sensitivity;
use crate::statistics::{self, Plan, State};
use crate::status_column::{StatusCounts, add_counts};
use crate::store::{Local, Store};
use crate::study::Study;
use arrow::record_batch::RecordBatch;
use rayon::prelude::*;
use serde_json::Value;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};

/// Which of a study's parts a run writes: those whose number leaves `index` when divided by `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of this shard, from 0 to `count` − 1.
    pub index: u64,
    /// How many shards share the study.
    pub count: u64,
}

impl Shard {
    /// The only shard of a study: all parts.
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
            _ => Err(format!("`{text}` is no shard; expected I/N with I from 0 to N-1, such as 0/16")),
        }
    }
}

/// Which parts a run writes, and what it keeps and reuses.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// Parts that this run writes.
    pub shard: Shard,
    /// Whether the rows are written; otherwise only their statistics.
    pub rows: bool,
    /// A smaller study whose rows are taken instead of solved again.
    pub earlier: Option<&'a Earlier>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self { shard: Shard::WHOLE, rows: true, earlier: None }
    }
}

impl From<Shard> for Options<'_> {
    fn from(shard: Shard) -> Self {
        Self { shard, ..Self::default() }
    }
}

/// What a run did and what it found done.
#[derive(Clone, Debug)]
pub struct Report {
    /// Parts this run wrote.
    pub parts_written: u64,
    /// Parts of this shard that were there already.
    pub parts_found: u64,
    /// Of those written, parts that had been there and were not what their record said.
    pub parts_damaged: u64,
    /// Rows this run computed.
    pub rows_written: u64,
    /// Rows this run took from an earlier study's folder.
    pub rows_taken: u64,
    /// Bytes of this shard's parts.
    pub bytes: u64,
    /// Rows of this shard's parts by status.
    pub statuses: StatusCounts,
    /// Whether all parts of the study are in the folder now and the manifest is written.
    pub complete: bool,
    /// Files with results beside the rows, by name.
    pub results: Vec<&'static str>,
}

/// Carries out a shard of a study into a folder. Parts that are there and whole, which is checked byte for byte, stay;
/// when all parts of the study are there in the end, the manifest is written. May be repeated, interrupted, and run
/// beside other shards. Where nothing is missing nothing is written.
///
/// Threads are those of the current rayon pool; memory grows with their number, not with the study's rows.
///
/// # Errors
/// The folder is another study's or cannot be written. Parts finished before stay.
pub fn run<'a>(
    study: &Study,
    store: &dyn Store,
    options: impl Into<Options<'a>>,
    progress: &dyn Progress,
) -> Result<Report, Error> {
    let options: Options<'_> = options.into();
    let Options { shard, rows, earlier } = options;
    let plan = plan_of(study, options);
    let folder = Folder::open(study, store)?;
    let mine: Vec<u64> = (0..study.parts).filter(|part| shard.has(*part)).collect();
    let look = |part: &u64| (*part, folder.find(*part, rows, Look::Contents));
    let looked: Vec<(u64, Found)> = mine.par_iter().map(look).collect();
    let is_whole = |found: &Found| matches!(found, Found::Whole(_));
    let missing: Vec<u64> = looked.iter().filter(|(_, found)| !is_whole(found)).map(|(part, _)| *part).collect();
    let found = looked.iter().filter(|(_, found)| is_whole(found)).map(|(part, _)| study.rows_of(*part));
    progress.found(found.map(|rows| rows.end - rows.start).sum());
    let damaged = looked.iter().filter(|(_, found)| *found == Found::Damaged).count() as u64;
    if !missing.is_empty() {
        folder.prepare()?;
        folder.clean(|part| shard.has(part))?;
        folder.remove_manifest()?;
        write(study, &folder, &missing, options, plan.as_ref(), progress)?;
    }
    if let Some(plan) = &plan {
        mine.par_iter().try_for_each(|part| add_statistics(study, &folder, *part, rows, plan, progress))?;
    }
    let parts: Vec<Record> = mine.iter().filter_map(|part| folder.find(*part, rows, Look::Length).whole()).collect();
    let (mut rows_written, mut rows_taken) = (0, 0);
    for rows in missing.iter().map(|part| study.rows_of(*part)) {
        let taken = earlier.map_or(0, |earlier| earlier.count(&rows));
        rows_taken += taken;
        rows_written += rows.end - rows.start - taken;
    }
    let all = folder.all_finished(rows);
    let results = match &all {
        Some(all) => finish(study, &folder, all, rows, plan.as_ref())?,
        None => Vec::new(),
    };
    Ok(Report {
        parts_written: missing.len() as u64,
        parts_found: (mine.len() - missing.len()) as u64,
        parts_damaged: damaged,
        rows_written,
        rows_taken,
        bytes: parts.iter().filter_map(|part| part.file.as_ref()).map(|file| file.bytes).sum(),
        statuses: statuses_of(&parts),
        complete: all.is_some(),
        results,
    })
}

/// Writes what the rows of all parts come to, then the manifest; names of the files with results.
fn finish(
    study: &Study,
    folder: &Folder<'_>,
    all: &[Record],
    rows: bool,
    plan: Option<&Plan>,
) -> Result<Vec<&'static str>, Error> {
    let mut results = Vec::new();
    if rows && let Some(indices) = sensitivity::of_study(study, |part| folder.local_part(part))? {
        folder.write_json(SENSITIVITY, &indices)?;
        results.push(SENSITIVITY);
    }
    if let Some(plan) = plan
        && let Some(summary) = summary(study, plan, folder, all)?
    {
        folder.write_json(STATISTICS, &summary)?;
        results.push(STATISTICS);
    }
    folder.write_manifest(all)?;
    Ok(results)
}

/// The statistics that a run makes: the study's, or all of them where nothing else is kept.
fn plan_of(study: &Study, options: Options<'_>) -> Option<Plan> {
    study.statistics.clone().or_else(|| (!options.rows).then(|| Plan::all(study.outputs())))
}

/// Gives a part that was found the statistics that its record does not have, from its stored rows where there are some.
fn add_statistics(
    study: &Study,
    folder: &Folder<'_>,
    part: u64,
    rows: bool,
    plan: &Plan,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let Found::Whole(record) = folder.find(part, rows, Look::Length) else { return Ok(()) };
    if folder.statistics(part).is_some_and(|state| state.plan == plan.identity()) {
        return Ok(());
    }
    let state = match &record.file {
        Some(_) => statistics::of_file(plan, folder.local_part(part)?.path(), record.first_row)?,
        None => {
            let work = Work { plan: Some(plan), workers: Workers::One, ..Work::new(study, progress) };
            let written = work.write(study.rows_of(part), None)?;
            written.statistics.unwrap_or_else(|| State::new(plan))
        }
    };
    folder.write_record(part, &Record { statistics: Some(state), ..record })
}

/// The statistics of all parts, if each has its own; one part's are in memory at a time.
fn summary(study: &Study, plan: &Plan, folder: &Folder<'_>, parts: &[Record]) -> Result<Option<Value>, Error> {
    let mut total = State::new(plan);
    for part in 0..study.parts {
        match folder.statistics(part) {
            Some(state) if state.plan == total.plan => total.merge(&state),
            _ => return Ok(None),
        }
    }
    total.summary(study, plan, &statuses_of(parts)).map(Some)
}

/// Computes parts and puts them in their places.
fn write(
    study: &Study,
    folder: &Folder<'_>,
    missing: &[u64],
    options: Options<'_>,
    plan: Option<&Plan>,
    progress: &dyn Progress,
) -> Result<(), Error> {
    keep_memory();
    // Fewer files than threads: the threads share each file's rows.
    let workers = if missing.len() < rayon::current_num_threads() { Workers::All } else { Workers::One };
    let work = Work { study, plan, earlier: options.earlier, workers, progress };
    let staging = folder.staging()?;
    let one = |part: u64| -> Result<Finished<'_>, Error> {
        let extra = [("shard", options.shard.to_string()), ("part", part.to_string())];
        let path = folder.path(&folder.part_file(part));
        let place = options.rows.then_some(Place { path: &path, staging: &staging, extra: &extra });
        let written = work.write(study.rows_of(part), place.as_ref())?;
        let record = folder.record(part, &written);
        Ok(Finished { folder, part, record, file: written.file })
    };
    let scattered = scattered(missing);
    publishing(|publish| match workers {
        Workers::All => scattered.iter().try_for_each(|part| publish.send(one(*part)?)),
        Workers::One => scattered.par_iter().with_max_len(1).try_for_each(|part| publish.send(one(*part)?)),
    })
}

/// The same parts, one after the other far from each other (by the reversed bits of their places): what is done at any
/// time is a fair share of the design, and the rate so far that of the rest, though one end of an axis may be slow.
fn scattered(parts: &[u64]) -> Vec<u64> {
    let bits = parts.len().next_power_of_two().trailing_zeros();
    let places =
        (0..parts.len().next_power_of_two()).map(|i| i.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0));
    places.filter_map(|place| parts.get(place).copied()).collect()
}

/// Lets the C library keep freed memory for the next pages instead of giving it back to the system after each one, which
/// costs more than the pages' compression. glibc keeps blocks up to twice the size of the largest one that it has seen
/// freed, up to 32 MiB; others take no notice.
fn keep_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(31 << 20)));
}

/// A part that has all its contents, and what is to be known of it.
struct Finished<'a> {
    folder: &'a Folder<'a>,
    part: u64,
    record: Record,
    file: Option<Ended>,
}

impl Finished<'_> {
    /// Makes the record last, then the part under its name: no part is ever there without its record.
    fn publish(self) -> Result<(), Error> {
        self.folder.write_record(self.part, &self.record)?;
        let name = self.folder.part_file(self.part);
        self.file.map_or(Ok(()), |file| file.publish(self.folder.store(), &name))
    }
}

/// Where parts go that have all their contents: a thread of its own publishes them, since a disk takes its time.
struct Publisher<'a>(SyncSender<Finished<'a>>);

/// Why no further file is to be made.
enum Stop {
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
    fn send(&self, file: Finished<'a>) -> Result<(), Stop> {
        self.0.send(file).map_err(|_| Stop::Unpublished)
    }
}

/// Lets `make` make files, and returns when all of them are published or something went wrong.
fn publishing<'a>(make: impl FnOnce(&Publisher<'a>) -> Result<(), Stop>) -> Result<(), Error> {
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

/// Carries out a whole study into one Parquet file, which appears when it is whole; returns its rows by status.
///
/// # Errors
/// The file cannot be written; nothing remains then.
pub fn run_to_file(study: &Study, path: &Path, progress: &dyn Progress) -> Result<StatusCounts, Error> {
    let extra = [("shard", Shard::WHOLE.to_string()), ("part", "0".to_owned())];
    keep_memory();
    let folder = path.parent().unwrap_or(Path::new(""));
    let place = Place { path, staging: folder, extra: &extra };
    let written = Work::new(study, progress).write(0..study.rows, Some(&place))?;
    if let Some(file) = written.file {
        file.publish(&Local::new(folder), &path.file_name().unwrap_or_default().to_string_lossy())?;
    }
    Ok(written.statuses)
}

/// The statistics of a whole study, as `statistics.json` of a folder has them; nothing is written.
///
/// # Errors
/// A table of points cannot be read.
pub fn statistics(study: &Study, plan: &Plan, progress: &dyn Progress) -> Result<Value, Error> {
    let (mut total, mut statuses) = (State::new(plan), StatusCounts::new());
    let work = Work { plan: Some(plan), ..Work::new(study, progress) };
    for part in 0..study.parts {
        let written = work.write(study.rows_of(part), None)?;
        written.statistics.iter().for_each(|state| total.merge(state));
        add_counts(&mut statuses, &written.statuses);
    }
    total.summary(study, plan, &statuses)
}

/// The rows of a study, batch after batch, in order: a wave of chunks is computed by all threads of the current pool when
/// the one before is used up, so that memory does not grow with the study.
pub fn batches(study: Arc<Study>) -> impl Iterator<Item = Result<RecordBatch, Error>> + Send {
    let wave = CHUNK * 2 * rayon::current_num_threads() as u64;
    let waves = (0..study.rows).step_by(wave as usize);
    waves.flat_map(move |begin| computed(&study, begin..study.rows.min(begin + wave)))
}

/// Carries out a whole study in memory.
///
/// # Errors
/// A table of points cannot be read.
pub fn run_in_memory(study: &Study) -> Result<Vec<RecordBatch>, Error> {
    computed(study, 0..study.rows).into_iter().collect()
}

/// Some rows as batches, computed by all threads of the current pool.
fn computed(study: &Study, rows: Range<u64>) -> Vec<Result<RecordBatch, Error>> {
    chunks(rows).into_par_iter().map(|rows| part::batch(study, rows)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_parts_are_the_same_parts_and_any_beginning_is_spread_over_all() {
        for count in [0, 1, 2, 3, 16, 23] {
            let parts: Vec<u64> = (0..count).collect();
            let mut sorted = scattered(&parts);
            sorted.sort_unstable();
            assert_eq!(sorted, parts);
        }
        assert_eq!(scattered(&(0..16).collect::<Vec<_>>())[..4], [0, 8, 4, 12]);
    }
}
