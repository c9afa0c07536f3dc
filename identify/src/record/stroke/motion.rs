//! The piston's stroke between the rows of a record.
//!
//! A move is a cubic spline near its rows that meets the holds around it, since straight lines between 100 Hz rows would put
//! corners into a fast move (the chord misses the stroke by up to x″ h²/8); short moves use `smoothed`, long ones `thinned`. A
//! hold is the mean of its rows, which averages the position noise out. A move at constant speed keeps its corners (`ramp`), as
//! does one that leaves a hold abruptly or is stopped (`corner`). Position in m, time in s from the record's start.

use super::corner;
use super::moving::{moving, narrow, ranges};
use super::position_noise::position_noise;
use super::positions::Positions;
use super::ramp;
use super::smoothed::{self, Held};
use super::spline::{Spline, mean};
use super::{thinned, unfollowed};
use records::Line;
use std::cell::Cell;
use std::ops::Range;

/// What the piston does in one part of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Held before the first move.
    Rest,
    /// Moving.
    Move,
    /// Held after a move.
    Hold,
}

/// One part of a record: its rows `first..end`, and the times at which it begins and ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What the piston does.
    pub phase: Phase,
    /// Whether its rows were lost, so that the motion is unknown.
    pub lost: bool,
    /// First row.
    pub first: usize,
    /// One past the last row.
    pub end: usize,
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// The stroke in it, m.
    pub stroke: Spline,
    /// Uncertainty of the time by which the stroke as a whole may be early or late, s, since its course between rows is unknown.
    pub shift_s: f64,
}

impl Segment {
    /// Number of rows whose mean has the same error as the stroke by their noise: one if it goes through every row.
    pub fn rows_in_stroke(&self) -> f64 {
        let every = (self.end - self.first) as f64 / self.stroke.knots().0.len() as f64;
        if every < FEWEST_TO_A_KNOT { 1.0 } else { thinned::rows_in_mean(every) }
    }

    fn is_unfollowed(&self) -> bool {
        self.phase == Phase::Move && !self.lost && unfollowed::is_unfollowed(&self.stroke)
    }
}

/// Least number of rows per knot of a stroke that does not go through each row.
const FEWEST_TO_A_KNOT: f64 = 2.0;
/// A stop of fewer rows is part of its move, ...
const SHORTEST_HOLD: usize = 10;
/// ...or one of fewer readings, where the position is read less often.
const FEWEST_READINGS_OF_HOLD: usize = 4;

/// The whole stroke of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Its parts, one after the other.
    pub segments: Vec<Segment>,
    /// Standard deviation of the measured position, m.
    pub noise_m: f64,
    /// Rows from one reading of the position to the next; 1 where every row is a reading.
    pub rows_per_reading: usize,
}

impl Motion {
    /// Splits a stroke, m at times in s, into moves and holds.
    pub fn detect(time_s: &[f64], position_m: &[f64]) -> Self {
        Self::detect_in(time_s, position_m, position_noise(position_m))
    }

    /// The same with a known noise of the positions, m.
    fn detect_in(time_s: &[f64], position_m: &[f64], noise_m: f64) -> Self {
        let moving = moving(position_m, SHORTEST_HOLD, noise_m);
        Self::of_ranges(&ranges(&moving), time_s, position_m, noise_m)
    }

    /// The same for known ranges of rows that move or do not.
    fn of_ranges(ranges: &[(usize, usize, bool)], time_s: &[f64], position_m: &[f64], noise_m: f64) -> Self {
        let mut segments: Vec<Segment> = Vec::with_capacity(ranges.len());
        let n = time_s.len();
        for (k, &(first, end, moves)) in ranges.iter().enumerate() {
            let from_s = if k == 0 { time_s[0] } else { segments[k - 1].to_s };
            let to_s = if end == n { time_s[n - 1] } else { time_s[end - usize::from(!moves)] };
            let phase = if moves {
                Phase::Move
            } else if k == 0 {
                Phase::Rest
            } else {
                Phase::Hold
            };
            let stroke =
                if moves { Spline::default() } else { held(&time_s[first..end], &position_m[first..end], noise_m) };
            segments.push(Segment { phase, lost: false, first, end, from_s, to_s, stroke, shift_s: 0.0 });
        }
        for k in 0..segments.len() {
            if segments[k].phase == Phase::Move {
                let stroke = moved(k, &segments, time_s, position_m, noise_m);
                segments[k].shift_s = stroke.open_shift(noise_m);
                set(k, &mut segments, stroke);
                straighten(k, &mut segments, time_s, position_m, noise_m);
            }
        }
        Self { segments, noise_m, rows_per_reading: 1 }
    }

    /// The same from the rows that are readings of the position; its segments count all rows.
    pub fn through(time_s: &[f64], position_m: &[f64], positions: &Positions) -> Self {
        Self::through_in(time_s, position_m, positions, position_noise(&positions.readings(position_m)))
    }

    /// The same with a known noise of the readings, m.
    pub fn through_in(time_s: &[f64], position_m: &[f64], positions: &Positions, noise_m: f64) -> Self {
        let rows = &positions.rows;
        if rows.len() == time_s.len() {
            return Self::detect_in(time_s, position_m, noise_m);
        }
        let rows_per_reading = positions.rows_per_reading();
        let shortest = (SHORTEST_HOLD / rows_per_reading).max(FEWEST_READINGS_OF_HOLD);
        let (time_of_readings_s, readings_m) = (positions.readings(time_s), positions.readings(position_m));
        let mut moving = moving(&readings_m, shortest, noise_m);
        narrow(&mut moving, &readings_m, noise_m);
        let mut motion = Self::of_ranges(&ranges(&moving), &time_of_readings_s, &readings_m, noise_m);
        motion.rows_per_reading = rows_per_reading;
        let between_readings_s = motion.row_s();
        let last = motion.segments.len() - 1;
        let mut first = 0;
        for (k, segment) in motion.segments.iter_mut().enumerate() {
            // A hold ends with its last reading: after it the piston may move.
            let end = match segment.phase {
                _ if k == last => time_s.len(),
                Phase::Move => rows[segment.end],
                Phase::Rest | Phase::Hold => rows[segment.end - 1] + 1,
            };
            (segment.first, segment.end) = (first, end);
            first = end;
            if segment.is_unfollowed() {
                segment.shift_s = segment.shift_s.hypot(unfollowed::SHIFT * between_readings_s);
            }
        }
        motion.segments[0].from_s = time_s[0];
        motion.segments[last].to_s = time_s[time_s.len() - 1];
        motion
    }

    /// Rows of the moves whose course the readings do not show.
    pub fn unfollowed(&self) -> Vec<Range<usize>> {
        self.segments
            .iter()
            .filter(|s| self.rows_per_reading > 1 && s.is_unfollowed())
            .map(|s| s.first..s.end)
            .collect()
    }

    /// Its start and its end, s.
    pub fn extent(&self) -> (f64, f64) {
        (self.segments[0].from_s, self.segments[self.segments.len() - 1].to_s)
    }

    /// Index of the segment at a time, s: the first or the last one beyond the record's ends.
    pub fn segment_at(&self, time: f64) -> usize {
        self.segments.partition_point(|s| s.to_s < time).min(self.segments.len() - 1)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.segments.iter().map(|s| s.end - s.first).sum()
    }

    /// Mean time between rows, s.
    pub fn row_s(&self) -> f64 {
        let (begin, end) = self.extent();
        (end - begin) / self.rows() as f64
    }

    /// Whether the record begins with the piston held.
    pub fn starts_at_rest(&self) -> bool {
        self.segments.first().is_some_and(|s| s.phase == Phase::Rest)
    }
}

/// A hold: a straight line through its rows, since a held piston creeps; its mean if no slope shows; a curve near its rows if it
/// clearly moves otherwise.
fn held(time_s: &[f64], position_m: &[f64], noise_m: f64) -> Spline {
    /// A slope of this many standard errors is creep.
    const SLOPE_SHOWS: f64 = 4.0;
    let n = position_m.len();
    let constant = || Spline::through(vec![time_s[0]], vec![mean(position_m)], [None, None]);
    if n < FEWEST_READINGS_OF_HOLD {
        return constant();
    }
    let line = Line::through(time_s, position_m);
    if is_off(&line, time_s, position_m, noise_m) {
        return thinned::through(time_s, position_m, [None, None], noise_m);
    }
    // The scatter of rounded positions about a line is less than their error.
    let ends = [time_s[0], time_s[n - 1]];
    let error = line.slope_error.max(noise_m * 12.0f64.sqrt() / ((ends[1] - ends[0]) * (n as f64).sqrt()));
    if line.slope.abs() > SLOPE_SHOWS * error { Spline::line(ends, ends.map(|t| line.at(t))) } else { constant() }
}

/// Whether the mean of a part of a hold is off its line by more than the noise of its rows allows.
fn is_off(line: &Line, time_s: &[f64], position_m: &[f64], noise_m: f64) -> bool {
    const PARTS: usize = 20;
    const FEWEST_ROWS: usize = 5;
    /// In standard errors of the mean, and in standard deviations of a row.
    const DEVIATIONS: [f64; 2] = [6.0, 2.0];
    let size = (position_m.len() / PARTS).max(FEWEST_ROWS);
    let limit = noise_m * (DEVIATIONS[0] / (size as f64).sqrt()).max(DEVIATIONS[1]);
    let mut parts = time_s.chunks_exact(size).zip(position_m.chunks_exact(size));
    parts.any(|(t, x)| (mean(x) - line.at(mean(t))).abs() > limit)
}

/// A move: a spline near its rows that meets the holds before and after it, or has corners with them.
fn moved(k: usize, segments: &[Segment], time_s: &[f64], position_m: &[f64], noise_m: f64) -> Spline {
    let segment = &segments[k];
    let rows = segment.first..segment.end;
    let (mut time, mut value) = (time_s[rows.clone()].to_vec(), position_m[rows].to_vec());
    let near = Cell::new(0);
    let held = |hold: &Segment, time_s: f64| {
        let (position_m, speed) = hold.stroke.at(time_s, &near);
        Held { time_s, position_m, speed, at_once: false }
    };
    let before =
        k.checked_sub(1).map(|k| corner::at_begin(held(&segments[k], segment.from_s), &mut time, &mut value, noise_m));
    let after =
        segments.get(k + 1).map(|next| corner::at_end(held(next, time_s[next.first]), &mut time, &mut value, noise_m));
    let speeds = [before, after].map(|held| held.map(|held| held.speed));
    let curve = match (before, after) {
        _ if time.len() >= thinned::FEWEST_ROWS => Some(thinned::through(&time, &value, speeds, noise_m)),
        (Some(before), Some(after)) => smoothed::between(&time, &value, [before, after], noise_m),
        _ => None,
    };
    curve.unwrap_or_else(|| Spline::through(time, value, speeds))
}

/// Replaces a move between two holds by a straight line if its rows lie on one.
fn straighten(k: usize, segments: &mut [Segment], time_s: &[f64], position_m: &[f64], noise_m: f64) {
    let around = k.saturating_sub(1)..(k + 2).min(segments.len());
    let [before, segment, after] = &mut segments[around] else { return };
    let near = Cell::new(0);
    let (from, to) = (before.stroke.at(segment.from_s, &near).0, after.stroke.at(time_s[after.first], &near).0);
    let rows = segment.first..segment.end;
    let Some([begin, end]) = ramp::corners(&time_s[rows.clone()], &position_m[rows], from, to, noise_m) else { return };
    if begin <= before.from_s || end >= after.to_s {
        return;
    }
    let speed = (to - from) / (end - begin);
    segment.shift_s = noise_m / speed.abs() / ((segment.end - segment.first) as f64).sqrt();
    set(k, segments, Spline::line([begin, end], [from, to]));
}

/// Sets a move's stroke, and adjusts the ends of the holds around it.
fn set(k: usize, segments: &mut [Segment], stroke: Spline) {
    let (begin, end) = stroke.ends();
    if let Some(before) = k.checked_sub(1).map(|k| &mut segments[k]) {
        before.to_s = begin;
        before.stroke.go_on(begin);
    }
    if let Some(after) = segments.get_mut(k + 1) {
        after.from_s = end;
        after.stroke.go_on(end);
    }
    (segments[k].from_s, segments[k].to_s, segments[k].stroke) = (begin, end, stroke);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(noise: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        (0..400)
            .map(|i| {
                let t = i as f64 * 0.01;
                (t, 0.1 - 0.05 * smooth(((t - 0.3) / 0.18).clamp(0.0, 1.0)) + noise(i))
            })
            .unzip()
    }

    #[test]
    fn a_push_between_two_holds_is_found_and_followed_between_its_rows() {
        let (t, x) = record(|i| 2e-6 * ((i * 7919 % 13) as f64 / 6.5 - 1.0));
        let motion = Motion::detect(&t, &x);
        let phases: Vec<Phase> = motion.segments.iter().map(|s| s.phase).collect();
        assert_eq!(phases, [Phase::Rest, Phase::Move, Phase::Hold]);
        let (exact, _) = (record(|_| 0.0).1, ());
        let near = Cell::new(0);
        let push = &motion.segments[1];
        // The push, and at most a dozen rows before and after it.
        let (early, late) = (0.3 - push.from_s, push.to_s - 0.48);
        assert!((0.0..0.135).contains(&early) && (0.0..0.135).contains(&late), "{} {}", push.from_s, push.to_s);
        for i in push.first..push.end {
            assert!((push.stroke.at(t[i], &near).0 - exact[i]).abs() < 5e-6);
            let between = push.stroke.at(t[i] + 0.005, &near).0;
            let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
            let truth = 0.1 - 0.05 * smooth(((t[i] + 0.005 - 0.3) / 0.18).clamp(0.0, 1.0));
            assert!((between - truth).abs() < 1.2e-5, "{i}: {between} {truth}");
        }
        assert!((motion.segments[2].stroke.at(2.0, &near).0 - 0.05).abs() < 5e-7);
    }

    #[test]
    fn the_gentle_end_of_a_slow_push_belongs_to_it_though_noise_hides_it() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let push = |t: f64| 0.03 - 0.02 * smooth(((t - 0.3) / 0.6).clamp(0.0, 1.0));
        let mut random = crate::synthetic::Random::new(3);
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..500).map(|i| f64::from(i) * 0.005).map(|t| (t, push(t) + 1.5e-5 * random.normal())).unzip();
        let motion = Motion::detect(&t, &x);
        assert_eq!(motion.segments.len(), 3);
        let [_, moved, _] = &motion.segments[..] else { return };
        // To within the position noise over √8 of the held positions.
        let off = |time: f64, held: f64| (push(time) - held).abs();
        assert!(off(moved.to_s, 0.01) < 5e-6 && off(moved.from_s, 0.03) < 5e-6, "{} {}", moved.from_s, moved.to_s);
        assert!(moved.to_s < 1.1 && moved.from_s > 0.1, "{} {}", moved.from_s, moved.to_s);
    }

    #[test]
    fn a_record_begins_at_rest_if_even_few_rows_show_it_and_else_in_motion() {
        let steady = |u: f64| u;
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let moves: [&dyn Fn(f64) -> f64; 2] = [&steady, &smooth];
        for (form, noise_m) in moves.into_iter().zip([1e-5, 2e-6]) {
            for rest in 0..12u32 {
                let push = |i: f64| 0.1 - 0.05 * form(((i - f64::from(rest)) / 30.0).clamp(0.0, 1.0));
                let mut random = crate::synthetic::Random::new(u64::from(rest));
                // Row by row; the first one lies within the push if there is no rest.
                let first = if rest == 0 { 10.0 } else { 0.0 };
                let (t, x): (Vec<f64>, Vec<f64>) =
                    (0..300).map(f64::from).map(|i| (0.01 * i, push(first + i) + noise_m * random.normal())).unzip();
                let motion = Motion::detect(&t, &x);
                // A row is recognised as standing by the three after it.
                match rest {
                    0 => assert!(!motion.starts_at_rest()),
                    5.. => assert!(motion.starts_at_rest(), "{rest} {noise_m}"),
                    _ => {}
                }
            }
        }
    }

    #[test]
    fn small_steps_of_a_hand_before_a_push_are_moves_however_fast_the_rows_follow() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let step = |t: f64, begin: f64, travel_m: f64| travel_m * smooth(((t - begin) / 0.065).clamp(0.0, 1.0));
        // 0.35 and 0.45 mm of 6 mm, 7 µm from row to row.
        let hand = |t: f64| 7e-3 + step(t, 0.14, 3.5e-4) + step(t, 0.24, 4.5e-4) + step(t, 0.37, 5.2e-3);
        let mut random = crate::synthetic::Random::new(7);
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..3700).map(|i| f64::from(i) * 1e-3).map(|t| (t, hand(t) + 1.25e-5 * random.normal())).unzip();
        let phases: Vec<Phase> = Motion::detect(&t, &x).segments.iter().map(|s| s.phase).collect();
        let [rest, moved, hold] = [Phase::Rest, Phase::Move, Phase::Hold];
        assert_eq!(phases, [rest, moved, hold, moved, hold, moved, hold]);
    }

    #[test]
    fn a_push_sampled_a_hundred_thousand_times_a_second_is_one_move() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let push = |t: f64| 0.15 - 0.08 * smooth(((t - 0.3) / 0.2).clamp(0.0, 1.0));
        let mut random = crate::synthetic::Random::new(5);
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..100_000).map(|i| f64::from(i) * 1e-5).map(|t| (t, push(t) + 4e-6 * random.normal())).unzip();
        let motion = Motion::detect(&t, &x);
        assert_eq!(
            motion.segments.iter().map(|s| s.phase).collect::<Vec<_>>(),
            [Phase::Rest, Phase::Move, Phase::Hold]
        );
        let near = Cell::new(0);
        let curve = &motion.segments[1].stroke;
        let worst = (1..200).map(|k| 0.3 + 0.001 * f64::from(k)).map(|t| (curve.at(t, &near).0 - push(t)).abs());
        assert!(worst.fold(0.0, f64::max) < 4e-6);
    }

    #[test]
    fn a_slow_push_whose_travel_from_row_to_row_is_lost_in_the_noise_is_a_move() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let push = |t: f64| 0.03 - 0.012 * smooth(((t - 0.3) / 1.0).clamp(0.0, 1.0));
        let mut random = crate::synthetic::Random::new(9);
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..50_000).map(|i| f64::from(i) * 1e-4).map(|t| (t, push(t) + 6e-6 * random.normal())).unzip();
        let motion = Motion::detect(&t, &x);
        assert_eq!(
            motion.segments.iter().map(|s| s.phase).collect::<Vec<_>>(),
            [Phase::Rest, Phase::Move, Phase::Hold]
        );
        let [_, moved, _] = &motion.segments[..] else { return };
        assert!(
            (0.1..0.4).contains(&moved.from_s) && (1.2..1.5).contains(&moved.to_s),
            "{} {}",
            moved.from_s,
            moved.to_s
        );
    }

    /// The motion found in `n` rows, `row_s` apart, of a stroke with noise, and the largest error of its stroke.
    fn worst_of(stroke: impl Fn(f64) -> f64, n: u32, row_s: f64, noise_m: f64) -> (Motion, f64) {
        let mut random = crate::synthetic::Random::new(6);
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..n).map(|i| f64::from(i) * row_s).map(|t| (t, stroke(t) + noise_m * random.normal())).unzip();
        let motion = Motion::detect(&t, &x);
        let near = Cell::new(0);
        let off = |t: &f64| (motion.segments[motion.segment_at(*t)].stroke.at(*t, &near).0 - stroke(*t)).abs();
        let worst = t.iter().map(off).fold(0.0, f64::max);
        (motion, worst)
    }

    #[test]
    fn a_piston_that_swings_to_its_stop_is_followed_until_it_rests() {
        let stroke = |t: f64| {
            let u = (t - 0.5).max(0.0);
            0.07 + 0.07 * (-u / 0.08).exp() * ((30.0 * u).cos() + (30.0 * u).sin() / (30.0 * 0.08))
        };
        for noise_m in [5e-6, 2e-5] {
            let (motion, worst) = worst_of(stroke, 6000, 0.001, noise_m);
            // A last swing of a few times the noise may be a separate move.
            assert!((3..=5).contains(&motion.segments.len()));
            assert!(worst < 4.0 * noise_m, "{noise_m}: {worst}");
        }
    }

    #[test]
    fn a_piston_that_tends_to_its_stop_moves_until_it_rests() {
        let stroke = |t: f64| 0.07 + 0.07 * (-(t - 0.5).max(0.0) / 0.12).exp();
        for (rows, row_s) in [(3000, 0.002), (25_000, 0.0002), (600, 0.01)] {
            let (motion, worst) = worst_of(stroke, rows, row_s, 5e-6);
            assert_eq!(motion.segments.len(), 3);
            // The corner lies between two rows.
            let corner = 0.07 / 0.12 * row_s;
            assert!(worst < 1.5e-5 + 0.1 * corner, "{row_s}: {worst}");
        }
    }

    #[test]
    fn the_corner_of_a_sudden_start_or_stop_is_followed_between_rows() {
        const NOISE_M: f64 = 5e-6;
        for (row_s, corner_s) in [(0.02, 0.5031), (0.01, 0.5072), (0.004, 0.5011), (0.002, 0.5007), (2e-4, 0.50013)] {
            let leaves = |t: f64| 0.07 + 0.07 * (-(t - corner_s).max(0.0) / 0.12).exp();
            let is_stopped = |t: f64| 0.07 - 0.07 * (-(corner_s - t).max(0.0) / 0.12).exp();
            let strokes: [&dyn Fn(f64) -> f64; 2] = [&leaves, &is_stopped];
            for stroke in strokes {
                let mut random = crate::synthetic::Random::new(6);
                let times = (0..(2.0 / row_s) as u32).map(|i| f64::from(i) * row_s);
                let (t, x): (Vec<f64>, Vec<f64>) = times.map(|t| (t, stroke(t) + NOISE_M * random.normal())).unzip();
                let motion = Motion::detect(&t, &x);
                let near = Cell::new(0);
                let off = |t: f64| motion.segments[motion.segment_at(t)].stroke.at(t, &near).0 - stroke(t);
                let worst = (-200..200).map(|k| off(corner_s + 0.01 * f64::from(k) * row_s).abs()).fold(0.0, f64::max);
                assert!(worst < 4.0 * NOISE_M, "{row_s}: {worst}");
            }
        }
    }

    #[test]
    fn a_piston_that_goes_to_and_fro_never_stops_though_its_turns_are_lost_in_the_noise() {
        for (rows, row_s, frequency_hz) in [(2000, 0.005, 0.4), (8000, 4e-4, 1.3), (16_000, 4e-4, 0.25)] {
            let stroke = |t: f64| 0.04 - 0.015 * (2.0 * std::f64::consts::PI * frequency_hz * t).cos();
            let (motion, worst) = worst_of(stroke, rows, row_s, 1e-5);
            let phases: Vec<Phase> = motion.segments.iter().map(|s| s.phase).collect();
            assert_eq!(phases, [Phase::Move], "{frequency_hz} Hz");
            // At the record's ends the curve goes through single rows.
            assert!(worst < 3e-5, "{frequency_hz} Hz: {worst}");
        }
    }

    #[test]
    fn a_hold_between_two_gentle_moves_contains_neither_the_end_of_one_nor_the_begin_of_the_other() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        for (length_s, row_s, rows) in [(0.9, 1e-3, 5500), (2.0, 5e-4, 15_000), (1.0, 2e-4, 28_000)] {
            let progress = |t: f64, begin: f64, length_s: f64| smooth(((t - begin) / length_s).clamp(0.0, 1.0));
            let back = 1.3 + length_s;
            let stroke = |t: f64| 0.04 - 0.028 * (progress(t, 0.3, length_s) - progress(t, back, 1.4 * length_s));
            let (motion, worst) = worst_of(stroke, rows, row_s, 1e-5);
            let phases: Vec<Phase> = motion.segments.iter().map(|s| s.phase).collect();
            assert_eq!(phases, [Phase::Rest, Phase::Move, Phase::Hold, Phase::Move, Phase::Hold], "{length_s} s");
            assert!(worst < 4e-5, "{length_s} s: {worst}");
        }
    }

    #[test]
    fn a_piston_that_sticks_and_slips_in_a_hold_is_followed() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        // 1.5 mm in one and a half seconds of a hold after 40 mm.
        let slip = |t: f64| 7e-4 * (smooth((t - 1.4).clamp(0.0, 1.0)) + smooth(((t - 2.1) / 0.8).clamp(0.0, 1.0)));
        let stroke = |t: f64| 0.1 - 0.04 * smooth(((t - 0.5) / 0.6).clamp(0.0, 1.0)) - slip(t);
        let (motion, worst) = worst_of(stroke, 200, 0.02, 5e-6);
        assert!(motion.segments.len() >= 3 && worst < 3e-5, "{worst} {:?}", motion.segments.len());
    }

    #[test]
    fn a_piston_that_creeps_after_a_push_is_held_along_its_line() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let stroke = |t: f64| 0.1 - 0.05 * smooth(((t - 0.5) / 0.2).clamp(0.0, 1.0)) - 1e-4 * (t - 0.7).max(0.0);
        let (motion, worst) = worst_of(stroke, 1000, 0.005, 2e-6);
        let [_, moved, hold] = &motion.segments[..] else { panic!() };
        assert!(hold.stroke.is_line() && moved.end - moved.first < 100, "{}", moved.end - moved.first);
        assert!(worst < 1e-5, "{worst}");
    }

    #[test]
    fn parts_follow_each_other_without_gaps() {
        let (t, x) = record(|_| 0.0);
        let motion = Motion::detect(&t, &x);
        assert_eq!(motion.segments[0].from_s, t[0]);
        assert_eq!(motion.segments.last().unwrap().to_s, *t.last().unwrap());
        for pair in motion.segments.windows(2) {
            assert_eq!((pair[0].to_s, pair[0].end), (pair[1].from_s, pair[1].first));
        }
    }

    #[test]
    fn a_stroke_that_is_read_at_every_tenth_row_is_followed_through_its_readings() {
        const SLOW: usize = 10;
        let stroke = |t: f64| {
            let u = ((t - 0.5) / 0.4).clamp(0.0, 1.0);
            0.15 - 0.07 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        };
        let mut random = crate::synthetic::Random::new(4);
        let time_s: Vec<f64> = (0..2000).map(|i| 0.002 * f64::from(i)).collect();
        let read = time_s.iter().step_by(SLOW).map(|t| (1e6 * (stroke(*t) + 5e-6 * random.normal())).round() * 1e-6);
        let mut read: Vec<f64> = read.collect();
        read.push(read[199]);
        let share = |i: usize| (i % SLOW) as f64 / SLOW as f64;
        let held = (0..2000).map(|i| read[i / SLOW]).collect();
        let joined = (0..2000).map(|i| read[i / SLOW] * (1.0 - share(i)) + read[i / SLOW + 1] * share(i));
        let joined: Vec<f64> = joined.map(|x| (1e6 * x).round() * 1e-6).collect();
        let two: [Vec<f64>; 2] = [held, joined];
        for position_m in two {
            let positions = Positions::of(&position_m);
            assert_eq!(positions.rows_per_reading(), SLOW);
            let motion = Motion::through(&time_s, &position_m, &positions);
            let phases: Vec<Phase> = motion.segments.iter().map(|s| s.phase).collect();
            assert_eq!(phases, [Phase::Rest, Phase::Move, Phase::Hold]);
            assert_eq!((motion.extent(), motion.rows()), ((time_s[0], time_s[1999]), 2000));
            for pair in motion.segments.windows(2) {
                assert_eq!((pair[0].end, pair[0].to_s), (pair[1].first, pair[1].from_s));
            }
            let near = Cell::new(0);
            for t in &time_s {
                let off = motion.segments[motion.segment_at(*t)].stroke.at(*t, &near).0 - stroke(*t);
                assert!(off.abs() < 3e-5, "{t}: {off}");
            }
            assert!((3e-6..1e-5).contains(&motion.noise_m), "{}", motion.noise_m);
        }
    }

    /// A move of this length, read at every 20th of 500 rows per second.
    fn read_slowly(length_s: f64) -> Motion {
        let mut random = crate::synthetic::Random::new(7);
        let stroke = |t: f64| {
            let u = ((t - 0.813) / length_s).clamp(0.0, 1.0);
            0.1 - 0.02 * (1.0 - (std::f64::consts::PI * u).cos())
        };
        let time_s: Vec<f64> = (0..1500).map(|i| 0.002 * f64::from(i)).collect();
        let readings: Vec<f64> = time_s.iter().step_by(20).map(|t| stroke(*t) + 1e-6 * random.normal()).collect();
        let position_m: Vec<f64> = (0..1500).map(|i| readings[i / 20]).collect();
        Motion::through(&time_s, &position_m, &Positions::of(&position_m))
    }

    #[test]
    fn a_hold_begins_with_the_second_reading_at_its_place() {
        let [rest, moved, hold] = &read_slowly(0.2).segments[..] else { panic!() };
        // From 0.813 s to 1.013 s: read at 0.8 s, at 1.04 s and at 1.08 s.
        assert_eq!([rest.end, moved.first], [20 * 19 + 1; 2]);
        assert_eq!((moved.end, hold.first), (540, 540));
        // The piston is held from the first of the last two on.
        assert!((hold.from_s - 1.04).abs() < 1e-12, "{}", hold.from_s);
    }

    #[test]
    fn a_move_that_is_over_between_few_readings_is_not_followed() {
        assert!(read_slowly(0.2).unfollowed().is_empty());
        let short = read_slowly(0.06);
        let moved = &short.segments[1];
        assert_eq!(short.unfollowed(), vec![moved.first..moved.end; 1]);
        // Uncertain by at least 0.6 ms.
        assert!((6e-4..1e-2).contains(&moved.shift_s), "{}", moved.shift_s);
    }
}
