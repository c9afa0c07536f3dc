//! The paper's steps 2 to 7 on the result of step 1.

use crate::outcome::Fit;
use crate::regression::Regression;
use crate::scenario::Scenario;
use chamber::seven_steps::{self, Push, Setup};
use chamber::{AreaLaw, Geometry};

/// Steps 2 to 7 as published: Aq by (27) with the whole gas volume. None if pressures and strokes contradict each other.
pub fn steps(scenario: &Scenario, regression: Regression) -> Option<Fit> {
    let Regression { exponential, misfit } = regression;
    let chamber = &scenario.chamber;
    let setup = Setup {
        gas: chamber.gas,
        geometry: Geometry { area_law: AreaLaw::Total, ..chamber.geometry },
        ambient_temperature_k: scenario.ambient_temperature_k,
        reference_pressure_pa: chamber.heat_transfer.reference_pressure,
        reference_temperature_k: chamber.heat_transfer.reference_temperature,
    };
    let &Scenario { initial_pressure_pa, initial_position_m, final_position_m, .. } = scenario;
    let push = Push { initial_pressure_pa, initial_position_m, final_position_m };
    let steps = seven_steps::steps(&setup, setup.ambient_temperature_k, &push, &exponential);
    let (lambda_av, lambda0) = (steps.coefficient_av_w_per_m2_k, steps.coefficient_0_w_per_m2_k);
    (steps.mass_kg > 0.0 && steps.final_volume_m3 > 0.0 && lambda0.is_finite()).then_some(Fit {
        final_pressure_pa: exponential.final_pressure_pa,
        pressure_rise_pa: exponential.pressure_rise_pa,
        time_constant_s: exponential.time_constant_s,
        lambda_av_w_per_m2_k: lambda_av,
        lambda0_w_per_m2_k: lambda0,
        misfit,
    })
}
