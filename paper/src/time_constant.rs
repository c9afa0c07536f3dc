//! The thermal time constant method: the seven published steps, equations (20) to (31) of the paper.
//!
//! Step 1 is the regression P = Pf + ΔP e^(−t/τ) from the peak; the others are [`chamber::seven_steps`].
//!
//! The method is biased: 1 − Pf/P decays exponentially, not P − Pf (see [`section31`](super::section31)). Its intervals describe
//! the effect of noise, not that of the bias.

use super::Error;
use super::decay::{self, Exponential, Fit};
use super::recording::{Recording, Relaxation};
use super::statistics::{Estimate, propagated};
use chamber::dual::Dual;
pub use chamber::seven_steps::{Push, Regression, Setup, Steps, mass_and_volumes, steps};
use nalgebra::{Matrix3, SMatrix};

/// Uncertainty of each input of the steps.
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

/// Steps 2 to 7 with 95 % intervals, from the inputs' covariance and the steps' exact derivatives.
///
/// # Errors
/// If pressures and strokes contradict each other.
pub fn steps_with_intervals(
    setup: &Setup,
    push: &Push,
    regression: &Regression,
    uncertainty: &Uncertainty,
) -> Result<Steps<Estimate>, Error> {
    check_setup(setup)?;
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

/// Checks that every quantity of the setup is positive and finite.
pub(super) fn check_setup(setup: &Setup) -> Result<(), Error> {
    for (quantity, value) in [
        ("the bore in m", setup.geometry.bore),
        ("the piston area in m²", setup.geometry.piston_area),
        ("the ambient temperature in K", setup.ambient_temperature_k),
        ("the reference pressure in Pa", setup.reference_pressure_pa),
        ("the reference temperature in K", setup.reference_temperature_k),
    ] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::NotPositive { quantity, value });
        }
    }
    Ok(())
}

/// Checks that the pressure rises as the volume falls, as in a closed chamber at one temperature, and that some volume is left.
pub(super) fn check_push(setup: &Setup, push: &Push, final_pressure_pa: f64) -> Result<(), Error> {
    let [mass, _, volume] = mass_and_volumes(setup, setup.ambient_temperature_k, push, final_pressure_pa);
    if mass > 0.0 && mass.is_finite() && volume > 0.0 {
        return Ok(());
    }
    Err(Error::Contradiction {
        initial_pa: push.initial_pressure_pa,
        final_pa: final_pressure_pa,
        initial_m3: setup.geometry.piston_area * push.initial_position_m,
        final_m3: setup.geometry.piston_area * push.final_position_m,
    })
}

/// The method on a recording.
#[derive(Clone, Debug)]
pub struct TimeConstant {
    /// Push and hold found in it.
    pub relaxation: Relaxation,
    /// Step 1, with intervals.
    pub regression: Regression<Estimate>,
    /// Steps 2 to 7, with intervals.
    pub steps: Steps<Estimate>,
    /// The underlying fit.
    pub fit: Fit,
}

/// Evaluates a recording by the seven steps.
///
/// # Errors
/// For a recording that is not a push-and-hold test of a closed chamber.
pub fn evaluate(setup: &Setup, recording: &Recording) -> Result<TimeConstant, Error> {
    let relaxation = recording.relaxation()?;
    let fit = decay::fit::<Exponential>(&relaxation.time_s, &relaxation.pressure_pa)?;
    let [pf, rise, tau] = fit.parameters.into();
    let hold_s = relaxation.time_s[relaxation.time_s.len() - 1] - relaxation.time_s[0];
    if tau > hold_s {
        return Err(Error::NoDecay { hold_s });
    }
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
    /// Start and end of the push, for the steps.
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
        let (vd, a) = (1.57e-6, setup.geometry.piston_area);
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
    fn a_hold_that_is_shorter_than_its_time_constant_shows_no_decay() {
        let time_s: Vec<f64> = (0..600).map(|i| 0.01 * f64::from(i)).collect();
        let position_m: Vec<f64> = time_s.iter().map(|t| 0.1 - ((t - 0.5) / 0.1).clamp(0.0, 1.0) * 0.05).collect();
        let evaluated = |time_constant_s: f64| {
            let pressure = |t: &f64| match t - 0.6 {
                since if since < 0.0 => 1e5,
                since => 1.91e5 + 5e4 * (-since / time_constant_s).exp(),
            };
            let pressure_pa: Vec<f64> = time_s.iter().map(pressure).collect();
            let recording = Recording { time_s: &time_s, pressure_pa: &pressure_pa, position_m: &position_m };
            evaluate(&example().0, &recording).map(|found| found.regression.time_constant_s.value)
        };
        assert!((evaluated(2.0).unwrap() - 2.0).abs() < 0.01);
        assert!(matches!(evaluated(8.0), Err(Error::NoDecay { .. })));
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
