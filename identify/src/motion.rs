//! The piston's stroke between the rows of a record.
//!
//! A move is a cubic spline through its samples with zero speed at its ends, since straight lines between 100 Hz rows
//! would put corners into a fast move (the chord of a sample misses the stroke by up to x″ h²/8); a hold is the mean of
//! its samples, so that the position's own noise is averaged away. A move at constant speed keeps its corners
//! ([`crate::ramp`]). Position in m, time in s from the record's start.

use crate::ramp;
use std::cell::Cell;

/// A piecewise cubic function of time with continuous slope; constant before its first and after its last knot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spline {
    time: Vec<f64>,
    value: Vec<f64>,
    slope: Vec<f64>,
}

impl Spline {
    /// Through these points with these slopes (C2 inside, by the tridiagonal system of the second derivatives).
    ///
    /// `ends` are the slopes at the first and last point; `None` leaves the end free (no curvature).
    pub fn through(time: Vec<f64>, value: Vec<f64>, ends: [Option<f64>; 2]) -> Self {
        let n = time.len();
        if n < 2 {
            return Self { slope: vec![0.0; n], time, value };
        }
        // Unknown slopes s: s[i-1]/h[i-1] + 2 (1/h[i-1] + 1/h[i]) s[i] + s[i+1]/h[i] = 3 (d[i-1]/h[i-1] + d[i]/h[i]),
        // d the chord slopes; Thomas algorithm.
        let h: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        let d: Vec<f64> = value.windows(2).zip(&h).map(|(w, h)| (w[1] - w[0]) / h).collect();
        let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let (low, diagonal, up, rhs) = if i == 0 {
                match ends[0] {
                    Some(slope) => (0.0, 1.0, 0.0, slope),
                    None => (0.0, 2.0, 1.0, 3.0 * d[0]),
                }
            } else if i == n - 1 {
                match ends[1] {
                    Some(slope) => (0.0, 1.0, 0.0, slope),
                    None => (1.0, 2.0, 0.0, 3.0 * d[n - 2]),
                }
            } else {
                let (a, b) = (1.0 / h[i - 1], 1.0 / h[i]);
                (a, 2.0 * (a + b), b, 3.0 * (d[i - 1] * a + d[i] * b))
            };
            let (before_upper, before_right) = if i == 0 { (0.0, 0.0) } else { (upper[i - 1], right[i - 1]) };
            let pivot = diagonal - low * before_upper;
            upper[i] = up / pivot;
            right[i] = (rhs - low * before_right) / pivot;
        }
        let mut slope = right;
        for i in (0..n - 1).rev() {
            slope[i] -= upper[i] * slope[i + 1];
        }
        Self { time, value, slope }
    }

    /// Standard deviation of the time by which the whole curve may be early or late, s: ∫ error dt over the way.
    ///
    /// The curve through every second knot misses the others by d; its integral's error is at least four times that of
    /// the curve through all (a corner; sixteen times where the stroke is smooth). The knots' own noise comes on top.
    fn open_shift(&self, noise: f64) -> f64 {
        let n = self.time.len();
        if n < 3 {
            return 0.0;
        }
        let way = self.range().1 - self.range().0;
        let row = (self.time[n - 1] - self.time[0]) / (n - 1) as f64;
        let near = Cell::new(0);
        let worst = (1..3)
            .map(|first| {
                let kept = |i: usize| i == 0 || i == n - 1 || i % 2 == first % 2;
                let pick = |v: &[f64]| v.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, v)| *v).collect();
                let half = Spline::through(pick(&self.time), pick(&self.value), [Some(0.0), Some(0.0)]);
                let missed = (0..n).filter(|i| !kept(*i)).map(|i| self.value[i] - half.at(self.time[i], &near).0);
                (missed.sum::<f64>() * row).abs()
            })
            .fold(0.0, f64::max);
        (0.25 * worst).hypot(noise * row * (n as f64).sqrt()) / way.max(noise)
    }

    /// Smallest and largest of its knots' values.
    pub fn range(&self) -> (f64, f64) {
        extent(&self.value)
    }

    /// Smallest of its knots' values.
    pub fn lowest(&self) -> f64 {
        extent(&self.value).0
    }

    /// Value and slope at time `t`; `near` remembers the last piece.
    #[inline]
    pub fn at(&self, t: f64, near: &Cell<usize>) -> (f64, f64) {
        let last = self.time.len() - 1;
        if t < self.time[0] || last == 0 {
            return (self.value[0], 0.0);
        }
        if t > self.time[last] {
            return (self.value[last], 0.0);
        }
        let mut i = near.get().min(last - 1);
        if t < self.time[i] || t > self.time[i + 1] {
            i = if i + 2 <= last && t >= self.time[i + 1] && t <= self.time[i + 2] {
                i + 1
            } else {
                self.time.partition_point(|knot| *knot <= t).clamp(1, last) - 1
            };
            near.set(i);
        }
        let h = self.time[i + 1] - self.time[i];
        let u = (t - self.time[i]) / h;
        let (a, b) = (self.value[i], self.value[i + 1]);
        let (p, q) = (self.slope[i] * h, self.slope[i + 1] * h);
        let (c2, c3) = (3.0 * (b - a) - 2.0 * p - q, 2.0 * (a - b) + p + q);
        (a + u * (p + u * (c2 + u * c3)), (p + u * (2.0 * c2 + 3.0 * u * c3)) / h)
    }
}

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

/// One part of a record: rows `from..to` and times in between.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// What the piston does.
    pub phase: Phase,
    /// First row.
    pub first: usize,
    /// One past the last row.
    pub end: usize,
    /// Begin, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// The stroke in it, m.
    pub stroke: Spline,
    /// By how much the stroke may be early or late on the whole, s: what its rows leave open between them.
    pub shift_s: f64,
}

/// The whole stroke of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Its parts, one after the other.
    pub segments: Vec<Segment>,
    /// Standard deviation of the measured position, m.
    pub noise_m: f64,
}

impl Motion {
    /// Splits a stroke, m at times in s, into moves and holds.
    pub fn detect(time_s: &[f64], position_m: &[f64]) -> Self {
        let noise_m = position_noise(position_m);
        let (low, high) = extent(position_m);
        let threshold = (8.0 * noise_m).max(2e-4 * (high - low));
        let moving = moving_rows(position_m, threshold);
        let ranges = ranges(&moving);
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
            segments.push(Segment { phase, first, end, from_s, to_s, stroke, shift_s: 0.0 });
        }
        for k in 0..segments.len() {
            if segments[k].phase == Phase::Move {
                segments[k].stroke = moved(k, &segments, time_s, position_m);
                segments[k].shift_s = segments[k].stroke.open_shift(noise_m);
                straighten(k, &mut segments, time_s, position_m, noise_m);
            }
        }
        Self { segments, noise_m }
    }

    /// Whether the record begins with the piston held.
    pub fn starts_at_rest(&self) -> bool {
        self.segments.first().is_some_and(|s| s.phase == Phase::Rest)
    }
}

/// Smallest and largest.
pub fn extent(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)))
}

/// Standard deviation of the position from its second differences where they are small, with the recording's step as
/// the least: noise passes a second difference with the factor √6, a smooth stroke hardly at all.
fn position_noise(position_m: &[f64]) -> f64 {
    let mut second: Vec<f64> = position_m.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    second.sort_by(f64::total_cmp);
    let median = second.get(second.len() / 2).copied().unwrap_or(0.0);
    let step = position_m.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-12).fold(f64::INFINITY, f64::min);
    let quantisation = if step.is_finite() { step / 12.0f64.sqrt() } else { 0.0 };
    // Readings of few steps have few different second differences: their mean square says more than their median.
    let quiet = &second[..second.partition_point(|d| *d <= 4.5 * median)];
    let square = quiet.iter().map(|d| d * d).sum::<f64>() / quiet.len().max(1) as f64;
    // A stroke that never rests has no small second differences; then the step alone is believed.
    (square / 6.0).sqrt().max(quantisation.min(1e-4))
}

/// Rows within reach of a change of position larger than `threshold`.
fn moving_rows(position_m: &[f64], threshold: f64) -> Vec<bool> {
    const REACH: usize = 3;
    let n = position_m.len();
    let mut moving: Vec<bool> = (0..n)
        .map(|i| {
            let (low, high) = extent(&position_m[i.saturating_sub(REACH)..(i + REACH + 1).min(n)]);
            high - low > threshold
        })
        .collect();
    // A stop shorter than this many rows is part of its move.
    const SHORTEST_HOLD: usize = 10;
    let mut start = 0;
    while start < n {
        let end = (start..n).find(|&i| moving[i] != moving[start]).unwrap_or(n);
        if !moving[start] && end - start < SHORTEST_HOLD {
            moving[start..end].fill(true);
        }
        start = end;
    }
    moving
}

fn ranges(moving: &[bool]) -> Vec<(usize, usize, bool)> {
    let mut out = Vec::new();
    let mut start = 0;
    while start < moving.len() {
        let end = (start..moving.len()).find(|&i| moving[i] != moving[start]).unwrap_or(moving.len());
        out.push((start, end, moving[start]));
        start = end;
    }
    out
}

/// A hold: its mean, or, where the piston clearly creeps, a spline through the means of twenty parts.
fn held(time_s: &[f64], position_m: &[f64], noise_m: f64) -> Spline {
    const PARTS: usize = 20;
    let n = position_m.len();
    let mean = |r: &[f64]| r.iter().sum::<f64>() / r.len() as f64;
    let whole = mean(position_m);
    if n >= 5 * PARTS {
        let size = n / PARTS;
        let parts: Vec<(f64, f64)> = (0..PARTS)
            .map(|k| {
                let rows = k * size..if k + 1 == PARTS { n } else { (k + 1) * size };
                (mean(&time_s[rows.clone()]), mean(&position_m[rows]))
            })
            .collect();
        let spread = parts.iter().map(|(_, x)| (x - whole).abs()).fold(0.0, f64::max);
        if spread > 6.0 * noise_m / (size as f64).sqrt() && spread > 2.0 * noise_m {
            let (mut t, x): (Vec<f64>, Vec<f64>) = parts.into_iter().unzip();
            (t[0], t[PARTS - 1]) = (time_s[0], time_s[n - 1]);
            return Spline::through(t, x, [Some(0.0), Some(0.0)]);
        }
    }
    Spline::through(vec![time_s[0]], vec![whole], [None, None])
}

/// A move: a spline through its rows that meets the holds before and after it.
fn moved(k: usize, segments: &[Segment], time_s: &[f64], position_m: &[f64]) -> Spline {
    let segment = &segments[k];
    let mut time = time_s[segment.first..segment.end].to_vec();
    let mut value = position_m[segment.first..segment.end].to_vec();
    let mut ends = [None, None];
    let near = Cell::new(0);
    if k > 0 {
        time.insert(0, segment.from_s);
        value.insert(0, segments[k - 1].stroke.at(segment.from_s, &near).0);
        ends[0] = Some(0.0);
    }
    if let Some(next) = segments.get(k + 1) {
        time.push(time_s[next.first]);
        value.push(next.stroke.at(time_s[next.first], &near).0);
        ends[1] = Some(0.0);
    }
    Spline::through(time, value, ends)
}

/// Makes a move between two holds a straight line where its rows say that it is one.
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
    (before.to_s, segment.from_s) = (begin, begin);
    (segment.to_s, after.from_s) = (end, end);
    let speed = (to - from) / (end - begin);
    segment.shift_s = noise_m / speed.abs() / ((segment.end - segment.first) as f64).sqrt();
    segment.stroke = Spline { time: vec![begin, end], value: vec![from, to], slope: vec![speed; 2] };
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
        assert!((push.from_s - 0.3).abs() < 0.045 && (push.to_s - 0.48).abs() < 0.045, "{} {}", push.from_s, push.to_s);
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
    fn a_spline_reproduces_a_cubic_with_its_end_slopes() {
        let f = |t: f64| 1.0 + t - 2.0 * t * t + 0.5 * t * t * t;
        let g = |t: f64| 1.0 - 4.0 * t + 1.5 * t * t;
        let t: Vec<f64> = vec![0.0, 0.3, 1.0, 1.2, 2.0];
        let s = Spline::through(t.clone(), t.iter().map(|t| f(*t)).collect(), [Some(g(0.0)), Some(g(2.0))]);
        let near = Cell::new(0);
        for k in 1..40 {
            let t = f64::from(k) * 0.05;
            let (value, slope) = s.at(t, &near);
            assert!((value - f(t)).abs() < 1e-12 && (slope - g(t)).abs() < 1e-11, "{t}");
        }
    }
}
