//! Cuts records into pieces with at most one turn each: of the push, if they are delayed, and of the hold.

use super::hold::{BehindLag, HoldRecord};
use super::push::PushPressure;
use super::records::{Memory, Readings};
use super::shown::{Piece, Polynomial};
use crate::filter::{Lagged, TERMS, ToPowers};
use crate::lanes::{Lanes, each_lane};
use crate::numerics::root::Curve;
use crate::sensor::Sensor;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Pieces per part of the push, over each of which the pressure is a polynomial.
const PIECES_OF_A_PART: usize = 6;
/// Pieces of the hold with a lag: with drift; without drift, when it turns at most once; and without drift for a lag of at most `QUICK`
/// relaxations, when it turns within the first 13 lags.
const PIECES_OF_A_HOLD: usize = 12;
const PIECES_WITHOUT_A_DRIFT: usize = 6;
const PIECES_OF_A_QUICK_ONE: usize = 2;
const QUICK: f64 = 0.1;
/// Builds the pieces of records from the end of the push on: of delayed records up to the start of the hold, of lagging ones to their
/// ends.
pub struct Build<'b, 'a> {
    pub readings: &'b mut Readings<'a>,
    /// Pressure before the push, Pa.
    pub before: Lanes,
}

impl WithSimd for Build<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        let Readings { tests, memory, hold, sensors, duration, .. } = self.readings;
        let Memory { nodes, panels, pieces, in_push, polynomials, to_powers, .. } = &mut **memory;
        PushPressure::panels(tests, sensors, nodes, panels);
        let pushed = PushPressure::new(tests, sensors, nodes, panels);
        let mut writer = Writer { to_powers, sensors, reading: self.before, pieces, polynomials };
        // Time of the gas that the record shows at the end of the push.
        let first = -sensors.delay;
        if sensors.lags() {
            writer.reading = black_box(pushed.behind(sensors.lag, first, self.before));
        }
        if sensors.is_late() {
            let begin = pushed.share(first)[0];
            let left = Lanes::ONE - begin;
            let fine = tests.parts * left * PIECES_OF_A_PART as f64;
            let per_count = each_lane!(i => 1.0 / fine.0[i].ceil().max(1.0));
            let (mut from, mut shown) = (first, pushed.shown(first));
            for index in 0..tests.most_parts() * PIECES_OF_A_PART {
                let done = (per_count * (index + 1) as f64).min(Lanes::ONE);
                let to = pushed.time(begin + left * done);
                if !(to - from).any_positive() {
                    continue;
                }
                if sensors.lags() {
                    writer.add_behind(&pushed, [from, to]);
                } else {
                    let next = black_box(pushed.shown(to));
                    writer.push([from, to], [shown[0], next[0]], [shown[1], next[1]]);
                    shown = next;
                }
                from = to;
            }
            *in_push = writer.pieces.len();
        }
        if sensors.lags() {
            let HoldRecord { gas, behind } = hold;
            let behind = black_box(behind.insert(BehindLag::new(*gas, sensors.lag, writer.reading)));
            let begin = gas.at_rest / (Lanes::ONE - gas.excess);
            let (mut since, mut from) = (Lanes::ZERO, [writer.reading, (begin - writer.reading) / sensors.lag]);
            let pieces = |count: usize| Lanes::from(count as f64);
            let quick = Lanes::from(QUICK) - gas.rate * sensors.lag;
            let counts = quick.where_positive(pieces(PIECES_OF_A_QUICK_ONE), pieces(PIECES_WITHOUT_A_DRIFT));
            let counts = sensors.drift.abs().where_positive(pieces(PIECES_OF_A_HOLD), counts);
            let end = *duration - sensors.delay;
            for to in black_box(&hold_ends::<PIECES_OF_A_HOLD>(gas.rate, sensors.lag, end, counts)) {
                if !(end - since).any_positive() {
                    break;
                }
                let shown = black_box(behind.shown(*to));
                writer.push([since, *to], [from[0], shown[0]], [from[1], shown[1]]);
                (since, from) = (*to, shown);
            }
        }
    }
}

/// Ends of the `counts` pieces of a hold with a lag: a geometric sequence from half of the shorter to 13 times the longer one of lag
/// and relaxation, limited to the record's length, which is the last end. Of two pieces the first ends at 13 times the shorter.
#[inline(always)]
pub fn hold_ends<const COUNT: usize>(rate: Lanes, lag: Lanes, length: Lanes, counts: Lanes) -> [Lanes; COUNT] {
    let slowness = rate.recip();
    let mut end = slowness.min(lag) * (counts - 2.0).where_positive(Lanes::from(0.5), Lanes::from(13.0));
    let ratio = ((slowness.max(lag) * 13.0 / end).ln() / (counts - 2.0)).exp();
    let mut ends = [length; COUNT];
    for (index, to) in ends.iter_mut().enumerate() {
        let before_last = counts - (index as f64 + 1.5);
        *to = black_box(before_last.where_positive(end.min(length), length));
        end = end * ratio;
    }
    ends
}

/// Appends pieces.
struct Writer<'a> {
    to_powers: &'a ToPowers,
    sensors: &'a Sensor<Lanes>,
    /// Reading at the end of the last piece of the push, Pa.
    reading: Lanes,
    pieces: &'a mut Vec<Piece>,
    polynomials: &'a mut Vec<Polynomial>,
}

impl Writer<'_> {
    /// Appends a piece of the push between two times of the gas, for lagging sensors.
    #[inline(always)]
    fn add_behind(&mut self, pressure: &impl Curve, times: [Lanes; 2]) {
        let (begin, lag, length) = (self.reading, self.sensors.lag, times[1] - times[0]);
        let gas = black_box(self.to_powers.of(pressure, times[0], length));
        let mut end = Lanes::ZERO;
        for term in 0..TERMS {
            end += gas[term];
        }
        self.reading = Lagged { pressure: gas, begin, stiffness: length / lag }.at(Lanes::ONE);
        self.polynomials.push(black_box(Polynomial { gas, lagged: begin }));
        self.push(times, [begin, self.reading], [(gas[0] - begin) / lag, (end - self.reading) / lag]);
    }

    /// Appends a piece between two times of the gas, with the readings there without offset and drift.
    #[inline(always)]
    fn push(&mut self, times: [Lanes; 2], readings: [Lanes; 2], slopes: [Lanes; 2]) {
        let Sensor { delay, drift, .. } = *self.sensors;
        let times = [times[0] + delay, times[1] + delay];
        let shown = [readings[0] + self.sensors.beside(times[0]), readings[1] + self.sensors.beside(times[1])];
        let slopes = [slopes[0] + drift, slopes[1] + drift];
        self.pieces.push(black_box(Piece { times, shown, slopes }));
    }
}

/// Appends the pieces of the hold between its turns, for sensors without a lag.
pub struct HoldPieces<'a> {
    pub hold: &'a HoldRecord,
    pub sensors: &'a Sensor<Lanes>,
    pub corners: [Lanes; 4],
    pub pieces: &'a mut Vec<Piece>,
}

impl WithSimd for HoldPieces<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        let Self { hold, sensors, corners, pieces } = self;
        let mut shown = [Lanes::ZERO; 4];
        for corner in 0..4 {
            let time = corners[corner];
            shown[corner] = hold.gas.shown(time - sensors.delay)[0] + sensors.beside(time);
        }
        for corner in 0..3 {
            let times = [corners[corner], corners[corner + 1]];
            let shown = [shown[corner], shown[corner + 1]];
            // With the slopes of a piece without a turn.
            pieces.push(black_box(Piece { times, shown, slopes: [Lanes::ZERO; 2] }));
        }
    }
}
