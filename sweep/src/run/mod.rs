//! Runs a study, whole or one shard of it, into its folder.
//!
//! | module | holds |
//! |---|---|
//! | [`shard`] | a subset of a study's parts |
//! | `publish` | publishing parts while the next ones are computed |
//! | [`work`] | the rows of one file |
//! | [`whole`] | a study as one file or in memory, or only its statistics |

mod publish;
pub mod shard;
pub mod whole;
pub mod work;

use crate::error::Error;
use crate::file_names::{SENSITIVITY, STATISTICS};
use crate::folder::earlier::Earlier;
use crate::folder::record::{Record, statuses_of};
use crate::folder::{Folder, Found, Look};
use crate::part::new_file::keep_memory;
use crate::part::status_column::{self, StatusCounts};
use crate::progress::Progress;
use crate::sensitivity;
use crate::statistics::{self, State};
use crate::store::Store;
use crate::study::Study;
use crate::study::plan::Plan;
use publish::{Finished, publishing};
use rayon::prelude::*;
use serde_json::Value;
use shard::Shard;
use work::{Destination, Work, Workers};

/// Parts written by a run, and what it keeps and reuses.
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

/// What a run did and what already existed.
#[derive(Clone, Debug)]
pub struct Report {
    /// Parts written by this run.
    pub parts_written: u64,
    /// Existing parts of this shard.
    pub parts_found: u64,
    /// Parts rewritten because they did not match their records.
    pub parts_damaged: u64,
    /// Rows computed by this run.
    pub rows_written: u64,
    /// Rows taken from an earlier study's folder.
    pub rows_taken: u64,
    /// Bytes of this shard's parts.
    pub bytes: u64,
    /// Rows of this shard's parts by status.
    pub statuses: StatusCounts,
    /// Whether all parts of the study are in the folder and the manifest is written.
    pub complete: bool,
    /// Rows of all parts by status, once all exist.
    pub statuses_of_study: Option<StatusCounts>,
    /// Files with results alongside the rows, by name.
    pub results: Vec<&'static str>,
}

impl Report {
    /// For a complete study without any row with results: the most frequent reason, and its number of rows.
    pub fn why_without_results(&self) -> Option<(&str, u64)> {
        let statuses = self.statuses_of_study.as_ref()?;
        if statuses.keys().any(|status| status_column::has_results(status)) {
            return None;
        }
        let failures = statuses.iter().filter_map(|(status, rows)| Some((status_column::failure(status)?, *rows)));
        failures.max_by_key(|(_, rows)| *rows)
    }
}

/// Runs a shard of a study into a folder. Complete parts, checked byte for byte, are kept; once all parts of the study exist, the
/// manifest is written. May be repeated, interrupted, and run in parallel with other shards. If nothing is missing, nothing is
/// written; leftovers of killed runs are removed.
///
/// Uses the threads of the current rayon pool; memory grows with their number, not with the study's rows.
///
/// # Errors
/// The folder belongs to another study or cannot be written. Finished parts are kept.
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
    folder.clean(|part| shard.has(part))?;
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
        statuses_of_study: all.as_deref().map(statuses_of),
        results,
    })
}

/// Writes the results over all parts, then the manifest; returns the names of the files with results.
fn finish(
    study: &Study,
    folder: &Folder<'_>,
    all: &[Record],
    rows: bool,
    plan: Option<&Plan>,
) -> Result<Vec<&'static str>, Error> {
    let mut results = Vec::new();
    if rows && let Some(indices) = sensitivity::of_study(study, |part| folder.local_part(part))? {
        folder.write_result(SENSITIVITY, &indices)?;
        results.push(SENSITIVITY);
    }
    if let Some(plan) = plan
        && let Some(summary) = summary(study, plan, folder, all)?
    {
        folder.write_result(STATISTICS, &summary)?;
        results.push(STATISTICS);
    }
    folder.write_manifest(all)?;
    Ok(results)
}

/// The statistics made by a run: the study's, or all of them if nothing else is kept.
fn plan_of(study: &Study, options: Options<'_>) -> Option<Plan> {
    study.statistics.clone().or_else(|| (!options.rows).then(|| Plan::all(study.outputs())))
}

/// Adds missing statistics to the record of an existing part, from its stored rows if there are any.
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

/// The statistics of all parts, if each has them; only one part's are in memory at a time.
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

/// Computes parts and publishes them.
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
        let destination = options.rows.then_some(Destination { path: &path, staging: &staging, extra: &extra });
        let written = work.write(study.rows_of(part), destination.as_ref())?;
        let digest = written.file.as_ref().map(|file| file.digest().clone());
        let record = folder.record(part, written.statuses, digest, written.statistics);
        Ok(Finished { folder, part, record, file: written.file })
    };
    let scattered = scattered(missing);
    publishing(|publish| match workers {
        Workers::All => scattered.iter().try_for_each(|part| publish.send(one(*part)?)),
        Workers::One => scattered.par_iter().with_max_len(1).try_for_each(|part| publish.send(one(*part)?)),
    })
}

/// The same parts in a scattered order (bit-reversed indices): at any time the finished ones sample the design evenly, and the
/// rate so far predicts the rest, even if one end of an axis is slow.
fn scattered(parts: &[u64]) -> Vec<u64> {
    let bits = parts.len().next_power_of_two().trailing_zeros();
    let indices =
        (0..parts.len().next_power_of_two()).map(|i| i.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0));
    indices.filter_map(|index| parts.get(index).copied()).collect()
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
