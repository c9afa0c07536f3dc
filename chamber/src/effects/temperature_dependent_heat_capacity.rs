//! Temperature-dependent heat capacity: cv grows with temperature, as that of real diatomic gases does.
//!
//! cv(T) = cv (1 + s (T − T0) + c (T − T0)²),  T0 = 293 K;  U = m ∫ cv dT,  cp(T) = cv(T) + R;  s in 1/K, c in 1/K².
//! R/(γ − 1) is cv at T0. T follows from U by a quadratic equation or, where c is not zero, by Newton's method from its root.
//! Each flow carries h(T) = u(T) + R T. Combined with gas zones, both zones have the heat capacity of the mean temperature.
//! Source: NIST-JANAF thermochemical tables, slope between 300 and 400 K, see [`Gas::heat_capacity_slope`]. Below 300 K cv of air
//! hardly changes: with its molecules as harmonic oscillators (A. Einstein, Ann. Phys. 327 (1907) 180; N₂ at 3393 K, O₂ at 2273
//! K), s = 5.7e-5 1/K and c = 4.7e-7 1/K² fit 230 to 450 K.

use super::Effect;
use crate::card::{Balance, Card, Fitted, Normal, Parameter, Prior, Unit};
use crate::gas::Gas;
use crate::parts::{Conditions, Flows};
use crate::real::Real;

/// T at which cv is R/(γ − 1), K.
const REFERENCE_TEMPERATURE_K: f64 = 293.0;

/// Linear heat capacity.
pub struct TemperatureDependentHeatCapacity;

/// The gas's tabulated slope, with a standard deviation of a fifth of it; for an unknown gas, wide enough for any gas.
fn slope_of(gas: &Gas) -> Normal {
    match gas.heat_capacity_slope() {
        Some(slope) => Normal { mean: slope, standard_deviation: (0.2 * slope).max(1e-5) },
        None => Normal { mean: 0.0, standard_deviation: 5e-4 },
    }
}

/// Zero for a monatomic gas, which has no vibrations; for any other, the range that vibrations can give.
fn curvature_of(gas: &Gas) -> Normal {
    let is_monatomic = gas.heat_capacity_slope() == Some(0.0);
    Normal { mean: 0.0, standard_deviation: if is_monatomic { 1e-9 } else { 7e-7 } }
}

/// Coefficients of cv(T), for temperatures in K.
struct Law<R> {
    slope: R,
    curvature: R,
}

impl<R: Real> Law<R> {
    #[inline(always)]
    fn of(p: &[R]) -> Self {
        Self { slope: p[0], curvature: p[1] }
    }

    /// cv(T) over cv.
    #[inline(always)]
    fn capacity(&self, temperature: R) -> R {
        let above = temperature - REFERENCE_TEMPERATURE_K;
        above * (self.curvature * above + self.slope) + 1.0
    }

    /// u(T)/(cv T) as a polynomial in T, constant term first.
    #[inline(always)]
    fn mean_capacity(&self) -> [R; 3] {
        const T0: f64 = REFERENCE_TEMPERATURE_K;
        let constant = (self.curvature * T0 - self.slope) * T0 + 1.0;
        [constant, self.slope * 0.5 - self.curvature * T0, self.curvature * (1.0 / 3.0)]
    }

    /// u(T)/(cv T).
    #[inline(always)]
    fn mean_capacity_at(&self, temperature: R) -> R {
        let [constant, linear, square] = self.mean_capacity();
        (square * temperature + linear) * temperature + constant
    }

    /// T where U/(m cv) is `by_energy`, K.
    #[inline(always)]
    fn temperature(&self, by_energy: R) -> R {
        /// Steps to reach rounding from the root of the linear law, for any parameters.
        const MOST_STEPS: usize = 4;
        /// Below this fraction of T, a step leaves an error of the order of its square, so no further step is needed.
        const SMALL: f64 = 1e-7;
        const T0: f64 = REFERENCE_TEMPERATURE_K;
        // U/(m cv) = T + s (T²/2 − T0 T), in the form that s = 0 leaves exact.
        let linear = R::ONE - self.slope * T0;
        let root = (linear * linear + self.slope * by_energy * 2.0).sqrt();
        let mut temperature = by_energy * (R::from(2.0) / (linear + root));
        if !self.curvature.is_zero() {
            for _ in 0..MOST_STEPS {
                let energy = temperature * self.mean_capacity_at(temperature);
                let step = (energy - by_energy) / self.capacity(temperature);
                temperature -= step;
                let small = temperature * SMALL;
                if !(step * step - small * small).any_positive() {
                    break;
                }
            }
        }
        temperature
    }
}

impl Effect for TemperatureDependentHeatCapacity {
    const CARD: Card = Card {
        name: "temperature_dependent_heat_capacity",
        doc: "The gas's heat capacity grows with its temperature",
        equation: "cv(T) = cv (1 + s (T - 293 K) + c (T - 293 K)^2), U = m integral cv dT",
        source: "NIST-JANAF thermochemical tables",
        balance: Balance::Energy,
        parameters: &[
            Parameter {
                name: "slope",
                unit: Unit::PerKelvin,
                bounds: -5e-4..=3e-3,
                typical: 1.2e-4,
                prior: Prior::OfGas(slope_of),
                doc: "Relative slope s of the heat capacity at constant volume; 1.2e-4 for air between 300 and 400 K",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "curvature",
                unit: Unit::PerSquareKelvin,
                bounds: -1.5e-6..=4e-6,
                typical: 5e-7,
                fitted: Fitted::Secondary,
                prior: Prior::OfGas(curvature_of),
                doc: "Curvature c of the heat capacity, where its slope is that at 293 K; for air about 5e-7, with a slope of 6e-5",
                ..Parameter::DEFAULT
            },
        ],
        ..Card::DEFAULT
    };

    const CALORIC: bool = true;

    #[inline(always)]
    fn internal_energy<R: Real>(p: &[R], temperature: R) -> R {
        Law::of(p).mean_capacity_at(temperature)
    }

    #[inline(always)]
    fn temperature<R: Real>(p: &[R], by_energy: R) -> R {
        Law::of(p).temperature(by_energy)
    }

    #[inline(always)]
    fn gas_properties<R: Real>(p: &[R], at: &mut Conditions<R>) {
        let law = Law::of(p);
        let temperature = law.temperature(at.temperature);
        let (rise, capacity) = (temperature / at.temperature, law.capacity(temperature));
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
        // h(Tx) − cp(T) Tx = u(Tx) − cv(T) Tx for gas that enters at Tx; for gas at T, set Tx = T.
        let law = Law::of(p);
        let capacity = law.capacity(at.temperature);
        let [constant, linear, square] = law.mean_capacity();
        let of_inflow = flows.inflow_kelvin * (constant - capacity)
            + flows.inflow_square_kelvin * linear
            + flows.inflow_cube_kelvin * square;
        let own = at.temperature * (law.mean_capacity_at(at.temperature) - capacity);
        let cv = at.cv / capacity;
        [cv * (of_inflow - flows.outflow * own), cv * (of_inflow - flows.inflow * own)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_named_gas_has_the_slope_of_its_kind_of_molecule() {
        let of = |name: &str| slope_of(&Gas::named(name).unwrap()).mean;
        assert_eq!((of("argon"), of("helium")), (0.0, 0.0));
        let curvature = |name: &str| curvature_of(&Gas::named(name).unwrap()).standard_deviation;
        assert!(curvature("helium") < 0.01 * curvature("air"));
        assert!(of("air") > of("nitrogen") && of("oxygen") > of("air") && of("carbon_dioxide") > 1e-3);
    }
}
