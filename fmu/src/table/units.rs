//! Units with base and display units, and the physical quantities of the variables.

use chamber::card;

/// A unit of the model description.
pub struct Unit {
    /// Name used by variables.
    pub name: &'static str,
    /// Exponents of SI base units; `None` if not integers.
    pub base: Option<&'static [(&'static str, i32)]>,
    /// Display units: display = factor · value + offset.
    pub displays: &'static [Display],
}

/// A display unit.
pub struct Display {
    /// Name of the unit.
    pub name: &'static str,
    /// Factor on the value in the base unit.
    pub factor: f64,
    /// Offset added after the factor.
    pub offset: f64,
}

const fn display(name: &'static str, factor: f64) -> Display {
    Display { name, factor, offset: 0.0 }
}

/// Density of air at ISO 8778's reference conditions (20 °C, 1 bar, 65 % humidity), kg/m³, which defines l/min(ANR), here for
/// air.
const REFERENCE_DENSITY: f64 = 1.185;

/// All units of the variables.
pub const UNITS: &[Unit] = &[
    Unit { name: "1", base: Some(&[]), displays: &[display("%", 100.0)] },
    Unit { name: "s", base: Some(&[("s", 1)]), displays: &[display("ms", 1e3)] },
    Unit { name: "m", base: Some(&[("m", 1)]), displays: &[display("mm", 1e3), display("cm", 1e2)] },
    Unit { name: "m/s", base: Some(&[("m", 1), ("s", -1)]), displays: &[display("mm/s", 1e3)] },
    Unit { name: "m/s2", base: Some(&[("m", 1), ("s", -2)]), displays: &[] },
    Unit { name: "m2", base: Some(&[("m", 2)]), displays: &[display("cm2", 1e4)] },
    Unit {
        name: "m3",
        base: Some(&[("m", 3)]),
        displays: &[display("cm3", 1e6), display("ml", 1e6), display("l", 1e3)],
    },
    Unit {
        name: "Pa",
        base: Some(&[("kg", 1), ("m", -1), ("s", -2)]),
        displays: &[
            display("bar", 1e-5),
            display("kPa", 1e-3),
            display("MPa", 1e-6),
            display("psi", 1.0 / 6894.757293168),
        ],
    },
    Unit {
        name: "Pa/s",
        base: Some(&[("kg", 1), ("m", -1), ("s", -3)]),
        displays: &[display("bar/s", 1e-5), display("kPa/s", 1e-3)],
    },
    Unit { name: "K", base: Some(&[("K", 1)]), displays: &[Display { name: "degC", factor: 1.0, offset: -273.15 }] },
    Unit { name: "K/s", base: Some(&[("K", 1), ("s", -1)]), displays: &[] },
    Unit { name: "1/K", base: Some(&[("K", -1)]), displays: &[] },
    Unit { name: "1/K2", base: Some(&[("K", -2)]), displays: &[] },
    Unit { name: "kg", base: Some(&[("kg", 1)]), displays: &[display("g", 1e3), display("mg", 1e6)] },
    Unit {
        name: "kg/s",
        base: Some(&[("kg", 1), ("s", -1)]),
        displays: &[display("g/s", 1e3), display("l/min(ANR)", 60e3 / REFERENCE_DENSITY)],
    },
    Unit { name: "N", base: Some(&[("kg", 1), ("m", 1), ("s", -2)]), displays: &[display("kN", 1e-3)] },
    Unit { name: "J", base: Some(&[("kg", 1), ("m", 2), ("s", -2)]), displays: &[display("kJ", 1e-3)] },
    Unit { name: "W", base: Some(&[("kg", 1), ("m", 2), ("s", -3)]), displays: &[display("kW", 1e-3)] },
    Unit { name: "J/K", base: Some(&[("kg", 1), ("m", 2), ("s", -2), ("K", -1)]), displays: &[] },
    Unit { name: "W/K", base: Some(&[("kg", 1), ("m", 2), ("s", -3), ("K", -1)]), displays: &[] },
    Unit { name: "W/(m2.K)", base: Some(&[("kg", 1), ("s", -3), ("K", -1)]), displays: &[] },
    Unit { name: "J/(kg.K)", base: Some(&[("m", 2), ("s", -2), ("K", -1)]), displays: &[] },
    Unit {
        name: "m3/(s.Pa)",
        base: Some(&[("kg", -1), ("m", 4), ("s", 1)]),
        displays: &[display("l/(s.bar)", 1e8), display("l/(min.bar)", 6e9)],
    },
    Unit { name: "s/m", base: Some(&[("m", -1), ("s", 1)]), displays: &[] },
    Unit { name: "(s/m)0.8", base: None, displays: &[] },
    Unit { name: "m2.K/(W.s0.5)", base: None, displays: &[] },
];

/// A physical quantity: a type definition of the model description.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    /// Name of the type, and of the quantity as in ISO 31.
    pub name: &'static str,
    /// Unit of the interface values; empty if it differs between models.
    pub unit: &'static str,
    /// Default display unit, if different.
    pub display: Option<&'static str>,
    /// Order of magnitude, unless a variable has its own.
    pub nominal: f64,
    /// Smallest valid value.
    pub min: Option<f64>,
}

const fn quantity(
    name: &'static str,
    unit: &'static str,
    display: Option<&'static str>,
    nominal: f64,
    min: Option<f64>,
) -> Quantity {
    Quantity { name, unit, display, nominal, min }
}

macro_rules! quantities {
    ($($ident:ident = $($argument:expr),+;)*) => {
        $(#[doc = concat!("Quantity ", stringify!($ident), ".")] pub static $ident: Quantity = quantity($($argument),+);)*
        /// All quantities: the type definitions.
        pub static QUANTITIES: &[&Quantity] = &[$(&$ident),*];
    };
}

quantities! {
    DIMENSIONLESS = "Dimensionless", "1", None, 1.0, None;
    TIME = "Time", "s", Some("ms"), 1e-2, Some(0.0);
    LENGTH = "Length", "m", Some("mm"), 0.1, None;
    VELOCITY = "Velocity", "m/s", Some("mm/s"), 0.1, None;
    ACCELERATION = "Acceleration", "m/s2", None, 1.0, None;
    AREA = "Area", "m2", Some("cm2"), 1e-2, None;
    VOLUME = "Volume", "m3", Some("cm3"), 1e-5, Some(0.0);
    PRESSURE = "AbsolutePressure", "Pa", Some("bar"), 1e5, Some(0.0);
    PRESSURE_READING = "PressureReading", "Pa", Some("bar"), 1e5, None;
    PRESSURE_DIFFERENCE = "PressureDifference", "Pa", Some("bar"), 1e3, None;
    PRESSURE_RATE = "PressureRate", "Pa/s", Some("bar/s"), 1e5, None;
    TEMPERATURE = "ThermodynamicTemperature", "K", Some("degC"), 300.0, Some(0.0);
    TEMPERATURE_DIFFERENCE = "TemperatureDifference", "K", None, 10.0, None;
    TEMPERATURE_COEFFICIENT = "LinearTemperatureCoefficient", "1/K", None, 1e-4, None;
    SQUARE_TEMPERATURE_COEFFICIENT = "QuadraticTemperatureCoefficient", "1/K2", None, 1e-6, None;
    TEMPERATURE_RATE = "TemperatureRate", "K/s", None, 100.0, None;
    MASS = "Mass", "kg", Some("g"), 1e-4, Some(0.0);
    MASS_FLOW = "MassFlowRate", "kg/s", Some("g/s"), 1e-3, None;
    FORCE = "Force", "N", None, 100.0, None;
    ENERGY = "InternalEnergy", "J", None, 10.0, Some(0.0);
    ENERGY_CHANGE = "EnergyChange", "J", None, 10.0, None;
    MASS_CHANGE = "MassChange", "kg", Some("g"), 1e-4, None;
    ENERGY_FLOW = "EnthalpyFlowRate", "W", None, 300.0, None;
    POWER = "HeatFlowRate", "W", None, 10.0, None;
    HEAT_CAPACITY = "HeatCapacity", "J/K", None, 1.0, Some(0.0);
    THERMAL_CONDUCTANCE = "ThermalConductance", "W/K", None, 0.1, Some(0.0);
    HEAT_TRANSFER = "CoefficientOfHeatTransfer", "W/(m2.K)", None, 30.0, Some(0.0);
    GAS_CONSTANT = "SpecificHeatCapacity", "J/(kg.K)", None, 300.0, Some(0.0);
    SONIC_CONDUCTANCE = "SonicConductance", "m3/(s.Pa)", Some("l/(s.bar)"), 1e-12, Some(0.0);
    PER_SPEED = "InverseVelocity", "s/m", None, 1.0, Some(0.0);
    SPEED_POWER = "SpeedPower", "(s/m)0.8", None, 1.0, Some(0.0);
    INVERSE_EFFUSIVITY = "InverseEffusivity", "m2.K/(W.s0.5)", None, 1e-3, Some(0.0);
    TABLE_VALUE = "TableValue", "", None, 1.0, None;
}

impl Quantity {
    /// The unit attribute, if there is a unit.
    pub fn unit_attribute(&self) -> Option<(&'static str, String)> {
        (!self.unit.is_empty()).then(|| ("unit", self.unit.into()))
    }
}

/// A unit as written after a number; empty for a dimensionless one.
pub fn unit_suffix(unit: &str) -> String {
    if ["", "1"].contains(&unit) { String::new() } else { format!(" {unit}") }
}

/// The quantity of an effect's parameter or state.
pub fn of_card(unit: card::Unit) -> &'static Quantity {
    match unit {
        card::Unit::One => &DIMENSIONLESS,
        card::Unit::Second => &TIME,
        card::Unit::Metre => &LENGTH,
        card::Unit::SquareMetre => &AREA,
        card::Unit::CubicMetre => &VOLUME,
        card::Unit::Kelvin => &TEMPERATURE,
        card::Unit::KelvinDifference => &TEMPERATURE_DIFFERENCE,
        card::Unit::PerKelvin => &TEMPERATURE_COEFFICIENT,
        card::Unit::PerSquareKelvin => &SQUARE_TEMPERATURE_COEFFICIENT,
        card::Unit::PascalDifference => &PRESSURE_DIFFERENCE,
        card::Unit::Pascal => &PRESSURE,
        card::Unit::PascalPerSecond => &PRESSURE_RATE,
        card::Unit::JoulePerKelvin => &HEAT_CAPACITY,
        card::Unit::WattPerKelvin => &THERMAL_CONDUCTANCE,
        card::Unit::SonicConductance => &SONIC_CONDUCTANCE,
        card::Unit::MetrePerSecond => &VELOCITY,
        card::Unit::SecondPerMetre => &PER_SPEED,
        card::Unit::SpeedPower => &SPEED_POWER,
        card::Unit::InverseEffusivity => &INVERSE_EFFUSIVITY,
        card::Unit::OfTable => &TABLE_VALUE,
    }
}

/// The quantity of a state: the pressure state of a sensor's lag is a reading, which an offset can make negative.
pub fn of_state(unit: card::Unit) -> &'static Quantity {
    match unit {
        card::Unit::Pascal => &PRESSURE_READING,
        other => of_card(other),
    }
}

/// The quantity of the time derivative of a state with this quantity.
pub fn rate_of(quantity: &Quantity) -> &'static Quantity {
    match quantity.unit {
        "kg" => &MASS_FLOW,
        "m" => &VELOCITY,
        "m/s" => &ACCELERATION,
        "J" => &POWER,
        "K" => &TEMPERATURE_RATE,
        "Pa" => &PRESSURE_RATE,
        _ => &DIMENSIONLESS,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_has_a_unit_and_its_display_unit_belongs_to_it() {
        for quantity in QUANTITIES.iter().filter(|q| !q.unit.is_empty()) {
            let unit = UNITS.iter().find(|u| u.name == quantity.unit).unwrap_or_else(|| panic!("{}", quantity.name));
            assert!(quantity.display.is_none_or(|d| unit.displays.iter().any(|e| e.name == d)), "{}", quantity.name);
        }
    }

    #[test]
    fn every_state_s_rate_has_a_quantity_of_its_own() {
        for (_, card) in chamber::effects::all() {
            for state in card.states {
                assert_ne!(rate_of(of_state(state.unit)), &DIMENSIONLESS, "{}.{}", card.name, state.name);
            }
        }
    }
}
