//! The sensor as a filter of a known pressure: a lag y' = (P − y)/τ, then a delay, an offset and a drift.
//!
//! For P = Σ c_k x^k over a piece of length h, with x from 0 to 1 and z = h/τ,
//!
//! y(x) = y(0) e^(−zx) + Σ c_k x^k g_k(zx),  g_k(w) = w ∫₀¹ e^(−wv) (1 − v)^k dv
//!
//! so that a fast sensor needs no small steps. g_0 = 1 − e^(−w) and g_k = 1 − (k/w) g_(k−1). This recurrence loses no digits upwards
//! for w > k and none downwards for w < k, where it starts at k = 7 from the
//! series g_k = w/(k+1) (1 − w/(k+2) (1 − w/(k+3) (…))).

use crate::lanes::Lanes;
use crate::numerics::root::Curve;
use chamber::real::Real;
use core::hint::black_box;

/// Number of coefficients of the polynomial that approximates a pressure.
pub const TERMS: usize = 8;
/// The recurrence runs upwards above this w.
const UPWARDS: f64 = 8.0;
/// Terms of the series: sufficient up to that w.
const SERIES: usize = 36;
/// Times after a kink, in time constants, at which a lagging record is cut so that polynomials describe the pieces.
pub const CUTS: [f64; 9] = [0.7, 1.5, 2.5, 4.0, 6.0, 9.0, 13.0, 20.0, 30.0];

/// Computes the coefficients of a polynomial from its values.
#[derive(Clone, Debug)]
pub struct ToPowers {
    /// Places of the values, from 0 to 1.
    places: [f64; TERMS],
    /// Inverse of their Vandermonde matrix.
    inverse: [[f64; TERMS]; TERMS],
}

/// Places of interpolation, from 0 to 1: the Chebyshev points, including both ends.
fn places() -> [f64; TERMS] {
    core::array::from_fn(|i| 0.5 - 0.5 * (core::f64::consts::PI * i as f64 / (TERMS - 1) as f64).cos())
}

impl Default for ToPowers {
    fn default() -> Self {
        // Row i of the inverse holds the coefficient of x^i in each of Lagrange's polynomials.
        let (places, polynomials) = (places(), polynomials(places()));
        Self { places, inverse: core::array::from_fn(|i| polynomials.map(|polynomial| polynomial[i])) }
    }
}

/// Coefficients of the Lagrange polynomials, each of which is one at one of the places and zero at the others.
pub fn polynomials<const PLACES: usize>(places: [f64; PLACES]) -> [[f64; TERMS]; PLACES] {
    core::array::from_fn(|one| {
        let mut polynomial = [0.0; TERMS];
        polynomial[0] = 1.0;
        for place in (0..PLACES).filter(|other| *other != one).map(|other| places[other]) {
            let scale = 1.0 / (places[one] - place);
            for power in (0..PLACES).rev() {
                let lower = if power > 0 { polynomial[power - 1] } else { 0.0 };
                polynomial[power] = (lower - polynomial[power] * place) * scale;
            }
        }
        polynomial
    })
}

impl ToPowers {
    /// Coefficients of a quantity over the piece that starts at a time, s, and has a length, s; in powers of the place from 0 to 1.
    #[inline(always)]
    pub fn of(&self, quantity: &impl Curve, from: Lanes, length: Lanes) -> [Lanes; TERMS] {
        let mut values = [Lanes::ZERO; TERMS];
        for i in 0..black_box(TERMS) {
            values[i] = quantity.at(from + length * self.places[i]);
        }
        let first = values[0];
        let mut terms = [Lanes::ZERO; TERMS];
        terms[0] = first;
        for i in 1..TERMS {
            for j in 1..TERMS {
                terms[i] += (values[j] - first) * self.inverse[i][j];
            }
        }
        terms
    }
}

/// e^(−w): the fraction of a lagging sensor's reading that is left after w time constants.
#[inline(always)]
pub fn decay_factor<R: Real>(w: R) -> R {
    (-w.min(R::from(700.0))).exp()
}

/// The reading of a lagging sensor over a piece.
#[derive(Clone, Copy, Debug)]
pub struct Lagged<R> {
    /// Coefficients of the pressure, Pa, in powers of the place from 0 to 1.
    pub pressure: [R; TERMS],
    /// Reading at its start, Pa.
    pub begin: R,
    /// Its length over τ.
    pub stiffness: R,
}

/// g_k(w) for all k, where `faded` is e^(−w).
#[inline(always)]
pub fn shares<R: Real>(w: R, faded: R) -> [R; TERMS] {
    const TOP: usize = TERMS - 1;
    // Downwards from the series, if any lane needs it.
    let mut down = [R::ZERO; TERMS];
    if (R::from(UPWARDS + 1.0) - w).any_positive() {
        let small = w.min(R::from(UPWARDS));
        let mut series = R::ONE;
        for j in (1..SERIES).rev() {
            series = R::ONE - small * (1.0 / (TOP + 1 + j) as f64) * series;
        }
        down[TOP] = small * (1.0 / TERMS as f64) * series;
        for k in (1..TERMS).rev() {
            down[k - 1] = (R::ONE - down[k]) * small * (1.0 / k as f64);
        }
    }
    // Upwards from the exponential.
    let large = w.max(R::from(UPWARDS));
    let per_large = large.recip();
    let mut up = R::ONE - faded;
    for k in 0..TERMS {
        if k > 0 {
            up = R::ONE - per_large * k as f64 * up;
        }
        down[k] = (w - UPWARDS).where_positive(up, down[k]);
    }
    down
}

impl<R: Real> Lagged<R> {
    /// Reading at a place x of the piece, Pa.
    #[inline(always)]
    pub fn at(&self, x: R) -> R {
        let w = self.stiffness * x;
        let faded = decay_factor(w);
        let shares = shares(w, faded);
        let (mut power, mut reading) = (R::ONE, self.begin * faded);
        for k in 0..TERMS {
            reading += self.pressure[k] * power * shares[k];
            power = power * x;
        }
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::gauss::{NODES, node};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_lagging_reading_solves_its_equation_from_stiff_to_slow(
            terms in prop::array::uniform8(-1.0..1.0f64), begin in -1.0..1.0f64, log_stiffness in -4.0..8.0f64, x in 0.01..1.0f64,
        ) {
            let stiffness = 10f64.powf(log_stiffness);
            let lagged = Lagged { pressure: terms, begin, stiffness };
            // In parts short enough for Gauss–Legendre quadrature of the solution's integral to be exact.
            let parts = (stiffness * x / 4.0).ceil().clamp(1.0, 2000.0);
            prop_assume!(stiffness * x / parts <= 4.0 || stiffness > 1e4);
            let pressure = |x: f64| terms.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let expected = if stiffness > 1e4 {
                // P − P'/z + P''/z², the rest below 1e-10.
                let derivative = |order: usize| {
                    (order..8).map(|k| terms[k] * x.powi((k - order) as i32) * (0..order).map(|i| (k - i) as f64).product::<f64>()).sum::<f64>()
                };
                (0..4).map(|order| derivative(order) * (-1.0 / stiffness).powi(order as i32)).sum::<f64>()
            } else {
                let (mut y, step) = (begin, x / parts);
                for part in 0..parts as usize {
                    let at = part as f64 * step;
                    let w = stiffness * step;
                    let nodes = (0..NODES).map(node);
                    let fed: f64 = nodes.map(|(u, weight)| weight * w * (-w * (1.0 - u)).exp() * pressure(at + u * step)).sum();
                    y = y * (-w).exp() + fed;
                }
                y
            };
            prop_assert!((lagged.at(x) - expected).abs() < 1e-9, "{} {expected}", lagged.at(x));
        }
    }
}
