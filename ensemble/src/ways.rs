//! The ways in which rows are solved, and which of them a row takes.

use crate::Batch;
use crate::closed::ClosedRows;
use crate::closed::readings::Behind;
use crate::general::{GeneralRows, Kind};
use crate::instructions;
use crate::outcome::{Failure, Outcome};
use crate::own::Own;
use crate::plan;
use crate::scenario::{Scenario, Solver};
use crate::sets;
use chamber::AreaLaw;
use chamber::effects::{self, EffectSet};

/// A row whose numbers are checked, and its duration, s.
pub type Timed = (u32, f64);

/// A chunk's rows by the way they are solved, and what is kept from one chunk to the next.
#[derive(Default)]
pub struct Ways {
    own: Own,
    closed: ClosedRows,
    general: GeneralRows,
}

/// What decides how a row is solved.
pub struct Features<'a> {
    pub scenario: &'a Scenario,
    /// Its active effects, and those on the gas.
    pub active: EffectSet,
    pub of_gas: EffectSet,
    /// The sensor, where the record does not show the gas as it is.
    pub behind: Option<Behind>,
    /// Whether no gas enters or leaves but by effects, and the piston follows the ramp.
    pub is_sealed: bool,
    pub is_swept: bool,
    /// Whether the integrator is asked for, or closed forms only.
    pub integrates: bool,
    pub is_exact: bool,
    /// Whether there are wide instructions.
    pub is_wide: bool,
}

impl<'a> Features<'a> {
    #[inline]
    fn of(scenario: &'a Scenario, Batch { arch, options, .. }: Batch) -> Self {
        let active = scenario.chamber.active();
        let shown = active.intersection(effects::of_sensor());
        Self {
            scenario,
            active,
            of_gas: sets::on_the_gas(active),
            behind: (!shown.is_empty()).then(|| Behind::new(shown, scenario)),
            is_sealed: scenario.is_sealed(),
            is_swept: scenario.chamber.geometry.area_law == AreaLaw::Swept,
            integrates: options.solver == Solver::Adaptive,
            is_exact: options.solver == Solver::Exact,
            is_wide: instructions::is_wide(arch),
        }
    }
}

impl Ways {
    /// Solves a chunk of scenarios into the outcomes of the same index.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        let Batch { scenarios, .. } = batch;
        self.closed.clear();
        self.general.clear();
        for (row, (scenario, out)) in scenarios.iter().zip(&mut *out).enumerate() {
            if let Err(reason) = self.add(row as u32, set, &Features::of(scenario, batch)) {
                *out = Outcome::failed(reason);
            }
        }
        for (list, kind) in self.own.lists() {
            for row in list.solve(batch, out) {
                if let Err(reason) = self.general.add(row, kind, set, &Features::of(&scenarios[row as usize], batch)) {
                    out[row as usize] = Outcome::failed(reason);
                }
            }
        }
        self.closed.solve(set, batch, out);
        self.general.solve(set, batch, out);
    }

    /// Adds a row to those that are solved in its way.
    #[inline]
    fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        let rows = if self.closed.takes(features) {
            self.closed.rows_like(features)
        } else if features.is_exact {
            return Err(Failure::NoExactSolution);
        } else if let Some(rows) = self.own.rows_like(features) {
            rows
        } else {
            return self.general.add(row, Kind::of(features), set, features);
        };
        plan::check(set, features.active, features.scenario)?;
        let (_, duration) = plan::times(features.scenario)?;
        rows.push((row, duration));
        Ok(())
    }
}
