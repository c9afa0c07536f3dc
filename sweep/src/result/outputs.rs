//! The computed columns.

use super::RowResult;
use crate::quantity::Base;
use When::{Always, Fit, Solved};

/// A computed column.
pub struct Output {
    /// Its name, with the unit's suffix.
    pub name: &'static str,
    /// The unit, for display.
    pub unit: &'static str,
    /// One-line description for people.
    pub doc: &'static str,
    /// Studies that have the column.
    pub when: When,
    /// Appends the values of some rows to a column; NaN for missing ones.
    pub append: fn(&[RowResult], &mut Vec<f64>),
}

/// Which studies have a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Every study.
    Always,
    /// Those with the paper's regression: not with `fit = false`.
    Fit,
    /// Those that solve for it because this quantity is varied.
    Solved(Base),
}

/// A column's values, from an expression for one row.
macro_rules! each {
    ($row:ident => $value:expr) => {
        |rows, column| column.extend(rows.iter().map(|$row| $value))
    };
}

/// All computed columns except the row's number and its status, in order.
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

/// Whether a computed column has that name, so that no varied quantity can use it.
pub fn is_output(name: &str) -> bool {
    let solved = |output: &Output| matches!(output.when, Solved(_));
    name == "row" || name == "status" || OUTPUTS.iter().any(|output| output.name == name && !solved(output))
}
