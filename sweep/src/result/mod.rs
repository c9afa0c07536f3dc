//! What comes out of a row.
//!
//! | module | holds |
//! |---|---|
//! | [`outputs`] | the columns that it becomes |
//! | [`status`] | how a row ended |

pub mod outputs;
pub mod status;

use ensemble::{Outcome, Scenario};
use status::Status;

/// Share of its rise within which a relaxation must be an exponential's, else its regression does not describe it.
const DESCRIBED: f64 = 0.05;
/// A closed chamber's own relaxation, of which 1 − Pf/P is an exponential, is 0.107 |ln(P/Pf)| of its rise from one at the
/// most, P being its first pressure (P/Pf from 0.2 to 10, least squares): what has that much more than 5 % is no leak.
const OWN_MISFIT: f64 = 0.11;

/// What came out of a row, SI units; NaN where there is nothing.
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
    /// What a scenario gave; `fit_wanted` says whether the regression was asked for.
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
                // Gas that flows on makes no exponential, however long the test.
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
