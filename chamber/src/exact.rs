//! Closed forms of the closed chamber (design.md, section 1), for tests and, where they apply, as the solver.
//!
//! With the port closed m is constant, T = P V/(m R), and u = 1/T turns the paper's equations into a linear one
//! (Bernoulli): du/dt + (b Tamb − (γ−1) V̇/V) u = b with b = c (4V/φ + π φ²/2)/√V, c = λ0 √(m R/(P0 T0))/(m cv).

use crate::geometry::AreaLaw;
use crate::model::Chamber;
use core::f64::consts::PI;

/// A closed chamber of the paper's model with a given mass of gas.
#[derive(Clone, Copy, Debug)]
pub struct Closed {
    chamber: Chamber,
    /// Mass of the gas, kg.
    pub mass: f64,
    /// Wall temperature, K.
    pub ambient_temperature: f64,
}

impl Closed {
    /// The chamber filled to a pressure, Pa, at a temperature, K, in that volume, m³. Effects are left out.
    pub fn filled(chamber: &Chamber, pressure: f64, temperature: f64, volume: f64, ambient_temperature: f64) -> Self {
        let mass = pressure * volume / (chamber.gas.gas_constant * temperature);
        Self { chamber: *chamber, mass, ambient_temperature }
    }

    /// Pressure at a temperature, K, and volume, m³; Pa.
    pub fn pressure(&self, temperature: f64, volume: f64) -> f64 {
        self.mass * self.chamber.gas.gas_constant * temperature / volume
    }

    /// c of the linear equation, so that b = c Aq/√V.
    fn c(&self) -> f64 {
        let h = &self.chamber.heat_transfer;
        let gas = &self.chamber.gas;
        h.coefficient * (self.mass * gas.gas_constant / (h.reference_pressure * h.reference_temperature)).sqrt()
            / (self.mass * gas.cv())
    }

    /// b = c Aq/√V, 1/(s K).
    fn b(&self, volume: f64) -> f64 {
        self.c() * self.chamber.geometry.heat_transfer_area(volume) / volume.sqrt()
    }

    /// k = 1/τ_f, 1/s, with the piston held at that volume: the exact rate at which 1 − Pf/P decays.
    pub fn rate(&self, volume: f64) -> f64 {
        self.ambient_temperature * self.b(volume)
    }

    /// Temperature, K, a time `t`, s, after `temperature`, with the piston held.
    pub fn held(&self, temperature: f64, volume: f64, t: f64) -> f64 {
        let excess = 1.0 - self.ambient_temperature / temperature;
        self.ambient_temperature / (1.0 - excess * (-self.rate(volume) * t).exp())
    }

    /// Temperature, K, at the end of a linear ramp of the volume over `duration`, s.
    ///
    /// 16-point Gauss–Legendre quadrature on panels no longer than a quarter of the shortest time scale.
    pub fn ramp(&self, temperature: f64, from_volume: f64, to_volume: f64, duration: f64) -> f64 {
        let speed = (to_volume - from_volume) / duration;
        if speed == 0.0 {
            return self.held(temperature, from_volume, duration);
        }
        let fastest =
            self.rate(from_volume).max(self.rate(to_volume)) + (to_volume / from_volume).ln().abs() / duration;
        let panels = (2.0 * fastest * duration).ceil().clamp(1.0, 1e6);
        let length = duration / panels;
        let mut u = 1.0 / temperature;
        let mut volume = from_volume;
        for panel in 1..=panels as usize {
            let end = from_volume + speed * length * panel as f64;
            // 1/E(V) relative to this panel's begin; u1 = (u0 + ∫ b E dt)/E(V1), all exponents small.
            let growth = |v: f64| self.integrating_factor(volume, v, speed);
            let mut integral = 0.0;
            for (node, weight) in GAUSS_16 {
                for sign in [-1.0, 1.0] {
                    let v = volume + 0.5 * (end - volume) * (1.0 + sign * node);
                    integral += weight * self.b(v) * growth(v);
                }
            }
            u = (u + 0.5 * length * integral) / growth(end);
            volume = end;
        }
        1.0 / u
    }

    /// E(V) = (V/V0)^(−(γ−1)) exp(Tamb (B(V) − B(V0))).
    fn integrating_factor(&self, from_volume: f64, volume: f64, speed: f64) -> f64 {
        let g1 = self.chamber.gas.heat_capacity_ratio - 1.0;
        let phi = self.chamber.geometry.bore;
        let faces = match self.chamber.geometry.area_law {
            AreaLaw::Total => PI * phi * phi / 2.0,
            AreaLaw::Swept => PI * phi * phi / 2.0 - 4.0 * self.chamber.geometry.dead_volume / phi,
        };
        let b = |v: f64| self.c() / speed * (2.0 / 3.0 * (4.0 / phi) * v.powf(1.5) + 2.0 * faces * v.sqrt());
        (-g1 * (volume / from_volume).ln() + self.ambient_temperature * (b(volume) - b(from_volume))).exp()
    }
}

/// Temperature, K, of a closed chamber with its piston held where λ is constant: the paper's exponential, with τ in s.
pub fn held_constant_coefficient(temperature: f64, ambient_temperature: f64, time_constant: f64, t: f64) -> f64 {
    ambient_temperature + (temperature - ambient_temperature) * (-t / time_constant).exp()
}

/// The same where λ ∝ |T − Tw|^¼ and else constant; `time_constant`, s, is that of the begin.
pub fn held_natural_convection(temperature: f64, ambient_temperature: f64, time_constant: f64, t: f64) -> f64 {
    ambient_temperature + (temperature - ambient_temperature) * (1.0 + t / (4.0 * time_constant)).powi(-4)
}

/// Positive nodes and weights of 16-point Gauss–Legendre quadrature on [−1, 1].
const GAUSS_16: [(f64, f64); 8] = [
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
    use crate::simulate::{Start, simulate};
    use crate::{EffectSet, Gas, Geometry, HeatTransfer, signals::Signals};
    use proptest::prelude::*;

    fn section31(area_law: AreaLaw) -> Chamber {
        Chamber::new(Gas::AIR, Geometry::new(0.02, 0.0, 1.57e-6, area_law), HeatTransfer::at_paper_reference(26.5))
    }

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
            let chamber = section31(if swept { AreaLaw::Swept } else { AreaLaw::Total });
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
    fn one_minus_pf_over_p_decays_with_the_rate_k() {
        let chamber = section31(AreaLaw::Total);
        let volume = chamber.geometry.volume(0.05);
        let closed = Closed::filled(&chamber, 2e5, 293.0, volume, 293.0);
        let decay = |t: f64| 1.0 - 293.0 / closed.held(370.0, volume, t);
        assert!((decay(0.7) / decay(0.0) - (-closed.rate(volume) * 0.7).exp()).abs() < 1e-14);
        let at_end = chamber.heat_transfer.coefficient_at(2e5, 293.0) * chamber.geometry.heat_transfer_area(volume);
        assert!((closed.rate(volume) - at_end / (closed.mass * chamber.gas.cv())).abs() < 1e-12 * closed.rate(volume));
    }
}
