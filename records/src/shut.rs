//! Detects that a port is shut while the piston rests: a fast change of the pressure stops abruptly.
//!
//! In a closed chamber the pressure relaxes smoothly. If it changes several times as fast shortly before a moment as shortly
//! after it, and by more than in a closed chamber at rest, gas flowed until then: the chamber was being filled or emptied before
//! the test.

use crate::statistics::{interval, median};

/// Minimum number of readings compared on each side of a moment...
const MIN_READINGS: usize = 8;
/// ...or this duration, s, if it contains more.
const BESIDE_S: f64 = 0.05;
/// Before the moment the pressure changes by this multiple of its change after it...
const MIN_CHANGE_RATIO: f64 = 3.0;
/// ...plus this many standard deviations of a reading...
const NOISE_DEVIATIONS: f64 = 10.0;
/// ...and by this fraction of itself, which neither weather nor a slow leak reaches.
const MIN_RELATIVE_CHANGE: f64 = 0.005;

/// Index of the first reading of a rest that certainly follows the shutting of the port; `None` where no shutting is detected.
/// Each reading has its time, s, and pressure, Pa. `noise_pa`: standard deviation of a reading, including rounding, Pa.
pub fn shut_from(time_s: &[f64], pressure_pa: &[f64], noise_pa: f64) -> Option<usize> {
    if time_s.len() < 2 {
        return None;
    }
    let width = MIN_READINGS.max((BESIDE_S / interval(time_s).max(f64::MIN_POSITIVE)) as usize);
    // Medians of three, so that a single spike is no change.
    let level = |row: usize| median([row - 1, row, row + 1].map(|row| pressure_pa[row]));
    let stops_abruptly = |row: &usize| {
        let [before, at, after] = [row - width, *row, row + width].map(level);
        let change = (at - before).abs();
        change > MIN_CHANGE_RATIO * (after - at).abs() + NOISE_DEVIATIONS * noise_pa
            && change > MIN_RELATIVE_CHANGE * at.abs()
    };
    (width + 1..time_s.len().saturating_sub(width + 1)).rev().find(stops_abruptly)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings at 100 Hz, with noise of at most 100 Pa.
    fn rest(length_s: f64, pressure_pa: impl Fn(f64) -> f64) -> [Vec<f64>; 2] {
        let rows = (100.0 * length_s) as usize;
        let noise = |k: usize| 100.0 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        let times: Vec<f64> = (0..rows).map(|k| k as f64 * 0.01).collect();
        let pressures = times.iter().enumerate().map(|(k, t)| pressure_pa(*t) + noise(k)).collect();
        [times, pressures]
    }

    #[test]
    fn readings_count_from_where_the_port_is_shut_however_shortly_before_the_move() {
        for quiet_s in [0.3, 1.0, 5.0] {
            // A relaxation, filling by 1 bar in 0.3 s, and cooling of the filled gas.
            let filled = |t: f64| 1e5 * (t / 0.3).min(1.0) - 2e4 * (1.0 - (-(t - 0.3).max(0.0) / 0.5).exp());
            let pressure = |t: f64| 4e5 + 1e5 * (-t.min(3.0) / 0.5).exp() + if t > 3.0 { filled(t - 3.0) } else { 0.0 };
            let [times, pressures] = rest(3.3 + quiet_s, pressure);
            let shut_s = times[shut_from(&times, &pressures, 60.0).unwrap()];
            assert!((3.29..3.42).contains(&shut_s), "{shut_s}");
        }
    }

    #[test]
    fn a_closed_chamber_that_relaxes_or_leaks_was_not_shut_nor_one_that_still_empties() {
        let smooth: [&dyn Fn(f64) -> f64; 4] =
            [&|_| 3e5, &|t| 3e5 + 3e5 * (-t / 0.1).exp(), &|t| 3e5 - 2e4 * t, &|t| {
                1e5 + 4e5 * (-(t - 1.0).max(0.0) / 0.6).exp()
            }];
        for pressure in smooth {
            let [times, mut pressures] = rest(4.0, pressure);
            pressures[200] += 5e4;
            assert_eq!(shut_from(&times, &pressures, 60.0), None);
        }
    }
}
