//! Steps 2 to 7 of the paper's thermal time constant method, equations (21) to (31), from the result of step 1.
//!
//! ```text
//! 1  P = Pf + ΔP e^(−t/τ) from the peak on                          Pa, Pa, s
//! 2  m = (Vcyl_i − Vcyl_f)/(R Tamb) · Pi Pf/(Pf − Pi),  Vd = m R Tamb/Pi − Vcyl_i     kg, m³
//! 3  k_av = m cv/τ                                                  W/K
//! 4  Aq = 4 Vf/φ + π φ²/2                                           m²
//! 5  λ_av = k_av/Aq                                                 W/(m² K)
//! 6  t_ss = τ ln 100,  Pav = mean of the fit over t_ss,  Tav = Vf Pav/(m R)           s, Pa, K
//! 7  λ0 = λ_av √(P0 T0/(Pav Tav)),  k0 = λ0 Aq                      W/(m² K), W/K
//! ```
//!
//! For `f64`, and for dual numbers that propagate intervals.

use crate::real::Real;
use crate::{AreaLaw, Gas, Geometry, paper};

/// Known data of cylinder, gas and surroundings. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Gas constant and heat capacities of the gas.
    pub gas: Gas,
    /// The chamber. Its dead volume is ignored, as step 2 determines it; the published steps use (27), [`AreaLaw::Total`].
    pub geometry: Geometry,
    /// Temperature of wall and surroundings, K.
    pub ambient_temperature_k: f64,
    /// Reference pressure P0, Pa.
    pub reference_pressure_pa: f64,
    /// Reference temperature T0, K.
    pub reference_temperature_k: f64,
}

impl Setup {
    /// Air in a cap-side chamber of a bore, m, with the paper's reference state and area law (27).
    pub fn air(bore_m: f64, ambient_temperature_k: f64) -> Self {
        Self {
            gas: Gas::AIR,
            geometry: Geometry::new(bore_m, 0.0, 0.0, AreaLaw::Total),
            ambient_temperature_k,
            reference_pressure_pa: paper::REFERENCE_PRESSURE_PA,
            reference_temperature_k: paper::REFERENCE_TEMPERATURE_K,
        }
    }

    /// Aq, m², for a gas volume and a dead volume, m³.
    #[inline(always)]
    pub fn area<R: Real>(&self, volume_m3: R, dead_volume_m3: R) -> R {
        Geometry { dead_volume: dead_volume_m3, ..self.geometry.lift() }.heat_transfer_area(volume_m3)
    }

    /// λ0/λ at pressure, Pa, and temperature, K: equation (5) inverted.
    #[inline(always)]
    pub fn reference_factor<R: Real>(&self, pressure_pa: R, temperature_k: R) -> R {
        (R::from(self.reference_pressure_pa * self.reference_temperature_k) / (pressure_pa * temperature_k)).sqrt()
    }
}

/// State before the push, and position after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push<R = f64> {
    /// Pressure before it, Pa, at ambient temperature.
    pub initial_pressure_pa: R,
    /// Position before it, m.
    pub initial_position_m: f64,
    /// Position of the hold, m.
    pub final_position_m: f64,
}

/// Step 1: P = Pf + ΔP e^(−t/τ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regression<R = f64> {
    /// Final pressure Pf, Pa.
    pub final_pressure_pa: R,
    /// Pressure rise ΔP above the final pressure, Pa.
    pub pressure_rise_pa: R,
    /// Time constant τ, s.
    pub time_constant_s: R,
}

/// Steps 2 to 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps<R = f64> {
    /// Mass m of the gas, kg.
    pub mass_kg: R,
    /// Dead volume Vd, m³.
    pub dead_volume_m3: R,
    /// Vf, dead volume included, m³.
    pub final_volume_m3: R,
    /// Mean thermal conductance k_av, W/K.
    pub conductance_av_w_per_k: R,
    /// Heat transfer area Aq, m².
    pub area_m2: R,
    /// λ_av, W/(m² K).
    pub coefficient_av_w_per_m2_k: R,
    /// Settling time t_ss to 1 %, s.
    pub settling_time_s: R,
    /// Mean pressure Pav over the settling time, Pa.
    pub pressure_av_pa: R,
    /// Mean temperature Tav over the settling time, K.
    pub temperature_av_k: R,
    /// Tf = Vf Pf/(m R), K.
    pub final_temperature_k: R,
    /// λ0, W/(m² K).
    pub coefficient_0_w_per_m2_k: R,
    /// Thermal conductance k0 at the reference state, W/K.
    pub conductance_0_w_per_k: R,
}

/// Fraction of the pressure rise left at the settling time.
const SETTLED_SHARE: f64 = 0.01;

/// Step 2: mass, dead volume and final volume from two states at ambient temperature.
#[inline(always)]
pub fn mass_and_volumes<R: Real>(setup: &Setup, ambient_k: R, push: &Push<R>, final_pressure_pa: R) -> [R; 3] {
    let swept = [push.initial_position_m, push.final_position_m].map(|x| setup.geometry.piston_area * x);
    let rt = ambient_k * setup.gas.gas_constant;
    let (pi, pf) = (push.initial_pressure_pa, final_pressure_pa);
    let mass = R::from(swept[0] - swept[1]) / rt * (pi * pf / (pf - pi));
    let dead = mass * rt / pi - swept[0];
    [mass, dead, dead + swept[1]]
}

/// Steps 2 to 7 in any number type; `ambient_k` replaces the setup's ambient temperature.
#[inline(always)]
pub fn steps<R: Real>(setup: &Setup, ambient_k: R, push: &Push<R>, regression: &Regression<R>) -> Steps<R> {
    let Regression { final_pressure_pa: pf, pressure_rise_pa: rise, time_constant_s: tau } = *regression;
    let [mass, dead, volume] = mass_and_volumes(setup, ambient_k, push, pf);
    let conductance = mass * setup.gas.cv() / tau;
    let area = setup.area(volume, dead);
    let coefficient = conductance / area;
    let settling_in_tau = (1.0 / SETTLED_SHARE).ln();
    let pressure = pf + rise * (1.0 - SETTLED_SHARE) / R::from(settling_in_tau);
    let temperature = |p: R| volume * p / (mass * setup.gas.gas_constant);
    let coefficient_0 = coefficient * setup.reference_factor(pressure, temperature(pressure));
    Steps {
        mass_kg: mass,
        dead_volume_m3: dead,
        final_volume_m3: volume,
        conductance_av_w_per_k: conductance,
        area_m2: area,
        coefficient_av_w_per_m2_k: coefficient,
        settling_time_s: tau * settling_in_tau,
        pressure_av_pa: pressure,
        temperature_av_k: temperature(pressure),
        final_temperature_k: temperature(pf),
        coefficient_0_w_per_m2_k: coefficient_0,
        conductance_0_w_per_k: coefficient_0 * area,
    }
}

impl<R: Copy> Steps<R> {
    /// The same quantities, each changed by `f`.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Steps<S> {
        Steps {
            mass_kg: f(self.mass_kg),
            dead_volume_m3: f(self.dead_volume_m3),
            final_volume_m3: f(self.final_volume_m3),
            conductance_av_w_per_k: f(self.conductance_av_w_per_k),
            area_m2: f(self.area_m2),
            coefficient_av_w_per_m2_k: f(self.coefficient_av_w_per_m2_k),
            settling_time_s: f(self.settling_time_s),
            pressure_av_pa: f(self.pressure_av_pa),
            temperature_av_k: f(self.temperature_av_k),
            final_temperature_k: f(self.final_temperature_k),
            coefficient_0_w_per_m2_k: f(self.coefficient_0_w_per_m2_k),
            conductance_0_w_per_k: f(self.conductance_0_w_per_k),
        }
    }
}
