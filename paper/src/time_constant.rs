//! The thermal time constant method: the seven published steps, equations (20) to (31) of the paper.
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
//! The method is biased: what decays exponentially is 1 − Pf/P, not P − Pf (see [`section31`](super::section31)). Its
//! intervals say how far noise moves it, not how far that bias does.

use super::Error;
use super::decay::{self, Exponential, Fit};
use super::recording::{Recording, Relaxation};
use super::statistics::{Estimate, propagated};
use chamber::dual::Dual;
use chamber::real::Real;
use chamber::{AreaLaw, Gas, Geometry, paper};
use nalgebra::{Matrix3, SMatrix};
use serde::Serialize;

/// What is known of cylinder, gas and surroundings. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Gas constant and heat capacities of the gas.
    pub gas: Gas,
    /// Bore φ, m.
    pub bore_m: f64,
    /// Piston area that the gas acts on, m².
    pub piston_area_m2: f64,
    /// Which volume's lateral area counts in Aq; the published steps use (27), [`AreaLaw::Total`].
    pub area_law: AreaLaw,
    /// Temperature of wall and surroundings, K.
    pub ambient_temperature_k: f64,
    /// Reference pressure P0, Pa.
    pub reference_pressure_pa: f64,
    /// Reference temperature T0, K.
    pub reference_temperature_k: f64,
}

impl Setup {
    /// Air in a cap-side chamber of that bore, m, with the paper's reference state and area law (27).
    pub fn air(bore_m: f64, ambient_temperature_k: f64) -> Self {
        Self {
            gas: Gas::AIR,
            bore_m,
            piston_area_m2: Geometry::new(bore_m, 0.0, 0.0, AreaLaw::Total).piston_area,
            area_law: AreaLaw::Total,
            ambient_temperature_k,
            reference_pressure_pa: paper::REFERENCE_PRESSURE_PA,
            reference_temperature_k: paper::REFERENCE_TEMPERATURE_K,
        }
    }

    /// Aq by (27) or for the swept length only, m².
    pub(super) fn area<R: Real>(&self, volume_m3: R, dead_volume_m3: R) -> R {
        let geometry = Geometry::with_piston_area(self.bore_m, self.piston_area_m2, 0.0, self.area_law);
        Geometry { dead_volume: dead_volume_m3, ..geometry.lift() }.heat_transfer_area(volume_m3)
    }

    /// λ0/λ at pressure, Pa, and temperature, K: equation (5) turned round.
    pub(super) fn reference_factor<R: Real>(&self, pressure_pa: R, temperature_k: R) -> R {
        (R::from(self.reference_pressure_pa * self.reference_temperature_k) / (pressure_pa * temperature_k)).sqrt()
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        for (quantity, value) in [
            ("the bore in m", self.bore_m),
            ("the piston area in m²", self.piston_area_m2),
            ("the ambient temperature in K", self.ambient_temperature_k),
            ("the reference pressure in Pa", self.reference_pressure_pa),
            ("the reference temperature in K", self.reference_temperature_k),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::NotPositive { quantity, value });
            }
        }
        Ok(())
    }
}

/// Begin and end of the push.
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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

/// Share of the pressure rise that remains at the settling time.
const SETTLED_SHARE: f64 = 0.01;

/// Step 2: mass, dead volume and final volume from two states at ambient temperature.
pub(super) fn mass_and_volumes<R: Real>(setup: &Setup, ambient_k: R, push: &Push<R>, final_pressure_pa: R) -> [R; 3] {
    let swept = [push.initial_position_m, push.final_position_m].map(|x| setup.piston_area_m2 * x);
    let rt = ambient_k * setup.gas.gas_constant;
    let (pi, pf) = (push.initial_pressure_pa, final_pressure_pa);
    let mass = R::from(swept[0] - swept[1]) / rt * (pi * pf / (pf - pi));
    let dead = mass * rt / pi - swept[0];
    [mass, dead, dead + swept[1]]
}

/// Steps 2 to 7 in any number type; `ambient_k` stands for the setup's ambient temperature.
pub fn steps<R: Real>(setup: &Setup, ambient_k: R, push: &Push<R>, regression: &Regression<R>) -> Steps<R> {
    let Regression { final_pressure_pa: pf, pressure_rise_pa: rise, time_constant_s: tau } = *regression;
    let [mass, dead, volume] = mass_and_volumes(setup, ambient_k, push, pf);
    let conductance = mass * setup.gas.cv() / tau;
    let area = setup.area(volume, dead);
    let coefficient = conductance / area;
    let settling_in_tau = (1.0 / SETTLED_SHARE).ln();
    let pressure = pf + rise * ((1.0 - SETTLED_SHARE) / settling_in_tau);
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

/// How far each input of the steps may be off.
#[derive(Clone, Copy, Debug)]
pub struct Uncertainty {
    /// Covariance of Pf, ΔP and τ.
    pub regression: Matrix3<f64>,
    /// Standard error of the initial pressure, Pa.
    pub initial_pressure_pa: f64,
    /// Standard error of the ambient temperature, K.
    pub ambient_temperature_k: f64,
    /// Half width of a 95 % interval in standard errors.
    pub quantile_95: f64,
}

impl Uncertainty {
    fn covariance(&self) -> SMatrix<f64, 5, 5> {
        let mut all = SMatrix::<f64, 5, 5>::zeros();
        all.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.regression);
        all[(3, 3)] = self.initial_pressure_pa.powi(2);
        all[(4, 4)] = self.ambient_temperature_k.powi(2);
        all
    }

    pub(super) fn estimate(&self, number: Dual<5>) -> Estimate {
        Estimate::new(number.value, propagated(&number.tangent, &self.covariance()), self.quantile_95)
    }
}

/// Steps 2 to 7 with 95 % intervals: the inputs' covariance carried through the steps' exact derivatives.
///
/// # Errors
/// Pressures and strokes that contradict each other.
pub fn steps_with_intervals(
    setup: &Setup,
    push: &Push,
    regression: &Regression,
    uncertainty: &Uncertainty,
) -> Result<Steps<Estimate>, Error> {
    setup.check()?;
    check_push(setup, push, regression.final_pressure_pa)?;
    let variable = |value, index| Dual::<5>::variable(value, index);
    let dual_push = Push {
        initial_pressure_pa: variable(push.initial_pressure_pa, 3),
        initial_position_m: push.initial_position_m,
        final_position_m: push.final_position_m,
    };
    let dual_regression = Regression {
        final_pressure_pa: variable(regression.final_pressure_pa, 0),
        pressure_rise_pa: variable(regression.pressure_rise_pa, 1),
        time_constant_s: variable(regression.time_constant_s, 2),
    };
    let found = steps(setup, variable(setup.ambient_temperature_k, 4), &dual_push, &dual_regression);
    Ok(found.map(|number| uncertainty.estimate(number)))
}

/// A closed chamber at one temperature has more pressure in less volume, and some volume left.
pub(super) fn check_push(setup: &Setup, push: &Push, final_pressure_pa: f64) -> Result<(), Error> {
    let [mass, _, volume] = mass_and_volumes(setup, setup.ambient_temperature_k, push, final_pressure_pa);
    if mass > 0.0 && mass.is_finite() && volume > 0.0 {
        return Ok(());
    }
    Err(Error::Contradiction {
        initial_pa: push.initial_pressure_pa,
        final_pa: final_pressure_pa,
        initial_m3: setup.piston_area_m2 * push.initial_position_m,
        final_m3: setup.piston_area_m2 * push.final_position_m,
    })
}

/// The method on a recording.
#[derive(Clone, Debug)]
pub struct TimeConstant {
    /// Push and hold as found in it.
    pub relaxation: Relaxation,
    /// Step 1, with intervals.
    pub regression: Regression<Estimate>,
    /// Steps 2 to 7, with intervals.
    pub steps: Steps<Estimate>,
    /// The fit behind them.
    pub fit: Fit,
}

/// Evaluates a recording by the seven steps.
///
/// # Errors
/// A recording that is not a push-and-hold test of a closed chamber.
pub fn evaluate(setup: &Setup, recording: &Recording) -> Result<TimeConstant, Error> {
    let relaxation = recording.relaxation()?;
    let fit = decay::fit::<Exponential>(&relaxation.time_s, &relaxation.pressure_pa)?;
    let [pf, rise, tau] = fit.parameters.into();
    let regression = Regression { final_pressure_pa: pf, pressure_rise_pa: rise, time_constant_s: tau };
    let uncertainty = Uncertainty {
        regression: fit.covariance,
        initial_pressure_pa: relaxation.initial_pressure_error_pa,
        ambient_temperature_k: 0.0,
        quantile_95: fit.quantile_95,
    };
    let steps = steps_with_intervals(setup, &relaxation.push(), &regression, &uncertainty)?;
    let own = |i: usize| Estimate::new(fit.parameters[i], fit.covariance[(i, i)].sqrt(), fit.quantile_95);
    let regression = Regression { final_pressure_pa: own(0), pressure_rise_pa: own(1), time_constant_s: own(2) };
    Ok(TimeConstant { relaxation, regression, steps, fit })
}

impl Relaxation {
    /// Begin and end of the push as the steps need them.
    pub fn push(&self) -> Push {
        Push {
            initial_pressure_pa: self.initial_pressure_pa,
            initial_position_m: self.initial_position_m,
            final_position_m: self.final_position_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> (Setup, Push, Regression) {
        let push = Push { initial_pressure_pa: 1e5, initial_position_m: 0.1, final_position_m: 0.05 };
        let regression = Regression { final_pressure_pa: 1.91e5, pressure_rise_pa: 5.24e4, time_constant_s: 0.4292 };
        (Setup::air(0.02, 293.0), push, regression)
    }

    #[test]
    fn the_steps_on_the_printed_regression_of_section_3_1_give_the_printed_numbers() {
        let (setup, push, regression) = example();
        let s = steps(&setup, 293.0, &push, &regression);
        for (ours, paper) in [
            (s.mass_kg, 39.2e-6),
            (s.conductance_av_w_per_k, 0.0656),
            (s.area_m2, 4.08e-3),
            (s.coefficient_av_w_per_m2_k, 16.07),
            (s.settling_time_s, 1.98),
            (s.pressure_av_pa, 2.023e5),
            (s.temperature_av_k, 310.42),
            (s.coefficient_0_w_per_m2_k, 26.16),
        ] {
            assert!((ours / paper - 1.0).abs() < 5e-3, "{ours} {paper}");
        }
    }

    #[test]
    fn mass_and_dead_volume_are_exact_for_two_states_at_ambient_temperature() {
        let (setup, push, _) = example();
        let (vd, a) = (1.57e-6, setup.piston_area_m2);
        let pf = 1e5 * (a * 0.1 + vd) / (a * 0.05 + vd);
        let [mass, dead, _] = mass_and_volumes(&setup, 293.0, &push, pf);
        assert!((dead / vd - 1.0).abs() < 1e-12);
        assert!((mass / (1e5 * (a * 0.1 + vd) / (287.0 * 293.0)) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn intervals_agree_with_moving_the_inputs() {
        let (setup, push, regression) = example();
        let sigma = 0.01;
        let mut covariance = Matrix3::zeros();
        covariance[(2, 2)] = sigma * sigma;
        let uncertainty = Uncertainty {
            regression: covariance,
            initial_pressure_pa: 0.0,
            ambient_temperature_k: 0.0,
            quantile_95: 2.0,
        };
        let with = steps_with_intervals(&setup, &push, &regression, &uncertainty).unwrap();
        let half = with.coefficient_0_w_per_m2_k.ci95[1] - with.coefficient_0_w_per_m2_k.value;
        // λ0 is inversely proportional to τ.
        let expected = 2.0 * with.coefficient_0_w_per_m2_k.value * sigma / regression.time_constant_s;
        assert!((half / expected - 1.0).abs() < 1e-12);
        assert_eq!(with.mass_kg.ci95[0], with.mass_kg.value);
    }

    #[test]
    fn a_pressure_that_falls_on_compression_is_a_contradiction() {
        let (setup, push, mut regression) = example();
        regression.final_pressure_pa = 0.9e5;
        let uncertainty = Uncertainty {
            regression: Matrix3::zeros(),
            initial_pressure_pa: 0.0,
            ambient_temperature_k: 0.0,
            quantile_95: 2.0,
        };
        let refused = steps_with_intervals(&setup, &push, &regression, &uncertainty);
        assert!(matches!(refused, Err(Error::Contradiction { .. })));
    }
}
