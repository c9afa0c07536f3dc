//! The curve of a long move through few of its rows. Position in m, time in s.

use crate::record::spline::Spline;
use nalgebra::{Matrix4, Vector4};
use std::cell::Cell;

/// Rows of a move that is long.
pub const FEWEST_ROWS: usize = 100;

/// A long move through fewer knots: local cubics through the rows around every few of them, where all rows then lie within their
/// noise of the curve. The position's noise no longer shakes the speed from row to row, and a simulation takes longer steps.
pub fn through(time_s: &[f64], position_m: &[f64], ends: [Option<f64>; 2], noise_m: f64) -> Option<Spline> {
    let n = time_s.len();
    [1024, 512, 256, 128, 64, 32, 16, 12, 8, 6, 4].into_iter().filter(|every| 8 * every < n).find_map(|every| {
        let (t, x) = knots(n, every)
            .into_iter()
            .map(|(i, reach)| match reach {
                0 | 1 => (time_s[i], position_m[i]),
                _ => {
                    let rows = i - reach..i + reach + 1;
                    (time_s[i], local_cubic(&time_s[rows.clone()], &position_m[rows], time_s[i]))
                }
            })
            .unzip();
        let curve = Spline::through(t, x, ends);
        let near = Cell::new(0);
        let squares: f64 = (0..n).map(|i| (position_m[i] - curve.at(time_s[i], &near).0).powi(2)).sum();
        let rms = (squares / n as f64).sqrt();
        (rms < within(every) * noise_m).then_some(curve)
    })
}

/// Root mean square of the rows' distances from the curve, over their noise, at the most: what is systematic in them stays near
/// the curve's own error, which is smaller the more rows make a knot. The noise itself is known to a few per cent.
fn within(every: usize) -> f64 {
    (1.0 + 3.0 / every as f64).sqrt().clamp(1.02, 1.1)
}

/// Rows to put knots at, and the rows to either side that make one: `every` in the middle, half the way to the next end of the
/// move at most, single rows at the ends themselves.
fn knots(n: usize, every: usize) -> Vec<(usize, usize)> {
    let mut out = Vec::new();
    let mut i = 0;
    while i < n {
        let reach = (i.min(n - 1 - i) / 2).clamp(1, every);
        out.push((i, reach));
        i += reach;
    }
    out
}

/// The value at a time of the cubic that fits these rows best.
fn local_cubic(time_s: &[f64], values: &[f64], at_s: f64) -> f64 {
    let scale = (time_s[time_s.len() - 1] - time_s[0]).max(f64::MIN_POSITIVE);
    let (mut square, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (t, v) in time_s.iter().zip(values) {
        let u = 2.0 * (t - at_s) / scale;
        let row = Vector4::new(1.0, u, u * u, u * u * u);
        square += row * row.transpose();
        right += row * (v - values[0]);
    }
    square.cholesky().map_or(values[values.len() / 2], |c| values[0] + c.solve(&right)[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn a_long_noisy_move_is_followed_closer_than_its_rows_are_known() {
        let mut random = Random::new(8);
        let truth = |t: f64| 1.0 + 0.4 * (1.3 * t).sin();
        let (t, x): (Vec<f64>, Vec<f64>) =
            (0..1000).map(|i| f64::from(i) * 0.02).map(|t| (t, truth(t) + 1e-5 * random.normal())).unzip();
        let curve = through(&t, &x, [None, None], 1e-5).unwrap();
        let near = Cell::new(0);
        let (mut off, mut speed_off): (f64, f64) = (0.0, 0.0);
        for between in t[50..950].iter().map(|t| t + 0.007) {
            let (place, speed) = curve.at(between, &near);
            off += (place - truth(between)).powi(2) / 900.0;
            speed_off += (speed - 0.52 * (1.3 * between).cos()).powi(2) / 900.0;
        }
        assert!(off.sqrt() < 0.6e-5, "{}", off.sqrt());
        // Rows themselves give the speed to 1.4e-5/0.02 m/s.
        assert!(speed_off.sqrt() < 2e-4, "{}", speed_off.sqrt());
    }
}
