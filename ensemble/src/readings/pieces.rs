//! The pieces of records: from the closed form over the push, and over the hold.

use super::{Memory, Readings};
use crate::exact_rows::Tests;
use crate::filter::{CUTS, Lagged, TERMS, ToPowers};
use crate::kept::{Heat, Panel};
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::look::Reading;
use crate::root::Curve;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Pieces, over which the pressure is a polynomial, of a part of the push.
const PIECES_OF_A_PART: usize = 6;
/// Ends of the pieces, over which the pressure of the hold is a polynomial, in 1/k; the last ends with the record.
const ENDS: [f64; 13] = [0.15, 0.33, 0.55, 0.85, 1.2, 1.7, 2.4, 3.3, 4.6, 6.5, 9.5, 14.0, f64::INFINITY];
/// A length, s, to divide by where there is none.
const SHORTEST: f64 = 1e-300;

/// A piece of each record.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Times at which it begins and ends, s.
    pub times: [Lanes; 2],
    /// What is shown there, Pa, and the slopes, Pa/s.
    pub shown: [Lanes; 2],
    pub slopes: [Lanes; 2],
    /// Coefficients of the gas's pressure, Pa, in powers of the share of the piece, where they are used.
    pub gas: [Lanes; TERMS],
    /// The lagging reading at its begin, Pa.
    pub lagged: Lanes,
    /// 1 where it is of the hold and read from the closed form, else 0.
    pub exact: Lanes,
}

/// The relaxation of the hold over the time since the push, s, of the gas.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    pub at_rest: Lanes,
    pub excess: Lanes,
    pub rate: Lanes,
}

impl Curve for Held {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.at_rest / (Lanes::ONE - self.excess * (-(self.rate * time)).exp())
    }
}

/// The pressure during the push over the (negative) time since its end, s, of the gas.
pub struct Pushed<'a> {
    tests: &'a Tests,
    panels: &'a [Panel<Lanes>],
    /// √V at the begin, and its rise.
    root: Lanes,
    rise: Lanes,
}

impl<'a> Pushed<'a> {
    #[inline(always)]
    fn new(tests: &'a Tests, panels: &'a [Panel<Lanes>]) -> Self {
        let root = tests.from.sqrt();
        Self { tests, panels, root, rise: tests.to.sqrt() - root }
    }

    /// Time since the end of the push, s, at a share of √V's way.
    #[inline(always)]
    fn time(&self, share: Lanes) -> Lanes {
        let (rise, twice) = (self.rise, self.root * 2.0);
        self.tests.push * (share * (twice + rise * share) / (twice + rise) - 1.0)
    }

    /// Share of √V's way at a time since the end of the push, s, and √V there.
    #[inline(always)]
    fn share(&self, time: Lanes) -> [Lanes; 2] {
        let way = (time / self.tests.push + 1.0) * (self.root * 2.0 + self.rise);
        let root = (self.root * self.root + self.rise * way).sqrt();
        [way / (root + self.root), root]
    }
}

impl Curve for Pushed<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        let [share, root] = self.share(time);
        let place = share.min(Lanes::ONE) * self.tests.parts;
        let mut inverse = self.panels[0].at(place);
        for index in 1..self.panels.len() {
            let inside = place - index as f64;
            inverse = inside.where_positive(self.panels[index].at(inside), inverse);
        }
        self.tests.closed.mass_gas_constant / (inverse * root * root)
    }
}

/// A piece's record as a curve.
#[derive(Clone, Copy)]
pub struct Shown<const LAGS: bool> {
    pub piece: Piece,
    pub held: Held,
    pub sensors: Sensors,
}

impl<const LAGS: bool> Curve for Shown<LAGS> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        let Self { piece: Piece { times: [from, to], gas, lagged, exact, .. }, held, sensors } = self;
        let length = *to - *from;
        let share = (time - *from) / length.max(Lanes::from(SHORTEST));
        let reading = if LAGS {
            Lagged { pressure: *gas, begin: *lagged, stiffness: length / sensors.lag }.at(share)
        } else {
            let mut sum = gas[TERMS - 1];
            for term in (0..TERMS - 1).rev() {
                sum = sum * share + gas[term];
            }
            exact.where_positive(held.at(time - sensors.delay), sum)
        };
        reading + sensors.offset + sensors.drift * time
    }
}

impl<const LAGS: bool> Reading for Shown<LAGS> {
    type Curve = Self;

    #[inline(always)]
    fn curve(self) -> Self {
        self
    }
}

/// The sensors of as many tests as there are lanes: lags and delays, s, offsets at the end of the push, Pa, drifts, Pa/s.
#[derive(Clone, Copy, Debug)]
pub struct Sensors {
    pub lag: Lanes,
    pub delay: Lanes,
    pub offset: Lanes,
    pub drift: Lanes,
}

/// Pressures of the push, and the pieces of records up to the hold's begin, or where they lag to their ends.
pub struct Build<'b, 'a, const LAGS: bool, H> {
    pub readings: &'b mut Readings<'a, LAGS>,
    pub heat: &'b H,
    pub delayed: bool,
    pub before: Lanes,
}

impl<const LAGS: bool, H: Heat<Lanes>> WithSimd for Build<'_, '_, LAGS, H> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        let Readings { tests, memory: Memory { panels, pieces, to_powers, .. }, held, sensors, duration, .. } =
            self.readings;
        let parts = tests.panels(self.heat, panels);
        let pushed = Pushed::new(tests, panels);
        let mut writer = Writer { to_powers, sensors, reading: self.before, pieces };
        // Up to what the record shows at the end of the push, and from there on.
        let middle = if self.delayed { pushed.share(-sensors.delay)[0] } else { Lanes::ONE };
        for (begin, end, is_shown, counts) in
            [(Lanes::ZERO, middle, false, LAGS), (middle, Lanes::ONE, true, self.delayed)]
        {
            let fine = tests.parts * (end - begin) * PIECES_OF_A_PART as f64;
            let per_count = each_lane!(i => 1.0 / fine.0[i].ceil().max(1.0));
            let mut from = pushed.time(begin);
            for index in 0..if counts { parts * PIECES_OF_A_PART } else { 0 } {
                let done = (per_count * (index + 1) as f64).min(Lanes::ONE);
                let to = pushed.time(begin + (end - begin) * done);
                writer.add::<LAGS>(&pushed, [from, to], is_shown);
                from = to;
            }
        }
        if LAGS {
            let length = *duration - sensors.delay;
            let mut from = Lanes::ZERO;
            for to in black_box(&hold_ends(held.rate, sensors.lag, length)) {
                writer.add::<LAGS>(held, [from, *to], true);
                from = *to;
            }
        }
    }
}

/// Ends of the hold's pieces behind a lag: where the gas's pressure asks for one, and where the sensor does.
#[inline(always)]
fn hold_ends(rate: Lanes, lag: Lanes, length: Lanes) -> [Lanes; ENDS.len() + CUTS.len()] {
    let mut ends = [Lanes::ZERO; ENDS.len() + CUTS.len()];
    for lane in 0..WIDTH {
        let (mut gas, mut sensor) = (0, 0);
        for end in &mut ends {
            let of_gas = if gas < ENDS.len() { ENDS[gas] / rate[lane] } else { f64::INFINITY };
            let of_sensor = if sensor < CUTS.len() { CUTS[sensor] * lag[lane] } else { f64::INFINITY };
            if sensor < CUTS.len() && of_sensor <= of_gas {
                sensor += 1;
            } else {
                gas += 1;
            }
            end[lane] = of_gas.min(of_sensor).min(length[lane]);
        }
    }
    ends
}

/// Writes piece after piece.
struct Writer<'a> {
    to_powers: &'a ToPowers,
    sensors: &'a Sensors,
    /// The reading at the end of the last piece, Pa.
    reading: Lanes,
    pieces: &'a mut Vec<Piece>,
}

impl Writer<'_> {
    /// A piece between two times of the gas.
    #[inline(always)]
    fn add<const LAGS: bool>(&mut self, pressure: &impl Curve, times: [Lanes; 2], is_shown: bool) {
        let length = times[1] - times[0];
        if !length.any_positive() {
            return;
        }
        let gas = black_box(self.to_powers.of(pressure, times[0], length));
        let mut end = Lanes::ZERO;
        let mut rise = Lanes::ZERO;
        for term in 0..TERMS {
            end += gas[term];
            rise += gas[term] * term as f64;
        }
        let begin = self.reading;
        let per_length = length.max(Lanes::from(SHORTEST)).recip();
        let Sensors { lag, delay, drift, .. } = *self.sensors;
        let (readings, slopes) = if LAGS {
            self.reading = Lagged { pressure: gas, begin, stiffness: length / lag }.at(Lanes::ONE);
            ([begin, self.reading], [(gas[0] - begin) / lag, (end - self.reading) / lag])
        } else {
            // A piece without length, which others beside it ask for, shows what the one before has shown.
            let readings = [length.where_positive(gas[0], begin), length.where_positive(end, begin)];
            self.reading = readings[1];
            (readings, [gas[1] * per_length, rise * per_length])
        };
        if is_shown {
            let times = [times[0] + delay, times[1] + delay];
            let offset = self.sensors.offset;
            let shown = [readings[0] + offset + drift * times[0], readings[1] + offset + drift * times[1]];
            let slopes = [slopes[0] + drift, slopes[1] + drift];
            self.pieces.push(black_box(Piece { times, shown, slopes, gas, lagged: begin, exact: Lanes::ZERO }));
        }
    }
}

/// The hold's pieces between corners, read from the closed form.
pub struct Hold<'a> {
    pub held: Held,
    pub sensors: Sensors,
    pub corners: [Lanes; 4],
    pub pieces: &'a mut Vec<Piece>,
}

impl WithSimd for Hold<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        let Self { held, sensors, corners, pieces } = self;
        let mut shown = [Lanes::ZERO; 4];
        for corner in 0..4 {
            let time = corners[corner];
            shown[corner] = held.at(time - sensors.delay) + sensors.offset + sensors.drift * time;
        }
        for corner in 0..3 {
            let times = [corners[corner], corners[corner + 1]];
            let shown = [shown[corner], shown[corner + 1]];
            // Slopes of a piece that does not turn, and a polynomial that is not read.
            let (slopes, gas, lagged) = ([Lanes::ZERO; 2], [Lanes::ZERO; TERMS], Lanes::ZERO);
            pieces.push(black_box(Piece { times, shown, slopes, gas, lagged, exact: Lanes::ONE }));
        }
    }
}
