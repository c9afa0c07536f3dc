//! Peaks of records and the last time they are outside the band around their ends, from the corners of their pieces: begin, turn and
//! end. A record is monotone between corners.

use super::hold::{BehindLag, HoldRecord, Relaxation};
use super::shown::Piece;
use crate::closed::test::Tests;
use crate::lanes::Lanes;
use crate::outcome::{ROUNDING, SETTLED};
use crate::sensor::Sensor;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Largest number of Newton steps, and the size of the last one, as a fraction of a relaxation or a lag.
const ROUNDS: usize = 6;
const NEARLY: f64 = 1e-6;
const NEARLY_TURNED: f64 = 3e-4;

/// The turns of records inside a piece.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// 1 if there is one, else 0.
    is: Lanes,
    /// Its time, s.
    time: Lanes,
    /// The reading there, Pa.
    value: Lanes,
}

impl Turn {
    /// No record turns.
    pub const NONE: Self = Self { is: Lanes::ZERO, time: Lanes::ZERO, value: Lanes::ZERO };

    /// Sets the turn of a lane: its time, s, and the reading there, Pa.
    pub fn put(&mut self, lane: usize, time: f64, value: f64) {
        (self.is[lane], self.time[lane], self.value[lane]) = (1.0, time, value);
    }
}

/// Finds the turns of records between `times` of the hold, for sensors with a lag but no drift: the time, s, the reading there, Pa, and
/// a number that is positive if the turn was found. P' − y' = τ y″ decays as e^(−t/τ) while P' changes slowly, so that Newton's method
/// for the logarithm of (P' − y')/P' needs few steps.
pub struct TurnBehind<'a> {
    pub gas: &'a Relaxation,
    pub behind: &'a BehindLag,
    pub sensors: &'a Sensor<Lanes>,
    pub times: [Lanes; 2],
}

impl WithSimd for TurnBehind<'_> {
    type Output = [Lanes; 3];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> [Lanes; 3] {
        let Self { gas, behind, sensors, times: [begin, end] } = self;
        let (mut time, mut shown, mut open) = (begin, Lanes::ZERO, Lanes::ONE);
        let [per_rest, per_lag] = [gas.at_rest, sensors.lag].map(|all| all.recip());
        for _ in 0..ROUNDS {
            let [reading, slope] = black_box(behind.shown(time - sensors.delay));
            let pressure = reading + slope * sensors.lag;
            let (way, left) = (pressure * per_rest, Lanes::ONE - pressure * per_rest);
            let gas_slope = gas.rate * pressure * left;
            let lags = (Lanes::ONE - slope / gas_slope).max(Lanes::from(f64::MIN_POSITIVE)).ln();
            // Its part of the logarithm's rate of decrease, with P″ = −k (2 P/Pf − 1) P'.
            let bend = gas.rate * (way * 2.0 - 1.0) * slope / (gas_slope - slope);
            let step = (lags / (per_lag + bend)).max(begin - time).min(end - time);
            // Over the step to the turn the slope falls to zero.
            shown = open.where_positive(reading + slope * step * 0.5 + sensors.beside(time), shown);
            time = open.where_positive(time + step, time);
            open = (Lanes::from(NEARLY_TURNED) - lags.abs()).where_positive(Lanes::ZERO, open);
            if !open.any_positive() {
                break;
            }
        }
        let inside = (time - begin).min(end - time);
        [time, shown, open.where_positive(Lanes::ZERO, inside)]
    }
}

/// Finds the peaks of records and where they settle: [`FoundEvents`].
pub struct Events<'a> {
    pub tests: &'a Tests,
    pub pieces: &'a [Piece],
    pub turns: &'a [Turn],
    /// End of the records, s.
    pub end: Lanes,
}

/// Peaks of records, and where they settle.
pub struct FoundEvents {
    /// Largest reading, Pa, or smallest for an expansion, and its time, s.
    pub peak: Lanes,
    pub peak_time: Lanes,
    /// Reading at the end, Pa.
    pub last: Lanes,
    /// Half-width of the band around it, Pa.
    pub band: Lanes,
    /// The last piece with a corner outside the band.
    pub piece: Lanes,
    /// Times of the last corner outside and of the one after it, s; both 0 if there is none.
    pub between: [Lanes; 2],
}

impl WithSimd for Events<'_> {
    type Output = FoundEvents;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> FoundEvents {
        let Self { tests, pieces, turns, end } = self;
        let sign = (tests.to - tests.from).where_positive(-Lanes::ONE, Lanes::ONE);
        let (mut peak, mut peak_time, mut last) = (Lanes::from(f64::MIN), Lanes::ZERO, Lanes::ZERO);
        for (piece, turn) in pieces.iter().zip(turns) {
            for [is, time, value] in corners(piece, turn) {
                let height = value * sign;
                let above = is.where_positive(height - peak, Lanes::ZERO);
                peak = above.where_positive(height, peak);
                peak_time = above.where_positive(time, peak_time);
            }
            last = piece.shown[1];
        }
        let peak = peak * sign;
        let band = ((peak - last).abs() * SETTLED).max(last.abs() * ROUNDING);
        // Backwards from the end to the last corner outside.
        let (mut found, mut later) = (Lanes::ZERO, end);
        let (mut at, mut between) = (Lanes::ZERO, [Lanes::ZERO; 2]);
        for (index, (piece, turn)) in pieces.iter().zip(turns).enumerate().rev() {
            for [is, time, value] in corners(piece, turn).into_iter().rev() {
                let seen = found.where_positive(Lanes::ZERO, is);
                let outside = seen.where_positive((value - last).abs() - band, Lanes::ZERO);
                at = outside.where_positive(Lanes::from(index as f64), at);
                between = [outside.where_positive(time, between[0]), outside.where_positive(later, between[1])];
                found = outside.where_positive(Lanes::ONE, found);
                later = seen.where_positive(time, later);
            }
        }
        FoundEvents { peak, peak_time, last, band, piece: at, between }
    }
}

/// Times at which records enter their bands for good during the hold, s, for sensors without drift: in closed form, or with a lag by
/// Newton's method for the logarithm of the distance to the end, which is nearly linear in time; and a number that is positive if the
/// method has converged.
pub struct Enter<'a> {
    pub hold: &'a HoldRecord,
    pub sensors: &'a Sensor<Lanes>,
    pub found: &'a FoundEvents,
}

impl WithSimd for Enter<'_> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> [Lanes; 2] {
        let Self { hold: HoldRecord { gas, behind }, sensors, found } = self;
        let side = gas.excess.where_positive(Lanes::ONE, -Lanes::ONE);
        let edge = found.last + side * found.band;
        let [outside, later] = found.between;
        let mut time = gas.reaches(edge - sensors.offset) + sensors.delay;
        let Some(behind) = behind else { return [time.max(outside).min(later), Lanes::ONE] };
        time = (time + sensors.lag).max(outside).min(later);
        let per_band = (side * found.band).recip();
        let mut open = Lanes::ONE;
        for _ in 0..ROUNDS {
            let [reading, slope] = black_box(behind.shown(time - sensors.delay));
            let distance = reading + sensors.offset - found.last;
            let step = (distance * per_band).max(Lanes::from(f64::MIN_POSITIVE)).ln() * distance / slope;
            time = open.where_positive((time - step).max(outside).min(later), time);
            // The next step would be at most the square of this one. False if it is not a number.
            open = (Lanes::from(NEARLY) - (step * gas.rate).abs()).where_positive(Lanes::ZERO, open);
            if !open.any_positive() {
                break;
            }
        }
        let inside = (time - outside).min(later - time);
        [time, open.where_positive(Lanes::ZERO, inside)]
    }
}

/// Corners of a piece in chronological order: whether it exists (1 or 0), time and value.
#[inline(always)]
fn corners(piece: &Piece, turn: &Turn) -> [[Lanes; 3]; 3] {
    let [begin, end] = [0, 1].map(|end| [Lanes::ONE, piece.times[end], piece.shown[end]]);
    [begin, [turn.is, turn.time, turn.value], end]
}
