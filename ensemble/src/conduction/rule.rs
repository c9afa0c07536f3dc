//! Radau's rule of six nodes over a step of length one, and what it makes of values at them. Its last node is the step's end
//! (E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 1996, IV.5).

use crate::filter::{self, TERMS};
use crate::numerics::elimination;
use std::sync::LazyLock;

/// Nodes of a step, and their places in it.
pub const NODES: usize = elimination::SIZE;
pub const PLACES: [f64; NODES] = [
    0.039_809_857_051_468_74, 0.198_013_417_873_608_17, 0.437_974_810_247_386_14, 0.695_464_273_353_636_1,
    0.901_464_914_201_173_6, 1.0,
];
/// Of how many values at the end of a step d ahead is guessed.
pub const GUESSED: usize = 5;
/// Share of the Legendre term before the last that counts beside it, should it happen to vanish.
const BEFORE_LAST: f64 = 0.02;

/// What the rule makes of values at the nodes of a step of length one.
pub struct RadauRule {
    /// Coefficients in powers of the place of the polynomial that is one at a node and zero at the others.
    pub powers: [[f64; TERMS]; NODES],
    /// The same of its integral from the start on, from the first power on.
    pub integrated: [[f64; NODES]; NODES],
    /// The polynomial's integrals up to each node, to be multiplied by the values.
    pub integrals: [[f64; NODES]; NODES],
    /// Its last Legendre coefficient, likewise, and the share of the one before.
    pub last: [[f64; NODES]; 2],
    /// Coefficients, in powers of the place beyond the end, of the polynomial through the last of the values.
    pub ahead: [[f64; GUESSED]; GUESSED],
}

/// Worked out at its first use.
pub static RULE: LazyLock<RadauRule> = LazyLock::new(|| {
    let powers = filter::polynomials(PLACES);
    let integrated = powers.map(|of| core::array::from_fn(|power| of[power] / (power + 1) as f64));
    let integral = |polynomial: &[f64; TERMS], x: f64| {
        (0..NODES).rev().fold(0.0, |sum, power| (sum + polynomial[power] / (power + 1) as f64) * x)
    };
    let integrals = PLACES.map(|x| core::array::from_fn(|node| integral(&powers[node], x)));
    // Of Legendre's polynomials from 0 to 1, that of order five begins with 252 x⁵ − 630 x⁴, that of order four with 70 x⁴.
    let fifth = powers.map(|polynomial| polynomial[5] / 252.0);
    let fourth = core::array::from_fn(|node| (powers[node][4] + 630.0 * fifth[node]) / 70.0 * BEFORE_LAST);
    let beyond = filter::polynomials::<GUESSED>(core::array::from_fn(|k| PLACES[NODES - GUESSED + k] - 1.0));
    let ahead = core::array::from_fn(|power| beyond.map(|polynomial| polynomial[power]));
    RadauRule { powers, integrated, integrals, last: [fifth, fourth], ahead }
});
