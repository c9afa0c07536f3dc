//! Deviation of a position sensor's characteristic from a straight line, m.
//!
//! off(x) = Σ aₖ sin(k π u), where u goes from 0 to 1 over the positions of all records. It is zero at both ends, since the
//! linearity of a sensor is stated between its end points: zero and scale of the positions are separate parameters.

use chamber::real::Real;
use std::f64::consts::PI;

/// Number of waves.
pub const WAVES: usize = 4;

/// A sensor characteristic relative to its straight line.
#[derive(Clone, Copy, Debug)]
pub struct Characteristic<R> {
    /// Lowest and highest position of all records, m.
    pub extent_m: [f64; 2],
    /// aₖ, m.
    pub amplitudes_m: [R; WAVES],
}

impl<R: Real> Characteristic<R> {
    /// A straight characteristic.
    pub fn straight(extent_m: [f64; 2]) -> Self {
        Self { extent_m, amplitudes_m: [R::ZERO; WAVES] }
    }

    /// True minus recorded position, m, and its derivative, m/m.
    pub fn off(&self, position_m: f64) -> [R; 2] {
        let [low, high] = self.extent_m;
        let per_metre = PI / (high - low);
        let (mut off, mut slope) = (R::ZERO, R::ZERO);
        for (k, amplitude) in self.amplitudes_m.iter().enumerate() {
            let along = (k + 1) as f64 * per_metre;
            let (sin, cos) = (along * (position_m - low)).sin_cos();
            off += *amplitude * sin;
            slope += *amplitude * (along * cos);
        }
        [off, slope]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_characteristic_is_right_at_both_ends_and_its_slope_is_that_of_the_curve() {
        let bent = Characteristic { extent_m: [0.02, 0.12], amplitudes_m: [3e-5, -2e-5, 1e-5, 4e-5] };
        for end in bent.extent_m {
            assert!(bent.off(end)[0].abs() < 1e-18);
        }
        for k in 1..10 {
            let x = 0.02 + 0.01 * f64::from(k);
            let [after, before] = [1e-6, -1e-6].map(|step| bent.off(x + step)[0]);
            assert!((bent.off(x)[1] - (after - before) / 2e-6).abs() < 1e-8);
        }
    }
}
