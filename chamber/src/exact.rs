//! Closed forms of the closed chamber (design.md, section 1), for tests and, where they apply, as the solver.
//!
//! With the port closed m is constant, T = P V/(m R), and u = 1/T makes the paper's equations linear (Bernoulli): du/dt + (b Tamb
//! − (γ−1) V̇/V) u = b with b = c (4V/φ + π φ²/2)/√V, c = λ0 √(m R/(P0 T0))/(m cv).

use crate::geometry::AreaLaw;
use crate::model::Chamber;
use crate::real::Real;
use core::hint::black_box;

/// A closed chamber of the paper's model with a given mass of gas.
#[derive(Clone, Copy, Debug)]
pub struct Closed<R = f64> {
    /// m R, J/K.
    pub mass_gas_constant: R,
    /// c a1 and c a0, so that b = (c a1 V + c a0)/√V: Aq = a1 V + a0.
    pub exchange: [R; 2],
    /// γ − 1.
    pub expansion: R,
    /// Wall temperature, K.
    pub ambient_temperature: R,
}

impl<R: Real> Closed<R> {
    /// The chamber filled to a pressure, Pa, at a temperature, K, in a volume, m³. Effects are ignored.
    pub fn filled(chamber: &Chamber<R>, pressure: R, temperature: R, volume: R, ambient_temperature: R) -> Self {
        let mass_gas_constant = pressure * volume / temperature;
        let (h, g) = (&chamber.heat_transfer, &chamber.geometry);
        let expansion = chamber.gas.heat_capacity_ratio - 1.0;
        let c = h.coefficient * expansion / (mass_gas_constant * h.reference_pressure * h.reference_temperature).sqrt();
        let [lateral, ends] = g.area_constants();
        let unwetted = match g.area_law {
            AreaLaw::Total => R::ZERO,
            AreaLaw::Swept => g.dead_volume,
        };
        let faces = ends - unwetted * lateral;
        Self { mass_gas_constant, exchange: [c * lateral, c * faces], expansion, ambient_temperature }
    }

    /// Pressure at a temperature, K, and volume, m³; Pa.
    #[inline(always)]
    pub fn pressure(&self, temperature: R, volume: R) -> R {
        self.mass_gas_constant * temperature / volume
    }

    /// k = 1/τ_f, 1/s, with the piston held at a volume, m³: the exact decay rate of 1 − Pf/P.
    #[inline(always)]
    pub fn rate(&self, volume: R) -> R {
        self.ambient_temperature * ((self.exchange[0] * volume + self.exchange[1]) / volume.sqrt())
    }

    /// Temperature, K, a time `t`, s, after `temperature`, with the piston held.
    #[inline(always)]
    pub fn held(&self, temperature: R, volume: R, t: R) -> R {
        let excess = R::ONE - self.ambient_temperature / temperature;
        self.ambient_temperature / (R::ONE - excess * (-self.rate(volume) * t).exp())
    }

    /// E(x) relative to the start of one part of a ramp: see [`ramp_part`](Self::ramp_part).
    #[inline(always)]
    fn growth(&self, root: R, step: R, dwell: R, x: f64) -> R {
        let stretched = step * x;
        let squares = root * root + root * stretched + stretched * stretched * (1.0 / 3.0);
        let exchanged = dwell * x * (self.exchange[0] * squares + self.exchange[1]);
        let expanded = self.expansion * (R::ONE + stretched / root).ln() * 2.0;
        (self.ambient_temperature * exchanged - expanded).exp()
    }

    /// 1/T at the end of one of the parts of a ramp, equal in √V, from 1/T and √V at its start and its increase of √V.
    ///
    /// With q = √V as the variable, x from 0 to 1 and `dwell` = 2 (duration of the ramp)/(q0 + q1)/(number of parts),
    /// b dt = dwell (c a1 q² + c a0) dx. 16-point Gauss–Legendre quadrature.
    #[inline(always)]
    pub fn ramp_part(&self, inverse: R, root: R, step: R, dwell: R) -> R {
        let mut integral = R::ZERO;
        // `black_box` keeps the compiler from unrolling the rule completely, lane by lane.
        let rule: &[(f64, f64)] = black_box(&GAUSS_16);
        for (node, weight) in rule {
            for side in black_box(&[-0.5, 0.5]) {
                let x = 0.5 + side * node;
                let q = root + step * x;
                let value = (self.exchange[0] * (q * q) + self.exchange[1])
                    * self.growth(root, step, dwell, x)
                    * (0.5 * weight);
                *black_box(&mut integral) += value;
            }
        }
        (inverse + dwell * integral) / self.growth(root, step, dwell, 1.0)
    }

    /// Duration of a ramp in units of its shortest time scale: from 1/τ_f at both ends, 1/s, and the volume ratio.
    #[inline(always)]
    pub fn time_scales(rates: [R; 2], ratio: R, duration: R) -> R {
        rates[0].max(rates[1]) * duration + ratio.ln().abs()
    }
}

impl Closed<f64> {
    /// Number of parts for a ramp of this many time scales: none longer than 1.4 of them.
    pub fn parts(time_scales: f64) -> f64 {
        (0.7 * time_scales).ceil().clamp(1.0, 1e6)
    }

    /// Temperature, K, at the end of a linear ramp of the volume over `duration`, s.
    pub fn ramp(&self, temperature: f64, from_volume: f64, to_volume: f64, duration: f64) -> f64 {
        let rates = [from_volume, to_volume].map(|volume| self.rate(volume));
        let parts = Self::parts(Self::time_scales(rates, to_volume / from_volume, duration));
        self.ramp_in(parts, temperature, from_volume, to_volume, duration)
    }

    fn ramp_in(&self, parts: f64, temperature: f64, from_volume: f64, to_volume: f64, duration: f64) -> f64 {
        let [begin, end] = [from_volume, to_volume].map(f64::sqrt);
        let (step, dwell) = ((end - begin) / parts, 2.0 * duration / (begin + end) / parts);
        let mut inverse = 1.0 / temperature;
        for part in 0..parts as usize {
            inverse = self.ramp_part(inverse, begin + step * part as f64, step, dwell);
        }
        1.0 / inverse
    }
}

/// Temperature, K, of a closed chamber with its piston held where λ ∝ |T − Tw|^¼ and otherwise constant; `time_constant`, s, is
/// that at the start.
pub fn held_natural_convection(temperature: f64, ambient_temperature: f64, time_constant: f64, t: f64) -> f64 {
    ambient_temperature + (temperature - ambient_temperature) * (1.0 + t / (4.0 * time_constant)).powi(-4)
}

/// Positive nodes and weights of 16-point Gauss–Legendre quadrature on [−1, 1].
pub const GAUSS_16: [(f64, f64); 8] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::papers_chamber::section_31;
    use crate::simulate::{Start, simulate};
    use crate::{EffectSet, signals::Signals};
    use proptest::prelude::*;

    fn simulated(chamber: &Chamber, motion: &[(f64, f64)], pressure: f64, times: &[f64]) -> Vec<f64> {
        let start = Start { pressure, temperature: 293.0 };
        let signals = Signals::closed(motion, 293.0, 1e5);
        let samples = simulate(chamber, EffectSet::NONE, start, &signals, times, 1e-10).unwrap();
        samples.iter().map(|s| s.gas_pressure).collect()
    }

    #[test]
    fn gauss_weights_sum_to_two_and_integrate_degree_31() {
        let sum: f64 = GAUSS_16.iter().map(|(_, w)| 2.0 * w).sum();
        let degree30: f64 = GAUSS_16.iter().map(|(x, w)| 2.0 * w * x.powi(30)).sum();
        assert!((sum - 2.0).abs() < 1e-15 * 8.0);
        assert!((degree30 - 2.0 / 31.0).abs() < 1e-15);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_integrator_agrees_with_the_exact_ramp_and_hold(
            push_time in 0.02..2.0f64, from in 0.05..0.2f64, to in 0.02..0.2f64, pressure in 0.8e5..8e5f64, swept in any::<bool>(),
        ) {
            let chamber = section_31(if swept { AreaLaw::Swept } else { AreaLaw::Total });
            let (v0, v1) = (chamber.geometry.volume(from), chamber.geometry.volume(to));
            let closed = Closed::filled(&chamber, pressure, 293.0, v0, 293.0);
            let peak = closed.ramp(293.0, v0, v1, push_time);
            let times = [push_time, push_time + 0.3, push_time + 1.0];
            let motion = [(0.0, from), (push_time, to), (push_time + 1.0, to)];
            let ours = simulated(&chamber, &motion, pressure, &times);
            for (t, p) in times.iter().zip(ours) {
                let exact = closed.pressure(closed.held(peak, v1, t - push_time), v1);
                prop_assert!((p / exact - 1.0).abs() < 1e-9, "at {t}: {p} {exact}");
            }
        }
    }

    #[test]
    fn a_ramp_does_not_depend_on_the_number_of_its_parts() {
        for (from, to, push) in [(0.2, 0.02, 2.0), (0.02, 0.2, 0.02), (0.1, 0.1, 1.0), (0.4, 0.01, 10.0)] {
            let chamber = section_31(AreaLaw::Total);
            let (v0, v1) = (chamber.geometry.volume(from), chamber.geometry.volume(to));
            let closed = Closed::filled(&chamber, 3e5, 293.0, v0, 300.0);
            let parts = Closed::parts(Closed::time_scales([v0, v1].map(|v| closed.rate(v)), v1 / v0, push));
            let [ours, finer] = [1.0, 5.0].map(|n| closed.ramp_in(parts * n, 293.0, v0, v1, push));
            assert!((ours / finer - 1.0).abs() < 1e-14 * parts, "{ours} {finer}");
        }
    }

    #[test]
    fn one_minus_pf_over_p_decays_with_the_rate_k() {
        let chamber = section_31(AreaLaw::Total);
        let volume = chamber.geometry.volume(0.05);
        let closed = Closed::filled(&chamber, 2e5, 293.0, volume, 293.0);
        let decay = |t: f64| 1.0 - 293.0 / closed.held(370.0, volume, t);
        assert!((decay(0.7) / decay(0.0) - (-closed.rate(volume) * 0.7).exp()).abs() < 1e-14);
        let at_end = chamber.heat_transfer.coefficient_at(2e5, 293.0) * chamber.geometry.heat_transfer_area(volume);
        assert!(
            (closed.rate(volume) - at_end / (closed.mass_gas_constant / chamber.gas.gas_constant * chamber.gas.cv()))
                .abs()
                < 1e-12 * closed.rate(volume)
        );
    }
}
