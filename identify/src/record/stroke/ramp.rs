//! Moves at constant speed: a straight line between two holds, with its corners where the lines meet.
//!
//! The corners of a ramp lie between two rows of a record; a smooth curve through the rows rounds them off, and a
//! lagging or delayed sensor sees the difference. Position in m, time in s.

/// Fewest rows that distinguish a straight line from a curve.
const FEWEST_ROWS: usize = 3;
/// Largest distance of a row from the ramp, in standard deviations of the position and as a fraction of the stroke.
const DEVIATIONS: f64 = 6.0;
const SHARE: f64 = 1e-5;

/// Start and end, s, of the ramp from `before` to `after` on which every row of a move lies, if there is one.
pub fn corners(time_s: &[f64], position_m: &[f64], before: f64, after: f64, noise_m: f64) -> Option<[f64; 2]> {
    let span = after - before;
    let inside: Vec<(f64, f64)> = time_s
        .iter()
        .zip(position_m)
        .filter(|(_, x)| (0.1..=0.9).contains(&((*x - before) / span)))
        .map(|(t, x)| (*t, *x))
        .collect();
    if inside.len() < FEWEST_ROWS {
        return None;
    }
    let n = inside.len() as f64;
    let (t0, x0) = inside.iter().fold((0.0, 0.0), |(t, x), row| (t + row.0 / n, x + row.1 / n));
    let (tt, tx) =
        inside.iter().fold((0.0, 0.0), |(tt, tx), (t, x)| (tt + (t - t0) * (t - t0), tx + (t - t0) * (x - x0)));
    let speed = tx / tt;
    let (begin, end) = (t0 + (before - x0) / speed, t0 + (after - x0) / speed);
    let allowed = DEVIATIONS * noise_m + SHARE * span.abs();
    let on_ramp = |(t, x): (&f64, &f64)| (before + speed * (t.clamp(begin, end) - begin) - x).abs() <= allowed;
    (begin < end && time_s.iter().zip(position_m).all(on_ramp)).then_some([begin, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(stroke: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let noise = |i: u32| 2e-6 * (f64::from(i * 7919 % 13) / 6.5 - 1.0);
        (0..40).map(|i| (f64::from(i) * 0.01, stroke(f64::from(i) * 0.01) + noise(i))).unzip()
    }

    #[test]
    fn the_corners_of_a_ramp_are_found_between_the_rows() {
        let (t, x) = rows(|t| 0.1 - 0.05 * ((t - 0.123) / 0.05).clamp(0.0, 1.0));
        let [begin, end] = corners(&t, &x, 0.1, 0.05, 2e-6).unwrap();
        assert!((begin - 0.123).abs() < 1e-5 && (end - 0.173).abs() < 1e-5, "{begin} {end}");
    }

    #[test]
    fn a_smooth_move_is_no_ramp() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        for duration in [0.05, 0.1, 0.2] {
            let (t, x) = rows(|t| 0.1 - 0.05 * smooth(((t - 0.12) / duration).clamp(0.0, 1.0)));
            assert_eq!(corners(&t, &x, 0.1, 0.05, 2e-6), None, "{duration}");
        }
    }
}
