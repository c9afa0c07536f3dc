//! What is shown in the pieces of records, between which they may turn round: of the push, where they are late, and of the hold.

use super::hold::HoldRecord;
use super::push::PushPressure;
use super::sensors::Sensors;
use crate::closed::test::Tests;
use crate::filter::{Lagged, TERMS};
use crate::lanes::Lanes;
use crate::numerics::gauss::{NODES, Panel};
use crate::numerics::root::Curve;
use chamber::real::Real;

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
}

/// The gas during a piece of the push of sensors that lag.
#[derive(Clone, Copy, Debug)]
pub struct Polynomial {
    /// Coefficients of its pressure, Pa, in powers of the share of the piece.
    pub gas: [Lanes; TERMS],
    /// The lagging reading at the piece's start, Pa.
    pub lagged: Lanes,
}

/// A piece's record as a curve.
#[derive(Clone, Copy)]
pub struct Shown<'a> {
    /// Times at which the piece begins and ends, s.
    pub times: [Lanes; 2],
    /// 1 where it is of the push, 0 where of the hold.
    pub pushed: Lanes,
    /// That of the push, where any of the pieces is of it.
    pub push: Option<Push<'a>>,
    pub hold: &'a HoldRecord,
    pub sensors: &'a Sensors,
}

/// Pieces of the push, one a lane.
#[derive(Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "one lives at a time")]
pub enum Push<'a> {
    /// Of sensors that lag.
    Behind(Polynomial),
    /// Of sensors that show the gas late: the tests, and 1/T at the nodes and along the parts of their pushes.
    Gas(&'a Tests, &'a [[Lanes; NODES]], &'a [Panel<Lanes>]),
}

impl Shown<'_> {
    /// The reading without offset and drift, Pa, and its slope, Pa/s.
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
