//! One file: its rows are computed chunk by chunk, written and summarised as they arrive.

use crate::error::Error;
use crate::folder::earlier::{Earlier, EarlierReader};
use crate::part::new_file::{Ended, NewFile};
use crate::part::status_column::{StatusCounts, Statuses};
use crate::part::{columns, encoding};
use crate::progress::Progress;
use crate::row::chunk::chunks;
use crate::row::solve::{RowSolver, Rows};
use crate::statistics::State;
use crate::study::Study;
use crate::study::plan::Plan;
use rayon::prelude::*;
use serde_json::json;
use std::ops::Range;
use std::path::Path;

/// Chunks of one file in memory per thread.
const CHUNKS_PER_THREAD: usize = 4;

/// Threads that compute the rows of one file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workers {
    /// The calling thread: others are busy with other files.
    One,
    /// All threads of the pool.
    All,
}

/// Destination of a part's rows.
pub struct Destination<'a> {
    /// Final path of the file, for error messages.
    pub path: &'a Path,
    /// The folder it is written in until complete.
    pub staging: &'a Path,
    /// Further entries of its metadata.
    pub extra: &'a [(&'a str, String)],
}

/// How the rows of one file are computed and summarised.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    /// The study whose rows they are.
    pub study: &'a Study,
    /// The requested statistics, if any.
    pub plan: Option<&'a Plan>,
    /// A smaller study whose rows are taken instead of solved again.
    pub earlier: Option<&'a Earlier>,
    /// Threads that compute.
    pub workers: Workers,
    /// Receives the progress.
    pub progress: &'a dyn Progress,
}

impl<'a> Work<'a> {
    /// Solves all rows, on all threads, without statistics.
    pub fn new(study: &'a Study, progress: &'a dyn Progress) -> Self {
        Self { study, plan: None, earlier: None, workers: Workers::All, progress }
    }

    /// Computes some rows of the study, into a new, still unpublished file if a destination is given.
    ///
    /// # Errors
    /// The file cannot be written, or a table of points cannot be read; nothing is left behind.
    pub fn write(&self, rows: Range<u64>, destination: Option<&Destination<'_>>) -> Result<Written, Error> {
        let study = self.study;
        let schema = columns::schema(study);
        let create = |destination: &Destination<'_>| {
            let properties = encoding::properties(study, &schema, destination.extra);
            NewFile::create(destination.staging, destination.path, schema.clone(), properties)
        };
        let mut file = destination.map(create).transpose()?;
        let mut statuses = Statuses::new(study);
        let mut statistics = self.plan.map(|plan| (plan, State::new(plan), column_indices(study, plan)));
        let mut source = Source::new(*self, &rows);
        let together = if self.workers == Workers::All { CHUNKS_PER_THREAD * rayon::current_num_threads() } else { 1 };
        for wave in chunks(rows).chunks(together) {
            for rows in source.rows(wave) {
                let rows = rows?;
                if let Some((plan, state, indices)) = &mut statistics {
                    state.add(plan, rows.first, indices.iter().map(|index| rows.outputs[*index].as_slice()));
                }
                match &mut file {
                    Some(file) => file.write(&columns::batch(study, &schema, rows, &mut statuses)?)?,
                    None => statuses.count_all(&rows.statuses),
                }
            }
        }
        let counts = statuses.counts();
        if let Some(file) = &mut file {
            file.note("status_counts", json!(counts).to_string());
        }
        let statistics = statistics.map(|(_, state, _)| state);
        Ok(Written { file: file.map(NewFile::end).transpose()?, statuses: counts, statistics })
    }
}

/// Source of the rows of one file: the solver or, where they exist, an earlier study's folder.
struct Source<'a> {
    work: Work<'a>,
    solver: RowSolver<'a>,
    reader: Option<EarlierReader<'a>>,
}

impl<'a> Source<'a> {
    /// For at most these `rows`.
    fn new(work: Work<'a>, rows: &Range<u64>) -> Self {
        let Work { study, progress, .. } = work;
        let earlier = work.earlier.filter(|earlier| earlier.count(rows) > 0);
        Self {
            work: Work { earlier, ..work },
            solver: RowSolver::new(study).with_progress(progress),
            reader: earlier.map(|earlier| EarlierReader::new(earlier, study, progress)),
        }
    }

    /// The rows of some chunks, in order.
    fn rows(&mut self, wave: &[Range<u64>]) -> Vec<Result<Rows, Error>> {
        let Work { study, earlier, workers, progress, .. } = self.work;
        let (solver, is_there) = (&mut self.solver, |rows| earlier.is_some_and(|earlier| earlier.count(rows) > 0));
        match (workers, &mut self.reader) {
            (_, Some(reader)) if wave.iter().any(is_there) => {
                wave.iter().map(|rows| reader.rows(rows.clone(), solver)).collect()
            }
            (Workers::One, _) => wave.iter().map(|rows| solver.rows(rows.clone())).collect(),
            (Workers::All, _) => {
                let new = || RowSolver::new(study).with_progress(progress);
                wave.par_iter().map_init(new, |solver, rows| solver.rows(rows.clone())).collect()
            }
        }
    }
}

/// Indices of a plan's columns among the study's computed ones.
fn column_indices(study: &Study, plan: &Plan) -> Vec<usize> {
    let index = |name: &String| study.outputs().position(|output| output.name == name);
    plan.columns.iter().filter_map(index).collect()
}

/// A part after its rows were computed.
pub struct Written {
    /// Their file, still to be published, if there was a destination for one.
    pub file: Option<Ended>,
    /// Number of rows with each status.
    pub statuses: StatusCounts,
    /// Their statistics, if requested.
    pub statistics: Option<State>,
}
