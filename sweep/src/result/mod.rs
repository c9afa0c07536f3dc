//! Results of a row.
//!
//! | module | holds |
//! |---|---|
//! | [`outputs`] | the columns they become |
//! | [`status`] | status of a row |

pub mod outputs;
pub mod status;

use ensemble::{Outcome, Scenario};
use status::Status;

/// Largest deviation of a relaxation from its exponential fit, as a fraction of its rise; beyond it the regression does not
/// describe it.
const DESCRIBED: f64 = 0.05;
/// A closed chamber's own relaxation, of which 1 − Pf/P is an exponential, deviates from an exponential by at most 0.107
/// |ln(P/Pf)| of its rise, P being its first pressure (P/Pf from 0.2 to 10, least squares): a deviation within this is no leak,
/// even above 5 %.
const OWN_MISFIT: f64 = 0.11;

/// Results of a row, SI units; NaN for missing ones.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug)]
pub struct RowResult {
    pub volume: f64,
    pub area: f64,
    pub pressure_peak: f64,
    pub pressure_final: f64,
    pub temperature_final: f64,
    pub temperature_peak: f64,
    pub time_constant: f64,
    pub lambda_av: f64,
    pub lambda0: f64,
    pub settling_time: f64,
    pub energy_error: f64,
    pub bore: f64,
    pub strokes: [f64; 2],
    pub status: Status,
}

impl RowResult {
    /// Results of a scenario; `fit_wanted`: whether the regression was requested.
    pub fn new(scenario: &Scenario, outcome: &Outcome, fit_wanted: bool) -> Self {
        if let Err(failure) = outcome.status {
            return Self::without(Status::Failed(failure.into()));
        }
        let (volume, area) = final_geometry(scenario);
        let described = outcome.fit.as_ref().filter(|fit| {
            let own = OWN_MISFIT * (outcome.pressure_peak_pa / fit.final_pressure_pa).ln().abs();
            fit.misfit <= own.max(DESCRIBED)
        });
        let fit = |value: fn(&ensemble::Fit) -> f64| described.map_or(f64::NAN, value);
        Self {
            volume,
            area,
            pressure_peak: outcome.pressure_peak_pa,
            pressure_final: outcome.pressure_final_pa,
            temperature_final: outcome.temperature_final_k,
            temperature_peak: outcome.temperature_peak_k,
            time_constant: fit(|f| f.time_constant_s),
            lambda_av: fit(|f| f.lambda_av_w_per_m2_k),
            lambda0: fit(|f| f.lambda0_w_per_m2_k),
            settling_time: outcome.settling_time_s.unwrap_or(f64::NAN),
            energy_error: outcome.energy_error,
            bore: scenario.chamber.geometry.bore,
            strokes: [scenario.initial_position_m, scenario.final_position_m],
            status: match (outcome.settling_time_s, described) {
                // A continuing gas flow gives no exponential, however long the test.
                (None, None) if fit_wanted && outcome.flows_on => Status::NoTimeConstant,
                (None, _) => Status::NotSettled,
                (_, None) if fit_wanted => Status::NoTimeConstant,
                _ => Status::Ok,
            },
        }
    }

    /// A row without results.
    pub fn without(status: Status) -> Self {
        Self {
            volume: f64::NAN,
            area: f64::NAN,
            pressure_peak: f64::NAN,
            pressure_final: f64::NAN,
            temperature_final: f64::NAN,
            temperature_peak: f64::NAN,
            time_constant: f64::NAN,
            lambda_av: f64::NAN,
            lambda0: f64::NAN,
            settling_time: f64::NAN,
            energy_error: f64::NAN,
            bore: f64::NAN,
            strokes: [f64::NAN; 2],
            status,
        }
    }
}

/// Volume of the gas, m³, and its heat transfer area, m², at the final stroke.
pub fn final_geometry(scenario: &Scenario) -> (f64, f64) {
    let geometry = &scenario.chamber.geometry;
    let volume = geometry.volume(scenario.final_position_m);
    (volume, geometry.heat_transfer_area(volume))
}
