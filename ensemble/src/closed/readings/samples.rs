//! Lays out the samples of records from their peaks on for the regression.

use super::pieces::hold_ends;
use super::records::{Memory, Readings};
use super::shown::{Piece, Push, Shown};
use crate::lanes::Lanes;
use crate::numerics::root::Curve;
use crate::query::{Query, Question};
use crate::regression::Records;
use crate::regression::relaxing::ENDS;
use crate::regression::samples::{self, POINTS, SAMPLE_RATE_HZ};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Pieces of the hold with a lag in which its samples are summed.
const PIECES_BEHIND_A_LAG: usize = 24;

impl Readings<'_> {
    /// Number of the first sample: the larger of those beside the peak.
    fn first_samples(&self, peak_times: Lanes) -> Lanes {
        let push = self.tests.push;
        let push_end = Lanes::from_fn(|lane| samples::from(push[lane]));
        let after = Lanes::from_fn(|lane| samples::from(push[lane] + peak_times[lane]).max(push_end[lane]));
        if after == push_end {
            return after;
        }
        let [earlier, later] = [1.0, 0.0].map(|back| {
            let times = (after - back) * (1.0 / SAMPLE_RATE_HZ) - push;
            let holds = |lane: usize| {
                let ends = |piece: &Piece| times[lane] <= piece.times[1][lane];
                self.memory.pieces.iter().position(ends).unwrap_or(self.memory.pieces.len() - 1)
            };
            let question = Question::Pressures([times.max(Lanes::ZERO); POINTS]);
            let reading = self.gather(holds);
            Query { times: reading.times, reading, question }.answer(self.arch)[0]
        });
        Lanes::from_fn(|lane| {
            let sign = if self.tests.to[lane] > self.tests.from[lane] { -1.0 } else { 1.0 };
            let back = after[lane] > push_end[lane] && sign * earlier[lane] > sign * later[lane];
            after[lane] - f64::from(back)
        })
    }

    /// Lays out the samples from the peaks on, whose times, s, are given.
    pub fn lay_out(&self, peak_times: Lanes, records: &mut Records) {
        records.begin_with(self.first_samples(peak_times));
        self.arch.dispatch(Sample { readings: self, records });
    }
}

/// Lays out the samples of all pieces.
struct Sample<'b, 'a> {
    readings: &'b Readings<'a>,
    records: &'b mut Records,
}

impl WithSimd for Sample<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(mut self, _: I) {
        let Readings { tests, memory, hold, sensors, duration, .. } = self.readings;
        let Memory { nodes, panels, pieces, polynomials, in_push, .. } = &**memory;
        for (index, piece) in pieces[..*in_push].iter().enumerate() {
            let gas = Push::Gas(tests, nodes, panels);
            let push = polynomials.get(index).map_or(gas, |polynomial| Push::Behind(*black_box(polynomial)));
            self.add(black_box(piece.times), Some(push));
        }
        // Not the pieces of the hold, which reach from turn to turn.
        let (rate, length) = (hold.gas.rate, *duration - sensors.delay);
        let ends: &[Lanes] = if sensors.lags() {
            &hold_ends::<PIECES_BEHIND_A_LAG>(rate, sensors.lag, length, Lanes::from(PIECES_BEHIND_A_LAG as f64))
        } else {
            let slowness = rate.recip();
            &ENDS.map(|end| (slowness * end).min(length))
        };
        let mut from = sensors.delay;
        for end in black_box(ends) {
            let to = *end + sensors.delay;
            self.add(black_box([from, to]), None);
            from = to;
        }
    }
}

impl Sample<'_, '_> {
    #[inline(always)]
    fn add(&mut self, times: [Lanes; 2], push: Option<Push>) {
        let Readings { tests, hold, sensors, .. } = self.readings;
        let push_end = tests.push;
        let end = black_box(push_end + times[1]);
        let Some(nodes) = self.records.nodes_up_to(end) else { return };
        let pushed = if push.is_some() { Lanes::ONE } else { Lanes::ZERO };
        let curve = Shown { times, pushed, push, hold, sensors };
        let mut pressure = [Lanes::ZERO; POINTS];
        for k in 0..black_box(POINTS) {
            let time = nodes.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - push_end;
            // Nodes without weight may lie anywhere.
            pressure[k] = black_box(curve.at(time.max(times[0]).min(times[1])));
        }
        self.records.push(&nodes, &pressure);
    }
}
