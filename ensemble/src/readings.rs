//! What a sensor shows of tests that have a closed form, one a lane: a filter of a known pressure, without integration.
//!
//! While the piston rests P = Pf/(1 − z), z = ε e^(−kt); while it moves P = m R/(u V) with u = 1/T from the nodes of the
//! quadrature ([`Panel`]). The record shows it a delay later, behind a lag, with an offset and a drift. Without a lag it turns
//! where P' = −r, that is where Pf k z = r (1 − z)²: at two places, z and 1/z. Behind a lag it is cut into pieces over which
//! the pressure is a polynomial ([`filter`](crate::filter)). Times in s from the end of the push on the record, pressures in Pa.

use crate::exact_rows::{Ends, Tests};
use crate::filter::{CUTS, Lagged, Sensor, TERMS, ToPowers};
use crate::finish::SETTLED;
use crate::fit;
use crate::kept::{Heat, Panel};
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::outcome::Outcome;
use crate::reader::{Look, Question, ROUNDING, Reading};
use crate::regression::{Records, Regression};
use crate::root::Curve;
use crate::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use crate::scenario::Scenario;
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Pieces, over which the pressure is a polynomial, of a part of the push.
const PIECES_OF_A_PART: usize = 6;
/// Ends of the pieces, over which the pressure of the hold is a polynomial, in 1/k; the last ends with the record.
const ENDS: [f64; 13] = [0.15, 0.33, 0.55, 0.85, 1.2, 1.7, 2.4, 3.3, 4.6, 6.5, 9.5, 14.0, f64::INFINITY];
/// A length, s, to divide by where there is none.
const SHORTEST: f64 = 1e-300;

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
    /// Its peak, Pa.
    pub peak: f64,
    /// When it stands.
    peak_time: f64,
    /// At the end of the test, Pa.
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

/// A piece of each record.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Its begin and end.
    times: [Lanes; 2],
    /// What is shown there, Pa, and the slopes, Pa/s.
    shown: [Lanes; 2],
    slopes: [Lanes; 2],
    /// Coefficients of the gas's pressure, Pa, in powers of the share of the piece, where they are used.
    gas: [Lanes; TERMS],
    /// The lagging reading at its begin, Pa.
    lagged: Lanes,
    /// 1 where it is of the hold and read from the closed form, else 0.
    exact: Lanes,
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

/// The relaxation of the hold over the time since the push, s, of the gas.
#[derive(Clone, Copy, Debug)]
struct Held {
    at_rest: Lanes,
    excess: Lanes,
    rate: Lanes,
}

impl Curve for Held {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.at_rest / (Lanes::ONE - self.excess * (-(self.rate * time)).exp())
    }
}

/// The pressure during the push over the (negative) time since its end, s, of the gas.
struct Pushed<'a> {
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
struct Shown<const LAGS: bool> {
    piece: Piece,
    held: Held,
    sensors: Sensors,
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
struct Sensors {
    lag: Lanes,
    delay: Lanes,
    offset: Lanes,
    drift: Lanes,
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

    /// Number of the first sample that counts: the larger of those beside the peak.
    fn first_samples(&self, answers: &[Answer; WIDTH]) -> Lanes {
        let push = self.tests.push;
        let push_end = Lanes::from_fn(|lane| samples::from(push[lane]));
        let after = Lanes::from_fn(|lane| samples::from(push[lane] + answers[lane].peak_time).max(push_end[lane]));
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
            self.arch.dispatch(Look { times: reading.piece.times, reading, question })[0]
        });
        Lanes::from_fn(|lane| {
            let sign = if self.tests.to[lane] > self.tests.from[lane] { -1.0 } else { 1.0 };
            let back = after[lane] > push_end[lane] && sign * earlier[lane] > sign * later[lane];
            after[lane] - f64::from(back)
        })
    }

    /// Lays the samples from the peak on out for the regression.
    pub fn lay_out(&self, answers: &[Answer; WIDTH], records: &mut Records) {
        let first = self.first_samples(answers);
        records.clear();
        self.arch.dispatch(Sample { readings: self, first, records });
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

/// Pressures of the push, and the pieces of records up to the hold's begin, or where they lag to their ends.
struct Build<'b, 'a, const LAGS: bool, H> {
    readings: &'b mut Readings<'a, LAGS>,
    heat: &'b H,
    delayed: bool,
    before: Lanes,
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
struct Hold<'a> {
    held: Held,
    sensors: Sensors,
    corners: [Lanes; 4],
    pieces: &'a mut Vec<Piece>,
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

/// Samples, from the first that counts on, for the regression.
struct Sample<'b, 'a, const LAGS: bool> {
    readings: &'b Readings<'a, LAGS>,
    first: Lanes,
    records: &'b mut Records,
}

impl<const LAGS: bool> WithSimd for Sample<'_, '_, LAGS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(mut self, _: I) {
        let Readings { memory, held, sensors, duration, .. } = self.readings;
        let held_from = memory.pieces.iter().position(|piece| piece.exact == Lanes::ONE);
        let (pieces, rest) = memory.pieces.split_at(held_from.unwrap_or(memory.pieces.len()));
        for piece in pieces {
            self.add(black_box(piece));
        }
        // Without a lag the hold's pieces are as long as from turn to turn.
        let Some(piece) = rest.first() else { return };
        let (mut from, slowness) = (piece.times[0], held.rate.recip());
        for end in black_box(&crate::exact_rows::ENDS) {
            let to = (sensors.delay + slowness * *end).min(*duration);
            self.add(black_box(&Piece { times: [from, to], ..*piece }));
            from = to;
        }
    }
}

impl<const LAGS: bool> Sample<'_, '_, LAGS> {
    #[inline(always)]
    fn add(&mut self, piece: &Piece) {
        let Readings { tests, held, sensors, .. } = self.readings;
        let (push, first) = (tests.push, black_box(self.first));
        let end = black_box(push + piece.times[1]);
        let next = black_box(each_lane!(i => samples::after(end.0[i])));
        let count = black_box((next - first).max(Lanes::ZERO));
        let nodes = black_box(Samples { first, count }.nodes());
        let curve = Shown::<LAGS> { piece: *piece, held: *held, sensors: *sensors };
        let mut pressure = [Lanes::ZERO; POINTS];
        for k in 0..POINTS {
            let time = nodes.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - push;
            // Nodes without weight may stand anywhere.
            pressure[k] = black_box(curve.at(time.max(piece.times[0]).min(piece.times[1])));
        }
        self.records.push(first, &nodes, &pressure);
        self.first = black_box(first.max(next));
    }
}
