//! The sealed chamber's equation with the coefficients of one scenario, for the peers.

use crate::scenario::{AMBIENT_TEMPERATURE_K, Case};
use std::f64::consts::PI;

/// Air and the paper's reference state: the numbers of `../model.toml`.
const HEAT_CAPACITY_RATIO: f64 = 1.4;
const REFERENCE_PRESSURE_PA: f64 = 5.65e5;
const REFERENCE_TEMPERATURE_K: f64 = 293.0;

/// dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V̇/V) with the coefficients of one scenario; P = m R T/V.
#[derive(Clone, Copy, Default)]
pub struct Sealed {
    pub volume: f64,
    pub volume_rate: f64,
    /// c a1 and c a0.
    pub exchange: [f64; 2],
    pub expansion_rate: f64,
    pub held_volume: f64,
    /// c (a1 V + a0)/√V in the hold.
    pub held_exchange: f64,
    pub mass_gas_constant: f64,
}

impl Sealed {
    pub fn new(case: &Case) -> Self {
        let area = PI / 4.0 * case.bore_m * case.bore_m;
        let volume = case.dead_volume_m3 + area * case.initial_stroke_m;
        let held_volume = case.dead_volume_m3 + area * case.final_stroke_m;
        let mass_gas_constant = case.initial_pressure_pa * volume / AMBIENT_TEMPERATURE_K;
        let c = case.coefficient * (HEAT_CAPACITY_RATIO - 1.0)
            / (mass_gas_constant * REFERENCE_PRESSURE_PA * REFERENCE_TEMPERATURE_K).sqrt();
        let exchange = [c * 4.0 / case.bore_m, c * PI / 2.0 * case.bore_m * case.bore_m];
        let volume_rate = (held_volume - volume) / case.push_time_s;
        Self {
            volume,
            volume_rate,
            exchange,
            expansion_rate: (HEAT_CAPACITY_RATIO - 1.0) * volume_rate,
            held_volume,
            held_exchange: (exchange[0] * held_volume + exchange[1]) / held_volume.sqrt(),
            mass_gas_constant,
        }
    }

    /// dT/dt, K/s, a time `t`, s, into the push.
    #[inline(always)]
    pub fn pushed(&self, t: f64, temperature: f64) -> f64 {
        let volume = self.volume + self.volume_rate * t;
        let per_volume = 1.0 / volume;
        let exchange = (self.exchange[0] * volume + self.exchange[1]) * per_volume.sqrt();
        temperature * (exchange * (AMBIENT_TEMPERATURE_K - temperature) - self.expansion_rate * per_volume)
    }

    /// dT/dt, K/s, in the hold.
    #[inline(always)]
    pub fn held(&self, temperature: f64) -> f64 {
        temperature * self.held_exchange * (AMBIENT_TEMPERATURE_K - temperature)
    }

    /// Pressure in the hold, Pa.
    pub fn pressure(&self, temperature: f64) -> f64 {
        self.mass_gas_constant * temperature / self.held_volume
    }
}
