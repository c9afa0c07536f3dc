//! The Radau rule with six nodes over a step of length one. Its last node is the step's end (E. Hairer and G. Wanner, Solving Ordinary
//! Differential Equations II, 1996, IV.5).

use crate::filter::{self, TERMS};
use crate::numerics::elimination;
use std::sync::LazyLock;

/// Number of nodes of a step, and their places.
pub const NODES: usize = elimination::SIZE;
pub const PLACES: [f64; NODES] = [
    0.039_809_857_051_468_74, 0.198_013_417_873_608_17, 0.437_974_810_247_386_14, 0.695_464_273_353_636_1,
    0.901_464_914_201_173_6, 1.0,
];
/// Number of values at the end of a step from which d in the next one is extrapolated.
pub const GUESSED: usize = 5;
/// Weight of the Legendre term before the last, in case the last happens to vanish.
const BEFORE_LAST: f64 = 0.02;

/// The matrices of the rule.
pub struct RadauRule {
    /// Coefficients of the Lagrange polynomials, in powers of the place.
    pub powers: [[f64; TERMS]; NODES],
    /// The same for their integrals from the start, from the first power on.
    pub integrated: [[f64; NODES]; NODES],
    /// Integrals of the polynomial up to each node, to be multiplied by the values.
    pub integrals: [[f64; NODES]; NODES],
    /// Its last Legendre coefficient, likewise, and the weighted one before.
    pub last: [[f64; NODES]; 2],
    /// Coefficients, in powers of the place beyond the end, of the polynomial through the last [`GUESSED`] values.
    pub ahead: [[f64; GUESSED]; GUESSED],
}

/// The matrices, computed at their first use.
pub static RULE: LazyLock<RadauRule> = LazyLock::new(|| {
    let powers = filter::polynomials(PLACES);
    let integrated = powers.map(|of| core::array::from_fn(|power| of[power] / (power + 1) as f64));
    let integral = |polynomial: &[f64; TERMS], x: f64| {
        (0..NODES).rev().fold(0.0, |sum, power| (sum + polynomial[power] / (power + 1) as f64) * x)
    };
    let integrals = PLACES.map(|x| core::array::from_fn(|node| integral(&powers[node], x)));
    // The leading terms of the Legendre polynomials from 0 to 1: 252 x⁵ − 630 x⁴ for order five, 70 x⁴ for order four.
    let fifth = powers.map(|polynomial| polynomial[5] / 252.0);
    let fourth = core::array::from_fn(|node| (powers[node][4] + 630.0 * fifth[node]) / 70.0 * BEFORE_LAST);
    let beyond = filter::polynomials::<GUESSED>(core::array::from_fn(|k| PLACES[NODES - GUESSED + k] - 1.0));
    let ahead = core::array::from_fn(|power| beyond.map(|polynomial| polynomial[power]));
    RadauRule { powers, integrated, integrals, last: [fifth, fourth], ahead }
});
