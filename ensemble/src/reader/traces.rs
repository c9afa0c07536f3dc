//! Traces of rows: the knots of their segments, and the pieces of their records. Pieces reach from knot to knot and are cut further for
//! sensors with a lag or a curve of the reading.

use super::bends::{Bends, Straight};
use super::interpolant::{Knot, Stencils};
use crate::filter::{CUTS, TERMS, ToPowers};
use crate::plan::{Plan, TimeSpan};
use crate::regression::Records;
use crate::regression::samples::POINTS;
use crate::scenario::Scenario;
use crate::sensor::Sensor;
use std::ops::Range;

/// Indices of pressure and temperature in a view.
pub const PRESSURE: usize = 0;
pub const TEMPERATURE: usize = 1;

/// The trace of a row: the knots of each of its segments from [`Traces::begin`] on.
#[derive(Clone, Copy, Debug)]
pub struct Trace<'a> {
    pub scenario: &'a Scenario,
    pub plan: &'a Plan,
    pub sensor: Sensor,
    pub bends: Bends<'a>,
}

impl Trace<'_> {
    /// 1 if peaks are maxima, −1 if they are minima: for an expansion.
    pub fn sign(&self) -> f64 {
        if self.scenario.expands() { -1.0 } else { 1.0 }
    }

    /// Cuts a segment, given by its index, span and knots, into pieces.
    pub fn cut(&self, segment: u32, span: &TimeSpan, knots: &[Knot], pieces: &mut Vec<TracePiece>) {
        let Sensor { lag, drift, .. } = self.sensor;
        let mut cuts = CUTS.map(|cut| cut * lag).into_iter().peekable();
        // Time, reading and its slope for an instantaneous sensor.
        let seen = |knot: &Knot| {
            let (time, pace) = span.transformation.time_and_pace(knot.at);
            let shown = self.sensor.shown(knot.view.value[PRESSURE], span.elapsed + time);
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
            // The readings of a lagging sensor follow later: `follow_lags`.
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

/// Working memory of traces, kept from one group of rows to the next.
#[derive(Default)]
pub struct Memory {
    pub knots: Vec<Knot>,
    pub segments: Vec<Segment>,
    pub pieces: Vec<TracePiece>,
    /// The pieces of each row.
    pub cut: Vec<Cut>,
    /// Answered queries for the turns of the records, in the order of the pieces.
    pub turns: Vec<Job>,
    /// Of the pieces of lagging sensors.
    pub lags: Vec<LaggedPiece<f64>>,
    pub to_powers: ToPowers,
    pub jobs: Vec<Job>,
    pub records: Records,
}

/// A span of a row and its knots.
#[derive(Clone, Debug)]
pub struct Segment {
    pub row: u32,
    pub span: u32,
    pub knots: Range<usize>,
}

/// A piece of a record: between two knots, or a part of that.
#[derive(Clone, Copy, Debug)]
pub struct TracePiece {
    pub segment: u32,
    /// Index, in its segment, of the knot at which its interval begins.
    pub knot: u32,
    /// Index in [`Memory::lags`], if the sensor lags.
    pub lag: u32,
    /// Begin and end, in s from the segment's start.
    pub times: [f64; 2],
    /// Record at both ends, Pa, and its slopes there, Pa/s; before [`Traces::bend`], the reading.
    pub shown: [f64; 2],
    pub slopes: [f64; 2],
    pub straight: Straight,
}

/// The pieces of a record.
#[derive(Clone, Debug)]
pub struct Cut {
    pub all: Range<usize>,
    /// Reading at the start of the first, Pa.
    pub begin: f64,
    /// Those shown between the end of the push and the end of the test.
    pub shown: Range<usize>,
    /// The turns in these.
    pub turns: Range<usize>,
}

/// The effect of a piece on the reading of a lagging sensor: at its end the reading is `decay` times the initial one plus `fed`, Pa.
#[derive(Clone, Copy, Debug, Default)]
pub struct LaggedPiece<R> {
    /// Coefficients of the gas pressure, Pa, in powers of the place from 0 to 1.
    pub pressure: [R; TERMS],
    /// Start and length, s.
    pub from: R,
    pub length: R,
    pub decay: R,
    pub fed: R,
    /// Reading at its start, Pa, once it is known.
    pub begin: R,
}

/// A query on a piece.
#[derive(Clone, Copy, Debug)]
pub struct Job {
    pub piece: usize,
    pub numbers: [f64; POINTS],
    pub answer: [f64; POINTS],
}

impl Job {
    pub fn new(piece: usize, numbers: [f64; POINTS]) -> Self {
        Self { piece, numbers, answer: [0.0; POINTS] }
    }
}

/// The first span of a row that is read.
pub fn seen_from(plan: &Plan, sensor: &Sensor) -> usize {
    if sensor.lag > 0.0 { 0 } else { plan.window[0].min(plan.hold) }
}

/// The traces of a group of rows.
pub struct Traces<'a> {
    pub rows: Vec<Trace<'a>>,
    pub memory: &'a mut Memory,
}

impl<'a> Traces<'a> {
    /// No rows yet; clears `memory`.
    pub fn new(memory: &'a mut Memory) -> Self {
        memory.knots.clear();
        memory.segments.clear();
        Self { rows: Vec::new(), memory }
    }

    /// Begins the trace of a row.
    pub fn begin(&mut self, scenario: &'a Scenario, plan: &'a Plan, sensor: Sensor, bends: Bends<'a>) {
        self.rows.push(Trace { scenario, plan, sensor, bends });
    }

    /// Adds a span of that row; `fill` appends its knots.
    pub fn span(&mut self, span: usize, fill: impl FnOnce(&mut Vec<Knot>)) {
        let knots = &mut self.memory.knots;
        let from = knots.len();
        fill(knots);
        if knots.len() > from + 1 {
            let (row, span) = (self.rows.len() as u32 - 1, span as u32);
            self.memory.segments.push(Segment { row, span, knots: from..knots.len() });
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Number of knots of all rows.
    pub fn knots(&self) -> usize {
        self.memory.knots.len()
    }

    /// The row of a segment, and its span.
    pub fn of_segment(&self, segment: u32) -> (&Trace<'a>, &TimeSpan) {
        let Segment { row, span, .. } = self.memory.segments[segment as usize];
        let row = &self.rows[row as usize];
        (row, &row.plan.spans[span as usize])
    }

    /// Cuts all records into pieces.
    pub fn cut(&mut self) {
        let Memory { knots, segments, pieces, cut, .. } = &mut *self.memory;
        pieces.clear();
        cut.clear();
        let mut segments = segments.iter().enumerate().peekable();
        for (number, row) in self.rows.iter().enumerate() {
            let begin = pieces.len();
            let mut shown = begin..begin;
            while let Some((index, segment)) = segments.next_if(|(_, segment)| segment.row as usize == number) {
                let (span, from) = (segment.span as usize, pieces.len());
                row.cut(index as u32, &row.plan.spans[span], &knots[segment.knots.clone()], pieces);
                let [first, end] = row.plan.window;
                if (first..end).contains(&span) {
                    shown = if shown.is_empty() { from } else { shown.start }..pieces.len();
                }
            }
            let reading = pieces.get(begin).map_or(row.scenario.initial_pressure_pa, |first| first.shown[0]);
            cut.push(Cut { all: begin..pieces.len(), begin: reading, shown, turns: 0..0 });
        }
    }

    /// The pieces of a row.
    pub fn pieces_of(&self, row: usize) -> Range<usize> {
        self.memory.cut[row].all.clone()
    }

    /// Reading of a row at a time of the record, s, at which it still shows the gas before the test, Pa.
    pub fn before(&self, row: usize, time: f64) -> f64 {
        self.rows[row].sensor.shown(self.rows[row].scenario.initial_pressure_pa, time)
    }

    /// Time of the record, s, at a time of a segment.
    pub fn record_time(&self, segment: u32, time: f64) -> f64 {
        self.of_segment(segment).1.elapsed + time
    }

    /// Stencils of a quantity for one interval per lane, given by segment and knot.
    pub fn stencils(&self, quantity: usize, interval: impl Fn(usize) -> (u32, u32)) -> Stencils {
        Stencils::new(quantity, |lane| {
            let (segment, knot) = interval(lane);
            let knots = self.memory.segments[segment as usize].knots.clone();
            (&self.of_segment(segment).1.transformation, &self.memory.knots[knots], knot as usize)
        })
    }
}
