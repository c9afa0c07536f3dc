//! What a test that has been solved gives back, by the temperature of its gas.

use crate::lanes::Lanes;
use crate::outcome::{Failure, Outcome, Standing, closure, to_be_lost};
use crate::regression::{Regression, Regressions, fit};
use crate::scenario::Scenario;

/// How a test has ended, by the temperature of its gas, or by whatever else the pressure of its hold is in proportion to.
pub struct Ending<'a> {
    /// What was pushed and held, and how.
    pub scenario: &'a Scenario,
    /// Temperature that the wall has at last, K.
    pub wall: f64,
    /// Temperature at the end of the push, K: from there it goes one way.
    pub pushed: f64,
    /// Temperature at the end, K.
    pub end: f64,
    /// P/T in the hold, Pa/K.
    pub pressure_per_temperature: f64,
    /// From the end of the push until within 1 %, s.
    pub settling: f64,
    /// What gas that flows in or out as at the end changes in as long as the hold has lasted, K; zero of a closed chamber.
    pub flowing: f64,
    /// The rate of its pressure at the end over the pressure, times the hold; none of a closed chamber, in which the wall tells it.
    pub relative_rate: Option<f64>,
    /// The paper's regression of its record, where it was asked for.
    pub regression: Option<Regression>,
}

impl Ending<'_> {
    /// The outcome, of the exact solution.
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
            // A record that peaks at its end has no relaxation to describe.
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

/// How holds of closed chambers have ended, one a lane: see [`Ending`].
pub struct HoldsEnded {
    pub wall: Lanes,
    pub pushed: Lanes,
    pub end: Lanes,
    pub pressure_per_temperature: Lanes,
    pub settling: Lanes,
    pub regressions: Option<Regressions>,
}

impl HoldsEnded {
    /// How the test of a lane has ended.
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

/// How the push of a test has ended whose hold is solved in another way.
#[derive(Clone, Copy)]
pub struct AfterPush {
    /// Number of the test.
    pub row: u32,
    /// About how many relaxations the hold takes.
    pub relaxations: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Internal energy before and after the push, J.
    pub energy: [f64; 2],
    /// What the gas has received as heat less its work, and the magnitude of the work, J.
    pub received: [f64; 2],
    /// Why the push was given up.
    pub failure: Option<Failure>,
}

impl AfterPush {
    /// The outcome of a test that has ended so.
    pub fn outcome(&self, ending: &Ending) -> Outcome {
        let ([start, energy], [received, work]) = (self.energy, self.received);
        match self.failure {
            Some(reason) => Outcome::failed(reason),
            None if !ending.end.is_finite() => Outcome::failed(Failure::TooManySteps),
            None => Outcome { energy_error: closure(start, energy, received, work), exact: false, ..ending.outcome() },
        }
    }
}
