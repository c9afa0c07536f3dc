//! The noise of recorded positions, m, and the rounding error that a mean of readings keeps.

use crate::record::series::lattice;
use crate::record::series::scatter::{scatter, scatter_about_bends};
use records::extremes;
use std::f64::consts::PI;

/// Smaller changes of a position count as none, m.
pub const NOTHING_M: f64 = 1e-12;
/// Most noise that rounding to a sensor's steps counts as, m.
const COARSEST_M: f64 = 1e-4;
/// The same where the readings show no steps, and their smallest change is that of the piston.
const FINEST_M: f64 = 1e-6;

/// Steps of the sensor, m; zero where the positions show none.
pub fn step(position_m: &[f64]) -> f64 {
    lattice::of_bends(position_m, NOTHING_M)
}

/// Standard deviation of the position about the stroke, m, and at least that of rounding to its steps.
pub fn position_noise(position_m: &[f64]) -> f64 {
    let changes = position_m.windows(2).map(|w| (w[1] - w[0]).abs());
    let smallest_m = changes.filter(|d| *d > NOTHING_M).fold(f64::INFINITY, f64::min);
    let (step_m, moves_often) = (step(position_m), moves_often(position_m));
    let most_m = if step_m > 0.0 { COARSEST_M } else { FINEST_M };
    // The smallest change of a piston that hardly ever rests may be many steps.
    let rounded_to_m = if moves_often && step_m > 0.0 { smallest_m.min(step_m) } else { smallest_m };
    let least = if rounded_to_m.is_finite() { (rounded_to_m / 12.0f64.sqrt()).min(most_m) } else { 0.0 };
    let scatter = if moves_often { scatter_about_bends } else { scatter };
    scatter(position_m).max(least)
}

/// Whether the piston moves in so many rows that its stroke's bends are among the small ones of the record. `FAR` is the fraction
/// of the travel from which on a window's bends can exceed the noise; other bends at rest, a filter's noise, do not count.
fn moves_often(position_m: &[f64]) -> bool {
    const ROWS: usize = 13;
    const FAR: f64 = 0.01;
    const SHARE: f64 = 0.25;
    let (low, high) = extremes(position_m);
    let ranges_m = position_m.windows(ROWS).map(extremes).map(|(lowest, highest)| highest - lowest);
    let (all, far) =
        ranges_m.fold((0, 0), |(all, far), range_m| (all + 1, far + usize::from(range_m > FAR * (high - low))));
    far as f64 > SHARE * all as f64
}

/// Standard deviation that rounding to a sensor's steps leaves in the mean of any number of readings of one place, m.
///
/// Noise σ moves the readings from step to step, and of the rounding's variance step²/12 the mean keeps
/// step²/(2π²) Σ exp(−4π²k²σ²/step²)/k², which is nothing from half a step of noise on. σ is such that the rest of both variances
/// is the readings' own scatter. Source: B. Widrow and I. Kollár, Quantization Noise (2008), chapter 4.
pub fn rounding_of_mean(readings_m: &[f64], step_m: f64) -> f64 {
    if step_m == 0.0 {
        return 0.0;
    }
    let n = readings_m.len() as f64;
    let mean = readings_m.iter().sum::<f64>() / n;
    let scatter = readings_m.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n / (step_m * step_m);
    let kept = |noise: f64| -> f64 {
        let harmonic = |k: f64| (-4.0 * (PI * k * noise).powi(2)).exp() / (k * k);
        (1..=20).map(|k| harmonic(f64::from(k))).sum::<f64>() / (2.0 * PI * PI)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let noise = 0.5 * (low + high);
        let shown = noise * noise + 1.0 / 12.0 - kept(noise);
        if shown < scatter { low = noise } else { high = noise }
    }
    step_m * kept(low).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    /// Positions, m, of this stroke at `n` rows `row_s` apart, with this noise, m, and rounded to these steps, m.
    fn recorded(stroke: impl Fn(f64) -> f64, n: u32, row_s: f64, noise_m: f64, step_m: f64) -> Vec<f64> {
        let mut random = Random::new(12);
        let positions = (0..n).map(|i| stroke(f64::from(i) * row_s) + noise_m * random.normal());
        positions.map(|x| (x / step_m).round() * step_m).collect()
    }

    fn sine(frequency_hz: f64) -> impl Fn(f64) -> f64 {
        move |t: f64| 0.1 - 0.01 * (1.0 - (2.0 * PI * frequency_hz * t).cos())
    }

    /// 50 mm in 0.13 s from 1.013 s on and back from 4.017 s on, at constant speed.
    fn push_and_hold(t: f64) -> f64 {
        let range_m = |begin: f64| ((t - begin) / 0.13).clamp(0.0, 1.0);
        0.1 - 0.05 * (range_m(1.013) - range_m(4.017))
    }

    #[test]
    fn the_bends_of_a_fast_sine_are_no_noise_at_any_rate() {
        for noise_m in [1e-6, 3e-6, 2e-5] {
            for (frequency_hz, rate_hz, rows) in [
                (1.5, 50.0, 600),
                (1.5, 100.0, 600),
                (2.0, 50.0, 300),
                (4.0, 100.0, 600),
                (5.0, 50.0, 300),
                (5.0, 100.0, 600),
                (5.0, 500.0, 3000),
                (5.0, 5000.0, 30_000),
            ] {
                let found = position_noise(&recorded(sine(frequency_hz), rows, 1.0 / rate_hz, noise_m, 1e-7));
                let ratio = found / noise_m;
                assert!((0.85..1.3).contains(&ratio), "{frequency_hz} Hz at {rate_hz} Hz, {noise_m} m: {ratio}");
            }
        }
    }

    #[test]
    fn the_corners_of_pushes_and_of_a_triangle_are_no_noise() {
        for noise_m in [1e-6, 3e-6, 2e-5] {
            let held = recorded(push_and_hold, 700, 0.01, noise_m, 1e-7);
            assert_eq!(position_noise(&held), scatter(&held));
            let triangle = |t: f64| 0.1 - 0.03 * ((1.7 * t).fract() - 0.5).abs();
            for positions in [held, recorded(triangle, 700, 0.01, noise_m, 1e-7)] {
                let ratio = position_noise(&positions) / noise_m;
                assert!((0.85..1.15).contains(&ratio), "{noise_m} m: {ratio}");
            }
        }
    }

    #[test]
    fn coarse_steps_are_noise_of_their_size() {
        const STEP_M: f64 = 5e-5;
        let held = recorded(|t| push_and_hold(t) + 0.4 * STEP_M, 700, 0.01, 4e-6, STEP_M);
        assert!((position_noise(&held) / (STEP_M / 12.0f64.sqrt()) - 1.0).abs() < 1e-6);
        // No sine with a period of whole rows: its rounding would be that of few positions.
        for frequency_hz in [0.51, 1.53, 4.97] {
            let ratio =
                position_noise(&recorded(sine(frequency_hz), 600, 0.01, 0.0, STEP_M)) / (STEP_M / 12.0f64.sqrt());
            assert!((0.85..1.4).contains(&ratio), "{frequency_hz} Hz: {ratio}");
        }
    }

    #[test]
    fn noise_that_hides_the_bends_of_a_sine_is_found() {
        for frequency_hz in [0.5, 5.0] {
            let ratio = position_noise(&recorded(sine(frequency_hz), 600, 0.01, 1e-3, 1e-6)) / 1e-3;
            assert!((0.85..1.2).contains(&ratio), "{frequency_hz} Hz: {ratio}");
        }
    }

    #[test]
    fn slow_noise_of_a_held_piston_is_judged_by_its_second_differences() {
        let mut random = Random::new(5);
        let slow = (0..700).scan(0.0, |noise, i| {
            *noise += 0.2 * (1e-5 * random.normal() - *noise);
            Some(push_and_hold(0.01 * f64::from(i)) + *noise)
        });
        let positions: Vec<f64> = slow.collect();
        assert_eq!(position_noise(&positions), scatter(&positions));
    }

    #[test]
    fn the_error_of_the_mean_of_rounded_readings_is_of_the_stated_size() {
        let mut random = Random::new(21);
        for noise in [0.0, 0.05, 0.15, 0.3, 0.6] {
            let (mut square, mut said) = (0.0, 0.0);
            for k in 0..400 {
                let position = 100.0 + f64::from(k) / 400.0;
                let readings: Vec<f64> = (0..500).map(|_| (position + noise * random.normal()).round()).collect();
                let mean = readings.iter().sum::<f64>() / 500.0;
                square += (mean - position).powi(2) - noise * noise / 500.0;
                said += rounding_of_mean(&readings, 1.0).powi(2);
            }
            let (off, said) = ((square.max(0.0) / 400.0).sqrt(), (said / 400.0).sqrt());
            assert!((0.9 * off - 0.015..1.4 * off + 0.03).contains(&said), "{noise}: {off} {said}");
        }
    }

    #[test]
    fn rounding_adds_no_error_to_a_mean_where_readings_have_no_steps() {
        assert_eq!(rounding_of_mean(&[0.1, 0.1], 0.0), 0.0);
    }
}
