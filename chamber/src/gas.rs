//! The perfect gas: P V = m R T with constant heat capacities. R in J/(kg K), γ dimensionless.

use crate::real::{Real, lift};

/// A perfect gas with constant heat capacities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas<R = f64> {
    /// Specific gas constant R, J/(kg K).
    pub gas_constant: R,
    /// Heat capacity ratio γ = cp/cv.
    pub heat_capacity_ratio: R,
}

impl Gas<f64> {
    /// Air as in the paper's appendix: R = 287 J/(kg K), γ = 1.4.
    pub const AIR: Gas = Gas { gas_constant: 287.0, heat_capacity_ratio: 1.4 };

    /// Gases known by name, at 300 K and 1 bar: (name, R, γ). Source: NIST Chemistry WebBook, except for air (the paper).
    pub const NAMED: [(&'static str, Gas); 7] = [
        ("air", Gas::AIR),
        ("nitrogen", Gas { gas_constant: 296.8, heat_capacity_ratio: 1.4 }),
        ("oxygen", Gas { gas_constant: 259.8, heat_capacity_ratio: 1.395 }),
        ("argon", Gas { gas_constant: 208.1, heat_capacity_ratio: 1.667 }),
        ("helium", Gas { gas_constant: 2077.1, heat_capacity_ratio: 1.667 }),
        ("hydrogen", Gas { gas_constant: 4124.2, heat_capacity_ratio: 1.405 }),
        ("carbon_dioxide", Gas { gas_constant: 188.9, heat_capacity_ratio: 1.29 }),
    ];

    /// Relative slope of cv between 300 and 400 K of each of [`Gas::NAMED`], 1/K. Source: NIST-JANAF tables.
    const SLOPES: [f64; 7] = [1.2e-4, 6e-5, 3.4e-4, 0.0, 0.0, 1.6e-4, 1.4e-3];

    /// Relative slope of cv with temperature near 350 K, 1/K, if R and γ match one of [`Gas::NAMED`].
    pub fn heat_capacity_slope(&self) -> Option<f64> {
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.01;
        let is_this = |known: &Gas| {
            near(self.gas_constant, known.gas_constant) && near(self.heat_capacity_ratio, known.heat_capacity_ratio)
        };
        Gas::NAMED.iter().position(|(_, known)| is_this(known)).map(|index| Gas::SLOPES[index])
    }

    /// The gas of that name, if it is one of [`Gas::NAMED`].
    pub fn named(name: &str) -> Option<Gas> {
        Gas::NAMED.iter().find(|(n, _)| *n == name).map(|(_, gas)| *gas)
    }
}

impl<R: Real> Gas<R> {
    /// cv = R/(γ − 1), J/(kg K).
    #[inline(always)]
    pub fn cv(&self) -> R {
        self.gas_constant / (self.heat_capacity_ratio - 1.0)
    }

    /// cp = γ R/(γ − 1), J/(kg K).
    #[inline(always)]
    pub fn cp(&self) -> R {
        self.heat_capacity_ratio * self.cv()
    }
}

lift!(Gas: gas_constant, heat_capacity_ratio);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_capacities_differ_by_the_gas_constant() {
        for (name, gas) in Gas::NAMED {
            assert!((gas.cp() - gas.cv() - gas.gas_constant).abs() < 1e-11 * gas.cp(), "{name}");
            assert!((gas.cp() / gas.cv() - gas.heat_capacity_ratio).abs() < 1e-14, "{name}");
        }
    }
}
