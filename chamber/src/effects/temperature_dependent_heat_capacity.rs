//! Temperature-dependent heat capacity: cv grows linearly with temperature, as that of real diatomic gases does.
//!
//! cv(T) = cv (1 + s (T − 293 K)),  U = m ∫ cv dT = m cv (T + s (T²/2 − 293 K · T)),  cp(T) = cv(T) + R
//! s in 1/K; R/(γ − 1) is cv at 293 K. T follows from U by a quadratic equation, P = m R T/V.
//! h(T) = u(T) + R T of each flow. Beside gas zones both zones have the heat capacity of the mean temperature.
//! Source: NIST-JANAF thermochemical tables, slope between 300 and 400 K, see [`Gas::heat_capacity_slope`].

use super::Effect;
use crate::card::{Balance, Card, Normal, Parameter, Prior, Unit};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows};
use crate::real::Real;

/// T at which cv is R/(γ − 1), K.
const REFERENCE_TEMPERATURE_K: f64 = 293.0;

/// Linear heat capacity.
pub struct TemperatureDependentHeatCapacity;

/// The slope that tables give for the gas, known to a fifth of itself; for an unknown gas any that gases have.
fn slope_of(gas: &Gas) -> Normal {
    match gas.heat_capacity_slope() {
        Some(slope) => Normal { mean: slope, standard_deviation: (0.2 * slope).max(1e-5) },
        None => Normal { mean: 0.0, standard_deviation: 5e-4 },
    }
}

/// T over U/(m cv), and cv(T) over cv, where U/(m cv) is `by_energy`, K.
#[inline(always)]
fn solved<R: Real>(slope: R, by_energy: R) -> (R, R) {
    // U/(m cv) = T + s (T²/2 − 293 K · T), in the form that s = 0 leaves exact; the root is 1 + s (T − 293 K).
    let linear = R::ONE - slope * REFERENCE_TEMPERATURE_K;
    let root = (linear * linear + slope * by_energy * 2.0).sqrt();
    (R::from(2.0) / (linear + root), root)
}

impl Effect for TemperatureDependentHeatCapacity {
    const CARD: Card = Card {
        name: "temperature_dependent_heat_capacity",
        doc: "The gas's heat capacity grows with its temperature",
        equation: "cv(T) = cv (1 + s (T - 293 K)), U = m integral cv dT",
        source: "NIST-JANAF thermochemical tables",
        balance: Balance::Energy,
        parameters: &[Parameter {
            name: "slope",
            unit: Unit::PerKelvin,
            bounds: -5e-4..=3e-3,
            typical: 1.2e-4,
            prior: Prior::OfGas(slope_of),
            doc: "Relative slope s of the heat capacity at constant volume; 1.2e-4 for air",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    const CALORIC: bool = true;

    #[inline(always)]
    fn internal_energy<R: Real>(p: &[R], temperature: R) -> R {
        p[0] * (temperature * 0.5 - REFERENCE_TEMPERATURE_K) + 1.0
    }

    #[inline(always)]
    fn temperature<R: Real>(p: &[R], by_energy: R) -> R {
        by_energy * solved(p[0], by_energy).0
    }

    #[inline(always)]
    fn gas_properties<R: Real>(p: &[R], at: &mut Conditions<R>) {
        let (rise, capacity) = solved(p[0], at.temperature);
        let temperature = at.temperature * rise;
        at.pressure = at.pressure * rise;
        at.eichelberg = at.eichelberg * rise;
        at.energy = at.energy * rise * capacity;
        at.per_energy = at.per_energy / (rise * capacity);
        at.temperature = temperature;
        at.gas_temperature_at_wall = temperature;
        at.cv = at.cv * capacity;
        at.cp = at.cv + at.gas_constant;
        at.per_expansion = at.per_expansion * capacity;
        at.expansion = at.expansion / capacity;
        at.heat_capacity_ratio = at.expansion + 1.0;
    }

    #[inline(always)]
    fn excess_enthalpy<R: Real>(p: &[R], at: &Conditions<R>, flows: &Flows<R>) -> [R; 2] {
        // With c = cv s at 293 K: h(Tx) − cp(T) Tx = c (Tx²/2 − T Tx), and u(T) − cv(T) T = −c T²/2.
        let capacity = p[0] * (at.temperature - REFERENCE_TEMPERATURE_K) + 1.0;
        let half = at.cv * p[0] / capacity * 0.5;
        let square = at.temperature * at.temperature;
        let of_inflow = flows.inflow_square_kelvin - at.temperature * flows.inflow_kelvin * 2.0;
        [half * (of_inflow + flows.outflow * square), half * (of_inflow + flows.inflow * square)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_named_gas_has_the_slope_of_its_kind_of_molecule() {
        let of = |name: &str| slope_of(&Gas::named(name).unwrap()).mean;
        assert_eq!((of("argon"), of("helium")), (0.0, 0.0));
        assert!(of("air") > of("nitrogen") && of("oxygen") > of("air") && of("carbon_dioxide") > 1e-3);
    }
}
