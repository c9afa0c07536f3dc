//! The piston's true stroke, from a record that is a moving average and has passed a low-pass: what `position_averaging` and
//! `position_delay` take back, with its derivatives by the window and by the low-pass's time constant. Position in m, time in s
//! from the record's start.
//!
//! Around each motion the stroke is the spline of [`unaveraged`], elsewhere the record.

use crate::record::stroke::{Motion, Phase};
use chamber::unaveraged::{self, Unaveraged};
use std::cell::Cell;

/// The true stroke, with a cache of the places evaluated last.
pub struct TrueStroke<'a> {
    motion: &'a Motion,
    window: f64,
    /// Time constant of the low-pass, s.
    filter: f64,
    /// The stroke behind the average around each motion, in time order.
    unaveraged: Vec<Unaveraged>,
    /// Ends of the stretches without a corner: those of the record's segments, and of the splines.
    ends: Vec<f64>,
    near: Near,
}

/// The places evaluated last: indices of the recorded stroke's segment and of the piece in it, and of the stroke behind the
/// average.
#[derive(Default)]
struct Near {
    segment: Cell<usize>,
    piece: Cell<usize>,
    unaveraged: Cell<usize>,
}

/// The stroke at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Position, m.
    pub position: f64,
    /// Velocity, m/s.
    pub velocity: f64,
    /// Derivatives of position and velocity by the window, 1/s of each, without the low-pass's part of the latter.
    pub by_window: [f64; 2],
    /// Derivatives of position and velocity by the low-pass's time constant, 1/s of each.
    pub by_filter: [f64; 2],
}

impl<'a> TrueStroke<'a> {
    /// For a record averaged over `window`, s, that has passed a low-pass of time constant `filter`, s; zero means that the
    /// record is the stroke. Derivatives by the window are zero unless wanted.
    pub fn new(motion: &'a Motion, window: f64, filter: f64, with_derivatives: bool) -> Self {
        let ends: Vec<f64> = motion.segments.iter().map(|s| s.to_s).collect();
        let mut stroke = Self { motion, window, filter, unaveraged: Vec::new(), ends, near: Near::default() };
        if window > 0.0 {
            let (begin, end) = motion.extent();
            let moves = motion.segments.iter().filter(|s| s.phase == Phase::Move).map(|s| [s.from_s, s.to_s]);
            stroke.unaveraged =
                unaveraged::around(|time| stroke.recorded(time)[0], window, [begin, end], moves, with_derivatives);
            let of_splines = stroke.unaveraged.iter().flat_map(Unaveraged::extent);
            stroke.ends.extend(of_splines.filter(|time| *time > begin && *time < end));
            stroke.ends.sort_by(f64::total_cmp);
            stroke.ends.dedup_by(|later, earlier| *later - *earlier < 1e-9);
        }
        stroke
    }

    /// Number of stretches without a corner.
    #[inline]
    pub fn stretches(&self) -> usize {
        self.ends.len()
    }

    /// End of a stretch, s.
    #[inline]
    pub fn end(&self, stretch: usize) -> f64 {
        self.ends[stretch]
    }

    /// The stretch that ends nearest to a time, s.
    pub fn stretch_that_ends_at(&self, time: f64) -> usize {
        let behind = self.ends.partition_point(|end| *end < time).min(self.ends.len() - 1);
        let is_nearer = |before: &usize| time - self.ends[*before] < (self.ends[behind] - time).abs();
        behind.checked_sub(1).filter(is_nearer).unwrap_or(behind)
    }

    /// The longest first step on a stretch and the longest step at all, s: a fiftieth of the shortest part of the record in it,
    /// since the previous step is no guide there, and a tenth of the shortest move. What counts as a move begins and ends with
    /// rows of rest, and all stages of a longer step may fall on these.
    pub fn longest_steps(&self, stretch: usize) -> [f64; 2] {
        let begin = if stretch == 0 { self.motion.extent().0 } else { self.ends[stretch - 1] };
        let middle = 0.5 * (begin + self.ends[stretch]);
        let mut longest = [f64::INFINITY; 2];
        for windows in [-1.0, 0.0, 1.0] {
            let part = &self.motion.segments[self.motion.segment_at(middle + windows * self.window)];
            let length = part.to_s - part.from_s;
            let of_move = if part.phase == Phase::Move { 0.1 * length } else { f64::INFINITY };
            longest = [longest[0].min(0.02 * length), longest[1].min(of_move)];
        }
        longest
    }

    /// The stroke at a time on a stretch.
    #[inline]
    pub fn at(&self, stretch: usize, time: f64) -> Moment {
        if let Some(spline) = unaveraged::containing(&self.unaveraged, &self.near.unaveraged, time) {
            let unaveraged::At { derivatives, by_window } = spline.at(time);
            return self.before_filter(derivatives, by_window);
        }
        let recorded = if self.window == 0.0 {
            self.motion.segments[stretch].stroke.bent(time, &self.near.piece)
        } else {
            self.recorded(time)
        };
        self.before_filter(recorded, [0.0; 2])
    }

    /// Takes the low-pass back: position, m, velocity, m/s, and acceleration, m/s², are those behind it.
    #[inline(always)]
    fn before_filter(
        &self,
        [position, velocity, acceleration]: [f64; 3],
        [position_wider, velocity_wider]: [f64; 2],
    ) -> Moment {
        Moment {
            position: position + self.filter * velocity,
            velocity: velocity + self.filter * acceleration,
            by_window: [position_wider + self.filter * velocity_wider, velocity_wider],
            by_filter: [velocity, acceleration],
        }
    }

    /// Position, m, velocity, m/s, and acceleration, m/s², of the record.
    #[inline(always)]
    pub fn recorded(&self, time: f64) -> [f64; 3] {
        let (segments, Near { segment, piece, .. }) = (&self.motion.segments, &self.near);
        let last = segment.get();
        let is_there = time <= segments[last].to_s && (last == 0 || segments[last - 1].to_s < time);
        if !is_there {
            segment.set(self.motion.segment_at(time));
        }
        segments[segment.get()].stroke.bent(time, piece)
    }
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

    fn along(stroke: &TrueStroke<'_>, time: f64) -> Moment {
        let stretch = (0..stroke.stretches()).find(|s| time <= stroke.end(*s)).unwrap_or(stroke.stretches() - 1);
        stroke.at(stretch, time)
    }

    #[test]
    fn the_stroke_behind_a_moving_average_is_found_again() {
        let (truth, motion) = record();
        let [plain, behind] = [0.0, WINDOW].map(|window| TrueStroke::new(&motion, window, 0.0, true));
        let worst = |stroke: &TrueStroke<'_>| {
            (1..1490)
                .map(|k| f64::from(k) * 1e-3)
                .map(|t| (along(stroke, t).position - truth(t)).abs())
                .fold(0.0, f64::max)
        };
        assert!(worst(&plain) > 1e-4, "{}", worst(&plain));
        assert!(worst(&behind) < 0.05 * worst(&plain), "{} {}", worst(&behind), worst(&plain));
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
        let [less, behind, more] = [-1e-6, 0.0, 1e-6].map(|d| TrueStroke::new(&motion, 0.0, FILTER + d, true));
        for t in (1..1490).map(|k| f64::from(k) * 1e-3) {
            let Moment { position, by_filter, .. } = along(&behind, t);
            assert!((position - truth(t)).abs() < 5e-5, "{t}: {position} {}", truth(t));
            let [less, more] = [&less, &more].map(|stroke| along(stroke, t));
            let by_difference = [more.position - less.position, more.velocity - less.velocity].map(|d| d / 2e-6);
            for (exact, found) in by_filter.into_iter().zip(by_difference) {
                assert!((found - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{t}: {found} {exact}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_finite_differences() {
        let (_, motion) = record();
        // At the window itself the number of knots is about to change.
        let [less, middle, more] = [-1e-6, 0.0, 1e-6].map(|d| TrueStroke::new(&motion, 1.01 * WINDOW + d, 0.0, true));
        for t in [0.005, 0.013, 0.38, 0.45, 0.5123, 0.6, 0.71, 1.0, 1.49] {
            let Moment { velocity, by_window, .. } = along(&middle, t);
            let [narrow, wide] = [&less, &more].map(|stroke| along(stroke, t));
            let of_position = (wide.position - narrow.position) / 2e-6;
            let of_velocity = (wide.velocity - narrow.velocity) / 2e-6;
            assert!((by_window[0] - of_position).abs() < 1e-6, "{t}: {} {of_position}", by_window[0]);
            assert!((by_window[1] - of_velocity).abs() < 1e-3, "{t}: {} {of_velocity}", by_window[1]);
            let rate = (along(&middle, t + 1e-6).position - along(&middle, t - 1e-6).position) / 2e-6;
            assert!((rate - velocity).abs() < 1e-6, "{t}");
        }
    }
}
