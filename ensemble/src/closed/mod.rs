//! Rows with closed forms, grouped by kind: see [`rows`].

pub mod readings;
mod rows;
mod test;
pub mod with_effects;

use crate::batch::{Batch, Features};
use crate::outcome::Outcome;
use crate::plan;
use crate::sensor::Sensor;
use chamber::effects::{self, EffectSet};

/// Number of kinds: without effects that keep the closed form, or with some and one of two area laws; times without sensor effects, or
/// with or without a lag and with or without a delay.
const KINDS: usize = 3 * 5;

/// A chunk's rows with closed forms, by kind.
#[derive(Default)]
pub struct ClosedRows {
    lists: [Vec<u32>; KINDS],
    memory: rows::Memory,
}

impl ClosedRows {
    /// The list for a row, if it has a closed form and that is the faster or the only allowed method.
    #[inline]
    pub fn rows_like(&mut self, row: &Features) -> Option<&mut Vec<u32>> {
        let s = row.scenario;
        // A record delayed by more than the push or the hold shows other parts of the test.
        let shortest = s.push_time_s.min(s.hold_s());
        let in_time = |sensor: Sensor| plan::check_duration(s).is_err() || sensor.delay < shortest;
        let is_closed = !row.integrates
            && row.is_sealed
            && with_effects::EFFECTS.contains(row.of_gas)
            && row.sensor.is_none_or(|sensor| in_time(sensor) && (row.is_exact || readings::is_quick(&sensor, s)));
        let gas = if row.of_gas.is_empty() { 0 } else { 1 + usize::from(row.is_swept) };
        let shown =
            row.sensor.map_or(0, |sensor| 1 + usize::from(sensor.lag > 0.0) + 2 * usize::from(sensor.delay > 0.0));
        is_closed.then(|| &mut self.lists[gas + 3 * shown])
    }

    /// Solves all rows and empties the lists.
    pub fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        for (kind, rows) in self.lists.iter_mut().enumerate().filter(|(_, rows)| !rows.is_empty()) {
            let of_gas = if kind.is_multiple_of(3) { EffectSet::NONE } else { set.intersection(with_effects::EFFECTS) };
            let shown = if kind < 3 { EffectSet::NONE } else { set.intersection(effects::of_sensor()) };
            rows::run(batch, &mut self.memory, of_gas, shown, rows, out);
            rows.clear();
        }
    }
}
