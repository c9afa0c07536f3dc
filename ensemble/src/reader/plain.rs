//! Plain records: those that show the gas as it is, of one hold. Most rows have one, and it needs no pieces but those in which
//! it turns round and the one in which it settles: between its turns it goes one way, so that peaks stand at its ends or turns.

use super::bends::Straight;
use super::{Cut, Job, Knot, Memory, PRESSURE, RowAnswer, TEMPERATURE, Trace, TracePiece, Traces};
use crate::filter::Sensor;
use crate::outcome::{ROUNDING, SETTLED};

impl Trace<'_> {
    /// Whether it shows the gas as it is: so from the end of the push to that of the test in one stretch.
    pub(super) fn is_plain(&self) -> bool {
        let Sensor { lag, offset, drift } = self.sensor;
        lag == 0.0 && offset == 0.0 && drift == 0.0 && self.plan.delay == 0.0 && self.bends.is_none()
    }

    /// Cuts out the pieces of a plain record, by its segment and knots, in which it turns round, and notes where the temperature
    /// comes to a peak. False, of a record that stands still at a knot: it is not to be read in this way.
    pub(super) fn cut_turns(
        &self,
        segment: u32,
        knots: &[Knot],
        pieces: &mut Vec<TracePiece>,
        warmest: &mut Vec<(u32, u32)>,
    ) -> bool {
        let (had, noted) = (pieces.len(), warmest.len());
        for (index, ends) in knots.windows(2).enumerate() {
            let [begin, end] = [0, 1].map(|end| ends[end].view.slope);
            let turns = [PRESSURE, TEMPERATURE].map(|of| begin[of] * end[of]);
            if turns[PRESSURE] > 0.0 && turns[TEMPERATURE] > 0.0 {
                continue;
            }
            // Nor of what is no number.
            if !(turns[PRESSURE].abs() > 0.0 && turns[TEMPERATURE].abs() > 0.0) {
                pieces.truncate(had);
                warmest.truncate(noted);
                return false;
            }
            if turns[PRESSURE] < 0.0 {
                pieces.push(TracePiece::plain(segment, knots, index));
            }
            if turns[TEMPERATURE] < 0.0 && self.sign() * end[TEMPERATURE] < 0.0 {
                warmest.push((segment, index as u32));
            }
        }
        true
    }
}

impl TracePiece {
    /// That of a plain record from a knot to the next.
    fn plain(segment: u32, knots: &[Knot], index: usize) -> Self {
        let ends = [&knots[index], &knots[index + 1]];
        Self {
            segment,
            knot: index as u32,
            lag: 0,
            times: ends.map(|knot| knot.at),
            shown: ends.map(|knot| knot.view.value[PRESSURE]),
            slopes: ends.map(|knot| knot.view.slope[PRESSURE]),
            straight: Straight::READING,
        }
    }
}

impl Traces<'_> {
    /// The answer about a plain record but for the settling time; where that has to be found inside an interval, it becomes a
    /// job. The peak of the temperature is that of its ends, times the sign of peaks.
    pub(super) fn answer_plain(&mut self, row: usize, segment: u32) -> RowAnswer {
        let Memory { knots, segments, pieces, cut, turns, jobs, .. } = &mut *self.memory;
        let (trace, knots) = (&self.rows[row], &knots[segments[segment as usize].knots.clone()]);
        let turns = &turns[cut[row].turns.clone()];
        let sign = trace.sign();
        let value = |index: usize| knots[index].view.value[PRESSURE];
        let last = knots.len() - 1;
        let (mut peak, mut time) = (sign * value(0), 0.0);
        for (at, shown) in turns.iter().map(|turn| (turn.time, turn.shown)).chain([(knots[last].at, value(last))]) {
            if sign * shown > peak {
                (peak, time) = (sign * shown, at);
            }
        }
        let (pressure_peak, pressure_final) = (sign * peak, value(last));
        let band = (SETTLED * (pressure_peak - pressure_final).abs()).max(ROUNDING * pressure_final.abs());
        let outside = |value: f64| (value - pressure_final).abs() > band;
        // Back from the end to where it was outside the last time, and the next such place after it.
        let mut turns = turns.iter().rev().peekable();
        let entry = (0..last).rev().find_map(|index| {
            let mut later = knots[index + 1].at;
            if let Some(turn) = turns.next_if(|turn| pieces[turn.piece].knot as usize == index) {
                if outside(turn.shown) {
                    return Some((index, turn.time, later));
                }
                later = turn.time;
            }
            outside(value(index)).then_some((index, knots[index].at, later))
        });
        if let Some((index, from, later)) = entry {
            jobs.push(Job::new(pieces.len(), [from, later, pressure_final, band]));
            pieces.push(TracePiece::plain(segment, knots, index));
        }
        let temperatures = [0, last].map(|index| knots[index].view.value[TEMPERATURE]);
        RowAnswer {
            pressure_peak,
            peak_time: trace.plan.stretches[trace.plan.hold].elapsed + time,
            pressure_final,
            temperature_peak: (sign * temperatures[0]).max(sign * temperatures[1]),
            temperature_final: temperatures[1],
            settling: 0.0,
            inflow: knots[last].view.inflow(),
            pressure_rate: knots[last].view.pressure_rate(),
        }
    }

    /// Cuts plain records into all their pieces: their samples are read from these.
    pub(super) fn cut_plain(&mut self) {
        let Memory { knots, segments, pieces, cut, .. } = &mut *self.memory;
        for cut in cut {
            if let Cut { plain: Some(segment), all, .. } = cut {
                let from = pieces.len();
                let knots = &knots[segments[*segment as usize].knots.clone()];
                pieces.extend((0..knots.len() - 1).map(|index| TracePiece::plain(*segment, knots, index)));
                *all = from..pieces.len();
            }
        }
    }
}
