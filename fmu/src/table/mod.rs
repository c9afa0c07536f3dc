//! The one table of variables: the chamber's by hand, the effects' from their cards. A variable's value reference is its
//! place in the table. Model description, getters, setters, saved states and derivatives all read this table.

pub mod structure;
pub mod units;

use crate::plant::states::{ALL, HEAT, TRAVEL, WORK};
use crate::plant::values::{BASE, Choice, INPUTS, OUTPUTS, Starts, output, parameter};
use chamber::balance::{ENERGY, MASS, STATES};
use chamber::card::{ActsOn, Card, Kind, Parameter};
use chamber::effects::empirical::{Balance, Curve, Empirical};
use chamber::effects::{self, Effect};
use std::sync::LazyLock;
use units::Quantity;

/// Communication step that the descriptions propose, s.
pub const STEP_S: f64 = 1e-3;

/// What a variable stands for; indices are places among its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A continuous input.
    Input(usize),
    /// A continuous output.
    Output(usize),
    /// A real parameter.
    Parameter(usize),
    /// A parameter that is no number.
    Choice(Choice),
    /// A continuous state that is no output.
    State(usize),
    /// Rate of a continuous state.
    Rate(usize),
}

/// When a variable may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialisation.
    Fixed,
    /// Between steps.
    Tunable,
    /// Always.
    Continuous,
}

/// Type of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// A real number with its unit.
    Real,
    /// One of several, by number.
    Enumeration(&'static Enumeration),
    /// True or false.
    Boolean,
}

/// An enumeration: a type definition of the model description.
#[derive(Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// Name of the type.
    pub name: &'static str,
    /// One line for people.
    pub description: &'static str,
    /// Names and descriptions of its items, numbered from one.
    pub items: &'static [(&'static str, &'static str)],
}

/// Which area exchanges heat.
pub static AREA_LAW: Enumeration = Enumeration {
    name: "AreaLaw",
    description: "Lateral area that exchanges heat, beside both end faces",
    items: &[("total", "Of the whole gas volume, dead volume included"), ("swept", "Of the swept length only")],
};

/// What moves the piston.
pub static STROKE_INPUT: Enumeration = Enumeration {
    name: "StrokeInput",
    description: "Inputs that move the piston",
    items: &[
        ("positionAndVelocity", "Both; the volume at a communication point is that of the position"),
        ("velocity", "The velocity alone, from the start value of position"),
    ],
};

/// Every enumeration.
pub static ENUMERATIONS: [&Enumeration; 2] = [&AREA_LAW, &STROKE_INPUT];

/// One variable of the FMU.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Structured name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// What it stands for.
    pub role: Role,
    /// Its type.
    pub is: Type,
    /// Its unit and kind, where it is a number.
    pub quantity: &'static Quantity,
    /// When it may change.
    pub variability: Variability,
    /// Smallest value accepted.
    pub min: Option<f64>,
    /// Largest value accepted.
    pub max: Option<f64>,
    /// Order of magnitude.
    pub nominal: f64,
}

impl Variable {
    /// Whether the value lies within the bounds.
    pub fn admits(&self, value: f64) -> bool {
        self.min.is_none_or(|min| value >= min) && self.max.is_none_or(|max| value <= max)
    }
}

/// Every variable; a variable's value reference is its place here.
pub fn table() -> &'static [Variable] {
    static TABLE: LazyLock<Vec<Variable>> = LazyLock::new(build);
    &TABLE
}

/// Place of the variable with this role.
pub fn place(role: Role) -> Option<usize> {
    table().iter().position(|v| v.role == role)
}

/// What the continuous state of that index is among the variables: an output for the gas's and the sums.
pub fn role_of_state(state: usize) -> Role {
    match state {
        MASS => Role::Output(output::MASS),
        ENERGY => Role::Output(output::INTERNAL_ENERGY),
        HEAT => Role::Output(output::HEAT_RECEIVED),
        WORK => Role::Output(output::WORK_DONE),
        other => Role::State(other),
    }
}

/// The continuous state that a variable is, if it is one.
pub fn state_of_role(role: Role) -> Option<usize> {
    (0..ALL).find(|&state| role_of_state(state) == role)
}

/// Place of the variable that is the continuous state of that index.
pub fn place_of_state(state: usize) -> Option<usize> {
    place(role_of_state(state))
}

/// Orders of magnitude of the continuous states.
pub fn nominals() -> [f64; ALL] {
    core::array::from_fn(|state| place_of_state(state).map_or(1.0, |place| table()[place].nominal))
}

/// A start value, or the present value of a variable that a host can set.
pub fn settable(starts: &Starts, role: Role) -> Option<f64> {
    match role {
        Role::Input(i) => Some(starts.inputs[i]),
        Role::Parameter(i) => Some(starts.parameters.real[i]),
        Role::Choice(choice) => Some(f64::from(starts.parameters.choices.get(choice))),
        _ => None,
    }
}

fn build() -> Vec<Variable> {
    let mut table = Vec::new();
    inputs(&mut table);
    outputs(&mut table);
    base_parameters(&mut table);
    effect_parameters(&mut table);
    states(&mut table);
    table
}

struct Row(&'static str, &'static Quantity, Option<f64>, Option<f64>, f64, &'static str);

fn inputs(table: &mut Vec<Variable>) {
    let rows: [Row; INPUTS] = [
        Row(
            "position",
            &units::LENGTH,
            None,
            None,
            0.1,
            "Distance of the piston face from the end of the chamber; the volume follows from it. If strokeInput is velocity, only the start value is used",
        ),
        Row(
            "velocity",
            &units::VELOCITY,
            None,
            None,
            0.1,
            "Velocity of the piston, positive when the chamber grows; moves the position within a step unless the host sets the derivative of position",
        ),
        Row(
            "massFlowIn",
            &units::MASS_FLOW,
            None,
            None,
            1e-3,
            "Mass flow into the chamber at temperatureIn; where negative it leaves at the gas's temperature",
        ),
        Row("temperatureIn", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the gas that enters"),
        Row(
            "massFlowOut",
            &units::MASS_FLOW,
            None,
            None,
            1e-3,
            "Mass flow out of the chamber at the gas's temperature; where negative it enters at temperatureIn",
        ),
        Row(
            "ambientTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature of the surroundings, and of the wall unless wallHeating or externalWall is on",
        ),
        Row(
            "ambientPressure",
            &units::PRESSURE,
            Some(0.0),
            Some(1e9),
            1e5,
            "Absolute pressure of the surroundings: the pressure outside a leak, and the zero of force",
        ),
        Row(
            "wallTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature of the wall if externalWall is true; otherwise not used",
        ),
        Row(
            "supplyPortPressure",
            &units::PRESSURE,
            Some(0.0),
            Some(1e9),
            1e5,
            "Absolute pressure on the other side of the supply port",
        ),
        Row(
            "supplyPortTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature of the gas on the other side of the supply port",
        ),
        Row(
            "supplyPortConductance",
            &units::SONIC_CONDUCTANCE,
            Some(0.0),
            Some(1e-6),
            1e-8,
            "Sonic conductance of the supply port (ISO 6358); zero closes it",
        ),
        Row(
            "exhaustPortPressure",
            &units::PRESSURE,
            Some(0.0),
            Some(1e9),
            1e5,
            "Absolute pressure on the other side of the exhaust port",
        ),
        Row(
            "exhaustPortTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature of the gas on the other side of the exhaust port",
        ),
        Row(
            "exhaustPortConductance",
            &units::SONIC_CONDUCTANCE,
            Some(0.0),
            Some(1e-6),
            1e-8,
            "Sonic conductance of the exhaust port (ISO 6358); zero closes it",
        ),
    ];
    push(table, &rows, Variability::Continuous, Role::Input);
}

fn outputs(table: &mut Vec<Variable>) {
    let rows: [Row; OUTPUTS] = [
        Row("pressure", &units::PRESSURE, Some(0.0), None, 1e5, "Absolute pressure of the gas"),
        Row(
            "measuredPressure",
            &units::PRESSURE,
            None,
            None,
            1e5,
            "Reading of the pressure sensor, with lag, delay, offset and drift",
        ),
        Row("temperature", &units::TEMPERATURE, Some(0.0), None, 300.0, "Mean temperature of the gas"),
        Row("mass", &units::MASS, Some(0.0), None, 1e-4, "Mass of the gas"),
        Row("volume", &units::VOLUME, Some(0.0), None, 1e-5, "Volume of the gas, dead volume included"),
        Row("force", &units::FORCE, None, None, 100.0, "Force of the gas on the piston face against ambientPressure"),
        Row("heatFlow", &units::POWER, None, None, 10.0, "Heat flow into the gas"),
        Row(
            "heatTransferCoefficient",
            &units::HEAT_TRANSFER,
            Some(0.0),
            None,
            30.0,
            "Heat transfer coefficient between gas and wall at the present state",
        ),
        Row("pistonPosition", &units::LENGTH, None, None, 0.1, "Position of the piston, limited to its stroke"),
        Row(
            "supplyPortMassFlow",
            &units::MASS_FLOW,
            None,
            None,
            1e-3,
            "Mass flow through the supply port into the chamber; under co-simulation its mean over the last step",
        ),
        Row(
            "supplyPortEnthalpyFlow",
            &units::ENERGY_FLOW,
            None,
            None,
            300.0,
            "Enthalpy flow through the supply port into the chamber, cp T of each mass; the mean as for the mass flow",
        ),
        Row(
            "exhaustPortMassFlow",
            &units::MASS_FLOW,
            None,
            None,
            1e-3,
            "Mass flow through the exhaust port into the chamber; under co-simulation its mean over the last step",
        ),
        Row(
            "exhaustPortEnthalpyFlow",
            &units::ENERGY_FLOW,
            None,
            None,
            300.0,
            "Enthalpy flow through the exhaust port into the chamber, cp T of each mass; the mean as for the mass flow",
        ),
        Row("internalEnergy", &units::ENERGY, Some(0.0), None, 10.0, "Internal energy of the gas"),
        Row("heatReceived", &units::ENERGY_CHANGE, None, None, 10.0, "Heat received by the gas since the start"),
        Row("workDone", &units::ENERGY_CHANGE, None, None, 10.0, "Work of the gas on the piston since the start"),
        Row(
            "enthalpyReceived",
            &units::ENERGY_CHANGE,
            None,
            None,
            10.0,
            "Enthalpy received with flows since the start: the change of internalEnergy minus heatReceived plus workDone",
        ),
        Row("massReceived", &units::MASS_CHANGE, None, None, 1e-4, "Mass received with flows since the start"),
    ];
    push(table, &rows, Variability::Continuous, Role::Output);
}

fn base_parameters(table: &mut Vec<Variable>) {
    let fixed: [Row; 6] = [
        Row("bore", &units::LENGTH, Some(1e-4), Some(100.0), 0.02, "Bore of the cylinder"),
        Row(
            "rodDiameter",
            &units::LENGTH,
            Some(0.0),
            Some(100.0),
            0.01,
            "Diameter of a rod that runs through this chamber; zero on the cap side",
        ),
        Row("deadVolume", &units::VOLUME, Some(0.0), Some(1e3), 1e-6, "Volume of the gas at position zero"),
        Row(
            "initialPressure",
            &units::PRESSURE,
            Some(1.0),
            Some(1e9),
            1e5,
            "Absolute pressure of the gas at the start",
        ),
        Row(
            "initialTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature of the gas at the start",
        ),
        Row(
            "stroke",
            &units::LENGTH,
            Some(0.0),
            Some(100.0),
            0.1,
            "Length of the stroke, which limits the position from below (0) and above; zero means no limits",
        ),
    ];
    push(table, &fixed, Variability::Fixed, Role::Parameter);
    let tunable: [Row; 5] = [
        Row(
            "lambda0",
            &units::HEAT_TRANSFER,
            Some(0.0),
            Some(1e6),
            30.0,
            "Heat transfer coefficient at the reference state",
        ),
        Row(
            "referencePressure",
            &units::PRESSURE,
            Some(1.0),
            Some(1e9),
            1e5,
            "Pressure at which the heat transfer coefficient is lambda0",
        ),
        Row(
            "referenceTemperature",
            &units::TEMPERATURE,
            Some(1.0),
            Some(1e5),
            300.0,
            "Temperature at which the heat transfer coefficient is lambda0",
        ),
        Row(
            "supplyPortCriticalRatio",
            &units::DIMENSIONLESS,
            Some(0.0),
            Some(0.9),
            0.3,
            "Critical pressure ratio of the supply port (ISO 6358)",
        ),
        Row(
            "exhaustPortCriticalRatio",
            &units::DIMENSIONLESS,
            Some(0.0),
            Some(0.9),
            0.3,
            "Critical pressure ratio of the exhaust port (ISO 6358)",
        ),
    ];
    push(table, &tunable, Variability::Tunable, |i| Role::Parameter(parameter::LAMBDA0 + i));
    let gas: [Row; 2] = [
        Row("gasConstant", &units::GAS_CONSTANT, Some(1.0), Some(1e5), 300.0, "Specific gas constant"),
        Row(
            "heatCapacityRatio",
            &units::DIMENSIONLESS,
            Some(1.001),
            Some(5.0),
            1.0,
            "Ratio of the heat capacities at constant pressure and constant volume",
        ),
    ];
    push(table, &gas, Variability::Fixed, |i| Role::Parameter(parameter::GAS_CONSTANT + i));
    let choices = [
        (
            "areaLaw",
            "Lateral area that exchanges heat: that of the whole gas volume, or of the swept length only",
            Choice::AreaLaw,
            Type::Enumeration(&AREA_LAW),
        ),
        (
            "strokeInput",
            "Inputs that move the piston: position and velocity, or velocity alone; pistonPosition is the result",
            Choice::StrokeInput,
            Type::Enumeration(&STROKE_INPUT),
        ),
        (
            "externalWall",
            "Whether the input wallTemperature is the temperature of the wall, for a thermal network that supplies heatFlow",
            Choice::ExternalWall,
            Type::Boolean,
        ),
    ];
    for (name, description, choice, is) in choices {
        let (min, max) = match is {
            Type::Enumeration(enumeration) => (1.0, enumeration.items.len() as f64),
            _ => (0.0, 1.0),
        };
        table.push(Variable {
            name: name.into(),
            description: description.into(),
            role: Role::Choice(choice),
            is,
            quantity: &units::DIMENSIONLESS,
            variability: Variability::Fixed,
            min: Some(min),
            max: Some(max),
            nominal: 1.0,
        });
    }
}

fn push(table: &mut Vec<Variable>, rows: &[Row], variability: Variability, role: impl Fn(usize) -> Role) {
    for (i, Row(name, quantity, min, max, nominal, description)) in rows.iter().enumerate() {
        table.push(Variable {
            name: (*name).into(),
            description: (*description).into(),
            role: role(i),
            is: Type::Real,
            quantity,
            variability,
            min: *min,
            max: *max,
            nominal: *nominal,
        });
    }
}

/// The effects that an FMU has: all but those on a record of the stroke, as here the stroke is the true one. Of an effect
/// that is a table its numbers are variables; what the table is of is the model's, and stays.
pub fn effects_here() -> impl Iterator<Item = (usize, &'static Card)> {
    effects::all().filter(|(_, card)| card.acts_on != ActsOn::RecordedStroke)
}

/// Whether an FMU can have an effect with these parameters.
///
/// # Errors
/// The reason why not, as a sentence.
pub fn exported(card: &Card, values: &[f64]) -> Result<(), String> {
    if card.name != Empirical::CARD.name {
        return Ok(());
    }
    match Curve::of(values) {
        Some(Curve { balance: Balance::VolumeShare, .. }) => {
            Err("its empirical term is a share of the volume, and an FMU's volume is that of its position".to_owned())
        }
        _ => Ok(()),
    }
}

fn effect_parameters(table: &mut Vec<Variable>) {
    for (index, card) in effects_here() {
        for (i, p) in card.parameters.iter().enumerate().filter(|(_, p)| p.is_variable()) {
            table.push(Variable {
                name: parameter_name(card, p),
                description: p.doc.into(),
                role: Role::Parameter(BASE + effects::PARAMETER_OFFSETS[index] + i),
                is: Type::Real,
                quantity: units::of_card(p.unit),
                variability: Variability::Tunable,
                min: Some(*p.bounds.start()),
                max: Some(*p.bounds.end()),
                nominal: p.typical.abs(),
            });
        }
    }
}

/// A parameter's structured name: `leakage.conductance`, `empirical.values[1]`.
pub fn parameter_name(card: &Card, parameter: &Parameter) -> String {
    let name = format!("{}.{}", camel(card.name), camel(parameter.name));
    match parameter.kind {
        Kind::Place { index, .. } => format!("{name}[{}]", index + 1),
        Kind::Number | Kind::Word(_) => name,
    }
}

fn states(table: &mut Vec<Variable>) {
    let mut own: Vec<(String, String, &'static Quantity, f64)> = Vec::new();
    for (_, card) in effects::all() {
        for s in card.states {
            let name = format!("{}.{}", camel(card.name), camel(s.name));
            own.push((name, s.doc.into(), units::of_card(s.unit), s.nominal));
        }
    }
    let travel = "Travel of the piston since the start: the integral of its velocity";
    own.push(("travel".into(), travel.into(), &units::LENGTH, 0.1));
    let mut continuous = |name: String, description: String, role, quantity: &'static Quantity, nominal| {
        table.push(Variable {
            name,
            description,
            role,
            is: Type::Real,
            quantity,
            variability: Variability::Continuous,
            min: None,
            max: None,
            nominal,
        });
    };
    for (state, (name, description, quantity, nominal)) in (ENERGY + 1..STATES).chain([TRAVEL]).zip(own) {
        continuous(name, description, Role::State(state), quantity, nominal);
    }
    for state in 0..ALL {
        let role = role_of_state(state);
        let Some(of) = table.iter().find(|v| v.role == role) else { continue };
        let (name, quantity) = (of.name.clone(), units::rate_of(of.quantity));
        table.push(Variable {
            name: format!("der({name})"),
            description: format!("Rate of {name}"),
            role: Role::Rate(state),
            is: Type::Real,
            quantity,
            variability: Variability::Continuous,
            min: None,
            max: None,
            nominal: quantity.nominal,
        });
    }
}

/// `wall_heating` as `wallHeating`.
pub fn camel(snake: &str) -> String {
    let mut out = String::with_capacity(snake.len());
    let mut raise = false;
    for c in snake.chars() {
        match c {
            '_' => raise = true,
            c if raise => {
                out.extend(c.to_uppercase());
                raise = false;
            }
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_each_role_has_one_variable() {
        let names: std::collections::HashSet<_> = table().iter().map(|v| &v.name).collect();
        assert_eq!(names.len(), table().len());
        for v in table() {
            assert_eq!(table().iter().filter(|w| w.role == v.role).count(), 1, "{}", v.name);
        }
        assert!(names.contains(&"wallHeating.outerConductance".to_owned()));
        assert!(names.contains(&"leakage.criticalPressureRatio".to_owned()));
    }

    #[test]
    fn start_values_lie_within_their_bounds() {
        let starts = Starts::default();
        for v in table() {
            assert!(settable(&starts, v.role).is_none_or(|start| v.admits(start)), "{}", v.name);
            assert!(v.nominal > 0.0, "{}", v.name);
        }
    }

    #[test]
    fn real_parameters_stand_in_the_order_of_their_places() {
        let parameters: Vec<_> =
            table().iter().filter_map(|v| if let Role::Parameter(i) = v.role { Some(i) } else { None }).collect();
        let offsets = effects::PARAMETER_OFFSETS;
        let no_variable = |i: usize| {
            let effect = offsets.partition_point(|offset| *offset <= i) - 1;
            effects::of_recorded_stroke().has(effect)
                || !effects::CARDS[effect].parameters[i - offsets[effect]].is_variable()
        };
        let expected = (0..crate::plant::values::REALS).filter(|i| !i.checked_sub(BASE).is_some_and(no_variable));
        assert_eq!(parameters, expected.collect::<Vec<_>>());
    }

    #[test]
    fn every_state_is_a_variable_with_a_rate() {
        for state in 0..ALL {
            assert!(place_of_state(state).is_some() && place(Role::Rate(state)).is_some(), "{state}");
            assert_eq!(state_of_role(role_of_state(state)), Some(state));
        }
    }
}
