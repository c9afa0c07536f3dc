//! One row: from the point of the design to the chamber and test it stands for, and what came out of it.

use crate::constraint::Constraint;
use crate::quantity::{Base, Point};
use crate::study::Study;
use chamber::Geometry;
use chamber::balance::{self, Boundary};
use chamber::effects::{self, EffectSet};
use ensemble::{Hold, Outcome, Scenario};
use std::borrow::Cow;
use thiserror::Error;

/// Largest and smallest bore that a volume-to-area ratio is solved for, m.
const BORES_M: (f64, f64) = (1e-4, 10.0);

/// Share of its rise within which a relaxation must be an exponential's, else its regression does not describe it.
const DESCRIBED: f64 = 0.05;
/// A closed chamber's own relaxation, of which 1 − Pf/P is an exponential, is 0.107 |ln(P/Pf)| of its rise from one at the
/// most, P being its first pressure (P/Pf from 0.2 to 10, least squares): what has that much more than 5 % is no leak.
const OWN_MISFIT: f64 = 0.11;

/// Why a row has no results. Few and without numbers, so that the status column is a small dictionary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Failure {
    /// The rod leaves no piston area.
    #[error("the rod leaves no piston area")]
    RodFillsBore,
    /// No heat transfer, so that a hold of some time constants has no length.
    #[error("without heat transfer there is no time constant to hold for")]
    NoTimeConstant,
    /// No bore gives the volume-to-area ratio.
    #[error("no bore gives this volume-to-area ratio")]
    NoBore,
    /// No strokes give the volume-to-area ratio.
    #[error("no length gives this volume-to-area ratio at this bore")]
    NoLength,
    /// The simulation failed.
    #[error(transparent)]
    Simulation(#[from] ensemble::Failure),
}

/// How a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// The row has all its results.
    Ok,
    /// Pressure had not settled to 1 % when the test ended.
    NotSettled,
    /// The relaxation is over 5 % of its rise, and more than a closed chamber's, from an exponential.
    NoTimeConstant,
    /// Not solved, since it breaks this one of the study's constraints.
    LeftOut(u8),
    /// No results, and why.
    Failed(Failure),
}

impl Status {
    /// The status of a row with results, from its text.
    pub fn of_text(study: &Study, text: &str) -> Option<Self> {
        [Status::Ok, Status::NotSettled, Status::NoTimeConstant].into_iter().find(|status| status.text(study) == text)
    }

    /// As in the status column of a study.
    pub fn text(self, study: &Study) -> Cow<'static, str> {
        match self {
            Status::Ok => "ok".into(),
            Status::NotSettled => "not_settled".into(),
            Status::NoTimeConstant => "no_time_constant".into(),
            Status::LeftOut(number) => {
                let constraint = study.constraints.get(usize::from(number));
                format!("left_out: {}", constraint.map_or("", Constraint::text)).into()
            }
            Status::Failed(failure) => format!("failed: {failure}").into(),
        }
    }
}

/// What came out of a row, SI units; NaN where there is nothing.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug)]
pub struct Outputs {
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

impl Outputs {
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

/// The push-and-hold test that a point of the study stands for.
///
/// # Errors
/// How the row ends without it: there is no such test, or the row breaks one of the study's constraints.
pub fn scenario(study: &Study, point: &Point) -> Result<Scenario, Status> {
    let mut scenario = no_test(study);
    set_scenario(study, point, &mut scenario)?;
    Ok(scenario)
}

/// A scenario that is none, to be set.
pub fn no_test(study: &Study) -> Scenario {
    Scenario::push(study.model.chamber, f64::NAN, [f64::NAN; 2], f64::NAN, Hold::Duration(f64::NAN))
}

/// As [`scenario`], in place of one that is there already, which spares copies of it. What is left there is of no use
/// where the row ends without a test.
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
    scenario.chamber.geometry = geometry(study, point)?;
    scenario.initial_pressure_pa = get(Base::InitialPressure);
    [scenario.initial_position_m, scenario.final_position_m] = strokes(&scenario.chamber.geometry, point)?;
    scenario.push_time_s = get(Base::PushTime);
    scenario.hold = Hold::Duration(get(Base::Duration));
    let initial_temperature = get(Base::InitialTemperature);
    scenario.initial_temperature_k = if initial_temperature.is_nan() {
        effects::rest_temperature(&scenario.chamber.effects, get(Base::AmbientTemperature))
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
        scenario.hold = Hold::Duration(scenario.push_time_s + hold);
    }
    Ok(())
}

/// The chamber's shape, its bore solved for where the volume-to-area ratio is given.
fn geometry(study: &Study, point: &Point) -> Result<Geometry, Failure> {
    let get = |base| point.get(base);
    let area_law = study.model.chamber.geometry.area_law;
    let shape = |bore| Geometry::new(bore, get(Base::Rod), get(Base::DeadVolume), area_law);
    let wanted = get(Base::VolumeToArea);
    let bore = if wanted.is_nan() {
        get(Base::Bore)
    } else {
        let ratio = |bore| ratio(&shape(bore), get(Base::FinalStroke));
        bore_of(wanted, get(Base::Bore), get(Base::Rod), ratio).ok_or(Failure::NoBore)?
    };
    let geometry = shape(bore);
    if geometry.piston_area > 0.0 { Ok(geometry) } else { Err(Failure::RodFillsBore) }
}

/// Strokes before and after the push, m: solved for in their proportion where the volume-to-area ratio is given at a
/// bore. The area grows in proportion to the volume, so that the volume follows from a linear equation.
fn strokes(geometry: &Geometry, point: &Point) -> Result<[f64; 2], Failure> {
    let (wanted, given) = (point.get(Base::VolumeToAreaByLength), [Base::InitialStroke, Base::FinalStroke]);
    let [initial, last] = given.map(|base| point.get(base));
    if wanted.is_nan() {
        return Ok([initial, last]);
    }
    let at_zero = geometry.heat_transfer_area(0.0);
    let slope = geometry.heat_transfer_area(1.0) - at_zero;
    let volume = wanted * at_zero / (1.0 - wanted * slope);
    let solved = (volume - geometry.dead_volume) / geometry.piston_area;
    if solved.is_finite() && solved > 0.0 { Ok([solved * (initial / last), solved]) } else { Err(Failure::NoLength) }
}

/// Volume of the gas, m³, and its heat transfer area, m², at the final stroke.
pub fn final_geometry(scenario: &Scenario) -> (f64, f64) {
    let geometry = &scenario.chamber.geometry;
    let volume = geometry.volume(scenario.final_position_m);
    (volume, geometry.heat_transfer_area(volume))
}

/// τ_f = m cv/(λ(Pf, Tw) Aq), s, with Pf the pressure of all the gas at the wall's temperature at rest after the push and
/// λ with its effects but natural convection, which has no value without a temperature difference.
pub fn final_time_constant(scenario: &Scenario) -> f64 {
    let chamber = &scenario.chamber;
    let ambient = scenario.ambient_temperature_k;
    let rest = effects::rest_temperature(&chamber.effects, ambient);
    let mass = scenario.initial_pressure_pa * chamber.geometry.volume(scenario.initial_position_m)
        / (chamber.gas.gas_constant * scenario.initial_temperature_k);
    let boundary = Boundary::closed(scenario.final_position_m, ambient, scenario.ambient_pressure_pa);
    let at = balance::conditions(chamber, &boundary, mass, mass * chamber.gas.cv() * rest);
    let natural = effects::find("natural_convection").map(|(index, _)| index);
    let set: EffectSet = chamber.active().iter().filter(|index| Some(*index) != natural).collect();
    let coefficient = effects::heat_transfer_factor(set, &chamber.effects, &at, at.eichelberg);
    let area = effects::heat_transfer_area(set, &chamber.effects, final_geometry(scenario).1);
    mass * chamber.gas.cv() / (coefficient * area)
}

/// Gas volume over heat transfer area at a stroke.
fn ratio(geometry: &Geometry, stroke: f64) -> f64 {
    let volume = geometry.volume(stroke);
    volume / geometry.heat_transfer_area(volume)
}

/// The bore that gives a volume-to-area ratio: of several, the one nearest to `near` on a logarithmic scale.
fn bore_of(target: f64, near: f64, rod: f64, ratio: impl Fn(f64) -> f64) -> Option<f64> {
    const STEP: f64 = 1.1;
    let miss = |bore: f64| ratio(bore) - target;
    let (least, most) = (BORES_M.0.max(rod * (1.0 + 1e-12)), BORES_M.1);
    let (mut low, mut high) = (near.clamp(least, most), near.clamp(least, most));
    let (mut at_low, mut at_high) = (miss(low), miss(high));
    while low > least || high < most {
        let (next_low, next_high) = ((low / STEP).max(least), (high * STEP).min(most));
        let (at_next_low, at_next_high) = (miss(next_low), miss(next_high));
        if at_next_low * at_low <= 0.0 {
            return Some(root(next_low, low, at_next_low, at_low, miss));
        }
        if at_next_high * at_high <= 0.0 {
            return Some(root(high, next_high, at_high, at_next_high, miss));
        }
        (low, high, at_low, at_high) = (next_low, next_high, at_next_low, at_next_high);
    }
    None
}

/// A root between two bores at which the sign differs: regula falsi with the Illinois rule.
fn root(mut a: f64, mut b: f64, mut at_a: f64, mut at_b: f64, miss: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        if at_a == 0.0 || (b - a).abs() <= 1e-15 * b {
            return a;
        }
        let c = b - at_b * (b - a) / (at_b - at_a);
        let at_c = miss(c);
        if at_c * at_b <= 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        if (c - b).abs() <= 1e-15 * c {
            return c;
        }
        (b, at_b) = (c, at_c);
    }
    b
}
