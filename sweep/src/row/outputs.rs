//! What comes out of a row, and the columns that it becomes.

use super::geometry::final_geometry;
use super::status::Status;
use crate::quantity::Base;
use When::{Always, Fit, Solved};
use ensemble::{Outcome, Scenario};

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

/// A column that is computed.
pub struct Output {
    /// Its name, with the unit's suffix.
    pub name: &'static str,
    /// The unit as people write it.
    pub unit: &'static str,
    /// One line for people.
    pub doc: &'static str,
    /// Studies in which the column is.
    pub when: When,
    /// Adds the values of some rows to a column; NaN where there is none.
    pub append: fn(&[RowResult], &mut Vec<f64>),
}

/// Which studies have a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Every study.
    Always,
    /// Those with the paper's regression: not with `fit = false`.
    Fit,
    /// Those that solve for it because this is varied.
    Solved(Base),
}

/// A column's values, by what each is in a row.
macro_rules! each {
    ($row:ident => $value:expr) => {
        |rows, column| column.extend(rows.iter().map(|$row| $value))
    };
}

/// Every computed column but the row's number and its status, in order.
#[rustfmt::skip]
pub const OUTPUTS: [Output; 15] = [
    Output { name: "bore_m", unit: "m", when: Solved(Base::VolumeToArea), doc: "Bore, solved for", append: each!(o => o.bore) },
    Output { name: "initial_stroke_m", unit: "m", when: Solved(Base::VolumeToAreaByLength), doc: "Piston position before the push, solved for", append: each!(o => o.strokes[0]) },
    Output { name: "final_stroke_m", unit: "m", when: Solved(Base::VolumeToAreaByLength), doc: "Piston position after the push, solved for", append: each!(o => o.strokes[1]) },
    Output { name: "volume_m3", unit: "m3", when: Always, doc: "Gas volume at the final stroke", append: each!(o => o.volume) },
    Output { name: "area_m2", unit: "m2", when: Always, doc: "Heat transfer area at the final stroke by the area law, without that of `dead_volume_surface`", append: each!(o => o.area) },
    Output { name: "volume_to_area_m", unit: "m", when: Always, doc: "Gas volume over that area", append: each!(o => o.volume / o.area) },
    Output { name: "pressure_peak_pa", unit: "Pa", when: Always, doc: "Largest pressure from the end of the push on; for an expansion the smallest", append: each!(o => o.pressure_peak) },
    Output { name: "pressure_final_pa", unit: "Pa", when: Always, doc: "Pressure at the end of the test", append: each!(o => o.pressure_final) },
    Output { name: "temperature_final_k", unit: "K", when: Always, doc: "Gas temperature at the end of the test", append: each!(o => o.temperature_final) },
    Output { name: "temperature_peak_k", unit: "K", when: Always, doc: "Largest gas temperature from the end of the push on; for an expansion the smallest", append: each!(o => o.temperature_peak) },
    Output { name: "time_constant_s", unit: "s", when: Fit, doc: "Time constant of P = Pf + dP exp(-t/tau) fitted by least squares to 100 pressures a second, from the peak of the pressure on: the end of the push, or later with a lag or delay of the sensor", append: each!(o => o.time_constant) },
    Output { name: "lambda_av_w_per_m2_k", unit: "W/(m2.K)", when: Fit, doc: "Average heat transfer coefficient by the paper's steps", append: each!(o => o.lambda_av) },
    Output { name: "lambda0_w_per_m2_k", unit: "W/(m2.K)", when: Fit, doc: "Heat transfer coefficient at the reference state by the paper's steps", append: each!(o => o.lambda0) },
    Output { name: "settling_time_s", unit: "s", when: Always, doc: "From the end of the push until pressure stays within 1 % of its peak-to-final distance; null where it does so only because the test ends: more than that 1 % is still to come from the wall or out of a late sensor, or the flow of gas at the end, through a leak for instance, or the drift of the sensor changes more in as long as the hold has lasted. Gas that a flow or a wall of its own keeps warm has nothing more to come from the wall", append: each!(o => o.settling_time) },
    Output { name: "energy_error", unit: "1", when: Always, doc: "Closure of the energy balance over the work of the push: change of internal energy less the integrals of heat, enthalpy and work, which the step control does not know; 0 where the solution is exact", append: each!(o => o.energy_error) },
];

/// Whether a column of that name is computed, so that no varied quantity can have it.
pub fn is_output(name: &str) -> bool {
    let solved = |output: &Output| matches!(output.when, Solved(_));
    name == "row" || name == "status" || OUTPUTS.iter().any(|output| output.name == name && !solved(output))
}
