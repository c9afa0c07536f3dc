//! Readings along the pieces of records: of the push, if they are delayed, and of the hold.

use super::hold::HoldRecord;
use super::push::PushPressure;
use crate::closed::test::Tests;
use crate::filter::{Lagged, TERMS};
use crate::lanes::Lanes;
use crate::numerics::gauss::{NODES, Panel};
use crate::numerics::root::Curve;
use crate::sensor::Sensor;
use chamber::real::Real;

/// Smallest length to divide by, s.
const SHORTEST: f64 = 1e-300;

/// A piece of each record.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Begin and end, s.
    pub times: [Lanes; 2],
    /// Readings there, Pa, and their slopes, Pa/s.
    pub shown: [Lanes; 2],
    pub slopes: [Lanes; 2],
}

/// A piece of the push for lagging sensors.
#[derive(Clone, Copy, Debug)]
pub struct Polynomial {
    /// Coefficients of the gas pressure, Pa, in powers of the place from 0 to 1.
    pub gas: [Lanes; TERMS],
    /// Lagged reading at its start, Pa.
    pub lagged: Lanes,
}

/// The record along a piece, as a curve.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// Begin and end of the piece, s.
    pub times: [Lanes; 2],
    /// 1 if it belongs to the push, 0 if to the hold.
    pub pushed: Lanes,
    /// The pieces of the push, if there are any.
    pub push: Option<Push<'a>>,
    pub hold: &'a HoldRecord,
    pub sensors: &'a Sensor<Lanes>,
}

/// Pieces of the push, one per lane.
#[derive(Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "one lives at a time")]
pub enum Push<'a> {
    /// For lagging sensors.
    Behind(Polynomial),
    /// For sensors with a delay only: the tests, and 1/T at the nodes and along the parts of their pushes.
    Gas(&'a Tests, &'a [[Lanes; NODES]], &'a [Panel<Lanes>]),
}

impl Shown<'_> {
    /// Reading without offset and drift, Pa, and its slope, Pa/s.
    #[inline(always)]
    fn reading(&self, time: Lanes) -> [Lanes; 2] {
        let held = self.hold.shown(time - self.sensors.delay);
        match &self.push {
            None => held,
            Some(push) => {
                let pushed = self.of_push(push, time);
                let [reading, rise] = held;
                [self.pushed.where_positive(pushed[0], reading), self.pushed.where_positive(pushed[1], rise)]
            }
        }
    }

    /// The same in the push.
    #[inline(always)]
    fn of_push(&self, push: &Push, time: Lanes) -> [Lanes; 2] {
        let Polynomial { gas, lagged } = match push {
            Push::Behind(polynomial) => polynomial,
            Push::Gas(tests, nodes, panels) => {
                let pushed = PushPressure::new(tests, self.sensors, nodes, panels);
                return pushed.shown((time - self.sensors.delay).max(-tests.push).min(Lanes::ZERO));
            }
        };
        let length = (self.times[1] - self.times[0]).max(Lanes::from(SHORTEST));
        let share = (time - self.times[0]) / length;
        let mut pressure = gas[TERMS - 1];
        for term in (0..TERMS - 1).rev() {
            pressure = pressure * share + gas[term];
        }
        let lag = self.sensors.lag;
        let reading = Lagged { pressure: *gas, begin: *lagged, stiffness: length / lag }.at(share);
        [reading, (pressure - reading) / lag]
    }
}

impl Curve for Shown<'_> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.reading(time)[0] + self.sensors.beside(time)
    }

    #[inline(always)]
    fn rise(&self, time: Lanes, _: Lanes) -> Lanes {
        self.reading(time)[1] + self.sensors.drift
    }
}
