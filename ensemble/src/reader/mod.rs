//! What is asked of the records of traced rows: peaks and settling here, samples for the regression in [`regressions`].
//!
//! A record is monotone between the knots of its trace and the places in between where it turns round; with those at
//! hand, all else is a matter of comparing. Only intervals that turn, the one in which the record settles, and with the
//! regression those that hold samples are looked into, as many at once as there are lanes.

mod bends;
mod curves;
mod interpolant;
mod regressions;

pub use bends::Bends;

use crate::filter::{CUTS, Sensor, ToPowers};
use crate::integrator::step::View;
use crate::lanes::{Lanes, WIDTH};
use crate::look::{Look, Question};
use crate::outcome::{ROUNDING, SETTLED};
use crate::plan::{Plan, Stretch};
use crate::regression::Records;
use crate::regression::samples::POINTS;
use bends::Straight;
use chamber::real::Real;
use curves::{LaggedPiece, Prompt};
use pulp::Arch;
use std::ops::Range;

/// Index of the pressure and of the temperature where both are shown.
const PRESSURE: usize = 0;
const TEMPERATURE: usize = 1;

/// What is seen at a moment of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// The moment in the integrator's time, from the segment's start.
    pub at: f64,
    /// Pressure, Pa, and temperature, K, of the gas, and their slopes in the integrator's time.
    pub view: View<f64>,
    /// Whether the rates have a kink there.
    pub kink: bool,
}

/// The answers about one row. Pressures of the record, temperatures of the gas.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowAnswer {
    /// Peak from the end of the push on, Pa.
    pub pressure_peak: f64,
    /// When it stands, s of the record.
    pub peak_time: f64,
    /// Reading at the end of the test, Pa.
    pub pressure_final: f64,
    /// Peak from the end of the push on, K.
    pub temperature_peak: f64,
    /// Temperature of the gas at the end of the test, K.
    pub temperature_final: f64,
    /// From the end of the push until within 1 % for good, s.
    pub settling: f64,
    /// Gas that flows in at the end of the test, less what flows out, over the gas there, 1/s.
    pub inflow: f64,
    /// Rate of the gas's pressure at the end of the test, over the pressure, 1/s.
    pub pressure_rate: f64,
}

/// The trace of a row: the knots of each of its segments from [`Traces::begin`] on.
#[derive(Clone, Copy, Debug)]
struct Trace<'a> {
    plan: &'a Plan,
    sensor: Sensor,
    bends: Bends<'a>,
    /// Pressure of the gas before the test, Pa.
    before: f64,
}

impl Trace<'_> {
    /// 1 where peaks are tops, −1 where they are bottoms: of an expansion.
    fn sign(&self) -> f64 {
        if self.plan.expands { -1.0 } else { 1.0 }
    }

    /// Cuts a segment, by its number, stretch and knots, into pieces.
    fn cut(&self, segment: u32, stretch: &Stretch, knots: &[Knot], pieces: &mut Vec<TracePiece>) {
        let Sensor { lag, drift, .. } = self.sensor;
        let mut cuts = CUTS.map(|cut| cut * lag).into_iter().peekable();
        // Time, what the record shows there and its slope, of a sensor that follows at once.
        let seen = |knot: &Knot| {
            let (time, pace) = stretch.clock.time_and_pace(knot.at);
            let shown = self.sensor.shown(knot.view.value[PRESSURE], stretch.elapsed + time);
            (time, shown, knot.view.slope[PRESSURE] / pace + drift)
        };
        let mut begin = seen(&knots[0]);
        for (knot, to) in knots[1..].iter().enumerate() {
            let end = seen(to);
            let mut piece = TracePiece {
                segment,
                knot: knot as u32,
                lag: 0,
                times: [begin.0, end.0],
                shown: [begin.1, end.1],
                slopes: [begin.2, end.2],
                straight: Straight::READING,
            };
            // What a lagging sensor shows is found out later: `follow_lags`.
            while let Some(cut) = cuts.next_if(|cut| lag > 0.0 && *cut < end.0) {
                if cut > piece.times[0] {
                    piece.times[1] = cut;
                    pieces.push(piece);
                    piece.times = [cut, end.0];
                }
            }
            pieces.push(piece);
            begin = end;
        }
    }
}

/// Traces of rows, with memory that is kept from one group of rows to the next.
#[derive(Default)]
pub struct Memory {
    knots: Vec<Knot>,
    segments: Vec<Segment>,
    pieces: Vec<TracePiece>,
    /// By row.
    cut: Vec<Cut>,
    /// In the order of the pieces.
    turns: Vec<TraceTurn>,
    /// Of the pieces behind sensors that lag.
    lags: Vec<LaggedPiece<f64>>,
    to_powers: ToPowers,
    jobs: Vec<Job>,
    records: Records,
}

/// A stretch of a row with its knots.
#[derive(Clone, Debug)]
struct Segment {
    row: u32,
    stretch: u32,
    knots: Range<usize>,
}

/// A part of a record between two knots, or of such a part where the sensor lags or bends its reading.
#[derive(Clone, Copy, Debug)]
struct TracePiece {
    segment: u32,
    /// The knot at which its interval begins, of its segment's.
    knot: u32,
    /// Its place among [`Memory::lags`], where the sensor lags.
    lag: u32,
    /// Times of its ends from the segment's start, s.
    times: [f64; 2],
    /// What the record shows at both ends, Pa, and its slopes there, Pa/s; up to [`Traces::bend`], the reading.
    shown: [f64; 2],
    slopes: [f64; 2],
    straight: Straight,
}

/// The pieces that a record is cut into.
#[derive(Clone, Debug)]
struct Cut {
    all: Range<usize>,
    /// The reading at the start of the first, Pa.
    begin: f64,
    /// Those that it shows between the end of the push and the end of the test.
    shown: Range<usize>,
    /// Where it turns round in these.
    turns: Range<usize>,
}

/// Where a record turns round inside a piece.
#[derive(Clone, Copy, Debug)]
struct TraceTurn {
    piece: usize,
    /// Time from the segment's start, s.
    time: f64,
    /// What the record shows, Pa.
    shown: f64,
}

/// A question about a piece, or about the temperature in an interval.
#[derive(Clone, Copy, Debug)]
struct Job {
    piece: usize,
    numbers: [f64; POINTS],
    answer: [f64; POINTS],
}

impl Job {
    fn new(piece: usize, numbers: [f64; POINTS]) -> Self {
        Self { piece, numbers, answer: [0.0; POINTS] }
    }
}

/// The first stretch of a row that is looked into.
pub fn seen_from(plan: &Plan, sensor: &Sensor) -> usize {
    if sensor.lag > 0.0 { 0 } else { plan.window[0].min(plan.hold) }
}

/// Rows whose pressure is traced, with the knots of their traces.
pub struct Traces<'a> {
    rows: Vec<Trace<'a>>,
    memory: &'a mut Memory,
}

impl<'a> Traces<'a> {
    /// Begins without rows; what `memory` held is dropped.
    pub fn new(memory: &'a mut Memory) -> Self {
        memory.knots.clear();
        memory.segments.clear();
        Self { rows: Vec::new(), memory }
    }

    /// Begins the trace of a row: its pressure before the test, Pa.
    pub fn begin(&mut self, plan: &'a Plan, sensor: Sensor, bends: Bends<'a>, before: f64) {
        self.rows.push(Trace { plan, sensor, bends, before });
    }

    /// Goes on with a stretch of that row, whose knots `fill` appends.
    pub fn stretch(&mut self, stretch: usize, fill: impl FnOnce(&mut Vec<Knot>)) {
        let knots = &mut self.memory.knots;
        let from = knots.len();
        fill(knots);
        if knots.len() > from + 1 {
            let (row, stretch) = (self.rows.len() as u32 - 1, stretch as u32);
            self.memory.segments.push(Segment { row, stretch, knots: from..knots.len() });
        }
    }

    /// Number of rows begun so far.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Number of knots of all rows together.
    pub fn knots(&self) -> usize {
        self.memory.knots.len()
    }

    /// The answers about each row; none about those without a record.
    pub fn answers(&mut self, arch: Arch) -> Vec<Option<RowAnswer>> {
        self.cut();
        self.follow_lags(arch);
        self.bend(arch);
        self.find_turns(arch);
        self.memory.jobs.clear();
        let mut answers: Vec<Option<RowAnswer>> = (0..self.rows.len()).map(|row| self.answer(row)).collect();
        self.find_settling(arch, &mut answers);
        self.find_temperatures(arch, &mut answers);
        answers
    }

    fn of_segment(&self, segment: u32) -> (&Trace<'a>, &Stretch) {
        let Segment { row, stretch, .. } = self.memory.segments[segment as usize];
        let row = &self.rows[row as usize];
        (row, &row.plan.stretches[stretch as usize])
    }

    /// Cuts all records into pieces.
    fn cut(&mut self) {
        let Memory { knots, segments, pieces, cut, .. } = &mut *self.memory;
        pieces.clear();
        cut.clear();
        let mut segments = segments.iter().enumerate().peekable();
        for (number, row) in self.rows.iter().enumerate() {
            let begin = pieces.len();
            let mut shown = begin..begin;
            while let Some((index, segment)) = segments.next_if(|(_, segment)| segment.row as usize == number) {
                let (stretch, from) = (segment.stretch as usize, pieces.len());
                row.cut(index as u32, &row.plan.stretches[stretch], &knots[segment.knots.clone()], pieces);
                let [first, end] = row.plan.window;
                if (first..end).contains(&stretch) {
                    shown = if shown.is_empty() { from } else { shown.start }..pieces.len();
                }
            }
            let reading = pieces.get(begin).map_or(row.before, |first| first.shown[0]);
            cut.push(Cut { all: begin..pieces.len(), begin: reading, shown, turns: 0..0 });
        }
    }

    /// The pieces of a row.
    fn pieces_of(&self, row: usize) -> Range<usize> {
        self.memory.cut[row].all.clone()
    }

    /// Where the records turn round.
    fn find_turns(&mut self, arch: Arch) {
        let Memory { pieces, cut, jobs, .. } = &mut *self.memory;
        jobs.clear();
        for Cut { shown, turns, .. } in cut {
            let first = jobs.len();
            for (index, piece) in shown.clone().zip(&pieces[shown.clone()]) {
                if piece.slopes[0] * piece.slopes[1] < 0.0 {
                    jobs.push(Job::new(index, [0.0; POINTS]));
                }
            }
            *turns = first..jobs.len();
        }
        self.work(arch, |_| Question::Turn);
        let Memory { turns, jobs, .. } = &mut *self.memory;
        turns.clear();
        turns.extend(jobs.iter().map(|&Job { piece, answer: [time, shown, ..], .. }| TraceTurn { piece, time, shown }));
    }

    /// The reading of a row's sensor, Pa, at a time of the record, s, before the gas of the test arrives.
    fn before(&self, row: usize, time: f64) -> f64 {
        self.rows[row].sensor.shown(self.rows[row].before, time)
    }

    /// All but temperatures and the settling time; where that has to be found inside a piece, it becomes a job.
    fn answer(&mut self, row: usize) -> Option<RowAnswer> {
        let Memory { pieces, cut, turns, .. } = &*self.memory;
        let Cut { all, shown, turns: of_row, .. } = &cut[row];
        if all.is_empty() {
            return None;
        }
        let (Trace { plan, bends, sensor, .. }, turns) = (&self.rows[row], &turns[of_row.clone()]);
        let sign = self.rows[row].sign();
        // The extreme is where the record begins, or ends a piece, or turns round.
        let (mut pressure, mut peak_time) = (f64::NEG_INFINITY, plan.push_end);
        if plan.push_end < plan.delay {
            let [begin, end] = [plan.push_end, plan.delay.min(plan.duration)].map(|time| self.before(row, time));
            pressure = sign * bends.shown(begin);
            for reading in bends.between(begin, end) {
                let shown = sign * bends.shown(reading);
                if shown > pressure {
                    (pressure, peak_time) = (shown, plan.push_end + (reading - begin) / sensor.drift);
                }
            }
        }
        let mut look = |piece: &TracePiece, time: f64, value: f64| {
            if sign * value > pressure {
                (pressure, peak_time) = (sign * value, self.record_time(piece.segment, time));
            }
        };
        let shown_pieces = &pieces[shown.clone()];
        if let Some(first) = shown_pieces.first() {
            look(first, first.times[0], first.shown[0]);
        }
        for piece in shown_pieces {
            look(piece, piece.times[1], piece.shown[1]);
        }
        for turn in turns {
            look(&pieces[turn.piece], turn.time, turn.shown);
        }
        let at_rest = || bends.shown(self.before(row, plan.duration));
        let pressure_final = shown_pieces.last().map_or_else(at_rest, |last| last.shown[1]);
        let pressure_peak = sign * pressure.max(sign * pressure_final);
        let band = SETTLED * (pressure_peak - pressure_final).abs();
        let band = band.max(ROUNDING * pressure_final.abs());
        // Back from the end to where the record was outside the last time, and the next such place after it.
        let outside = |value: f64| (value - pressure_final).abs() > band;
        let mut turns = turns.iter().rev().peekable();
        let entry = shown.clone().rev().find_map(|index| {
            let TracePiece { times: [begin, mut later], shown: [value, _], .. } = pieces[index];
            if let Some(turn) = turns.next_if(|turn| turn.piece == index) {
                if outside(turn.shown) {
                    return Some((index, turn.time, later));
                }
                later = turn.time;
            }
            outside(value).then_some((index, begin, later))
        });
        if let Some((piece, from, later)) = entry {
            self.memory.jobs.push(Job::new(piece, [from, later, pressure_final, band]));
        }
        let temperature_peak = f64::NEG_INFINITY;
        Some(RowAnswer { pressure_peak, peak_time, pressure_final, temperature_peak, ..RowAnswer::default() })
    }

    /// Final and peak temperatures of the gas.
    fn find_temperatures(&mut self, arch: Arch, answers: &mut [Option<RowAnswer>]) {
        // Segments and intervals in which the temperature comes to a peak.
        let mut turns: Vec<(u32, u32)> = Vec::new();
        let sign = |rows: &[Trace], row: u32| rows[row as usize].sign();
        for (index, segment) in self.memory.segments.iter().enumerate() {
            let Some(answer) = &mut answers[segment.row as usize] else { continue };
            if (segment.stretch as usize) < self.rows[segment.row as usize].plan.hold {
                continue;
            }
            let sign = sign(&self.rows, segment.row);
            let mut rises = false;
            for (knot, Knot { view, .. }) in self.memory.knots[segment.knots.clone()].iter().enumerate() {
                let [value, slope] = [view.value, view.slope].map(|of| sign * of[TEMPERATURE]);
                answer.temperature_peak = answer.temperature_peak.max(value);
                if rises && slope < 0.0 {
                    turns.push((index as u32, knot as u32 - 1));
                }
                rises = slope > 0.0;
                answer.temperature_final = view.value[TEMPERATURE];
                (answer.inflow, answer.pressure_rate) = (view.inflow(), view.pressure_rate());
            }
        }
        for group in turns.chunks(WIDTH) {
            let turn = |lane: usize| group[lane.min(group.len() - 1)];
            let inside = self.stencils(TEMPERATURE, turn);
            let times = [0, 1].map(|end| {
                Lanes::from_fn(|lane| {
                    let (segment, knot) = turn(lane);
                    let knots = self.memory.segments[segment as usize].knots.clone();
                    self.of_segment(segment).1.clock.time_and_pace(self.memory.knots[knots][knot as usize + end].at).0
                })
            });
            let reading = Prompt { inside, gain: Lanes::ONE, offset: Lanes::ZERO, drift: Lanes::ZERO };
            let found = Look { reading, times, question: Question::Turn }.answer(arch);
            for (lane, &(segment, _)) in group.iter().enumerate() {
                let row = self.memory.segments[segment as usize].row;
                if let Some(answer) = &mut answers[row as usize] {
                    answer.temperature_peak = answer.temperature_peak.max(sign(&self.rows, row) * found[1][lane]);
                }
            }
        }
        for (row, answer) in answers.iter_mut().enumerate() {
            if let Some(answer) = answer {
                answer.temperature_peak *= sign(&self.rows, row as u32);
            }
        }
    }

    /// Time of the record, s, at a time of a segment.
    fn record_time(&self, segment: u32, time: f64) -> f64 {
        self.of_segment(segment).1.elapsed + time
    }

    /// When the records come within 1 % of their ends for good: does the jobs of [`Traces::answer`].
    fn find_settling(&mut self, arch: Arch, answers: &mut [Option<RowAnswer>]) {
        self.work(arch, |[outside, later, value, band]| Question::Enter { between: [outside, later], value, band });
        for job in &self.memory.jobs {
            let segment = self.memory.pieces[job.piece].segment;
            let row = self.memory.segments[segment as usize].row as usize;
            if let Some(answer) = &mut answers[row] {
                let settled = self.record_time(segment, job.answer[0]) - self.rows[row].plan.push_end;
                answer.settling = settled.max(0.0);
            }
        }
    }
}
