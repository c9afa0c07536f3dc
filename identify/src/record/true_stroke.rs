//! The piston's stroke behind a record of it that is a moving average and has passed a low-pass: what `position_averaging`
//! and `position_delay` take back, with its derivatives by the window and by the low-pass's time constant. Position in m,
//! time in s from the record's start.
//!
//! Where the record has a corner, the stroke has one there and half a window to either side of it.

use crate::record::stroke::{Motion, Segment};
use chamber::effects::position_averaging;
use std::cell::Cell;

/// A stroke on the way: with the places of the recorded one that were asked last.
pub struct TrueStroke<'a> {
    motion: &'a Motion,
    window: f64,
    /// Time constant of the low-pass, s.
    filter: f64,
    /// Where stretches without a corner end; those of the record itself where it is no average.
    ends: Vec<f64>,
    near: [Cell<usize>; 4],
    /// What was read for the bend that was asked last.
    read: Cell<Read>,
}

/// Where the record was read for a bend, and its speed, m/s, and acceleration, m/s², there.
#[derive(Clone, Copy, Default)]
struct Read {
    points: Points,
    rates: [[f64; 2]; 3],
}

impl<'a> TrueStroke<'a> {
    /// Behind a record that averages over `window`, s, and has passed a low-pass of time constant `filter`, s; zero means
    /// that the record is the stroke.
    pub fn new(motion: &'a Motion, window: f64, filter: f64) -> Self {
        let mut ends: Vec<f64> = motion.segments.iter().map(|s| s.to_s).collect();
        if window > 0.0 {
            let (begin, end) = motion.extent();
            ends.push(begin);
            ends = ends.iter().flat_map(|end| [-0.5, 0.0, 0.5].map(|share| end + share * window)).collect();
            ends.retain(|time| *time > begin && *time <= end);
            ends.sort_by(f64::total_cmp);
            ends.dedup_by(|later, earlier| *later - *earlier < 1e-9);
        }
        Self { motion, window, filter, ends, near: Default::default(), read: Cell::default() }
    }

    /// Number of stretches without a corner.
    #[inline]
    pub fn stretches(&self) -> usize {
        self.ends.len()
    }

    /// Where one of them ends, s.
    #[inline]
    pub fn end(&self, stretch: usize) -> f64 {
        self.ends[stretch]
    }

    /// Position, m, and velocity, m/s, at a time on a stretch.
    #[inline]
    pub fn at(&self, stretch: usize, time: f64) -> [f64; 2] {
        let [position, velocity] = self.filtered(stretch, time);
        if self.filter == 0.0 {
            return [position, velocity];
        }
        [position + self.filter * velocity, velocity + self.filter * self.acceleration(stretch, time)]
    }

    /// Derivatives of position and velocity by the low-pass's time constant, 1/s of each.
    pub fn by_filter(&self, stretch: usize, time: f64) -> [f64; 2] {
        [self.filtered(stretch, time)[1], self.acceleration(stretch, time)]
    }

    /// Acceleration behind the average and before the low-pass, m/s².
    fn acceleration(&self, stretch: usize, time: f64) -> f64 {
        if self.window == 0.0 {
            return self.motion.segments[stretch].stroke.curvature(time, &self.near[0]);
        }
        let recorded = |time: f64, near: usize| self.segment(time).stroke.curvature(time, &self.near[near]);
        let Points { times, moves_on, .. } = self.points(time);
        let bend = if moves_on { position_averaging::bend([0, 1, 2].map(|i| recorded(times[i], i))) } else { 0.0 };
        recorded(time, 3) - bend
    }

    /// Position, m, and velocity, m/s, behind the average and before the low-pass.
    #[inline]
    fn filtered(&self, stretch: usize, time: f64) -> [f64; 2] {
        if self.window == 0.0 {
            let (position, velocity) = self.motion.segments[stretch].stroke.at(time, &self.near[0]);
            return [position, velocity];
        }
        let recorded = |time: f64, near: usize| self.segment(time).stroke.bent(time, &self.near[near]);
        let [position, velocity, _] = recorded(time, 3);
        let points = self.points(time);
        let [before, middle, after] = [0, 1, 2].map(|i| recorded(points.times[i], i));
        self.read.set(Read { points, rates: [before, middle, after].map(|[_, speed, bend]| [speed, bend]) });
        let bend = position_averaging::bend([before[0], middle[0], after[0]]);
        let bend_rate = if points.moves_on { position_averaging::bend([before[1], middle[1], after[1]]) } else { 0.0 };
        [position - bend, velocity - bend_rate]
    }

    /// Derivatives of position and velocity by the window, 1/s of each, at the time that was asked last; the low-pass's share
    /// of the velocity's is left out.
    pub fn by_window(&self) -> [f64; 2] {
        let Read { points: Points { by_window, moves_on, .. }, rates } = self.read.get();
        let rates = [0, 1, 2].map(|i| rates[i].map(|rate| rate * by_window[i]));
        let of = |k: usize| -position_averaging::bend(rates.map(|r| r[k]));
        let velocity = if moves_on { of(1) } else { 0.0 };
        [of(0) + self.filter * velocity, velocity]
    }

    /// Where the record is read for the bend at a time.
    fn points(&self, time: f64) -> Points {
        let (begin, end) = self.motion.extent();
        let half = 0.5 * self.window;
        let middle = position_averaging::middle(time, half, [begin, end]);
        let moves = if middle > time {
            0.5
        } else if middle < time {
            -0.5
        } else {
            0.0
        };
        Points {
            times: [middle - half, middle, middle + half],
            by_window: [moves - 0.5, moves, moves + 0.5],
            moves_on: moves == 0.0,
        }
    }

    fn segment(&self, time: f64) -> &Segment {
        let segments = &self.motion.segments;
        &segments[segments.partition_point(|s| s.to_s < time).min(segments.len() - 1)]
    }
}

/// Three moments of the record, s, their rates by the window, and whether they go along with time.
#[derive(Clone, Copy, Default)]
struct Points {
    times: [f64; 3],
    by_window: [f64; 3],
    moves_on: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: f64 = 0.06;

    /// A push of 0.3 s and its moving average, at 200 Hz, without noise.
    fn record() -> (impl Fn(f64) -> f64, Motion) {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let truth = move |t: f64| 0.1 - 0.05 * smooth(((t - 0.4) / 0.3).clamp(0.0, 1.0));
        let averaged =
            |t: f64| (0..200).map(|k| truth(t + WINDOW * ((f64::from(k) + 0.5) / 200.0 - 0.5))).sum::<f64>() / 200.0;
        let (time, position): (Vec<f64>, Vec<f64>) =
            (0..300).map(|i| f64::from(i) * 5e-3).map(|t| (t, averaged(t))).unzip();
        (truth, Motion::detect(&time, &position))
    }

    fn along(stroke: &TrueStroke<'_>, time: f64) -> [f64; 2] {
        let stretch = (0..stroke.stretches()).find(|s| time <= stroke.end(*s)).unwrap_or(stroke.stretches() - 1);
        stroke.at(stretch, time)
    }

    #[test]
    fn the_stroke_behind_a_moving_average_is_found_again() {
        let (truth, motion) = record();
        let [plain, behind] = [0.0, WINDOW].map(|window| TrueStroke::new(&motion, window, 0.0));
        let worst = |stroke: &TrueStroke<'_>| {
            (1..1490).map(|k| f64::from(k) * 1e-3).map(|t| (along(stroke, t)[0] - truth(t)).abs()).fold(0.0, f64::max)
        };
        assert!(worst(&plain) > 1e-4, "{}", worst(&plain));
        assert!(worst(&behind) < 0.2 * worst(&plain), "{} {}", worst(&behind), worst(&plain));
    }

    #[test]
    fn the_stroke_behind_a_low_pass_is_found_again_with_its_derivative() {
        const FILTER: f64 = 0.05;
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let truth = |t: f64| 0.1 - 0.05 * smooth(((t - 0.4) / 0.3).clamp(0.0, 1.0));
        // τ y' = x − y in steps of 1 µs by the trapezoidal rule.
        let (mut filtered, mut y) = (vec![(0.0, 0.1)], 0.1);
        for i in 0..1_500_000 {
            let t = f64::from(i) * 1e-6;
            let share = 0.5e-6 / FILTER;
            y = (y * (1.0 - share) + share * (truth(t) + truth(t + 1e-6))) / (1.0 + share);
            if (i + 1) % 5000 == 0 {
                filtered.push((t + 1e-6, y));
            }
        }
        let (time, position): (Vec<f64>, Vec<f64>) = filtered.into_iter().unzip();
        let motion = Motion::detect(&time, &position);
        let [less, behind, more] = [-1e-6, 0.0, 1e-6].map(|d| TrueStroke::new(&motion, 0.0, FILTER + d));
        for t in (1..1490).map(|k| f64::from(k) * 1e-3) {
            assert!((along(&behind, t)[0] - truth(t)).abs() < 5e-5, "{t}: {} {}", along(&behind, t)[0], truth(t));
            let stretch = (0..behind.stretches()).find(|s| t <= behind.end(*s)).unwrap_or(behind.stretches() - 1);
            for (k, exact) in behind.by_filter(stretch, t).into_iter().enumerate() {
                let by_filter = (along(&more, t)[k] - along(&less, t)[k]) / 2e-6;
                assert!((by_filter - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{t}: {by_filter} {exact}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let (_, motion) = record();
        let [less, middle, more] = [-1e-6, 0.0, 1e-6].map(|d| TrueStroke::new(&motion, WINDOW + d, 0.0));
        for t in [0.005, 0.013, 0.38, 0.45, 0.5123, 0.6, 0.71, 1.0, 1.49] {
            along(&middle, t);
            let [position, velocity] = middle.by_window();
            let by_window = [0, 1].map(|k| (along(&more, t)[k] - along(&less, t)[k]) / 2e-6);
            assert!((position - by_window[0]).abs() < 1e-6, "{t}: {position} {}", by_window[0]);
            assert!((velocity - by_window[1]).abs() < 1e-3, "{t}: {velocity} {}", by_window[1]);
            let rate = (along(&middle, t + 1e-6)[0] - along(&middle, t - 1e-6)[0]) / 2e-6;
            assert!((rate - along(&middle, t)[1]).abs() < 1e-6, "{t}");
        }
    }
}
