//! What one row of a study gives back. SI units.

use thiserror::Error;

/// Share of the distance from peak to end within which a relaxation counts as settled.
pub const SETTLED: f64 = 0.01;
/// Share of its pressure by which a record that stands may tremble.
pub const ROUNDING: f64 = 1e-12;

/// The paper's evaluation of one test: P = Pf + ΔP e^(−t/τ) by least squares over the samples of a 100 Hz record from
/// its peak on, then steps 2 to 7.
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
    /// How far the record is from the exponential at most, as a share of its own rise.
    pub misfit: f64,
}

/// Results of one scenario; numbers are NaN where `status` is an error.
///
/// Pressures are those of the trace, as the sensor shows it (without sensor effects: the gas's); temperatures are the gas's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Largest pressure of the trace from the end of the push on, for an expansion the smallest, Pa.
    pub pressure_peak_pa: f64,
    /// Pressure at the end of the test, Pa.
    pub pressure_final_pa: f64,
    /// Gas temperature at the end of the test, K.
    pub temperature_final_k: f64,
    /// Largest gas temperature from the end of the push on, for an expansion the smallest, K.
    pub temperature_peak_k: f64,
    /// The paper's regression, where it was asked for and the record allows one.
    pub fit: Option<Fit>,
    /// From the end of the push until the pressure stays within 1 % of its peak-to-final distance of the final one, s.
    /// None when not settled in time: where it is within that 1 % only because the test ends. Then more than the 1 % is still to
    /// come as the gas takes the temperature of the wall and the sensor shows it, or gas that flows in or out as at the end changes
    /// more in as long as the hold has lasted, or a sensor drifts by more; so too where the pressure peaks at the end.
    pub settling_time_s: Option<f64>,
    /// Whether it has not settled for one reason only: gas goes on to flow in or out, or the sensor drifts.
    pub flows_on: bool,
    /// Closure of the energy balance: |U(t) − U(0) − ∫Q̇ dt − ∫ḣ dt + ∫P dV| over the work of the push, or over U(0) where the
    /// piston rests. The integrals are quadratures beside the integrator's states; zero for the exact solution, and of the push
    /// alone where the hold is an integral over the temperature or solved by collocation.
    pub energy_error: f64,
    /// Length of the test, s.
    pub duration_s: f64,
    /// Whether the exact solution was used.
    pub exact: bool,
    /// Why there is no result.
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

/// How the record of a test stands at its end, Pa. It has settled where neither what is to come nor what goes on is more than 1 % of
/// its distance: else it is within its band only because the test ends.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// From its peak to its end.
    pub distance: f64,
    /// What it still loses or gains once the gas has come to rest ([`to_be_lost`]), and the sensor has shown all of that.
    pub to_come: f64,
    /// What goes on as at the end changes in as long as the hold has lasted: gas that flows in or out, past a leak for instance, and
    /// a sensor that drifts.
    pub going_on: f64,
    /// Whether it shows a hold in which nothing changes.
    pub stands: bool,
}

impl Standing {
    /// [`Outcome::settling_time_s`] from when it is within its band, s, and [`Outcome::flows_on`].
    pub fn judge(&self, settling: f64) -> (Option<f64>, bool) {
        let small = |change: f64| change <= SETTLED * self.distance;
        let [at_rest, tight] = [self.to_come, self.going_on].map(small);
        let settled = self.stands || at_rest && tight;
        (settled.then_some(settling), !settled && at_rest)
    }
}

/// What the gas still loses once it has the temperature of the wall, P (1 − Tamb/T), Pa or K: or, if it is on no way there, what it
/// loses in as long as the hold has lasted at the rate of its end. Gas that a flow or a wall of its own keeps warm never has the
/// temperature of the surroundings.
pub fn to_be_lost(to_the_wall: f64, at_its_rate: f64) -> f64 {
    if at_its_rate.abs() < SETTLED * to_the_wall.abs() { at_its_rate } else { to_the_wall }
}

/// Closure of an energy balance: energies at the start and at the end, what the gas has received less its work, and the
/// magnitude of the work that it is relative to, or else the start.
pub fn closure(start: f64, end: f64, received: f64, work: f64) -> f64 {
    (end - start - received).abs() / if work == 0.0 { start } else { work.abs() }
}

/// Why a scenario has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Failure {
    /// A number that must be positive is not.
    #[error("{0} must be a positive number")]
    NotPositive(&'static str),
    /// A number is infinite or missing.
    #[error("{0} must be a finite number")]
    NotFinite(&'static str),
    /// The stroke leaves no gas volume.
    #[error("the gas volume is not positive along the whole stroke")]
    NoVolume,
    /// The test is over before the push.
    #[error("the test ends before the push does")]
    EndsInPush,
    /// Effects are active that the batch was not told of.
    #[error("an effect is active that the batch does not include")]
    EffectNotInSet,
    /// The exact solution was demanded where there is none.
    #[error(
        "the exact solution needs a closed chamber, with no effects but those that keep it, and a record that is late by less than its push and its hold"
    )]
    NoExactSolution,
    /// The outflow has emptied the chamber.
    #[error("the chamber runs empty")]
    Empty,
    /// The equations cannot be followed further.
    #[error("no integration step, however small, keeps the error within the tolerance")]
    StepTooSmall,
    /// The integration took more steps than a test may.
    #[error("the integration takes more steps than are allowed")]
    TooManySteps,
}
