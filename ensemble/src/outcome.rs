//! The result of one row of a study. SI units.

use thiserror::Error;

/// A relaxation has settled once it stays within this fraction of its peak-to-final distance.
pub const SETTLED: f64 = 0.01;
/// Rounding noise of a constant record, relative to its pressure.
pub const ROUNDING: f64 = 1e-12;

/// The paper's evaluation of one test: a least-squares fit of P = Pf + ΔP e^(−t/τ) to the samples of a 100 Hz record from its peak
/// on, then steps 2 to 7.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Pf, Pa.
    pub final_pressure_pa: f64,
    /// ΔP, Pa.
    pub pressure_rise_pa: f64,
    /// τ, s.
    pub time_constant_s: f64,
    /// λ_av, W/(m² K): step 5.
    pub lambda_av_w_per_m2_k: f64,
    /// λ0, W/(m² K): step 7.
    pub lambda0_w_per_m2_k: f64,
    /// Largest residual, relative to the record's own range.
    pub misfit: f64,
}

/// Results of one scenario; numbers are NaN if `status` is an error.
///
/// Pressures are sensor readings (without sensor effects: gas pressures); temperatures are gas temperatures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Largest pressure from the end of the push on, Pa; the smallest for an expansion.
    pub pressure_peak_pa: f64,
    /// Pressure at the end of the test, Pa.
    pub pressure_final_pa: f64,
    /// Gas temperature at the end of the test, K.
    pub temperature_final_k: f64,
    /// Largest gas temperature from the end of the push on, K; the smallest for an expansion.
    pub temperature_peak_k: f64,
    /// The paper's regression, if requested and if the record determines it.
    pub fit: Option<Fit>,
    /// Time from the end of the push until the pressure stays within 1 % of its peak-to-final distance of the final pressure, s.
    /// None if the pressure is within that 1 % only because the test ends: if more than 1 % is still to come until the gas has the
    /// wall's temperature and the sensor shows it, if at the final rate the flow of gas or the sensor's drift would change the
    /// pressure by more than that over another hold of the same duration, or if the pressure peaks at the end.
    pub settling_time_s: Option<f64>,
    /// Whether continuing flow or sensor drift is the only reason why it has not settled.
    pub flows_on: bool,
    /// Closure of the energy balance: |U(t) − U(0) − ∫Q̇ dt − ∫ḣ dt + ∫P dV| over the work of the push, or over U(0) if the piston
    /// does not move. The integrals are quadratures independent of the integrator's states. Zero for the exact solution; covers the
    /// push alone if the hold is an integral over temperature or solved by collocation.
    pub energy_error: f64,
    /// Duration of the test, s.
    pub duration_s: f64,
    /// Whether the exact solution was used.
    pub exact: bool,
    /// Why there is no result, if there is none.
    pub status: Result<(), Failure>,
}

impl Outcome {
    /// A row without a result.
    pub const fn failed(reason: Failure) -> Self {
        Self {
            pressure_peak_pa: f64::NAN,
            pressure_final_pa: f64::NAN,
            temperature_final_k: f64::NAN,
            temperature_peak_k: f64::NAN,
            fit: None,
            settling_time_s: None,
            flows_on: false,
            energy_error: f64::NAN,
            duration_s: f64::NAN,
            exact: false,
            status: Err(reason),
        }
    }
}

/// Changes of a record that are outstanding at its end, Pa. It has settled if neither of them exceeds 1 % of its peak-to-final
/// distance; otherwise it is within the band only because the test ends.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Distance from peak to end.
    pub distance: f64,
    /// Change until the gas has come to rest ([`to_be_lost`]) and the sensor shows it.
    pub to_come: f64,
    /// Change over another hold of the same duration by what continues at its final rate: flow of gas, through a leak for instance,
    /// and sensor drift.
    pub going_on: f64,
    /// Whether the record is constant during the hold.
    pub stands: bool,
}

impl Standing {
    /// Returns [`Outcome::settling_time_s`] and [`Outcome::flows_on`], given when the record enters its band, s.
    pub fn judge(&self, settling: f64) -> (Option<f64>, bool) {
        let small = |change: f64| change <= SETTLED * self.distance;
        let [at_rest, tight] = [self.to_come, self.going_on].map(small);
        let settled = self.stands || at_rest && tight;
        (settled.then_some(settling), !settled && at_rest)
    }
}

/// Pressure that the gas still loses until it has the wall's temperature, P (1 − Tamb/T), Pa or K; or, if it does not approach that
/// temperature, what it loses at its final rate over another hold of the same duration. Gas kept warm by a flow or by a heated wall
/// never reaches ambient temperature.
pub fn to_be_lost(to_the_wall: f64, at_its_rate: f64) -> f64 {
    if at_its_rate.abs() < SETTLED * to_the_wall.abs() { at_its_rate } else { to_the_wall }
}

/// Relative closure error of an energy balance, from the energies at start and end, the energy received less the work done, and the
/// magnitude of the work. Relative to that work or, if it is zero, to the initial energy.
pub fn closure(start: f64, end: f64, received: f64, work: f64) -> f64 {
    (end - start - received).abs() / if work == 0.0 { start } else { work.abs() }
}

/// Why a scenario has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Failure {
    /// A number that must be positive is not positive.
    #[error("{0} must be a positive number")]
    NotPositive(&'static str),
    /// A number is infinite or missing.
    #[error("{0} must be a finite number")]
    NotFinite(&'static str),
    /// The stroke leaves no gas volume.
    #[error("the gas volume is not positive along the whole stroke")]
    NoVolume,
    /// The test ends before the push does.
    #[error("the test ends before the push does")]
    EndsInPush,
    /// An active effect is not in the batch's set.
    #[error("an effect is active that the batch does not include")]
    EffectNotInSet,
    /// The exact solution was requested but does not exist.
    #[error(
        "the exact solution needs a closed chamber, with no effects but those that keep it, and a record that is late by less than its push and its hold"
    )]
    NoExactSolution,
    /// The outflow has emptied the chamber.
    #[error("the chamber runs empty")]
    Empty,
    /// No step, however small, meets the tolerance.
    #[error("no integration step, however small, keeps the error within the tolerance")]
    StepTooSmall,
    /// The integration exceeded its step limit.
    #[error("the integration takes more steps than are allowed")]
    TooManySteps,
}
