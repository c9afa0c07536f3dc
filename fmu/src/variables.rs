//! The one table of variables: the chamber's by hand, the effects' from their cards. A variable's value reference is its
//! place in the table. Model description, getters, setters, saved states and derivatives all read this table.

use crate::units::{self, Quantity};
use chamber::balance::STATES;
use chamber::effects::{self, EffectValues, PARAMETERS};
use chamber::real::Real;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer, paper};
use std::sync::LazyLock;

/// Number of inputs.
pub const INPUTS: usize = 7;
/// Places among the inputs.
#[allow(missing_docs)]
pub mod input {
    pub const POSITION: usize = 0;
    pub const VELOCITY: usize = 1;
    pub const MASS_FLOW_IN: usize = 2;
    pub const TEMPERATURE_IN: usize = 3;
    pub const MASS_FLOW_OUT: usize = 4;
    pub const AMBIENT_TEMPERATURE: usize = 5;
    pub const AMBIENT_PRESSURE: usize = 6;
}

/// Number of outputs.
pub const OUTPUTS: usize = 8;
/// Places among the outputs.
#[allow(missing_docs)]
pub mod output {
    pub const PRESSURE: usize = 0;
    pub const MEASURED_PRESSURE: usize = 1;
    pub const TEMPERATURE: usize = 2;
    pub const MASS: usize = 3;
    pub const VOLUME: usize = 4;
    pub const FORCE: usize = 5;
    pub const HEAT_FLOW: usize = 6;
    pub const COEFFICIENT: usize = 7;
}

/// Number of the chamber's own real parameters.
pub const BASE: usize = 10;
/// Number of real parameters, the effects' included.
pub const REALS: usize = BASE + PARAMETERS;
/// Places among the real parameters; the effects' follow from [`BASE`] on in their cards' order.
#[allow(missing_docs)]
pub mod parameter {
    pub const BORE: usize = 0;
    pub const ROD_DIAMETER: usize = 1;
    pub const DEAD_VOLUME: usize = 2;
    pub const INITIAL_PRESSURE: usize = 3;
    pub const INITIAL_TEMPERATURE: usize = 4;
    pub const LAMBDA0: usize = 5;
    pub const REFERENCE_PRESSURE: usize = 6;
    pub const REFERENCE_TEMPERATURE: usize = 7;
    pub const GAS_CONSTANT: usize = 8;
    pub const HEAT_CAPACITY_RATIO: usize = 9;
}

/// What a variable stands for; indices are places among its like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A continuous input.
    Input(usize),
    /// A continuous output.
    Output(usize),
    /// A real parameter.
    Parameter(usize),
    /// The one enumeration: which area counts in the heat transfer.
    AreaLaw,
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

/// One variable of the FMU.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Structured name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// What it stands for.
    pub role: Role,
    /// Its unit and kind.
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

/// Place of the variable that is the continuous state of that index: an output for the mass.
pub fn place_of_state(state: usize) -> Option<usize> {
    place(if state == chamber::balance::MASS { Role::Output(output::MASS) } else { Role::State(state) })
}

/// Real parameters and the area law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<R = f64> {
    /// Real parameters, see [`parameter`].
    pub real: [R; REALS],
    /// Which volume's lateral area exchanges heat.
    pub area_law: AreaLaw,
}

impl<R: Real> Parameters<R> {
    /// The chamber with these parameters.
    pub fn chamber(&self) -> Chamber<R> {
        let p = &self.real;
        Chamber {
            gas: Gas {
                gas_constant: p[parameter::GAS_CONSTANT],
                heat_capacity_ratio: p[parameter::HEAT_CAPACITY_RATIO],
            },
            geometry: Geometry::new(
                p[parameter::BORE],
                p[parameter::ROD_DIAMETER],
                p[parameter::DEAD_VOLUME],
                self.area_law,
            ),
            heat_transfer: HeatTransfer {
                coefficient: p[parameter::LAMBDA0],
                reference_pressure: p[parameter::REFERENCE_PRESSURE],
                reference_temperature: p[parameter::REFERENCE_TEMPERATURE],
            },
            effects: EffectValues(core::array::from_fn(|i| p[BASE + i])),
        }
    }

    /// The same in another number type.
    pub fn lift<S: Real + From<R>>(&self) -> Parameters<S> {
        Parameters { real: self.real.map(S::from), area_law: self.area_law }
    }
}

/// Start values of all that a host can set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Starts {
    /// Parameters.
    pub parameters: Parameters,
    /// Inputs.
    pub inputs: [f64; INPUTS],
}

impl Default for Starts {
    /// The reference chamber: a small cylinder (bore 20 mm) at ambient state, with the paper's coefficient.
    fn default() -> Self {
        let mut real = [0.0; REALS];
        real[parameter::BORE] = 0.02;
        real[parameter::DEAD_VOLUME] = 2e-6;
        real[parameter::INITIAL_PRESSURE] = 101_325.0;
        real[parameter::INITIAL_TEMPERATURE] = 293.15;
        real[parameter::LAMBDA0] = 26.5;
        real[parameter::REFERENCE_PRESSURE] = paper::REFERENCE_PRESSURE_PA;
        real[parameter::REFERENCE_TEMPERATURE] = paper::REFERENCE_TEMPERATURE_K;
        real[parameter::GAS_CONSTANT] = Gas::AIR.gas_constant;
        real[parameter::HEAT_CAPACITY_RATIO] = Gas::AIR.heat_capacity_ratio;
        real[BASE..].copy_from_slice(&EffectValues::NEUTRAL.0);
        Self {
            parameters: Parameters { real, area_law: AreaLaw::Total },
            inputs: [0.1, 0.0, 0.0, 293.15, 0.0, 293.15, 101_325.0],
        }
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
            "Distance of the piston face from the chamber's end; the volume at a communication point is that of this position",
        ),
        Row(
            "velocity",
            &units::VELOCITY,
            None,
            None,
            0.1,
            "Speed of the piston, positive where the chamber grows; moves the position within a step unless the host sets the position's derivative",
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
            "Temperature of the surroundings, and of the wall unless wallHeating is on",
        ),
        Row(
            "ambientPressure",
            &units::PRESSURE,
            Some(0.0),
            Some(1e9),
            1e5,
            "Absolute pressure of the surroundings: on the other side of a leak, and what force is counted against",
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
            "What the pressure sensor shows: lag, delay and drift included",
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
    ];
    push(table, &rows, Variability::Continuous, Role::Output);
}

fn base_parameters(table: &mut Vec<Variable>) {
    let fixed: [Row; 5] = [
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
    ];
    push(table, &fixed, Variability::Fixed, Role::Parameter);
    let tunable: [Row; 3] = [
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
    table.push(Variable {
        name: "areaLaw".into(),
        description: "Lateral area that exchanges heat: of all the gas's volume, or of the swept length only".into(),
        role: Role::AreaLaw,
        quantity: &units::DIMENSIONLESS,
        variability: Variability::Fixed,
        min: Some(1.0),
        max: Some(2.0),
        nominal: 1.0,
    });
}

fn push(table: &mut Vec<Variable>, rows: &[Row], variability: Variability, role: impl Fn(usize) -> Role) {
    for (i, Row(name, quantity, min, max, nominal, description)) in rows.iter().enumerate() {
        table.push(Variable {
            name: (*name).into(),
            description: (*description).into(),
            role: role(i),
            quantity,
            variability,
            min: *min,
            max: *max,
            nominal: *nominal,
        });
    }
}

fn effect_parameters(table: &mut Vec<Variable>) {
    for (index, card) in effects::all() {
        for (i, p) in card.parameters.iter().enumerate() {
            table.push(Variable {
                name: format!("{}.{}", camel(card.name), camel(p.name)),
                description: p.doc.into(),
                role: Role::Parameter(BASE + effects::PARAMETER_OFFSETS[index] + i),
                quantity: units::of_card(p.unit),
                variability: Variability::Tunable,
                min: Some(*p.bounds.start()),
                max: Some(*p.bounds.end()),
                nominal: p.typical.abs(),
            });
        }
    }
}

fn states(table: &mut Vec<Variable>) {
    let mut all: Vec<(String, String, &'static Quantity, f64)> = vec![
        ("mass".into(), "the mass of the gas".into(), &units::MASS, 1e-3),
        ("internalEnergy".into(), "Internal energy of the gas".into(), &units::ENERGY, 10.0),
    ];
    for (_, card) in effects::all() {
        for s in card.states {
            let name = format!("{}.{}", camel(card.name), camel(s.name));
            all.push((name, s.doc.into(), units::of_card(s.unit), s.nominal));
        }
    }
    debug_assert_eq!(all.len(), STATES);
    for (i, (name, description, quantity, nominal)) in all.iter().enumerate().skip(1) {
        let (name, description) = (name.clone(), description.clone());
        let variability = Variability::Continuous;
        table.push(Variable {
            name,
            description,
            role: Role::State(i),
            quantity,
            variability,
            min: None,
            max: None,
            nominal: *nominal,
        });
    }
    for (i, (name, _, quantity, _)) in all.iter().enumerate() {
        let quantity = units::rate_of(quantity);
        table.push(Variable {
            name: format!("der({name})"),
            description: format!("Rate of {name}"),
            role: Role::Rate(i),
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
            match v.role {
                Role::Input(i) => assert!(v.admits(starts.inputs[i]), "{}", v.name),
                Role::Parameter(i) => assert!(v.admits(starts.parameters.real[i]), "{}", v.name),
                _ => {}
            }
            assert!(v.nominal > 0.0, "{}", v.name);
        }
    }

    #[test]
    fn real_parameters_stand_in_the_order_of_their_places() {
        let parameters: Vec<_> =
            table().iter().filter_map(|v| if let Role::Parameter(i) = v.role { Some(i) } else { None }).collect();
        assert_eq!(parameters, (0..REALS).collect::<Vec<_>>());
    }
}
