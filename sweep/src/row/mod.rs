//! One row: the chamber and test defined by a point of the design.
//!
//! | module | holds |
//! |---|---|
//! | `geometry` | bore or strokes, solved for where a ratio is given |
//! | [`solve`], [`chunk`] | rows through the kernel of `ensemble`, in chunks |

pub mod chunk;
pub(crate) mod geometry;
pub mod solve;

use crate::quantity::Base;
use crate::quantity::point::Point;
use crate::result::final_geometry;
use crate::result::status::{Failure, Status};
use crate::study::Study;
use chamber::balance::{self, Boundary};
use chamber::effects;
use ensemble::Scenario;

/// The push-and-hold test at a point of the study.
///
/// # Errors
/// The row's status if there is no test: none exists, or the row violates a constraint of the study.
pub fn scenario(study: &Study, point: &Point) -> Result<Scenario, Status> {
    let mut scenario = no_test(study);
    set_scenario(study, point, &mut scenario)?;
    Ok(scenario)
}

/// A placeholder scenario, to be set.
pub fn no_test(study: &Study) -> Scenario {
    Scenario::push(study.model.chamber, f64::NAN, [f64::NAN; 2], f64::NAN, f64::NAN)
}

/// As [`scenario`], updating one of the same study in place: only what varies changes. If the row has no test, the contents are
/// meaningless.
///
/// # Errors
/// As for [`scenario`].
pub fn set_scenario(study: &Study, point: &Point, scenario: &mut Scenario) -> Result<(), Status> {
    set_test(study, point, scenario).map_err(Status::Failed)?;
    match study.constraints.iter().position(|constraint| !constraint.holds(point, scenario)) {
        Some(broken) => Err(Status::LeftOut(broken as u8)),
        None => Ok(()),
    }
}

fn set_test(study: &Study, point: &Point, scenario: &mut Scenario) -> Result<(), Failure> {
    let get = |base| point.get(base);
    let or_ambient = |value: f64| if value.is_nan() { get(Base::AmbientTemperature) } else { value };
    point.set_gas(&mut scenario.chamber);
    study.vary_effects(point, &mut scenario.chamber.effects);
    scenario.chamber.geometry = geometry::of_point(point, study.model.chamber.geometry.area_law)?;
    scenario.initial_pressure_pa = get(Base::InitialPressure);
    [scenario.initial_position_m, scenario.final_position_m] = geometry::strokes(&scenario.chamber.geometry, point)?;
    scenario.push_time_s = get(Base::PushTime);
    scenario.duration_s = get(Base::Duration);
    let initial_temperature = get(Base::InitialTemperature);
    scenario.initial_temperature_k = if initial_temperature.is_nan() {
        scenario.chamber.effects.rest_temperature(get(Base::AmbientTemperature))
    } else {
        initial_temperature
    };
    scenario.ambient_temperature_k = get(Base::AmbientTemperature);
    scenario.ambient_pressure_pa = get(Base::AmbientPressure);
    scenario.mass_flow_in_kg_per_s = get(Base::MassFlowIn);
    scenario.temperature_in_k = or_ambient(get(Base::TemperatureIn));
    scenario.mass_flow_out_kg_per_s = get(Base::MassFlowOut);
    let time_constants = get(Base::HoldTimeConstants);
    if !time_constants.is_nan() {
        let hold = time_constants * final_time_constant(scenario);
        if !hold.is_finite() {
            return Err(Failure::NoTimeConstant);
        }
        scenario.duration_s = scenario.push_time_s + hold;
    }
    Ok(())
}

/// τ_f = m cv/(λ(Pf, Tw) Aq), s, with Pf the pressure of all the gas at rest at the wall's temperature after the push, and λ with
/// its effects except natural convection, which is undefined without a temperature difference.
pub fn final_time_constant(scenario: &Scenario) -> f64 {
    let chamber = &scenario.chamber;
    let ambient = scenario.ambient_temperature_k;
    let rest = chamber.effects.rest_temperature(ambient);
    let mass = scenario.initial_pressure_pa * chamber.geometry.volume(scenario.initial_position_m)
        / (chamber.gas.gas_constant * scenario.initial_temperature_k);
    let boundary = Boundary::closed(scenario.final_position_m, ambient, scenario.ambient_pressure_pa);
    let at = balance::conditions(chamber, &boundary, mass, mass * chamber.gas.cv() * rest);
    let set = chamber.active().without(effects::SINGULAR);
    let coefficient = chamber.effects.heat_transfer_factor(set, &at, at.eichelberg);
    let area = chamber.effects.heat_transfer_area(set, final_geometry(scenario).1);
    mass * chamber.gas.cv() / (coefficient * area)
}
