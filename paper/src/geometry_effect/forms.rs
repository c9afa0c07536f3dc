//! The forms of λ fitted to the six measured points. Adding one takes a line of [`FORMS`].
//!
//! λ = c · Π quantity^exponent, c in W/(m² K) at the quantities' reference values; a form's exponents are fixed or fitted.

use super::point::Point;

/// A quantity whose powers a form may contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// P over 5.65 bar.
    Pressure,
    /// T over 293 K.
    Temperature,
    /// T − Tamb over 10 K.
    Excess,
    /// Gas column length over 0.1 m.
    Column,
    /// V/Aq over 5 mm.
    VolumeToArea,
    /// Bore over 25 mm.
    Bore,
    /// V over 1e-4 m³.
    Volume,
    /// Aq over 0.01 m².
    Area,
    /// Gas column length over bore.
    Slenderness,
}

use Quantity::{Area, Bore, Column, Excess, Pressure, Slenderness, Temperature, Volume, VolumeToArea};

/// Reference length of the fitted coefficient, m: the default of the effect `gas_column_length`.
pub const REFERENCE_LENGTH_M: f64 = 0.1;

impl Quantity {
    pub(super) fn of(self, p: &Point) -> f64 {
        match self {
            Pressure => p.pressure_pa / chamber::paper::REFERENCE_PRESSURE_PA,
            Temperature => p.temperature_k / chamber::paper::REFERENCE_TEMPERATURE_K,
            Excess => p.excess_k / 10.0,
            Column => p.column_m / REFERENCE_LENGTH_M,
            VolumeToArea => p.volume_m3 / p.area_m2 / 5e-3,
            Bore => p.bore_m / 0.025,
            Volume => p.volume_m3 / 1e-4,
            Area => p.area_m2 / 0.01,
            Slenderness => p.column_m / p.bore_m,
        }
    }
}

/// A product of powers, as (quantity, exponent).
pub(super) type Powers = &'static [(Quantity, f64)];

/// A form of λ: a coefficient, fixed powers, and products of powers whose common exponent is fitted.
#[derive(Clone, Copy, Debug)]
pub struct Form {
    /// Name of the form in tables and figures.
    pub name: &'static str,
    /// λ as a formula.
    pub equation: &'static str,
    pub(super) fixed: Powers,
    pub(super) free: &'static [(&'static str, Powers)],
    /// Whether each actuator has its own coefficient instead of a common one.
    pub(super) per_actuator: bool,
    /// Whether side wall and end faces have different coefficients, whose ratio is fitted.
    pub(super) faces: bool,
}

const PT: Powers = &[(Pressure, 1.0), (Temperature, 1.0)];
const SQRT_PT: Powers = &[(Pressure, 0.5), (Temperature, 0.5)];

const fn form(
    name: &'static str,
    equation: &'static str,
    fixed: Powers,
    free: &'static [(&'static str, Powers)],
) -> Form {
    Form { name, equation, fixed, free, per_actuator: false, faces: false }
}

/// Name of the baseline.
pub const ONE_LAMBDA0: &str = "one lambda0";
/// Name of the form used by the sweep of table 5's trend.
pub const COLUMN_HALF: &str = "column length^-1/2";

/// All forms tried.
pub const FORMS: &[Form] = &[
    form(ONE_LAMBDA0, "c sqrt(PT)", SQRT_PT, &[]),
    form("free pressure exponent", "c (PT)^n", &[], &[("n", PT)]),
    form(
        "volume/area^-1/2",
        "c sqrt(PT) (V/A)^-1/2",
        &[(Pressure, 0.5), (Temperature, 0.5), (VolumeToArea, -0.5)],
        &[],
    ),
    form("volume/area^-1", "c sqrt(PT) (V/A)^-1", &[(Pressure, 0.5), (Temperature, 0.5), (VolumeToArea, -1.0)], &[]),
    form("volume/area", "c sqrt(PT) (V/A)^a", SQRT_PT, &[("a", &[(VolumeToArea, 1.0)])]),
    form("volume/area, free pressure exponent", "c (PT)^n (V/A)^a", &[], &[("n", PT), ("a", &[(VolumeToArea, 1.0)])]),
    form(COLUMN_HALF, "c sqrt(PT) l^-1/2", &[(Pressure, 0.5), (Temperature, 0.5), (Column, -0.5)], &[]),
    form("column length^-1", "c sqrt(PT) l^-1", &[(Pressure, 0.5), (Temperature, 0.5), (Column, -1.0)], &[]),
    form("column length", "c sqrt(PT) l^a", SQRT_PT, &[("a", &[(Column, 1.0)])]),
    form("column length^-1/2, free pressure exponent", "c (PT)^n l^-1/2", &[(Column, -0.5)], &[("n", PT)]),
    form("column length, free pressure exponent", "c (PT)^n l^a", &[], &[("n", PT), ("a", &[(Column, 1.0)])]),
    form("column length^-1/2, pressure only", "c P^1/2 l^-1/2", &[(Pressure, 0.5), (Column, -0.5)], &[]),
    form("bore", "c sqrt(PT) phi^a", SQRT_PT, &[("a", &[(Bore, 1.0)])]),
    form("bore^-1", "c sqrt(PT) phi^-1", &[(Pressure, 0.5), (Temperature, 0.5), (Bore, -1.0)], &[]),
    form("volume", "c sqrt(PT) V^a", SQRT_PT, &[("a", &[(Volume, 1.0)])]),
    form("volume^-1/3", "c sqrt(PT) V^-1/3", &[(Pressure, 0.5), (Temperature, 0.5), (Volume, -1.0 / 3.0)], &[]),
    form("area", "c sqrt(PT) A^a", SQRT_PT, &[("a", &[(Area, 1.0)])]),
    form("area^-1/2", "c sqrt(PT) A^-1/2", &[(Pressure, 0.5), (Temperature, 0.5), (Area, -0.5)], &[]),
    form("slenderness", "c sqrt(PT) (l/phi)^a", SQRT_PT, &[("a", &[(Slenderness, 1.0)])]),
    form(
        "slenderness^-1/2",
        "c sqrt(PT) (l/phi)^-1/2",
        &[(Pressure, 0.5), (Temperature, 0.5), (Slenderness, -0.5)],
        &[],
    ),
    form("column length and bore", "c sqrt(PT) l^a phi^b", SQRT_PT, &[("a", &[(Column, 1.0)]), ("b", &[(Bore, 1.0)])]),
    form(
        "laminar natural convection, column",
        "c (P^2 dT/l)^1/4",
        &[(Pressure, 0.5), (Excess, 0.25), (Column, -0.25)],
        &[],
    ),
    form(
        "laminar natural convection, bore",
        "c (P^2 dT/phi)^1/4",
        &[(Pressure, 0.5), (Excess, 0.25), (Bore, -0.25)],
        &[],
    ),
    form("turbulent natural convection", "c (P^2 dT)^1/3", &[(Pressure, 2.0 / 3.0), (Excess, 1.0 / 3.0)], &[]),
    form("conduction along the column", "c l^-1", &[(Column, -1.0)], &[]),
    Form { faces: true, ..form("side wall and end faces apart", "c sqrt(PT) (A_side + w A_faces)/A", SQRT_PT, &[]) },
    Form { per_actuator: true, ..form("own lambda0 for each actuator", "c_i sqrt(PT)", SQRT_PT, &[]) },
    Form {
        per_actuator: true,
        ..form("own lambda0 for each actuator, free pressure exponent", "c_i (PT)^n", &[], &[("n", PT)])
    },
];
