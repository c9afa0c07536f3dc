//! The chamber's own real variables, listed by hand: inputs, outputs and parameters with unit, bounds and meaning, in the order
//! of their indices in [`crate::plant::values`].

use super::units::{self, Quantity};
use super::variable::{Role, Type, Variability, Variable};
use crate::plant::values::{INPUTS, OUTPUTS, parameter};

/// A real variable: name, quantity, minimum, maximum, order of magnitude, meaning.
struct Row(&'static str, &'static Quantity, Option<f64>, Option<f64>, f64, &'static str);

/// Appends the inputs: motion of the piston, flows, surroundings, in the order of their references.
#[rustfmt::skip]
pub(super) fn inputs(table: &mut Vec<Variable>) {
    let rows: [Row; INPUTS] = [
        Row("position", &units::LENGTH, None, None, 0.1, "Distance of the piston face from the end of the chamber; the volume follows from it. If strokeInput is velocity, only the start value is used"),
        Row("velocity", &units::VELOCITY, None, None, 0.1, "Velocity of the piston, positive when the chamber grows; moves the position within a step unless the host sets the derivative of position"),
        Row("massFlowIn", &units::MASS_FLOW, None, None, 1e-3, "Mass flow into the chamber at temperatureIn; where negative it leaves at the gas's temperature"),
        Row("temperatureIn", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the gas that enters"),
        Row("massFlowOut", &units::MASS_FLOW, None, None, 1e-3, "Mass flow out of the chamber at the gas's temperature; where negative it enters at temperatureIn"),
        Row("ambientTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the surroundings, and of the wall unless externalWall, wallHeating, warmWall or wallConduction is on"),
        Row("ambientPressure", &units::PRESSURE, Some(0.0), Some(1e9), 1e5, "Absolute pressure of the surroundings: the pressure outside a leak, and the zero of force"),
        Row("wallTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the wall if externalWall is true; otherwise not used"),
        Row("supplyPortPressure", &units::PRESSURE, Some(0.0), Some(1e9), 1e5, "Absolute pressure on the other side of the supply port"),
        Row("supplyPortTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the gas on the other side of the supply port"),
        Row("supplyPortConductance", &units::SONIC_CONDUCTANCE, Some(0.0), Some(1e-6), 1e-8, "Sonic conductance of the supply port (ISO 6358); zero closes it"),
        Row("exhaustPortPressure", &units::PRESSURE, Some(0.0), Some(1e9), 1e5, "Absolute pressure on the other side of the exhaust port"),
        Row("exhaustPortTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the gas on the other side of the exhaust port"),
        Row("exhaustPortConductance", &units::SONIC_CONDUCTANCE, Some(0.0), Some(1e-6), 1e-8, "Sonic conductance of the exhaust port (ISO 6358); zero closes it"),
    ];
    push(table, &rows, Variability::Continuous, Role::Input);
}

/// Appends the outputs: state of the gas, flows of the ports, sums since the start, in the order of their references.
#[rustfmt::skip]
pub(super) fn outputs(table: &mut Vec<Variable>) {
    let rows: [Row; OUTPUTS] = [
        Row("pressure", &units::PRESSURE, Some(0.0), None, 1e5, "Absolute pressure of the gas"),
        Row("measuredPressure", &units::PRESSURE_READING, None, None, 1e5, "Reading of the pressure sensor, with lag, delay, offset and drift"),
        Row("temperature", &units::TEMPERATURE, Some(0.0), None, 300.0, "Mean temperature of the gas"),
        Row("mass", &units::MASS, Some(0.0), None, 1e-4, "Mass of the gas"),
        Row("volume", &units::VOLUME, Some(0.0), None, 1e-5, "Volume of the gas, dead volume included"),
        Row("force", &units::FORCE, None, None, 100.0, "Force of the gas on the piston face against ambientPressure"),
        Row("heatFlow", &units::POWER, None, None, 10.0, "Heat flow into the gas"),
        Row("heatTransferCoefficient", &units::HEAT_TRANSFER, Some(0.0), None, 30.0, "Heat transfer coefficient between gas and wall at the present state"),
        Row("pistonPosition", &units::LENGTH, None, None, 0.1, "Position of the piston, limited to its stroke"),
        Row("supplyPortMassFlow", &units::MASS_FLOW, None, None, 1e-3, "Mass flow through the supply port into the chamber; under co-simulation its mean over the last step"),
        Row("supplyPortEnthalpyFlow", &units::ENERGY_FLOW, None, None, 300.0, "Enthalpy flow through the supply port into the chamber, cp T of each mass; the mean as for the mass flow"),
        Row("exhaustPortMassFlow", &units::MASS_FLOW, None, None, 1e-3, "Mass flow through the exhaust port into the chamber; under co-simulation its mean over the last step"),
        Row("exhaustPortEnthalpyFlow", &units::ENERGY_FLOW, None, None, 300.0, "Enthalpy flow through the exhaust port into the chamber, cp T of each mass; the mean as for the mass flow"),
        Row("internalEnergy", &units::ENERGY, Some(0.0), None, 10.0, "Internal energy of the gas"),
        Row("heatReceived", &units::ENERGY_CHANGE, None, None, 10.0, "Heat received by the gas since the start"),
        Row("workDone", &units::ENERGY_CHANGE, None, None, 10.0, "Work of the gas on the piston since the start"),
        Row("enthalpyReceived", &units::ENERGY_CHANGE, None, None, 10.0, "Enthalpy received with flows since the start: the change of internalEnergy minus heatReceived plus workDone"),
        Row("massReceived", &units::MASS_CHANGE, None, None, 1e-4, "Mass received with flows since the start"),
    ];
    push(table, &rows, Variability::Continuous, Role::Output);
}

/// The numerical parameters.
#[rustfmt::skip]
pub(super) fn parameters(table: &mut Vec<Variable>) {
    let fixed: [Row; 6] = [
        Row("bore", &units::LENGTH, Some(1e-4), Some(100.0), 0.02, "Bore of the cylinder"),
        Row("rodDiameter", &units::LENGTH, Some(0.0), Some(100.0), 0.01, "Diameter of a rod that runs through this chamber; zero on the cap side"),
        Row("deadVolume", &units::VOLUME, Some(0.0), Some(1e3), 1e-6, "Volume of the gas at position zero"),
        Row("initialPressure", &units::PRESSURE, Some(1.0), Some(1e9), 1e5, "Absolute pressure of the gas at the start"),
        Row("initialTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature of the gas at the start"),
        Row("stroke", &units::LENGTH, Some(0.0), Some(100.0), 0.1, "Length of the stroke, which limits the position from below (0) and above; zero means no limits"),
    ];
    push(table, &fixed, Variability::Fixed, Role::Parameter);
    let tunable: [Row; 5] = [
        Row("lambda0", &units::HEAT_TRANSFER, Some(0.0), Some(1e6), 30.0, "Heat transfer coefficient at the reference state"),
        Row("referencePressure", &units::PRESSURE, Some(1.0), Some(1e9), 1e5, "Pressure at which the heat transfer coefficient is lambda0"),
        Row("referenceTemperature", &units::TEMPERATURE, Some(1.0), Some(1e5), 300.0, "Temperature at which the heat transfer coefficient is lambda0"),
        Row("supplyPortCriticalRatio", &units::DIMENSIONLESS, Some(0.0), Some(0.9), 0.3, "Critical pressure ratio of the supply port (ISO 6358)"),
        Row("exhaustPortCriticalRatio", &units::DIMENSIONLESS, Some(0.0), Some(0.9), 0.3, "Critical pressure ratio of the exhaust port (ISO 6358)"),
    ];
    push(table, &tunable, Variability::Tunable, |i| Role::Parameter(parameter::LAMBDA0 + i));
    let gas: [Row; 2] = [
        Row("gasConstant", &units::GAS_CONSTANT, Some(1.0), Some(1e5), 300.0, "Specific gas constant"),
        Row("heatCapacityRatio", &units::DIMENSIONLESS, Some(1.001), Some(5.0), 1.0, "Ratio of the heat capacities at constant pressure and constant volume"),
    ];
    push(table, &gas, Variability::Fixed, |i| Role::Parameter(parameter::GAS_CONSTANT + i));
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
