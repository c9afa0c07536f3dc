//! The nodes of 16-point Gauss–Legendre quadrature for more than an integral: the integrals up to each node, by a matrix, and the
//! polynomial through the values. Places are fractions of an interval, from 0 to 1.
//!
//! Nodes come in pairs that are symmetric about the middle. The even part depends only on the sums of a pair's values, the odd part on
//! their differences: the matrices have half the size each way.

use crate::lanes::math::in_powers;
use chamber::exact::GAUSS_16;
use chamber::real::Real;
use core::hint::black_box;
use std::sync::LazyLock;

/// Nodes of the rule.
pub const NODES: usize = 16;

/// Pairs of nodes.
const PAIRS: usize = NODES / 2;

/// The matrices of the rule.
pub struct GaussRule {
    /// Integrals of the polynomial through the values: of the even part from the middle to the later node of a pair, of the odd part
    /// from 0 to either; to be multiplied by [`Mirrored`].
    up_to_node: [[[f64; PAIRS]; PAIRS]; 2],
    /// Legendre coefficients of that polynomial, likewise.
    legendre: [[f64; PAIRS]; NODES],
    /// Coefficients of the powers in the Legendre polynomials.
    powers: [[f64; NODES]; NODES],
}

/// Sums and differences of a quantity's values at each pair of nodes.
pub struct Mirrored<R>([[R; PAIRS]; 2]);

impl<R: Real> Mirrored<R> {
    /// The sums and differences of these values.
    #[inline(always)]
    pub fn new(values: &[R; NODES]) -> Self {
        // Passes through memory: otherwise the compiler vectorises the loop by gathering numbers from all lanes.
        let mut parts = [[R::ZERO; PAIRS]; 2];
        for pair in 0..black_box(PAIRS) {
            let [early, late] = [values[2 * pair], values[2 * pair + 1]];
            parts[0][pair] = black_box(early + late);
            parts[1][pair] = black_box(late - early);
        }
        Self(parts)
    }
}

impl GaussRule {
    /// Writes to `out` the integrals from 0 to each node of the polynomial with these values at the nodes.
    #[inline(always)]
    pub fn up_to_nodes<R: Real>(&self, Mirrored([sums, differences]): &Mirrored<R>, out: &mut [R; NODES]) {
        let mut half = R::ZERO;
        for pair in 0..PAIRS {
            half += sums[pair] * (0.25 * GAUSS_16[pair].1);
        }
        for pair in 0..black_box(PAIRS) {
            let even = weighted(sums, &self.up_to_node[0][pair]);
            let odd = half + weighted(differences, &self.up_to_node[1][pair]);
            out[2 * pair] = black_box(odd - even);
            out[2 * pair + 1] = black_box(odd + even);
        }
    }

    /// The Legendre coefficient of an order of the polynomial with these values at the nodes.
    #[inline(always)]
    pub fn legendre<R: Real>(&self, values: &Mirrored<R>, order: usize) -> R {
        weighted(&values.0[order % 2], &self.legendre[order])
    }
}

#[inline(always)]
fn weighted<R: Real>(values: &[R; PAIRS], weights: &[f64; PAIRS]) -> R {
    let mut sum = R::ZERO;
    for pair in 0..PAIRS {
        sum += values[pair] * weights[pair];
    }
    sum
}

/// The matrices, computed at their first use.
pub static RULE: LazyLock<GaussRule> = LazyLock::new(|| {
    let nodes: [(f64, f64); NODES] = core::array::from_fn(node);
    // The Legendre polynomials at a place from 0 to 1.
    let legendre = |x: f64| {
        let (mut p, t) = ([1.0; NODES + 1], 2.0 * x - 1.0);
        p[1] = t;
        for n in 1..NODES {
            p[n + 1] = ((2 * n + 1) as f64 * t * p[n] - n as f64 * p[n - 1]) / (n + 1) as f64;
        }
        p
    };
    // The later node of each pair, which represents both.
    let later: [(f64, f64); PAIRS] = core::array::from_fn(|pair| nodes[2 * pair + 1]);
    // Even Legendre polynomials have odd integrals, odd ones even integrals.
    let up_to_node = [0, 1].map(|parity| {
        later.map(|(x, _)| {
            let up_to = legendre(x);
            later.map(|(y, weight)| {
                let at = legendre(y);
                let constant = if parity == 0 { x - 0.5 } else { 0.0 };
                let series = |n: usize| at[n] * (up_to[n + 1] - up_to[n - 1]);
                weight * (constant + 0.5 * (1..NODES).filter(|n| n % 2 == parity).map(series).sum::<f64>())
            })
        })
    });
    let coefficient = |order| later.map(|(x, weight)| (2 * order + 1) as f64 * weight * legendre(x)[order]);
    let mut powers = [[0.0; NODES]; NODES];
    (powers[0][0], powers[1][1]) = (1.0, 1.0);
    for n in 1..NODES - 1 {
        for power in 0..NODES {
            let raised = if power > 0 { powers[n][power - 1] } else { 0.0 };
            powers[n + 1][power] = ((2 * n + 1) as f64 * raised - n as f64 * powers[n - 1][power]) / (n + 1) as f64;
        }
    }
    GaussRule { up_to_node, legendre: core::array::from_fn(coefficient), powers }
});

/// Place, from 0 to 1, and weight of a node.
pub fn node(index: usize) -> (f64, f64) {
    let (x, weight) = GAUSS_16[index / 2];
    let side = if index.is_multiple_of(2) { -0.5 } else { 0.5 };
    (0.5 + side * x, 0.5 * weight)
}

/// A quantity along an interval: coefficients in powers of the place from −1 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Panel<R>([R; NODES]);

impl<R: Real> Panel<R> {
    /// The polynomial through values at the nodes, by its Legendre series, whose terms fall so fast that the powers lose no digits.
    #[inline(always)]
    pub fn through(values: &[R; NODES], rule: &GaussRule) -> Self {
        // Inner loops are sums: the compiler would vectorise other loops by gathering numbers from all lanes.
        let [mut terms, mut powers] = [[R::ZERO; NODES]; 2];
        let values = Mirrored::new(values);
        for order in 0..black_box(NODES) {
            terms[order] = rule.legendre(&values, order);
        }
        for power in 0..black_box(NODES) {
            for order in (power..NODES).step_by(2) {
                powers[power] += terms[order] * rule.powers[order][power];
            }
        }
        Self(powers)
    }

    /// Value at a place of the interval, from 0 to 1.
    #[inline(always)]
    pub fn at(&self, share: R) -> R {
        in_powers(&self.0, share * 2.0 - 1.0)
    }

    /// Value there, and its derivative by the place from 0 to 1.
    #[inline(always)]
    pub fn with_slope(&self, share: R) -> [R; 2] {
        let (place, mut value, mut slope) = (share * 2.0 - 1.0, self.0[NODES - 1], R::ZERO);
        for power in (0..NODES - 1).rev() {
            slope = slope * place + value;
            value = value * place + self.0[power];
        }
        [value, slope * 2.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_is_the_quantity_whose_values_it_goes_through() {
        // 1/T along a part as long as any: a power of V.
        let quantity = |x: f64| (1.0 + x).powf(0.8);
        let values = core::array::from_fn(|index| quantity(node(index).0));
        let panel = Panel::through(&values, &RULE);
        for x in [0.0, 0.3, 1.0f64] {
            let ([value, slope], rise) = (panel.with_slope(x), 0.8 * quantity(x) / (1.0 + x));
            assert!((panel.at(x) - quantity(x)).abs() < 2e-14, "{x}");
            assert!((value - quantity(x)).abs() < 2e-14 && (slope - rise).abs() < 1e-11, "{x} {slope} {rise}");
        }
    }

    #[test]
    fn what_is_integrated_up_to_a_node_is_exact_for_polynomials() {
        for degree in 0..NODES as i32 {
            let (values, mut found) = (core::array::from_fn(|index| node(index).0.powi(degree)), [0.0; NODES]);
            RULE.up_to_nodes(&Mirrored::new(&values), &mut found);
            for (index, found) in found.iter().enumerate() {
                let expected = node(index).0.powi(degree + 1) / f64::from(degree + 1);
                assert!((found - expected).abs() < 1e-15, "{index} {degree}");
            }
        }
    }
}
