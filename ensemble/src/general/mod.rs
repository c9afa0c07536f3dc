//! Rows with any effects by the integrator: the general equations ([`equations`]), compiled for common sets of effects
//! ([`compiled`]), integrated span by span ([`integration`]).

pub mod compiled;
pub mod equations;
pub mod history;
mod integration;
mod kind;
mod relaxation;
pub mod relaxation_rows;
mod wall_conduction;

use crate::batch::{Batch, Features};
use crate::outcome::{Failure, Outcome};
use crate::plan::Plan;
use chamber::effects::EffectSet;
use kind::Kind;

/// A chunk's rows by kind and area law, which the lanes must have in common.
#[derive(Default)]
pub struct GeneralRows {
    /// Indices of the rows, and their plans.
    lists: [Vec<(u32, Plan)>; 2 * Kind::ALL.len()],
    memory: integration::Memory,
}

impl GeneralRows {
    /// Checks and plans a row and adds it to its list.
    pub fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        let plan = Plan::new(set, features.active, features.scenario)?;
        self.lists[usize::from(features.is_swept) + 2 * Kind::of(features) as usize].push((row, plan));
        Ok(())
    }

    /// Solves all rows and empties the lists.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        for (number, rows) in self.lists.iter_mut().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            compiled::integrate(batch, &mut self.memory, set, Kind::ALL[number / 2], rows, out);
            rows.clear();
        }
    }
}
