//! The noise of a position's record, m, and the rounding that a mean of its readings keeps.

use super::lattice;
use super::scatter::scatter;
use std::f64::consts::PI;

/// Less is no change of a position, m.
pub const NOTHING_M: f64 = 1e-12;
/// The rounding to a sensor's steps counts as this noise at the most, m.
const COARSEST_M: f64 = 1e-4;
/// The same where the readings show no steps, and their smallest change is that of the piston.
const FINEST_M: f64 = 1e-6;

/// Steps of the sensor, m; zero where the positions show none.
pub fn step(position_m: &[f64]) -> f64 {
    lattice::of_bends(position_m, NOTHING_M)
}

/// Standard deviation of the position as it scatters about the stroke, with that of the rounding to its steps as the least.
pub fn position_noise(position_m: &[f64]) -> f64 {
    let changes = position_m.windows(2).map(|w| (w[1] - w[0]).abs());
    let smallest_m = changes.filter(|d| *d > NOTHING_M).fold(f64::INFINITY, f64::min);
    let most_m = if step(position_m) > 0.0 { COARSEST_M } else { FINEST_M };
    let least = if smallest_m.is_finite() { (smallest_m / 12.0f64.sqrt()).min(most_m) } else { 0.0 };
    scatter(position_m).max(least)
}

/// Standard deviation that rounding to a sensor's steps leaves of the mean of so many readings of one place, m, however many they are.
///
/// Noise σ moves the readings from step to step, and of the rounding's variance step²/12 the mean keeps
/// step²/(2π²) Σ exp(−4π²k²σ²/step²)/k², which is nothing from half a step of noise on. σ is such that the rest of both is the
/// readings' own scatter. Source: B. Widrow and I. Kollár, Quantization Noise (2008), chapter 4.
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

    #[test]
    fn the_mean_of_rounded_readings_is_off_by_no_more_and_not_much_less_than_is_said_of_it() {
        let mut random = Random::new(21);
        for noise in [0.0, 0.05, 0.15, 0.3, 0.6] {
            let (mut square, mut said) = (0.0, 0.0);
            for k in 0..400 {
                let place = 100.0 + f64::from(k) / 400.0;
                let readings: Vec<f64> = (0..500).map(|_| (place + noise * random.normal()).round()).collect();
                let mean = readings.iter().sum::<f64>() / 500.0;
                square += (mean - place).powi(2) - noise * noise / 500.0;
                said += rounding_of_mean(&readings, 1.0).powi(2);
            }
            let (off, said) = ((square.max(0.0) / 400.0).sqrt(), (said / 400.0).sqrt());
            assert!((0.9 * off - 0.015..1.4 * off + 0.03).contains(&said), "{noise}: {off} {said}");
        }
    }

    #[test]
    fn rounding_leaves_nothing_of_a_mean_where_readings_have_no_steps() {
        assert_eq!(rounding_of_mean(&[0.1, 0.1], 0.0), 0.0);
    }
}
