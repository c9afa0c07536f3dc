//! Rows of any chamber by the integrator: the equations of all of them ([`equations`]), in code for their set of effects where there
//! is some ([`compiled`]), stretch after stretch ([`course`]).

pub mod compiled;
mod course;
pub mod equations;
pub mod history;
mod relaxation;
pub mod relaxing_rows;
mod remembering;

use crate::Batch;
use crate::features::Features;
use crate::outcome::{Failure, Outcome};
use crate::plan::Plan;
use chamber::effects::{self, EffectSet};

/// What rows that are integrated have in common.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Gas may enter or leave, at constant rates and by effects.
    Open,
    /// No gas enters or leaves.
    Tight,
    /// Nor has the hold a state but the temperature: see [`relaxation`].
    Relaxing,
    /// Nor has the hold states but the temperature and those of a wall that remembers: see [`remembering`].
    Remembering,
}

impl Kind {
    const ALL: [Self; 4] = [Self::Open, Self::Tight, Self::Relaxing, Self::Remembering];

    /// That of a row.
    fn of(row: &Features) -> Self {
        let of_gas = row.of_gas;
        let by_integrals = row.is_wide && !row.integrates;
        if !row.is_sealed || !effects::KEEP_THE_MASS.contains(of_gas) {
            Self::Open
        } else if by_integrals && row.behind.is_none() && relaxation::EFFECTS.contains(of_gas) {
            Self::Relaxing
        } else if by_integrals
            && remembering::EFFECTS.contains(of_gas)
            && !of_gas.intersection(effects::REMEMBERING).is_empty()
        {
            Self::Remembering
        } else {
            Self::Tight
        }
    }

    /// Whether no gas enters or leaves.
    fn is_tight(self) -> bool {
        matches!(self, Self::Tight | Self::Relaxing | Self::Remembering)
    }
}

/// A chunk's rows that are integrated so, with their plans, by kind and area law: what lanes must have in common.
#[derive(Default)]
pub struct GeneralRows {
    lists: [Vec<(u32, Plan)>; 2 * Kind::ALL.len()],
    memory: course::Memory,
}

impl GeneralRows {
    /// Plans one more, unless it cannot be solved.
    pub fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        let plan = Plan::new(set, features.active, features.scenario)?;
        self.lists[usize::from(features.is_swept) + 2 * Kind::of(features) as usize].push((row, plan));
        Ok(())
    }

    /// Solves all, after which there are none.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        for (number, rows) in self.lists.iter_mut().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            compiled::course(batch, &mut self.memory, set, Kind::ALL[number / 2], rows, out);
            rows.clear();
        }
    }
}
