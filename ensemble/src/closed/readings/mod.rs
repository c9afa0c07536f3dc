//! Sensor readings of tests that have a closed form, one per lane: a filter of a known pressure, without integration.
//!
//! While the piston rests P = Pf/(1 − z), z = ε e^(−kt); while it moves P = m R/(u V) with u = 1/T from the nodes of the
//! quadrature ([`Panel`](crate::numerics::gauss::Panel)). The record shows it a delay later, behind a lag, with an offset and a
//! drift r. Without a lag it turns where P' = −r, that is where Pf k z = r (1 − z)²: at two places, z and 1/z. With a lag the push is
//! integrated ([`push`]) and the hold has a closed form ([`hold`]). What a delayed record still shows of the push is cut into pieces,
//! over which with a lag the pressure is a polynomial ([`filter`](crate::filter)). Times in s from the end of the push on the record,
//! pressures in Pa.

mod events;
mod hold;
mod pieces;
mod push;
mod records;
mod samples;
mod shown;

pub use records::{Memory, Readings};

use crate::closed::test::{Ends, Tests};
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::{Outcome, ROUNDING, Standing};
use crate::query::{Query, Question};
use crate::regression::Regression;
use crate::regression::fit;
use crate::scenario::Scenario;
use crate::sensor::Sensor;
use chamber::real::Real;
use events::{Enter, Events, FoundEvents, Turn, TurnBehind};
use hold::{HoldRecord, Relaxation};
use pieces::{Build, HoldPieces};
use pulp::Arch;
use shown::Piece;

/// Number of relaxations in the push up to which a lagging or delayed record is read from the closed form.
const MOST_RELAXATIONS: f64 = 20.0;

/// What is read from one record.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordAnswer {
    /// Largest reading from the end of the push on, Pa, or smallest for an expansion.
    pub peak: f64,
    /// Time of that reading, s.
    pub peak_time: f64,
    /// Reading at the end of the test, Pa.
    pub last: f64,
    /// Time after which it stays within 1 % of the last reading, s.
    pub settling: f64,
}

/// Whether the closed form is the faster method for the reading of a sealed test. With a lag or a delay the push is read in parts,
/// whose number, time and memory grow with the ratio of push to relaxation.
pub fn is_quick(sensor: &Sensor, scenario: &Scenario) -> bool {
    if !sensor.looks_back() {
        return true;
    }
    let Scenario { chamber, initial_pressure_pa, ambient_temperature_k: ambient, .. } = scenario;
    let (geometry, law) = (&chamber.geometry, &chamber.heat_transfer);
    let [first, last] = [scenario.initial_position_m, scenario.final_position_m].map(|x| geometry.volume(x));
    // Compares the squares of [`Closed::rate`] at rest times the push: without roots and divisions.
    let exchanged = law.coefficient * geometry.heat_transfer_area(last) * (chamber.gas.heat_capacity_ratio - 1.0);
    let rate = scenario.push_time_s * exchanged * ambient;
    let most = MOST_RELAXATIONS * MOST_RELAXATIONS * law.reference_pressure * law.reference_temperature;
    rate * rate * ambient < most * initial_pressure_pa * first * last
}

impl RecordAnswer {
    /// The outcome, from that of the gas, given the wall temperature, K, and the sensor.
    pub fn outcome(
        &self,
        s: &Scenario,
        regression: Option<Regression>,
        (wall, sensor): (f64, &Sensor),
        gas: Outcome,
    ) -> Outcome {
        let (settling_time_s, flows_on) = self.standing(s, wall, sensor, &gas).judge(self.settling);
        Outcome {
            pressure_peak_pa: self.peak,
            pressure_final_pa: self.last,
            fit: regression.and_then(|found| fit::steps(s, found)),
            settling_time_s,
            flows_on,
            ..gas
        }
    }

    /// What is outstanding at the end of the record.
    fn standing(&self, s: &Scenario, wall: f64, sensor: &Sensor, gas: &Outcome) -> Standing {
        let distance = (self.peak - self.last).abs();
        let cooled = wall / gas.temperature_final_k;
        let to_come = if sensor.looks_back() {
            (self.last - sensor.shown(gas.pressure_final_pa * cooled, gas.duration_s)).abs()
        } else {
            gas.pressure_final_pa * (1.0 - cooled).abs()
        };
        let stands = self.settling == 0.0 && distance <= ROUNDING * self.last.abs();
        let going_on = (sensor.drift * s.hold_s()).abs();
        Standing { distance, to_come, going_on, stands }
    }
}

impl<'a> Readings<'a> {
    /// The records of tests with their sensors; `before` is the gas pressure before the test, Pa. If the sensors look back, `memory`
    /// holds the nodes of the push.
    pub fn new(
        arch: Arch,
        memory: &'a mut Memory,
        tests: &'a Tests,
        ends: &Ends,
        sensor: impl Fn(usize) -> Sensor,
        before: Lanes,
    ) -> Self {
        let wall = tests.closed.ambient_temperature;
        let gas = Relaxation {
            at_rest: tests.closed.mass_gas_constant * wall / tests.to,
            excess: Lanes::ONE - wall / ends.pushed,
            rate: ends.rate,
        };
        let [mut lag, mut delay, mut offset, mut drift] = [Lanes::ZERO; 4];
        for lane in 0..WIDTH {
            let one = sensor(lane);
            (lag[lane], delay[lane], drift[lane]) = (one.lag, one.delay, one.drift);
            offset[lane] = one.shown(0.0, tests.push[lane]);
        }
        let sensors = Sensor { lag, delay, offset, drift };
        memory.pieces.clear();
        memory.polynomials.clear();
        memory.in_push = 0;
        let hold = HoldRecord { gas, behind: None };
        let mut readings = Self { arch, tests, memory, hold, sensors, duration: tests.hold };
        if sensors.lags() || sensors.is_late() {
            arch.dispatch(Build { readings: &mut readings, before });
        }
        if !sensors.lags() {
            readings.add_hold();
        }
        readings.find_turns();
        readings
    }

    /// Adds the hold without a lag: pieces between its turns, which have a closed form.
    fn add_hold(&mut self) {
        let Self { hold, sensors, duration, .. } = self;
        let mut corners = [sensors.delay, *duration, *duration, *duration];
        for lane in 0..WIDTH {
            let end = duration[lane] - sensors.delay[lane];
            let turns =
                turns(hold.gas.at_rest[lane], hold.gas.excess[lane], hold.gas.rate[lane], sensors.drift[lane], end);
            corners[1][lane] = sensors.delay[lane] + turns[0];
            corners[2][lane] = sensors.delay[lane] + turns[1];
        }
        self.arch.dispatch(HoldPieces { hold, sensors, corners, pieces: &mut self.memory.pieces });
    }

    /// Finds the turns of the records: of each lane the first piece with a turn, then the second, and so on.
    fn find_turns(&mut self) {
        let count = self.memory.pieces.len();
        self.memory.turns.clear();
        self.memory.turns.resize(count, Turn::NONE);
        let mut next = [0; WIDTH];
        loop {
            for lane in 0..WIDTH {
                let turns = |piece: &Piece| piece.slopes[0][lane] * piece.slopes[1][lane] < 0.0;
                next[lane] += self.memory.pieces[next[lane]..].iter().position(turns).unwrap_or(count - next[lane]);
            }
            if next.iter().all(|next| *next == count) {
                return;
            }
            let reading = self.gather(|lane| next[lane].min(count - 1));
            let Self { arch, sensors, memory, hold: HoldRecord { gas, behind }, .. } = &*self;
            let mut found = [Lanes::ZERO; 3];
            if let Some(behind) = behind {
                found = arch.dispatch(TurnBehind { gas, behind, sensors, times: reading.times });
            }
            let in_push = memory.in_push;
            let quick = |lane: usize| found[2][lane] > 0.0 && sensors.drift[lane] == 0.0 && next[lane] >= in_push;
            let open: [bool; WIDTH] = core::array::from_fn(|lane| next[lane] < count && !quick(lane));
            if open.contains(&true) {
                let [times, values, ..] =
                    Query { times: reading.times, reading, question: Question::Turn }.answer(*arch);
                for lane in (0..WIDTH).filter(|lane| open[*lane]) {
                    (found[0][lane], found[1][lane]) = (times[lane], values[lane]);
                }
            }
            for lane in (0..WIDTH).filter(|lane| next[*lane] < count) {
                self.memory.turns[next[lane]].put(lane, found[0][lane], found[1][lane]);
            }
            for next in &mut next {
                *next = (*next + 1).min(count);
            }
        }
    }

    /// What is read from each record.
    pub fn answers(&self) -> [RecordAnswer; WIDTH] {
        let Memory { pieces, turns, .. } = &*self.memory;
        let found = self.arch.dispatch(Events { tests: self.tests, pieces, turns, end: self.duration });
        let FoundEvents { last, between, band, .. } = found;
        // The hold needs a search only with drift.
        let of_hold = |lane: usize| found.piece[lane] >= self.memory.in_push as f64;
        let enter = Enter { hold: &self.hold, sensors: &self.sensors, found: &found };
        let [mut settled, good] = self.arch.dispatch(enter);
        let closed = |lane: usize| good[lane] > 0.0 && self.sensors.drift[lane] == 0.0 && of_hold(lane);
        let closed: [bool; WIDTH] = core::array::from_fn(closed);
        if !closed.iter().all(|closed| *closed) {
            let reading = self.gather(|lane| found.piece[lane] as usize);
            let question = Question::Enter { between, value: last, band };
            let [searched, ..] = Query { times: reading.times, reading, question }.answer(self.arch);
            for lane in (0..WIDTH).filter(|lane| !closed[*lane]) {
                settled[lane] = searched[lane];
            }
        }
        core::array::from_fn(|lane| {
            // A record that is never outside has no piece to enter from.
            let outside = between[1][lane] > between[0][lane];
            let settling = if outside { settled[lane].max(0.0) } else { between[0][lane] };
            RecordAnswer { peak: found.peak[lane], peak_time: found.peak_time[lane], last: last[lane], settling }
        })
    }
}

/// Times since the push, s, at which a relaxation with a drift turns before `end`; `end` for missing ones.
fn turns(at_rest: f64, excess: f64, rate: f64, drift: f64, end: f64) -> [f64; 2] {
    if drift == 0.0 || excess == 0.0 {
        return [end; 2];
    }
    // z + 1/z = 2 + Pf k/r.
    let half = 1.0 + 0.5 * at_rest * rate / drift;
    if half.abs() <= 1.0 {
        return [end; 2];
    }
    let larger = half + (half * half - 1.0).sqrt().copysign(half);
    let time = |z: f64| {
        let time = (excess / z).ln() / rate;
        if time > 0.0 && time < end { time } else { end }
    };
    let [one, other] = [time(larger), time(1.0 / larger)];
    [one.min(other), one.max(other)]
}
