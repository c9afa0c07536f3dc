//! Finds rest, push and hold in the recording of a push-and-hold test.
//!
//! The piston counts as at its final position where it deviates from it by no more than in the last quarter of the recording,
//! which must be part of the hold; its departure from the initial position is detected with the same tolerance. A noisy or
//! quantised position thus sets its own tolerance.

use super::Error;

/// Travel up to which the piston counts as held, m.
const LEAST_TRAVEL_M: f64 = 1e-4;
/// In a valid hold, the travel exceeds the deviation by this factor.
const TRAVEL_OVER_DEVIATION: f64 = 20.0;
/// Allowed overshoot of a push beyond start and end, as a fraction of its travel.
const REBOUND: f64 = 0.25;
/// A piston is under way if it is farther from start and end than this fraction of the travel.
const BEGUN: f64 = 0.05;
/// A piston that moves by at most this fraction of the travel ...
const REST_TRAVEL: f64 = 0.02;
/// ... over this many rows ...
const REST_ROWS: usize = 10;
/// ... and this fraction of the time under way is at rest there.
const REST_SHARE: f64 = 0.5;

/// A recorded push-and-hold test: SI units, absolute pressure, one entry per row.
#[derive(Clone, Copy, Debug)]
pub struct Recording<'a> {
    /// Time, s, increasing.
    pub time_s: &'a [f64],
    /// Absolute pressure of the gas, Pa.
    pub pressure_pa: &'a [f64],
    /// Distance of the piston face from the chamber's end, m.
    pub position_m: &'a [f64],
}

/// Data of a recording used by the evaluations.
#[derive(Clone, Debug, PartialEq)]
pub struct Relaxation {
    /// Mean pressure before the first movement, Pa.
    pub initial_pressure_pa: f64,
    /// Its standard error, Pa: zero when a single row precedes the movement.
    pub initial_pressure_error_pa: f64,
    /// Mean position before the first movement, m.
    pub initial_position_m: f64,
    /// Mean position of the hold, m.
    pub final_position_m: f64,
    /// First row of the hold.
    pub stop_row: usize,
    /// Times from the pressure's extreme after the stop, s.
    pub time_s: Vec<f64>,
    /// Pressures of those rows, Pa.
    pub pressure_pa: Vec<f64>,
}

impl Recording<'_> {
    /// The hold, from the pressure's extreme (a maximum, for an expansion a minimum).
    ///
    /// # Errors
    /// For invalid numbers, or a motion that is not push and hold.
    pub fn relaxation(&self) -> Result<Relaxation, Error> {
        self.check()?;
        let n = self.time_s.len();
        let quarter = &self.position_m[n - n.div_ceil(4)..];
        let final_position_m = mean(quarter);
        let deviation_m = largest_deviation(quarter, final_position_m);
        let (low, high) = self.position_m.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        let travel_m = high - low;
        if travel_m <= LEAST_TRAVEL_M {
            return Err(Error::NoMovement);
        }
        if travel_m < TRAVEL_OVER_DEVIATION * deviation_m {
            return Err(Error::NoHold { deviation_m, travel_m });
        }
        let tolerance_m = 1.5 * deviation_m + 1e-6 * travel_m;
        let held = self.position_m.iter().rev().take_while(|x| (**x - final_position_m).abs() <= tolerance_m).count();
        let stop_row = n - held;
        let rest = self.position_m.iter().take_while(|x| (**x - self.position_m[0]).abs() <= 2.0 * tolerance_m).count();
        let moving = rest.saturating_sub(1).min(stop_row)..(stop_row + 1).min(n);
        if is_interrupted(&self.time_s[moving.clone()], &self.position_m[moving], tolerance_m) {
            return Err(Error::SeveralMoves);
        }
        // In a record that starts at rest, the last row of rest is where the push begins.
        let (initial_pressure_pa, initial_pressure_error_pa) = mean_and_error(&self.pressure_pa[..rest]);
        let initial_position_m = mean(&self.position_m[..rest]);
        let from = self.extreme_row(stop_row, initial_pressure_pa);
        Ok(Relaxation {
            initial_pressure_pa,
            initial_pressure_error_pa,
            initial_position_m,
            final_position_m: mean(&self.position_m[stop_row..]),
            stop_row,
            time_s: self.time_s[from..].to_vec(),
            pressure_pa: self.pressure_pa[from..].to_vec(),
        })
    }

    /// Row of the hold whose pressure is farthest from the initial one.
    fn extreme_row(&self, stop_row: usize, initial_pressure_pa: f64) -> usize {
        let distance = |row: &usize| (self.pressure_pa[*row] - initial_pressure_pa).abs();
        (stop_row..self.time_s.len()).rev().max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(stop_row)
    }

    fn check(&self) -> Result<(), Error> {
        let (time, pressure, position) = (self.time_s.len(), self.pressure_pa.len(), self.position_m.len());
        if time != pressure || time != position {
            return Err(Error::LengthsDiffer { time, pressure, position });
        }
        if time < super::decay::ROWS_NEEDED {
            return Err(Error::TooFewRows { found: time, needed: super::decay::ROWS_NEEDED });
        }
        for (quantity, column) in [("time", self.time_s), ("pressure", self.pressure_pa), ("position", self.position_m)]
        {
            if let Some(i) = column.iter().position(|v| !v.is_finite()) {
                return Err(Error::NotFinite { row: i + 1, quantity });
            }
        }
        if let Some(i) = self.time_s.windows(2).position(|w| w[1] <= w[0]) {
            return Err(Error::TimeNotIncreasing { row: i + 2, time_s: self.time_s[i + 1] });
        }
        if let Some(i) = self.pressure_pa.iter().position(|p| *p <= 0.0) {
            return Err(Error::PressureNotPositive { row: i + 1, pressure_pa: self.pressure_pa[i] });
        }
        Ok(())
    }
}

/// Whether there is more than one move between rest and hold: the piston turns back, or rests on its way.
fn is_interrupted(time_s: &[f64], position_m: &[f64], tolerance_m: f64) -> bool {
    let (Some(first), Some(last)) = (position_m.first(), position_m.last()) else { return false };
    let travel = last - first;
    let (low, high) = position_m.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    // An overshoot or a rebound is part of a push.
    if high - low > (1.0 + REBOUND) * travel.abs() + 2.0 * tolerance_m {
        return true;
    }
    let fraction = |x: &f64| (x - first) / travel;
    let on_its_way = |x: &f64| (BEGUN..1.0 - BEGUN).contains(&fraction(x));
    let Some(from) = position_m.iter().position(on_its_way) else { return false };
    let to = position_m.iter().rposition(on_its_way).unwrap_or(from);
    let width = (REST_TRAVEL * travel.abs()).max(2.0 * tolerance_m);
    let mut begin = from;
    let longest = (from..=to).fold((0.0_f64, 0), |longest, row| {
        while (position_m[row] - position_m[begin]).abs() > width {
            begin += 1;
        }
        let rest = (time_s[row] - time_s[begin], row + 1 - begin);
        if rest.0 > longest.0 { rest } else { longest }
    });
    longest.1 >= REST_ROWS && longest.0 > REST_SHARE * (time_s[to] - time_s[from])
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let m = mean(values);
    if values.len() < 2 {
        return (m, 0.0);
    }
    let residuals: Vec<f64> = values.iter().map(|v| v - m).collect();
    let (scale, _) = super::statistics::residual_scale(&residuals, 1);
    (m, (scale / values.len() as f64).sqrt())
}

fn largest_deviation(values: &[f64], from: f64) -> f64 {
    values.iter().map(|v| (v - from).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rest of 0.5 s, push of 0.1 s, hold; the position is quantised to `grain`.
    fn push(grain: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = (0..300).map(|i| i as f64 * 0.01).collect();
        let x: Vec<f64> = t
            .iter()
            .map(|t| {
                let x: f64 = 0.1 - 0.05 * ((t - 0.5) / 0.1).clamp(0.0, 1.0);
                if grain > 0.0 { (x / grain).round() * grain } else { x }
            })
            .collect();
        let p = t.iter().zip(&x).map(|(t, x)| 1e4 / x + if *t > 0.6 { 4e4 * (0.6 - t).exp() } else { 0.0 }).collect();
        (t, p, x)
    }

    fn relaxation(columns: &(Vec<f64>, Vec<f64>, Vec<f64>)) -> Result<Relaxation, Error> {
        Recording { time_s: &columns.0, pressure_pa: &columns.1, position_m: &columns.2 }.relaxation()
    }

    #[test]
    fn rest_push_and_hold_are_distinguished() {
        for grain in [0.0, 1e-4] {
            let r = relaxation(&push(grain)).unwrap();
            assert!((59..=61).contains(&r.stop_row), "{}", r.stop_row);
            assert!((r.initial_pressure_pa - 1e5).abs() < 1.0);
            assert!((r.initial_position_m - 0.1).abs() < 1e-9 && (r.final_position_m - 0.05).abs() < 1e-9);
            assert!((r.time_s[0] - 0.61).abs() < 1e-9, "{}", r.time_s[0]);
        }
    }

    #[test]
    fn a_piston_that_still_moves_is_no_hold() {
        let mut columns = push(0.0);
        columns.2 = columns.0.iter().map(|t| 0.1 - 0.01 * t).collect();
        assert!(matches!(relaxation(&columns), Err(Error::NoHold { .. })));
        columns.2 = vec![0.1; 300];
        assert_eq!(relaxation(&columns), Err(Error::NoMovement));
    }

    #[test]
    fn two_moves_are_no_push_and_hold() {
        let strokes: [fn(f64) -> f64; 3] = [
            // There and back; in two stages; there and half of the way back.
            |t| ramp(t, 0.5) - ramp(t, 1.2),
            |t| 0.5 * (ramp(t, 0.5) + ramp(t, 1.2)),
            |t| ramp(t, 0.5) - 0.5 * ramp(t, 1.2),
        ];
        for (nth, stroke) in strokes.into_iter().enumerate() {
            let mut columns = push(0.0);
            columns.2 = columns.0.iter().map(|t| 0.1 - 0.05 * stroke(*t)).collect();
            assert_eq!(relaxation(&columns), Err(Error::SeveralMoves), "{nth}");
        }
    }

    #[test]
    fn a_push_may_overshoot_be_slow_or_come_to_rest_slowly() {
        let strokes: [fn(f64) -> f64; 3] = [
            |t| ramp(t, 0.5) + 0.1 * (ramp(t, 0.6) - ramp(t, 0.7)),
            |t| ((t - 0.2) / 1.5).clamp(0.0, 1.0),
            |t| 1.0 - (-(t - 0.5).max(0.0) / 0.1).exp(),
        ];
        for (nth, stroke) in strokes.into_iter().enumerate() {
            let mut columns = push(0.0);
            columns.2 = columns.0.iter().map(|t| 0.1 - 0.05 * stroke(*t)).collect();
            assert!(relaxation(&columns).is_ok(), "{nth}");
        }
    }

    /// Progress of a move of 0.1 s that starts at `from`, 0 to 1.
    fn ramp(t: f64, from: f64) -> f64 {
        ((t - from) / 0.1).clamp(0.0, 1.0)
    }

    #[test]
    fn bad_numbers_are_refused_with_their_row() {
        let mut columns = push(0.0);
        columns.1[7] = f64::NAN;
        assert_eq!(relaxation(&columns), Err(Error::NotFinite { row: 8, quantity: "pressure" }));
        columns.1[7] = -2e4;
        assert_eq!(relaxation(&columns), Err(Error::PressureNotPositive { row: 8, pressure_pa: -2e4 }));
        columns.1[7] = 1e5;
        columns.0[9] = columns.0[8];
        assert!(matches!(relaxation(&columns), Err(Error::TimeNotIncreasing { row: 10, .. })));
        columns.0.pop();
        assert!(matches!(relaxation(&columns), Err(Error::LengthsDiffer { .. })));
    }
}
