//! Uncertainty of the stroke between the rows of a move, where a model evaluates it there.
//!
//! A reading without delay shows the stroke at its own row. One that is late or lags shows it between two rows, where a curve
//! through the rows may miss it; so does a reading between two readings of a position that is not read at every row. The distance
//! of a row from the cubic through the two rows on either side gives the error: at a corner of the stroke the curve through all
//! rows misses a quarter of it, elsewhere less (1/64 for a fourth power). This is stated as the error of moves of few rows, zero
//! at the rows and largest halfway between them. Taking back a low-pass adds its time constant times the slope: in any move, and
//! at the rows too, this adds the error of the curve's slope and that of the positions' noise in it.
//! Position in m, time in s.

use crate::record::series::local_cubic::{OF_NOISE, cubic};
use crate::record::stroke::{Motion, Phase, Segment};

/// Fraction of a row's distance from the cubic through its neighbours that the curve through all rows may miss.
const MISSED: f64 = 0.25;
/// Standard deviation of a spline's slope at its knots, over that of the knots divided by their distance: √(9 ⟨sin²/(2 + cos)²⟩).
const SLOPE_OF_NOISE: f64 = 1.18;
/// Most rows of a move for which the stroke between two of them matters.
const FEW: usize = 20;
/// Parts of a gap between two rows in which a lag is integrated.
const PARTS: usize = 8;
/// A gap is forgotten after this many time constants.
const REMEMBERED: f64 = 8.0;

/// Timing of a model's reading relative to the recorded stroke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorTiming {
    /// Window over which the stroke is assumed to have been averaged, s.
    pub window_s: f64,
    /// Time constant of the low-pass that the pressure has passed, s.
    pub lag_s: f64,
    /// Delay of the reading behind the stroke that it shows, s.
    pub delay_s: f64,
    /// Time constant of the low-pass that the recorded stroke has passed, s.
    pub filter_s: f64,
}

/// A gap between two knots of a move's curve.
#[derive(Clone, Copy)]
struct Gap {
    from_s: f64,
    to_s: f64,
    /// Error of the curve halfway, m.
    error_m: f64,
    /// Rows in it, which share an error of the slope and count as one reading.
    rows: f64,
    /// Standard deviation of the positions, m.
    noise_m: f64,
}

impl Gap {
    /// Error of the stroke behind a low-pass at a time in the gap, m, from the errors of the curve and of its slope.
    fn error_at(&self, time: f64, filter_s: f64) -> f64 {
        let length = self.to_s - self.from_s;
        let u = ((time - self.from_s) / length).clamp(0.0, 1.0);
        let by_slope = 4.0 * self.error_m / length * (1.0 - 2.0 * u).abs() * self.rows.sqrt();
        let missed = 4.0 * self.error_m * u * (1.0 - u) + filter_s * by_slope;
        // The noise of a knot is that of the mean of the rows in a gap, which share it.
        missed.hypot(filter_s * SLOPE_OF_NOISE * self.noise_m / length)
    }
}

/// The gaps of a record's moves, and the timing of its readings.
pub struct BetweenRows {
    gaps: Vec<Gap>,
    timing: SensorTiming,
    /// Square root of the number of rows that share an error and count as one reading.
    shared: f64,
}

impl BetweenRows {
    /// For a record whose readings have this timing.
    pub fn new(motion: &Motion, timing: SensorTiming) -> Self {
        let is_read_seldom = motion.rows_per_reading > 1;
        let depends_between_rows =
            timing.lag_s > 0.0 || timing.delay_s != 0.0 || timing.filter_s > 0.0 || is_read_seldom;
        let moves = motion.segments.iter().filter(|s| depends_between_rows && s.phase == Phase::Move);
        // A straight line has exact corners; in a longer move the travel between two rows is a small part.
        let is_open = |s: &&Segment| !s.stroke.is_line() && (timing.filter_s > 0.0 || s.stroke.knots_inside() <= FEW);
        let gaps = moves.filter(is_open).flat_map(|s| gaps(s, motion)).collect();
        Self { gaps, timing, shared: (1.0 + timing.lag_s / motion.row_s()).sqrt() }
    }

    /// Error of the stroke that a reading at a time shows, m.
    pub fn error_m(&self, time: f64) -> f64 {
        let SensorTiming { lag_s, delay_s, filter_s, .. } = self.timing;
        let shown = time - delay_s;
        if lag_s == 0.0 {
            let here = self.gaps.iter().find(|gap| (gap.from_s..=gap.to_s).contains(&shown));
            return here.map_or(0.0, |gap| gap.error_at(shown, filter_s));
        }
        let seen = self.gaps.iter().filter(|gap| gap.from_s < shown && shown - gap.to_s < REMEMBERED * lag_s);
        let squares: f64 = seen.map(|gap| weighted(gap, shown, lag_s, filter_s).powi(2)).sum();
        self.shared * squares.sqrt()
    }
}

/// What a lag of this time constant retains at `shown` of a gap's error, m.
fn weighted(gap: &Gap, shown: f64, lag_s: f64, filter_s: f64) -> f64 {
    let kept = |time: f64| (-(shown - time.min(shown)) / lag_s).exp();
    let length = (gap.to_s - gap.from_s) / PARTS as f64;
    (0..PARTS)
        .map(|part| gap.from_s + length * part as f64)
        .map(|from| (kept(from + length) - kept(from)) * gap.error_at(from + 0.5 * length, filter_s))
        .sum()
}

/// Gaps between the knots of a move's curve; the piston is held before and after it.
fn gaps(segment: &Segment, motion: &Motion) -> Vec<Gap> {
    let (time, value) = segment.stroke.knots();
    let (n, noise_m) = (time.len(), motion.noise_m);
    if n < 3 {
        return Vec::new();
    }
    let row = |i: isize| {
        let near = i.clamp(0, n as isize - 1) as usize;
        let step = if i < 0 { time[1] - time[0] } else { time[n - 1] - time[n - 2] };
        (time[near] + step * (i - near as isize) as f64, value[near])
    };
    let missed: Vec<f64> = (0..n as isize)
        .map(|i| {
            let distance = value[i as usize] - cubic([i - 2, i - 1, i + 1, i + 2].map(row), time[i as usize]);
            (distance * distance - OF_NOISE * noise_m * noise_m).max(0.0).sqrt()
        })
        .collect();
    let gap = |i: usize| Gap {
        from_s: time[i - 1],
        to_s: time[i],
        error_m: MISSED * missed[i - 1].max(missed[i]),
        rows: ((time[i] - time[i - 1]) / motion.row_s()).max(1.0),
        noise_m,
    };
    (1..n).map(gap).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    const ROW: f64 = 0.01;

    /// Strokes of a few rows: one of constant acceleration and deceleration, a very smooth one, and one that begins with a corner
    /// and approaches its end.
    fn strokes() -> [fn(f64) -> f64; 3] {
        [
            |t| {
                let u = (t / 0.06).clamp(0.0, 1.0);
                if u < 0.5 { 0.1 - 0.1 * u * u } else { 0.05 + 0.1 * (1.0 - u) * (1.0 - u) }
            },
            |t| {
                let u = (t / 0.06).clamp(0.0, 1.0);
                0.1 - 0.05 * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
            },
            |t| 0.05 + 0.05 * (-t.max(0.0) / 0.02).exp(),
        ]
    }

    fn recorded(stroke: fn(f64) -> f64, begin: f64) -> Motion {
        let (time, position): (Vec<f64>, Vec<f64>) =
            (0..100).map(|i| f64::from(i) * ROW).map(|t| (t, stroke(t - begin))).unzip();
        Motion::detect(&time, &position)
    }

    #[test]
    fn the_error_of_a_stroke_between_rows_is_of_the_stated_size() {
        for (k, stroke) in strokes().into_iter().enumerate() {
            let (mut off, mut stated) = (0.0, 0.0);
            for begin in (0..20).map(|i| 0.3 + ROW * f64::from(i) / 20.0) {
                let motion = recorded(stroke, begin);
                let late = SensorTiming { delay_s: 0.5 * ROW, ..SensorTiming::default() };
                let between = BetweenRows::new(&motion, late);
                let near = Cell::new(0);
                for i in 25..60 {
                    let t = f64::from(i) * ROW;
                    let curve = &motion.segments[motion.segment_at(t - late.delay_s)].stroke;
                    off += (curve.at(t - late.delay_s, &near).0 - stroke(t - late.delay_s - begin)).powi(2);
                    stated += between.error_m(t).powi(2);
                }
            }
            let ratio: f64 = (off / stated).sqrt();
            assert!((0.02..1.5).contains(&ratio), "{k}: {ratio}");
        }
    }

    #[test]
    fn the_error_of_an_inverted_low_pass_is_of_the_stated_size() {
        const FILTER_S: f64 = 0.05;
        const NOISE_M: f64 = 2e-6;
        // A piston that starts at 0.5 m/s and stops after 0.15 m, through a low-pass.
        let behind = |t: f64| if t > 0.0 { t - FILTER_S * (1.0 - (-t / FILTER_S).exp()) } else { 0.0 };
        let ramp = |t: f64| 0.2 - 0.5 * (t.max(0.0) - (t - 0.3).max(0.0));
        for row_s in [0.01, 0.002, 0.001] {
            let (mut off, mut stated) = ([0.0; 2], [0.0; 2]);
            for begin in (0..10).map(|i| 0.2 + 0.01 * f64::from(i) / 10.0) {
                let mut random = crate::synthetic::Random::new(3);
                let shown = |t: f64| 0.2 - 0.5 * (behind(t - begin) - behind(t - begin - 0.3));
                let rows = (0..(1.2 / row_s) as usize).map(|i| i as f64 * row_s);
                let (time, position): (Vec<f64>, Vec<f64>) =
                    rows.map(|t| (t, shown(t) + NOISE_M * random.normal())).unzip();
                let motion = Motion::detect(&time, &position);
                let between = BetweenRows::new(&motion, SensorTiming { filter_s: FILTER_S, ..SensorTiming::default() });
                let near = Cell::new(0);
                let push = motion.segments.iter().find(|s| s.phase == Phase::Move).unwrap();
                // Rows between two knots share their error; each of them counts as if it were alone.
                let sharing = [1.0, (push.end - push.first) as f64 / push.stroke.knots().0.len() as f64];
                for t in time.iter().filter(|t| **t > begin - 0.1 && **t < begin + 0.6) {
                    let (position, speed) = motion.segments[motion.segment_at(*t)].stroke.at(*t, &near);
                    // Near a corner, and elsewhere, where only noise is left.
                    let part = usize::from((t - begin).abs() > 0.03 && (t - begin - 0.3).abs() > 0.03);
                    off[part] += sharing[part] * (position + FILTER_S * speed - ramp(t - begin)).powi(2);
                    stated[part] += between.error_m(*t).powi(2);
                }
            }
            let ratios: Vec<f64> = off.iter().zip(stated).map(|(off, stated)| (off / stated).sqrt()).collect();
            // Where a curve bends gently, less is missed than at a corner.
            let [at_corners, between_them] = [ratios[0], ratios[1]];
            assert!((0.2..1.5).contains(&at_corners) && (0.1..1.5).contains(&between_them), "{row_s}: {ratios:?}");
        }
    }

    #[test]
    fn a_reading_of_its_own_row_has_no_error_between_rows() {
        let motion = recorded(strokes()[0], 0.303);
        let largest_error_m = |timing: SensorTiming| {
            (0..100).map(|i| BetweenRows::new(&motion, timing).error_m(f64::from(i) * ROW)).fold(0.0, f64::max)
        };
        assert_eq!(largest_error_m(SensorTiming::default()), 0.0);
        assert!(largest_error_m(SensorTiming { lag_s: 0.002, ..SensorTiming::default() }) > 0.0);
        // A long lag remembers the move for a while.
        let behind =
            |lag_s: f64| BetweenRows::new(&motion, SensorTiming { lag_s, ..SensorTiming::default() }).error_m(0.42);
        assert!(behind(0.02) > 10.0 * behind(0.002), "{} {}", behind(0.02), behind(0.002));
        assert!(largest_error_m(SensorTiming { delay_s: -0.5 * ROW, ..SensorTiming::default() }) > 0.0);
    }

    #[test]
    fn only_moves_of_few_rows_have_an_error_between_rows() {
        // Constant acceleration and deceleration over this many rows.
        let largest_error_m = |rows: f64| {
            let stroke = |t: f64| {
                let u = (t / (rows * ROW)).clamp(0.0, 1.0);
                if u < 0.5 { 0.1 - 0.1 * u * u } else { 0.05 + 0.1 * (1.0 - u) * (1.0 - u) }
            };
            let (time, position): (Vec<f64>, Vec<f64>) =
                (0..400).map(|i| f64::from(i) * ROW).map(|t| (t, stroke(t - 0.303))).unzip();
            let between = BetweenRows::new(
                &Motion::detect(&time, &position),
                SensorTiming { delay_s: 0.005, ..SensorTiming::default() },
            );
            (20..380).map(|i| between.error_m(f64::from(i) * ROW)).fold(0.0, f64::max)
        };
        assert!(largest_error_m(6.0) > 1e-4, "{}", largest_error_m(6.0));
        assert_eq!(largest_error_m(40.0), 0.0);
        // Nor where no row is farther from the next than a hundredth of the travel.
        assert_eq!(largest_error_m(290.0), 0.0);
    }

    #[test]
    fn a_ramp_between_its_corners_has_no_error_between_rows() {
        let motion = recorded(|t| 0.1 - 0.05 * (t / 0.07).clamp(0.0, 1.0), 0.303);
        let timing = SensorTiming { lag_s: 0.02, delay_s: 0.004, ..SensorTiming::default() };
        assert_eq!(BetweenRows::new(&motion, timing).error_m(0.35), 0.0);
    }
}
