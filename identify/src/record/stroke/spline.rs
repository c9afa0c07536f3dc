//! Cubic splines over time: the stroke between a record's rows, and what else a record says of its surroundings.

use records::extremes;
use std::cell::Cell;

/// Fraction of a move's travel at either end that does not count as moving: a piston creeps to its stop.
const ENDS: f64 = 0.01;

/// A piecewise cubic function of time with continuous slope; constant before its first and after its last knot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spline {
    time: Vec<f64>,
    value: Vec<f64>,
    /// Coefficients of the polynomial between each knot and the next, with time in s from the former: the constant first.
    pieces: Vec<[f64; 4]>,
}

impl Spline {
    /// Through these points with these slopes (C2 inside, by the tridiagonal system of the second derivatives).
    ///
    /// `ends` are the slopes at the first and last point; `None` leaves the end free (no curvature).
    pub fn through(time: Vec<f64>, value: Vec<f64>, ends: [Option<f64>; 2]) -> Self {
        let n = time.len();
        if n < 2 {
            return Self { time, value, pieces: Vec::new() };
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
        let piece = |i: usize| {
            let [bend, twist] = [3.0 * d[i] - 2.0 * slope[i] - slope[i + 1], slope[i] + slope[i + 1] - 2.0 * d[i]];
            [value[i], slope[i], bend / h[i], twist / (h[i] * h[i])]
        };
        Self { pieces: (0..n - 1).map(piece).collect(), time, value }
    }

    /// Standard deviation of the time by which the whole curve may be early or late, s: ∫ error dt over the travel.
    ///
    /// The curve through every second knot misses the others by d; its integral's error is at least four times that of the curve
    /// through all (at a corner; sixteen times for a smooth stroke). The knots' own noise is added.
    pub fn open_shift(&self, noise: f64) -> f64 {
        let n = self.time.len();
        if n < 3 {
            return 0.0;
        }
        let travel = self.range().1 - self.range().0;
        let row = (self.time[n - 1] - self.time[0]) / (n - 1) as f64;
        let near = Cell::new(0);
        let missed = |half: Spline| {
            let each = self.time.iter().zip(&self.value).map(|(t, value)| value - half.at(*t, &near).0);
            (each.sum::<f64>() * row).abs()
        };
        let worst = self.halves().map(missed).fold(0.0, f64::max);
        (0.25 * worst).hypot(noise * row * (n as f64).sqrt()) / travel.max(noise)
    }

    /// The two curves through every second knot and the ends, with this curve's slopes at the ends.
    pub fn halves(&self) -> impl Iterator<Item = Self> + '_ {
        let last = self.time.len() - 1;
        let speeds = [self.time[0], self.time[last]].map(|t| Some(self.at(t, &Cell::default()).1));
        (0..2).map(move |first| {
            let kept = move |i: usize| i == 0 || i == last || i % 2 == first;
            let pick = |v: &[f64]| v.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, v)| *v).collect();
            Self::through(pick(&self.time), pick(&self.value), speeds)
        })
    }

    /// A straight line between two times, with corners there.
    pub fn line([begin, end]: [f64; 2], [from, to]: [f64; 2]) -> Self {
        let speed = (to - from) / (end - begin);
        Self { time: vec![begin, end], value: vec![from, to], pieces: vec![[from, speed, 0.0, 0.0]] }
    }

    /// Whether it is one straight line.
    pub fn is_line(&self) -> bool {
        self.time.len() == 2 && self.pieces[0][2..] == [0.0; 2]
    }

    /// Extends a straight line to a time, s; any other curve stays constant beyond its knots.
    pub fn go_on(&mut self, time: f64) {
        if self.is_line() {
            let [from, speed, ..] = self.pieces[0];
            let (begin, end) = (self.time[0].min(time), self.time[1].max(time));
            let at = |t: f64| from + speed * (t - self.time[0]);
            *self = Self::line([begin, end], [at(begin), at(end)]);
        }
    }

    /// Times of its first and last knot.
    pub fn ends(&self) -> (f64, f64) {
        (self.time[0], self.time[self.time.len() - 1])
    }

    /// Number of a move's knots at which the piston is in motion.
    pub fn knots_inside(&self) -> usize {
        let (low, high) = self.range();
        let end = ENDS * (high - low);
        self.value.iter().filter(|at| low + end < **at && **at < high - end).count()
    }

    /// Times and values of its knots.
    pub fn knots(&self) -> (&[f64], &[f64]) {
        (&self.time, &self.value)
    }

    /// Smallest and largest of its knots' values.
    pub fn range(&self) -> (f64, f64) {
        extremes(&self.value)
    }

    /// Smallest of its knots' values.
    pub fn lowest(&self) -> f64 {
        extremes(&self.value).0
    }

    /// Largest of its knots' values.
    pub fn highest(&self) -> f64 {
        extremes(&self.value).1
    }

    /// Value and slope at time `t`; `near` caches the last piece.
    #[inline]
    pub fn at(&self, t: f64, near: &Cell<usize>) -> (f64, f64) {
        let [value, slope, _] = self.bent(t, near);
        (value, slope)
    }

    /// Value, slope and second derivative at time `t`; at a knot, the latter is that of the later piece.
    #[inline(always)]
    pub fn bent(&self, t: f64, near: &Cell<usize>) -> [f64; 3] {
        let last = self.time.len() - 1;
        if t < self.time[0] || last == 0 {
            return [self.value[0], 0.0, 0.0];
        }
        if t > self.time[last] {
            return [self.value[last], 0.0, 0.0];
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
        let (u, [a, b, c, d]) = (t - self.time[i], self.pieces[i]);
        [a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), 2.0 * c + 6.0 * u * d]
    }
}

/// Mean of some values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_reproduces_a_cubic_with_its_end_slopes() {
        let f = |t: f64| 1.0 + t - 2.0 * t * t + 0.5 * t * t * t;
        let g = |t: f64| 1.0 - 4.0 * t + 1.5 * t * t;
        let t: Vec<f64> = vec![0.0, 0.3, 1.0, 1.2, 2.0];
        let s = Spline::through(t.clone(), t.iter().map(|t| f(*t)).collect(), [Some(g(0.0)), Some(g(2.0))]);
        let near = Cell::new(0);
        for k in 1..40 {
            let t = f64::from(k) * 0.05;
            let [value, slope, bend] = s.bent(t, &near);
            assert!((value - f(t)).abs() < 1e-12 && (slope - g(t)).abs() < 1e-11, "{t}");
            assert!((bend - (3.0 * t - 4.0)).abs() < 1e-10, "{t}");
        }
    }
}
