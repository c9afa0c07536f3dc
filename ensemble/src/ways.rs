//! The ways in which rows are solved, and which of them a row takes.

use crate::batch::Batch;
use crate::closed::ClosedRows;
use crate::features::Features;
use crate::general::GeneralRows;
use crate::outcome::{Failure, Outcome};
use crate::own::Own;
use crate::plan;
use chamber::effects::EffectSet;

/// A chunk's rows by the way they are solved, and what is kept from one chunk to the next.
#[derive(Default)]
pub struct Ways {
    own: Own,
    closed: ClosedRows,
    general: GeneralRows,
}

impl Ways {
    /// Solves a chunk of scenarios into the outcomes of the same index.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        let Batch { scenarios, .. } = batch;
        for (row, (scenario, out)) in scenarios.iter().zip(&mut *out).enumerate() {
            if let Err(reason) = self.add(row as u32, set, &Features::of(scenario, batch)) {
                *out = Outcome::failed(reason);
            }
        }
        for list in self.own.lists() {
            for row in list.solve(batch, out) {
                if let Err(reason) = self.general.add(row, set, &Features::of(&scenarios[row as usize], batch)) {
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
        let rows = if let Some(rows) = self.closed.rows_like(features) {
            rows
        } else if features.is_exact {
            return Err(Failure::NoExactSolution);
        } else if let Some(rows) = self.own.rows_like(features) {
            rows
        } else {
            return self.general.add(row, set, features);
        };
        plan::check(set, features.active, features.scenario)?;
        rows.push(row);
        Ok(())
    }
}
