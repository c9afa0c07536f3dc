//! The gas during the hold, P = Pf/(1 − ε ζ) with ζ = e^(−kt), and the reading of a lagging sensor, in closed form.
//!
//! The Chebyshev series of P over ζ from 0 to 1 is geometric: with s = √(1 − ε), P = Pf/s Σ' 2 r^m T*_m(ζ),
//! r = (ε/2)/(1 − ε/2 + s). In powers of ζ, P = Σ c_n ζ^n, the sensor's equation y' = (P − y)/τ has the solution
//!
//! y = y0 e^(−t/τ) + Σ c_n (ζ^n − e^(−t/τ))/(1 − n k τ)
//!
//! If one 1 − n k τ is small, its term is computed as c_n (t/τ) e^(−t/τ) φ(x) with x = (1 − n k τ) t/τ and φ(x) = (e^x − 1)/x.

use crate::filter;
use crate::lanes::Lanes;
use crate::lanes::math::in_powers;
use chamber::real::Real;
use core::hint::black_box;

/// Number of powers of ζ: P is exact to nine digits for ε from −3, a gas at a quarter of the wall's temperature, to 0.7.
const POWERS: usize = 20;
/// |x| up to which φ is computed by its series, and the number of its terms.
const SMALL: f64 = 0.5;
const SERIES: usize = 12;

/// Coefficients of the Chebyshev polynomials from 0 to 1: T*_(m+1) = 2 (2ζ − 1) T*_m − T*_(m−1).
const CHEBYSHEV: [[f64; POWERS]; POWERS] = {
    let mut all = [[0.0; POWERS]; POWERS];
    all[0][0] = 1.0;
    (all[1][0], all[1][1]) = (-1.0, 2.0);
    let mut m = 1;
    while m + 1 < POWERS {
        let mut n = 0;
        while n < POWERS {
            let raised = if n > 0 { all[m][n - 1] } else { 0.0 };
            all[m + 1][n] = 4.0 * raised - 2.0 * all[m][n] - all[m - 1][n];
            n += 1;
        }
        m += 1;
    }
    all
};

/// The relaxation of the gas during the hold.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation {
    /// Pf, Pa.
    pub at_rest: Lanes,
    /// ε.
    pub excess: Lanes,
    /// k, 1/s.
    pub rate: Lanes,
}

impl Relaxation {
    /// Pressure at a time after the push, s, and its slope, Pa/s.
    #[inline(always)]
    pub fn shown(&self, time: Lanes) -> [Lanes; 2] {
        let left = self.excess * (-(self.rate * time)).exp();
        let per_rest = (Lanes::ONE - left).recip();
        let pressure = self.at_rest * per_rest;
        [pressure, -(pressure * per_rest * left * self.rate)]
    }

    /// Time after the push at which it reaches a pressure, Pa, s.
    #[inline(always)]
    pub fn reaches(&self, pressure: Lanes) -> Lanes {
        (self.excess / (Lanes::ONE - self.at_rest / pressure)).ln() / self.rate
    }
}

/// The hold: the gas, and the readings if the sensors lag.
#[derive(Clone, Copy, Debug)]
pub struct HoldRecord {
    pub gas: Relaxation,
    pub behind: Option<BehindLag>,
}

impl HoldRecord {
    /// Reading at a time after the push, s, and its slope, Pa and Pa/s.
    #[inline(always)]
    pub fn shown(&self, time: Lanes) -> [Lanes; 2] {
        match &self.behind {
            Some(behind) => behind.shown(time),
            None => self.gas.shown(time),
        }
    }
}

/// The readings of lagging sensors during the hold.
#[derive(Clone, Copy, Debug)]
pub struct BehindLag {
    gas: Relaxation,
    per_lag: Lanes,
    /// c_n/(1 − n k τ), Pa.
    terms: [Lanes; POWERS],
    /// Coefficient of e^(−t/τ), Pa.
    fading: Lanes,
    /// The term with the smallest 1 − n k τ, if that is less than half of kτ: n, 1 − n k τ, and c_n, Pa.
    near: [Lanes; 3],
}

impl BehindLag {
    /// The readings of sensors with a lag, s, that show `begin`, Pa, at the start of the hold.
    #[inline(always)]
    pub fn new(gas: Relaxation, lag: Lanes, begin: Lanes) -> Self {
        let root = (Lanes::ONE - gas.excess).sqrt();
        let half = gas.excess * 0.5;
        let ratio = half / (Lanes::ONE - half + root);
        let mut weights = [gas.at_rest / root; POWERS];
        for m in 1..POWERS {
            weights[m] = weights[m - 1] * ratio * if m == 1 { 2.0 } else { 1.0 };
        }
        // The inner loop is a sum: the compiler would vectorise other loops by gathering numbers from all lanes.
        let mut terms = [Lanes::ZERO; POWERS];
        for n in 0..black_box(POWERS) {
            for m in n..POWERS {
                terms[n] += weights[m] * CHEBYSHEV[m][n];
            }
        }
        let slowness = gas.rate * lag;
        let mut near = [Lanes::ZERO, Lanes::ONE, Lanes::ZERO];
        let mut fading = begin - terms[0];
        for n in 1..POWERS {
            let distance = Lanes::ONE - slowness * n as f64;
            let is_near = slowness * 0.5 - distance.abs();
            for (to, from) in near.iter_mut().zip([Lanes::from(n as f64), distance, terms[n]]) {
                *to = is_near.where_positive(from, *to);
            }
            terms[n] = is_near.where_positive(Lanes::ZERO, terms[n] / distance);
            fading -= terms[n];
        }
        Self { gas, per_lag: lag.recip(), terms, fading, near }
    }

    /// Reading at a time after the push, s, and its slope, Pa/s.
    #[inline(always)]
    pub fn shown(&self, time: Lanes) -> [Lanes; 2] {
        let Self { gas, per_lag, terms, fading, near: [power, distance, coefficient] } = self;
        let (since, left) = (time * *per_lag, (-(gas.rate * time)).exp());
        let faded = filter::decay_factor(since);
        let mut reading = in_powers(terms, left) + *fading * faded;
        if coefficient.abs().any_positive() {
            let x = *distance * since;
            let mut series = Lanes::ONE;
            for k in (2..=SERIES).rev() {
                series = Lanes::ONE + x * series * (1.0 / k as f64);
            }
            let far = ((-(gas.rate * time * *power)).exp() - faded) / *distance;
            let term = (x.abs() - SMALL).where_positive(far, since * faded * series);
            reading += coefficient.abs().where_positive(*coefficient * term, Lanes::ZERO);
        }
        let pressure = gas.at_rest / (Lanes::ONE - gas.excess * left);
        [reading, (pressure - reading) * *per_lag]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::gauss::{NODES, node};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_lagging_sensor_shows_the_solution_of_its_equation_near_to_resonance_too(
            excess in -2.0..0.65f64, log_slowness in -3.0..1.5f64, whole in 0u32..12, begin in 0.5..2.0f64, time in 0.01..6.0f64,
        ) {
            // One in four exactly, or nearly, at a resonance n k τ = 1.
            let slowness = match whole {
                0..3 => 1.0 / f64::from(whole + 1),
                3..5 => 1.0 / f64::from(whole) * (1.0 + 1e-9),
                _ => 10f64.powf(log_slowness),
            };
            let gas = Relaxation { at_rest: Lanes::ONE, excess: excess.into(), rate: Lanes::ONE };
            let behind = BehindLag::new(gas, slowness.into(), begin.into());
            // In parts of at most four lags and a tenth of a relaxation, by quadrature.
            let parts = (time / (4.0 * slowness).min(0.1)).ceil();
            let length = time / parts;
            let mut expected = begin;
            for part in 0..parts as usize {
                let end = length * (part + 1) as f64;
                let fed: f64 = (0..NODES)
                    .map(node)
                    .map(|(x, w)| {
                        let t = end - length * (1.0 - x);
                        w * length / slowness * (-(end - t) / slowness).exp() / (1.0 - excess * (-t).exp())
                    })
                    .sum();
                expected = expected * (-length / slowness).exp() + fed;
            }
            let [found, slope] = behind.shown(time.into()).map(|lanes| lanes[0]);
            prop_assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            let rise = (1.0 / (1.0 - excess * (-time).exp()) - expected) / slowness;
            prop_assert!((slope - rise).abs() < 2e-9 / slowness, "{slope} {rise}");
        }
    }
}
