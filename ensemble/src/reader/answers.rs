//! Peaks, final values and settling times of the records of traced rows.

use super::curves::Prompt;
use super::interpolant::Knot;
use super::traces::{Cut, Job, Memory, TEMPERATURE, Trace, TracePiece, Traces};
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::{ROUNDING, SETTLED};
use crate::query::{Query, Question};
use crate::regression::samples::POINTS;
use crate::scenario::Scenario;
use chamber::real::Real;
use pulp::Arch;

/// What is read from one row. Pressures are readings, temperatures those of the gas.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowAnswer {
    /// Peak pressure from the end of the push on, Pa.
    pub pressure_peak: f64,
    /// Time of the record at which it occurs, s.
    pub peak_time: f64,
    /// Reading at the end of the test, Pa.
    pub pressure_final: f64,
    /// Peak temperature from the end of the push on, K.
    pub temperature_peak: f64,
    /// Temperature of the gas at the end of the test, K.
    pub temperature_final: f64,
    /// Time from the end of the push until within 1 % for good, s.
    pub settling: f64,
    /// Net inflow of gas at the end of the test, relative to the gas in the chamber, 1/s.
    pub inflow: f64,
    /// Relative rate of the gas pressure at the end of the test, 1/s.
    pub pressure_rate: f64,
}

impl Traces<'_> {
    /// What is read from each row; none for rows without a record.
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

    /// Finds the turns of the records.
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
        std::mem::swap(turns, jobs);
    }

    /// Everything except temperatures and the settling time, for which a job is added if it lies inside a piece.
    fn answer(&mut self, row: usize) -> Option<RowAnswer> {
        let Memory { pieces, cut, turns, .. } = &*self.memory;
        let Cut { all, shown, turns: of_row, .. } = &cut[row];
        if all.is_empty() {
            return None;
        }
        let (Trace { scenario, bends, sensor, .. }, turns) = (&self.rows[row], &turns[of_row.clone()]);
        let &&Scenario { push_time_s: push_end, duration_s: duration, .. } = scenario;
        let sign = self.rows[row].sign();
        // The peak is at the start of the record, at the end of a piece or at a turn.
        let (mut pressure, mut peak_time) = (f64::NEG_INFINITY, push_end);
        if push_end < sensor.delay {
            let [begin, end] = [push_end, sensor.delay.min(duration)].map(|time| self.before(row, time));
            pressure = sign * bends.shown(begin);
            for reading in bends.between(begin, end) {
                let shown = sign * bends.shown(reading);
                if shown > pressure {
                    (pressure, peak_time) = (shown, push_end + (reading - begin) / sensor.drift);
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
            look(&pieces[turn.piece], turn.answer[0], turn.answer[1]);
        }
        let at_rest = || bends.shown(self.before(row, duration));
        let pressure_final = shown_pieces.last().map_or_else(at_rest, |last| last.shown[1]);
        let pressure_peak = sign * pressure.max(sign * pressure_final);
        let band = SETTLED * (pressure_peak - pressure_final).abs();
        let band = band.max(ROUNDING * pressure_final.abs());
        // Backwards from the end to the last corner outside the band, and the next corner after it.
        let outside = |value: f64| (value - pressure_final).abs() > band;
        let mut turns = turns.iter().rev().peekable();
        let entry = shown.clone().rev().find_map(|index| {
            let TracePiece { times: [begin, mut later], shown: [value, _], .. } = pieces[index];
            if let Some(Job { answer: [time, shown, ..], .. }) = turns.next_if(|turn| turn.piece == index) {
                if outside(*shown) {
                    return Some((index, *time, later));
                }
                later = *time;
            }
            outside(value).then_some((index, begin, later))
        });
        if let Some((piece, from, later)) = entry {
            self.memory.jobs.push(Job::new(piece, [from, later, pressure_final, band]));
        }
        let temperature_peak = f64::NEG_INFINITY;
        Some(RowAnswer { pressure_peak, peak_time, pressure_final, temperature_peak, ..RowAnswer::default() })
    }

    /// Finds final and peak temperatures of the gas.
    fn find_temperatures(&mut self, arch: Arch, answers: &mut [Option<RowAnswer>]) {
        // Segments and intervals in which the temperature has a peak.
        let mut turns: Vec<(u32, u32)> = Vec::new();
        let sign = |rows: &[Trace], row: u32| rows[row as usize].sign();
        for (index, segment) in self.memory.segments.iter().enumerate() {
            let Some(answer) = &mut answers[segment.row as usize] else { continue };
            if (segment.span as usize) < self.rows[segment.row as usize].plan.hold {
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
                    self.of_segment(segment)
                        .1
                        .transformation
                        .time_and_pace(self.memory.knots[knots][knot as usize + end].at)
                        .0
                })
            });
            let reading = Prompt { inside, gain: Lanes::ONE, offset: Lanes::ZERO, drift: Lanes::ZERO };
            let found = Query { reading, times, question: Question::Turn }.answer(arch);
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

    /// Finds the settling times: answers the jobs of [`Traces::answer`].
    fn find_settling(&mut self, arch: Arch, answers: &mut [Option<RowAnswer>]) {
        self.work(arch, |[outside, later, value, band]| Question::Enter { between: [outside, later], value, band });
        for job in &self.memory.jobs {
            let segment = self.memory.pieces[job.piece].segment;
            let row = self.memory.segments[segment as usize].row as usize;
            if let Some(answer) = &mut answers[row] {
                let settled = self.record_time(segment, job.answer[0]) - self.rows[row].scenario.push_time_s;
                answer.settling = settled.max(0.0);
            }
        }
    }
}
