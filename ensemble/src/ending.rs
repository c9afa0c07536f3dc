//! The outcome of a solved test, from the temperature of its gas.

use crate::lanes::Lanes;
use crate::outcome::{Failure, Outcome, Standing, closure, to_be_lost};
use crate::regression::{Regression, Regressions, fit};
use crate::scenario::Scenario;

/// The end of a test in terms of the gas temperature, or of whatever else the pressure during the hold is proportional to.
pub struct Ending<'a> {
    /// Geometry, times and ambient conditions of the test, as the caller stated them.
    pub scenario: &'a Scenario,
    /// Final temperature of the wall, K.
    pub wall: f64,
    /// Temperature at the end of the push, K; monotone from there on.
    pub pushed: f64,
    /// Temperature at the end, K.
    pub end: f64,
    /// P/T in the hold, Pa/K.
    pub pressure_per_temperature: f64,
    /// Time from the end of the push until within 1 % of the end, s.
    pub settling: f64,
    /// Change by the final flow of gas over another hold of the same duration, K; zero for a closed chamber.
    pub flowing: f64,
    /// Final relative rate of the pressure times the duration of the hold; none if the wall's temperature determines what is lost.
    pub relative_rate: Option<f64>,
    /// The paper's regression, if requested.
    pub regression: Option<Regression>,
}

impl Ending<'_> {
    /// The outcome, marked as an exact solution.
    #[inline]
    pub fn outcome(&self) -> Outcome {
        let (s, pushed, end) = (self.scenario, self.pushed, self.end);
        let peak = s.peak([pushed, end]);
        let to_be_lost = self.relative_rate.map_or(end - self.wall, |rate| to_be_lost(end - self.wall, -end * rate));
        let (to_come, distance) = (to_be_lost.abs(), (peak - end).abs());
        let standing = Standing { distance, to_come, going_on: self.flowing, stands: pushed == end };
        let (settling_time_s, flows_on) = standing.judge(self.settling);
        Outcome {
            pressure_peak_pa: peak * self.pressure_per_temperature,
            pressure_final_pa: end * self.pressure_per_temperature,
            temperature_final_k: end,
            temperature_peak_k: peak,
            // A record that peaks at its end has no relaxation.
            fit: self.regression.filter(|_| peak == pushed).and_then(|found| fit::steps(s, found)),
            settling_time_s,
            flows_on,
            energy_error: 0.0,
            duration_s: s.duration_s,
            exact: true,
            status: Ok(()),
        }
    }
}

/// Ends of holds of closed chambers, one per lane: see [`Ending`].
pub struct HoldsEnded {
    pub wall: Lanes,
    pub pushed: Lanes,
    pub end: Lanes,
    pub pressure_per_temperature: Lanes,
    pub settling: Lanes,
    pub regressions: Option<Regressions>,
}

impl HoldsEnded {
    /// The end of the test of a lane.
    pub fn ending<'a>(&self, lane: usize, scenario: &'a Scenario) -> Ending<'a> {
        Ending {
            scenario,
            wall: self.wall[lane],
            pushed: self.pushed[lane],
            end: self.end[lane],
            pressure_per_temperature: self.pressure_per_temperature[lane],
            settling: self.settling[lane],
            flowing: 0.0,
            relative_rate: None,
            regression: self.regressions.as_ref().and_then(|found| found.lane(lane)),
        }
    }
}

/// The end of an integrated push whose hold is solved by another method.
#[derive(Clone, Copy)]
pub struct AfterPush {
    /// Index of the test in the batch.
    pub row: u32,
    /// Approximate number of relaxations in the hold.
    pub relaxations: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Internal energy before and after the push, J.
    pub energy: [f64; 2],
    /// Heat received less work done, and the magnitude of the work, J.
    pub received: [f64; 2],
    /// Why the push failed, if it did.
    pub failure: Option<Failure>,
}

impl AfterPush {
    /// The outcome of the test, given the end of its hold.
    pub fn outcome(&self, ending: &Ending) -> Outcome {
        let ([start, energy], [received, work]) = (self.energy, self.received);
        match self.failure {
            Some(reason) => Outcome::failed(reason),
            None if !ending.end.is_finite() => Outcome::failed(Failure::TooManySteps),
            None => Outcome { energy_error: closure(start, energy, received, work), exact: false, ..ending.outcome() },
        }
    }
}
