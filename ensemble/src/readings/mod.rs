//! What a sensor shows of tests that have a closed form, one a lane: a filter of a known pressure, without integration.
//!
//! While the piston rests P = Pf/(1 − z), z = ε e^(−kt); while it moves P = m R/(u V) with u = 1/T from the nodes of the
//! quadrature ([`Panel`]). The record shows it a delay later, behind a lag, with an offset and a drift. Without a lag it turns
//! where P' = −r, that is where Pf k z = r (1 − z)²: at two places, z and 1/z. Behind a lag it is cut into pieces over which
//! the pressure is a polynomial ([`filter`](crate::filter)). Times in s from the end of the push on the record, pressures in Pa.

mod pieces;
mod samples;

use crate::exact_rows::{Ends, Tests};
use crate::filter::{Sensor, TERMS, ToPowers};
use crate::finish::SETTLED;
use crate::fit;
use crate::kept::{Heat, Panel};
use crate::lanes::{Lanes, WIDTH};
use crate::look::{Look, Question};
use crate::outcome::Outcome;
use crate::reader::ROUNDING;
use crate::regression::Regression;
use crate::scenario::Scenario;
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::real::Real;
use pieces::{Build, Held, Hold, Piece, Sensors, Shown};
use pulp::Arch;

/// Relaxations in the push of a lagging or late record up to which it is read from the closed form.
const MOST_RELAXATIONS: f64 = 20.0;

/// The sensor of one test.
#[derive(Clone, Copy, Debug)]
pub struct Behind {
    /// Lag, offset and drift.
    pub sensor: Sensor,
    /// Time by which the record is behind the gas, s.
    pub delay: f64,
}

/// The answers about one record.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    /// Extreme reading from the end of the push on, Pa.
    pub peak: f64,
    /// Time of that reading, s.
    peak_time: f64,
    /// Reading at the end of the test, Pa.
    pub last: f64,
    /// From when on it is within 1 % of that for good.
    pub settling: f64,
}

impl Behind {
    /// That of a scenario with the effects of a set.
    pub fn new(set: EffectSet, scenario: &Scenario) -> Self {
        let values = &scenario.chamber.effects;
        Self { sensor: Sensor::new(set, values), delay: effects::delay(set, values) }
    }

    /// Whether the closed form is the quicker way to what is shown of a sealed test. With a lag or a delay the push is read
    /// in parts; their number grows with the push over the relaxation, and the time and memory they take with it.
    pub fn is_quick(&self, scenario: &Scenario) -> bool {
        if self.sensor.lag == 0.0 && self.delay == 0.0 {
            return true;
        }
        let Scenario { chamber, initial_pressure_pa, ambient_temperature_k: ambient, .. } = scenario;
        let [first, last] =
            [scenario.initial_position_m, scenario.final_position_m].map(|x| chamber.geometry.volume(x));
        let pressure = initial_pressure_pa * first / last;
        let at_rest = Closed::filled(chamber, pressure, *ambient, last, *ambient);
        scenario.push_time_s * at_rest.rate(last) < MOST_RELAXATIONS
    }
}

impl Answer {
    /// The outcome, where that of a record that shows the gas is `gas`.
    pub fn outcome(&self, s: &Scenario, regression: Option<Regression>, wall: f64, gas: Outcome) -> Outcome {
        let distance = (self.peak - self.last).abs();
        let unsettled = gas.pressure_final_pa * (1.0 - wall / gas.temperature_final_k).abs();
        let stands = self.settling == 0.0 && distance <= ROUNDING * self.last.abs();
        let positions = [s.initial_position_m, s.final_position_m];
        Outcome {
            pressure_peak_pa: self.peak,
            pressure_final_pa: self.last,
            fit: regression.and_then(|found| fit::steps(s, positions, s.initial_pressure_pa, found)),
            settling_time_s: (unsettled <= SETTLED * distance || stands).then_some(self.settling),
            ..gas
        }
    }
}

/// Working memory, kept from one group to the next.
#[derive(Default)]
pub struct Memory {
    panels: Vec<Panel<Lanes>>,
    pieces: Vec<Piece>,
    /// By piece and lane, where the record turns inside: time and value; NaN where it does not.
    turns: Vec<[f64; 2]>,
    to_powers: ToPowers,
}

/// Records, one a lane; all of them lag or none, and all of them are delayed or none.
pub struct Readings<'a, const LAGS: bool> {
    arch: Arch,
    tests: &'a Tests,
    memory: &'a mut Memory,
    held: Held,
    sensors: Sensors,
    duration: Lanes,
}

impl<'a, const LAGS: bool> Readings<'a, LAGS> {
    /// Of these tests, whose heat is exchanged as `heat` says, with their sensors; `before` is the gas's pressure before the
    /// test, Pa.
    pub fn new(
        arch: Arch,
        memory: &'a mut Memory,
        tests: &'a Tests,
        ends: &Ends,
        heat: &(impl Heat<Lanes> + Sync),
        behind: impl Fn(usize) -> Behind,
        before: Lanes,
    ) -> Self {
        let wall = tests.closed.ambient_temperature;
        let held = Held {
            at_rest: tests.closed.mass_gas_constant * wall / tests.to,
            excess: Lanes::ONE - wall / ends.pushed,
            rate: ends.rate,
        };
        let [mut lag, mut delay, mut offset, mut drift] = [Lanes::ZERO; 4];
        for lane in 0..WIDTH {
            let Behind { sensor, delay: by } = behind(lane);
            (lag[lane], delay[lane], drift[lane]) = (sensor.lag, by, sensor.drift);
            offset[lane] = sensor.shown(0.0, tests.push[lane]);
        }
        let sensors = Sensors { lag, delay, offset, drift };
        memory.pieces.clear();
        let mut readings = Self { arch, tests, memory, held, sensors, duration: tests.hold };
        let delayed = delay[0] > 0.0;
        if LAGS || delayed {
            arch.dispatch(Build { readings: &mut readings, heat, delayed, before });
        }
        if !LAGS {
            readings.add_hold();
        }
        readings.find_turns();
        readings
    }

    /// The hold without a lag: pieces between the turns, which the closed form has.
    fn add_hold(&mut self) {
        let Self { held, sensors, duration, .. } = *self;
        let mut corners = [sensors.delay, duration, duration, duration];
        for lane in 0..WIDTH {
            let end = duration[lane] - sensors.delay[lane];
            let turns = turns(held.at_rest[lane], held.excess[lane], held.rate[lane], sensors.drift[lane], end);
            corners[1][lane] = sensors.delay[lane] + turns[0];
            corners[2][lane] = sensors.delay[lane] + turns[1];
        }
        self.arch.dispatch(Hold { held, sensors, corners, pieces: &mut self.memory.pieces });
    }

    /// A piece of each lane, not the same one of all.
    fn gather(&self, piece: impl Fn(usize) -> usize) -> Shown<LAGS> {
        let mut all = self.memory.pieces[piece(0)];
        for lane in 1..WIDTH {
            let from = &self.memory.pieces[piece(lane)];
            for end in 0..2 {
                all.times[end][lane] = from.times[end][lane];
            }
            for term in 0..TERMS {
                all.gas[term][lane] = from.gas[term][lane];
            }
            all.lagged[lane] = from.lagged[lane];
            all.exact[lane] = from.exact[lane];
        }
        Shown { piece: all, held: self.held, sensors: self.sensors }
    }

    /// Where the records turn round inside a piece: of each lane the first such piece, then the second, and so on.
    fn find_turns(&mut self) {
        let count = self.memory.pieces.len();
        self.memory.turns.clear();
        self.memory.turns.resize(count * WIDTH, [f64::NAN; 2]);
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
            let [times, values, ..] =
                self.arch.dispatch(Look { times: reading.piece.times, reading, question: Question::Turn });
            for lane in (0..WIDTH).filter(|lane| next[*lane] < count) {
                self.memory.turns[next[lane] * WIDTH + lane] = [times[lane], values[lane]];
            }
            for next in &mut next {
                *next = (*next + 1).min(count);
            }
        }
    }

    /// A lane's corners in the order of their times: piece, time and value. Between them the record is monotone.
    fn corners(&self, lane: usize) -> impl DoubleEndedIterator<Item = (usize, f64, f64)> {
        self.memory.pieces.iter().enumerate().flat_map(move |(index, piece)| {
            let [time, value] = self.memory.turns[index * WIDTH + lane];
            let turn = (!time.is_nan()).then_some((index, time, value));
            let [begin, end] = [0, 1].map(|end| Some((index, piece.times[end][lane], piece.shown[end][lane])));
            [begin, turn, end].into_iter().flatten()
        })
    }

    /// The answers about each record; an expansion's peak is its smallest pressure.
    pub fn answers(&self) -> [Answer; WIDTH] {
        let mut answers = [Answer::default(); WIDTH];
        let mut within = [(0, [0.0; 2]); WIDTH];
        let mut band = Lanes::ZERO;
        for lane in 0..WIDTH {
            let answer = &mut answers[lane];
            let sign = if self.tests.to[lane] > self.tests.from[lane] { -1.0 } else { 1.0 };
            answer.peak = f64::NEG_INFINITY;
            for (_, time, value) in self.corners(lane) {
                if sign * value > answer.peak {
                    (answer.peak, answer.peak_time) = (sign * value, time);
                }
                answer.last = value;
            }
            answer.peak *= sign;
            band[lane] = (SETTLED * (answer.peak - answer.last).abs()).max(ROUNDING * answer.last.abs());
            // From the end back to the last corner outside.
            let mut later = self.duration[lane];
            for (piece, time, value) in self.corners(lane).rev() {
                if (value - answer.last).abs() > band[lane] {
                    within[lane] = (piece, [time, later]);
                    break;
                }
                later = time;
            }
        }
        let between = [0, 1].map(|end| Lanes::from_fn(|lane| within[lane].1[end]));
        let reading = self.gather(|lane| within[lane].0);
        let value = Lanes::from_fn(|lane| answers[lane].last);
        let question = Question::Enter { between, value, band };
        let [settled, ..] = self.arch.dispatch(Look { times: reading.piece.times, reading, question });
        for lane in 0..WIDTH {
            // A record that never is outside has no piece to enter from.
            let outside = within[lane].1[1] > within[lane].1[0];
            answers[lane].settling = if outside { settled[lane].max(0.0) } else { within[lane].1[0] };
        }
        answers
    }
}

/// Times since the push, s, up to `end` at which a relaxation with a drift turns round; `end` in place of those it lacks.
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
