//! Solves points: rows become scenarios, which the kernel of `ensemble` simulates.

use crate::error::Error;
use crate::progress::Progress;
use crate::quantity::point::Point;
use crate::result::RowResult;
use crate::result::outputs::Output;
use crate::result::status::Status;
use crate::row;
use crate::study::Study;
use chamber::effects::EffectSet;
use ensemble::{Kernel, Options, Outcome, Scenario};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Some rows of a study by column.
pub struct Rows {
    /// Index of the first of these rows in the study.
    pub first: u64,
    /// Values of the varied quantities, a column each.
    pub points: Vec<Vec<f64>>,
    /// The study's computed columns, NaN for missing values.
    pub outputs: Vec<Vec<f64>>,
    /// Status of each row.
    pub statuses: Vec<Status>,
}

impl Rows {
    /// Empty columns with the study's layout.
    pub fn none(study: &Study) -> Self {
        let columns = |count| vec![Vec::new(); count];
        let (points, outputs) = (columns(study.varied.len()), columns(study.outputs().count()));
        Self { first: 0, points, outputs, statuses: Vec::new() }
    }

    /// Appends the rows that follow these.
    pub fn append(&mut self, mut later: Rows) {
        let columns = self.points.iter_mut().chain(&mut self.outputs);
        columns.zip(later.points.iter_mut().chain(&mut later.outputs)).for_each(|(column, later)| column.append(later));
        self.statuses.append(&mut later.statuses);
    }
}

/// Solves rows of a study on one thread, reusing its memory.
pub struct RowSolver<'a> {
    study: &'a Study,
    effects: EffectSet,
    options: Options,
    kernel: Kernel,
    point: Point,
    scenarios: Vec<Scenario>,
    outcomes: Vec<Outcome>,
    results: Vec<RowResult>,
    progress: &'a dyn Progress,
    /// Number of rows solved together: as many as take about [`TOGETHER`].
    piece: usize,
}

/// Longest time for a piece of rows without a progress report.
const TOGETHER: Duration = Duration::from_millis(200);
/// Minimum number of rows solved together: enough to fill a few registers.
const FEWEST: usize = 64;
/// Results converted to columns together: they fit into a core's first-level cache.
const BLOCK: usize = 64;

impl<'a> RowSolver<'a> {
    /// A solver for the rows of `study`.
    pub fn new(study: &'a Study) -> Self {
        Self {
            study,
            effects: study.effects(),
            options: Options { solver: study.solver, relative_tolerance: study.tolerance, fit: study.fit },
            kernel: Kernel::default(),
            point: study.base,
            scenarios: vec![row::no_test(study); ensemble::CHUNK],
            outcomes: vec![Outcome::failed(ensemble::Failure::TooManySteps); ensemble::CHUNK],
            results: Vec::with_capacity(ensemble::CHUNK),
            progress: &|_: u64| {},
            piece: FEWEST,
        }
    }

    /// The same solver, reporting rows as they are solved.
    pub fn with_progress(self, progress: &'a dyn Progress) -> Self {
        Self { progress, ..self }
    }

    /// Solves some rows, in pieces that fit into a core's cache.
    ///
    /// # Errors
    /// A table of points cannot be read.
    pub fn rows(&mut self, rows: Range<u64>) -> Result<Rows, Error> {
        let count = (rows.end - rows.start) as usize;
        let empty = || Vec::with_capacity(count);
        let mut points: Vec<Vec<f64>> = self.study.varied.iter().map(|_| empty()).collect();
        self.study.design.fill(rows.clone(), &mut points)?;
        let wanted: Vec<&Output> = self.study.outputs().collect();
        let mut outputs: Vec<Vec<f64>> = wanted.iter().map(|_| empty()).collect();
        let mut statuses = Vec::with_capacity(count);
        let mut start = 0;
        while start < count {
            let (begun, end) = (Instant::now(), count.min(start + self.piece));
            self.solve(&points, start..end);
            for results in self.results.chunks(BLOCK) {
                for (output, column) in wanted.iter().zip(&mut outputs) {
                    (output.append)(results, column);
                }
                statuses.extend(results.iter().map(|row| row.status));
            }
            self.progress.solved((end - start) as u64);
            start = end;
            self.piece = match begun.elapsed() {
                long if long > TOGETHER => (self.piece / 2).max(FEWEST),
                short if 4 * short < TOGETHER => (self.piece * 2).min(ensemble::CHUNK),
                _ => self.piece,
            };
        }
        Ok(Rows { first: rows.start, points, outputs, statuses })
    }

    /// Solves the points at some indices of their columns into `results`.
    fn solve(&mut self, points: &[Vec<f64>], indices: Range<usize>) {
        let count = indices.len();
        let mut impossible = Vec::new();
        for (i, index) in indices.enumerate() {
            self.study.vary(&mut self.point, points, index);
            let scenario = &mut self.scenarios[i];
            if let Err(status) = row::set_scenario(self.study, &self.point, scenario) {
                impossible.push((i, status));
                // A pressure that the kernel refuses at once.
                scenario.initial_pressure_pa = f64::NAN;
            }
        }
        let (scenarios, outcomes) = (&self.scenarios[..count], &mut self.outcomes[..count]);
        self.kernel.run(self.effects, scenarios, &self.options, outcomes);
        self.results.clear();
        self.results.extend(
            scenarios
                .iter()
                .zip(outcomes)
                .map(|(scenario, outcome)| RowResult::new(scenario, outcome, self.options.fit)),
        );
        for (i, status) in impossible {
            self.results[i] = RowResult::without(status);
        }
    }
}
