//! The Hermite polynomial of degree 7 over a step of length 1, from the Taylor coefficients up to the third power at both ends, by
//! divided differences (E. Isaacson and H. B. Keller, Analysis of Numerical Methods, 1966, 6.3).

use crate::lanes::Lanes;
use crate::numerics::root::Curve;
use chamber::real::Real;
use core::hint::black_box;

/// The polynomial in Newton's form, with the places 0 and 1 four times each.
#[derive(Clone, Copy, Debug)]
pub struct Hermite([Lanes; 8]);

impl Hermite {
    /// The polynomial from the Taylor coefficients at the start and at the end.
    #[inline(always)]
    pub fn new([a0, a1, a2, a3]: [Lanes; 4], [b0, b1, b2, b3]: [Lanes; 4]) -> Self {
        let rise = b0 - a0;
        // Divided differences of order two to seven: those with the most zeros first.
        // They pass through memory: otherwise the compiler computes lanes one by one.
        let [c, d] = black_box([rise - a1, b1 - rise]);
        let [c, d, e] = black_box([c - a2, d - c, b2 - d]);
        let [c, d, e, f] = black_box([c - a3, d - c, e - d, b3 - e]);
        let fourth = c;
        let [c, d, e] = black_box([d - c, e - d, f - e]);
        let fifth = c;
        let [c, d] = black_box([d - c, e - d]);
        Self([a0, a1, a2, a3, fourth, fifth, c, d - c])
    }

    /// Slope at a place from 0 to 1.
    #[inline(always)]
    pub fn slope(&self, x: Lanes) -> Lanes {
        let [_, c1, c2, c3, c4, c5, c6, c7] = self.0;
        let y = x - 1.0;
        let (mut value, mut slope) = (c7, Lanes::ZERO);
        for (factor, coefficient) in [(y, c6), (y, c5), (y, c4), (x, c3), (x, c2), (x, c1)] {
            slope = slope * factor + value;
            value = value * factor + coefficient;
        }
        slope * x + value
    }
}

impl Curve for Hermite {
    #[inline(always)]
    fn at(&self, x: Lanes) -> Lanes {
        let [c0, c1, c2, c3, c4, c5, c6, c7] = self.0;
        let y = x - 1.0;
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + y * (c5 + y * (c6 + y * c7))))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_polynomial_of_degree_seven_is_found_from_its_ends(c in prop::array::uniform8(-1.0..1.0f64), x in 0.0..1.0f64) {
            let value = |x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
            let binomial = |n: usize, k: usize| (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product::<f64>();
            let end = [0, 1, 2, 3].map(|k| (k..8).map(|n| c[n] * binomial(n, k)).sum::<f64>());
            let found = Hermite::new([c[0], c[1], c[2], c[3]].map(Lanes::from), end.map(Lanes::from));
            let ours = found.at(Lanes::from(x))[3];
            prop_assert!((ours - value(x)).abs() < 1e-12, "{ours} {}", value(x));
            let slope = (1..8).rev().fold(0.0, |sum, n| sum * x + n as f64 * c[n]);
            let ours = found.slope(Lanes::from(x))[3];
            prop_assert!((ours - slope).abs() < 1e-11, "{ours} {slope}");
        }
    }
}
