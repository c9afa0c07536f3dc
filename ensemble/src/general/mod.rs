//! Rows of any chamber by the integrator: the equations of all of them ([`equations`]), in code for their set of effects where there
//! is some ([`compiled`]), stretch after stretch ([`course`]).

pub mod compiled;
mod course;
pub mod equations;
pub mod history;
mod kind;
mod relaxation;
pub mod relaxing_rows;
mod remembering;

use crate::batch::Batch;
use crate::features::Features;
use crate::outcome::{Failure, Outcome};
use crate::plan::Plan;
use chamber::effects::EffectSet;
use kind::Kind;

/// A chunk's rows that are integrated so, by kind and area law: what lanes must have in common.
#[derive(Default)]
pub struct GeneralRows {
    lists: [Planned; 2 * Kind::ALL.len()],
    memory: course::Memory,
}

impl GeneralRows {
    /// Plans one more, unless it cannot be solved.
    pub fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        self.lists[usize::from(features.is_swept) + 2 * Kind::of(features) as usize].add(row, set, features)
    }

    /// Solves all, after which there are none.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        for (number, list) in self.lists.iter_mut().enumerate().filter(|(_, list)| list.count > 0) {
            let rows = &list.rows[..std::mem::take(&mut list.count)];
            compiled::course(batch, &mut self.memory, set, Kind::ALL[number / 2], rows, out);
        }
    }
}

/// Rows and their plans, whose memory is kept: as many as are of the present chunk, and those of others.
#[derive(Default)]
struct Planned {
    rows: Vec<(u32, Plan)>,
    count: usize,
}

impl Planned {
    fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        if self.count == self.rows.len() {
            self.rows.push((row, Plan::default()));
        }
        let place = &mut self.rows[self.count];
        *place = (row, Plan::new(std::mem::take(&mut place.1.stretches), set, features.active, features.scenario)?);
        self.count += 1;
        Ok(())
    }
}
