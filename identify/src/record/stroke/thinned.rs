//! The curve of a long move with few knots, each from a local cubic through the rows around it.
//!
//! Knots are evenly spaced, as far apart as all rows together stay within their noise of the curve, with more between them where
//! single rows require it (at a corner). If no even spacing fits (a piston that starts at once and then approaches its end), a
//! few knots are refined. The position noise then no longer shakes the speed from row to row, and a simulation takes longer
//! steps. Position in m, time in s.

use super::spline::Spline;
use crate::record::series::local_cubic::local_cubic;
use std::cell::Cell;

/// Fewest rows of a long move.
pub const FEWEST_ROWS: usize = 100;

/// Spacings of the even knots that are tried, rows.
const EVERY: [usize; 7] = [1024, 512, 256, 128, 64, 32, 16];

/// Fits a long move's curve, with these speeds at its ends.
pub fn through(time_s: &[f64], position_m: &[f64], ends: [Option<f64>; 2], noise_m: f64) -> Spline {
    let rows = Rows { time_s, position_m, ends, noise_m };
    let even = EVERY.into_iter().filter(|every| 8 * every < time_s.len()).find_map(|every| {
        let knots = even_knots(time_s.len(), every);
        let squares = rows.squares(&rows.curve(&knots), 0..time_s.len());
        (squares < within(every as f64).powi(2) * time_s.len() as f64).then_some(knots)
    });
    rows.refined(even.unwrap_or_else(|| vec![0, time_s.len() / 2, time_s.len() - 1]))
}

/// Largest root mean square distance of the rows from the curve, over their noise. What is systematic in it stays near the
/// curve's own error, which is the smaller the more rows a knot has. The noise itself is known to a few per cent.
fn within(every: f64) -> f64 {
    (1.0 + 3.0 / every).sqrt().clamp(1.02, 1.1)
}

/// Number of rows whose mean has the same error, from position noise and systematic deviations, as a curve with `every` rows per
/// knot.
pub fn rows_in_mean(every: f64) -> f64 {
    (within(every).powi(2) - 1.0 + 1.0 / every).recip().min(every)
}

/// Rows of the knots: `every` rows apart in the middle, at most half the distance to the nearer end of the move elsewhere.
fn even_knots(n: usize, every: usize) -> Vec<usize> {
    std::iter::successors(Some(0), |i| Some(i + ((*i).min((n - 1).saturating_sub(*i)) / 2).clamp(1, every)))
        .take_while(|i| *i < n)
        .collect()
}

/// The rows of a move.
struct Rows<'a> {
    time_s: &'a [f64],
    position_m: &'a [f64],
    ends: [Option<f64>; 2],
    noise_m: f64,
}

impl Rows<'_> {
    /// The curve through knots at these rows, each fitted to the rows on either side up to the nearer neighbouring knot.
    fn curve(&self, knots: &[usize]) -> Spline {
        let (t, x) = (0..knots.len())
            .map(|k| {
                let i = knots[k];
                let reach = match (k.checked_sub(1), knots.get(k + 1)) {
                    (Some(before), Some(after)) => (i - knots[before]).min(after - i),
                    _ => 1,
                };
                let through_rows = || local_cubic(self.time_s, self.position_m, i, reach)[0];
                (self.time_s[i], if reach > 1 { through_rows() } else { self.position_m[i] })
            })
            .unzip();
        Spline::through(t, x, self.ends)
    }

    /// Sum of the squares of the rows' distances from a curve, over their noise.
    fn squares(&self, curve: &Spline, rows: std::ops::Range<usize>) -> f64 {
        let near = Cell::new(0);
        rows.map(|i| ((self.position_m[i] - curve.at(self.time_s[i], &near).0) / self.noise_m).powi(2)).sum()
    }

    /// The curve with further knots added halfway between two of them, wherever the rows there are farther from it than their
    /// noise allows.
    fn refined(&self, mut knots: Vec<usize>) -> Spline {
        const DEVIATIONS: f64 = 3.0;
        loop {
            let curve = self.curve(&knots);
            let is_off = |pair: &&[usize]| {
                let rows = (pair[1] - pair[0] - 1) as f64;
                rows > 0.0 && self.squares(&curve, pair[0] + 1..pair[1]) > rows + DEVIATIONS * (2.0 * rows).sqrt()
            };
            let between: Vec<usize> = knots.windows(2).filter(is_off).map(|pair| pair[0].midpoint(pair[1])).collect();
            if between.is_empty() {
                return curve;
            }
            knots.extend(between);
            knots.sort_unstable();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::stroke::Motion;
    use crate::synthetic::Random;
    use std::f64::consts::TAU;

    #[test]
    fn the_error_of_a_curve_is_of_the_stated_size() {
        const NOISE_M: f64 = 1e-5;
        let near = Cell::new(0);
        for (rows, turns) in [(1000, 1.0), (3000, 3.0), (3000, 0.25)] {
            let stroke = |u: f64| 0.05 + 0.02 * (TAU * turns * u).sin();
            let (mut off, mut said) = (0.0, 0.0);
            for seed in 0..10 {
                let mut random = Random::new(seed);
                let time: Vec<f64> = (0..rows).map(|i| f64::from(i) / f64::from(rows)).collect();
                let position: Vec<f64> = time.iter().map(|t| stroke(*t) + NOISE_M * random.normal()).collect();
                let curve = through(&time, &position, [None, None], NOISE_M);
                let rows_in_mean = rows_in_mean(f64::from(rows) / curve.knots().0.len() as f64);
                // The curve goes through single rows at the ends of a move.
                for t in &time[50..time.len() - 50] {
                    off += (curve.at(*t, &near).0 - stroke(*t)).powi(2);
                    said += NOISE_M * NOISE_M / rows_in_mean;
                }
            }
            let ratio = f64::sqrt(off / said);
            assert!((0.2..1.0).contains(&ratio), "{rows} {turns}: {ratio}");
        }
    }

    #[test]
    fn a_fast_sine_of_few_rows_is_followed_between_them() {
        for (frequency_hz, row_s, rows) in [(5.0, 0.01, 600), (2.0, 0.02, 300), (1.5, 0.01, 600)] {
            let stroke = |t: f64| 0.1 - 0.01 * (1.0 - (TAU * frequency_hz * t).cos());
            let mut random = Random::new(11);
            let (time, position): (Vec<f64>, Vec<f64>) =
                (0..rows).map(|i| row_s * f64::from(i)).map(|t| (t, stroke(t) + 3e-6 * random.normal())).unzip();
            let motion = Motion::detect(&time, &position);
            let near = Cell::new(0);
            let off = |t: f64| motion.segments[motion.segment_at(t)].stroke.at(t, &near).0 - stroke(t);
            // At a record's ends the curve is less certain.
            let times = (40..2 * rows - 40).map(|k| 0.5 * row_s * f64::from(k));
            let square = times.clone().map(|t| off(t).powi(2)).sum::<f64>() / times.count() as f64;
            assert!(square.sqrt() < 6e-6, "{frequency_hz} Hz: {}", square.sqrt());
        }
    }

    #[test]
    fn the_curve_of_a_long_noisy_move_is_more_accurate_than_its_rows() {
        let mut random = Random::new(8);
        let truth = |t: f64| 1.0 + 0.4 * (1.3 * t).sin();
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..1000).map(|i| f64::from(i) * 0.02).map(|t| (t, truth(t) + 1e-5 * random.normal())).unzip();
        let curve = through(&t, &x, [None, None], 1e-5);
        let near = Cell::new(0);
        let (mut off, mut speed_off): (f64, f64) = (0.0, 0.0);
        for between in t[50..950].iter().map(|t| t + 0.007) {
            let (position, speed) = curve.at(between, &near);
            off += (position - truth(between)).powi(2) / 900.0;
            speed_off += (speed - 0.52 * (1.3 * between).cos()).powi(2) / 900.0;
        }
        assert!(off.sqrt() < 0.6e-5, "{}", off.sqrt());
        // The rows themselves give the speed to 1.4e-5/0.02 m/s.
        assert!(speed_off.sqrt() < 2e-4, "{}", speed_off.sqrt());
    }

    #[test]
    fn the_curve_of_an_exponential_move_is_more_accurate_than_its_rows() {
        const ROW_S: f64 = 0.002;
        // Rounded to 0.1 mm, and at 5 µm of noise.
        for (step_m, noise_m) in [(1e-4, 2e-6), (1e-6, 5e-6)] {
            let mut random = Random::new(8);
            let stroke = |t: f64| 0.07 + 0.07 * (-t.max(0.0) / 0.15).exp();
            let speed = |t: f64| if t > 0.0 { 0.07 / 0.15 * (-t / 0.15).exp() } else { 0.0 };
            let begin = 0.0507;
            let (t, x): (Vec<f64>, Vec<f64>) = (0..500)
                .map(|i| f64::from(i) * ROW_S)
                .map(|t| (t, ((stroke(t - begin) + noise_m * random.normal()) / step_m).round() * step_m))
                .unzip();
            let known_m: f64 = noise_m.hypot(step_m / 12.0f64.sqrt());
            let curve = through(&t, &x, [None, None], known_m);
            let near = Cell::new(0);
            let times: Vec<f64> =
                (0..5000).map(|k| f64::from(k) * 2e-4).filter(|t| (t - begin).abs() > 2.0 * ROW_S).collect();
            let off = |t: &f64| (curve.at(*t, &near).0 - stroke(t - begin)).powi(2);
            let rms = (times.iter().map(off).sum::<f64>() / times.len() as f64).sqrt();
            let rectified = |speed: f64| speed.abs().powf(0.8);
            let tail: Vec<&f64> = times.iter().filter(|t| **t > 0.5).collect();
            let shown = tail.iter().map(|t| rectified(curve.at(**t, &near).1)).sum::<f64>();
            let truth = tail.iter().map(|t| rectified(speed(**t - begin))).sum::<f64>();
            assert!(
                rms < 0.4 * known_m && (0.95..1.05).contains(&(shown / truth)),
                "{step_m}: {rms} {}",
                shown / truth
            );
        }
    }

    #[test]
    fn a_corner_that_few_rows_of_a_long_move_show_has_its_speed() {
        const ROW_S: f64 = 1e-3;
        const FILTER_S: f64 = 0.08;
        // A piston that starts at 1 m/s and stops after 60 mm, through a low-pass.
        let behind = |t: f64| if t > 0.0 { t - FILTER_S * (1.0 - (-t / FILTER_S).exp()) } else { 0.0 };
        let speed = |t: f64| if t > 0.0 { 1.0 - (-t / FILTER_S).exp() } else { 0.0 };
        let [begin, end] = [0.0205, 0.0805];
        let mut random = Random::new(8);
        let (t, x): (Vec<f64>, Vec<f64>) = (0..600)
            .map(|i| f64::from(i) * ROW_S)
            .map(|t| (t, 0.1 - behind(t - begin) + behind(t - end) + 2e-6 * random.normal()))
            .unzip();
        let curve = through(&t, &x, [None, None], 2e-6);
        let near = Cell::new(0);
        let off = |t: f64| FILTER_S * (curve.at(t, &near).1 + speed(t - begin) - speed(t - end));
        let around = (0..600).map(|k| begin - 0.03 + 1e-4 * f64::from(k)).map(|t| off(t).powi(2));
        let rms_m = (around.sum::<f64>() / 600.0).sqrt();
        // What taking back the low-pass adds to the position, of 1 mm from row to row.
        assert!(rms_m < 1.5e-4, "{rms_m}");
    }
}
