//! What 16-point Gauss–Legendre quadrature makes of a quantity beside its integral: the integrals up to each node, by a
//! matrix, and the polynomial through the values. Places are shares of an interval, from 0 to 1.

use crate::math::in_powers;
use chamber::exact::GAUSS_16;
use chamber::real::Real;
use core::hint::black_box;
use std::sync::LazyLock;

/// Nodes of the rule.
pub const NODES: usize = 16;

/// What the rule makes of values at its nodes.
pub struct Rule {
    /// Its own integrals, from 0 to each node, of the polynomials through them: to be multiplied by their values.
    up_to_node: [[f64; NODES]; NODES],
    /// The coefficients of Legendre's polynomials in them, likewise.
    legendre: [[f64; NODES]; NODES],
    /// The coefficients of powers in Legendre's polynomials.
    powers: [[f64; NODES]; NODES],
}

impl Rule {
    /// The integral from 0 to a node of the polynomial that has these values at the nodes.
    #[inline(always)]
    pub fn up_to_node<R: Real>(&self, values: &[R; NODES], index: usize) -> R {
        weighted(values, &self.up_to_node[index])
    }

    /// The coefficient of Legendre's polynomial of that order in the polynomial that has these values at the nodes.
    #[inline(always)]
    pub fn legendre<R: Real>(&self, values: &[R; NODES], order: usize) -> R {
        weighted(values, &self.legendre[order])
    }
}

#[inline(always)]
fn weighted<R: Real>(values: &[R; NODES], weights: &[f64; NODES]) -> R {
    let mut sum = R::ZERO;
    for node in 0..NODES {
        sum += values[node] * weights[node];
    }
    sum
}

/// Its matrices, worked out at their first use.
pub static RULE: LazyLock<Rule> = LazyLock::new(|| {
    let nodes: [(f64, f64); NODES] = core::array::from_fn(node);
    // Legendre's polynomials at a place from 0 to 1.
    let legendre = |x: f64| {
        let (mut p, t) = ([1.0; NODES + 1], 2.0 * x - 1.0);
        p[1] = t;
        for n in 1..NODES {
            p[n + 1] = ((2 * n + 1) as f64 * t * p[n] - n as f64 * p[n - 1]) / (n + 1) as f64;
        }
        p
    };
    let up_to_node = nodes.map(|(x, _)| {
        let up_to = legendre(x);
        nodes.map(|(y, weight)| {
            let at = legendre(y);
            let series: f64 = (1..NODES).map(|n| at[n] * (up_to[n + 1] - up_to[n - 1])).sum();
            weight * (x + 0.5 * series)
        })
    });
    let coefficient = |order| nodes.map(|(x, weight)| (2 * order + 1) as f64 * weight * legendre(x)[order]);
    let mut powers = [[0.0; NODES]; NODES];
    (powers[0][0], powers[1][1]) = (1.0, 1.0);
    for n in 1..NODES - 1 {
        for power in 0..NODES {
            let raised = if power > 0 { powers[n][power - 1] } else { 0.0 };
            powers[n + 1][power] = ((2 * n + 1) as f64 * raised - n as f64 * powers[n - 1][power]) / (n + 1) as f64;
        }
    }
    Rule { up_to_node, legendre: core::array::from_fn(coefficient), powers }
});

/// Place, from 0 to 1, and weight of a node.
pub fn node(index: usize) -> (f64, f64) {
    let (x, weight) = GAUSS_16[index / 2];
    let side = if index.is_multiple_of(2) { -0.5 } else { 0.5 };
    (0.5 + side * x, 0.5 * weight)
}

/// A quantity along an interval: coefficients in powers of its place from −1 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Panel<R>([R; NODES]);

impl<R: Real> Panel<R> {
    /// The polynomial through values at the nodes. By way of Legendre's series, whose terms fall so fast that powers lose
    /// no digits.
    #[inline(always)]
    pub fn through(values: &[R; NODES], rule: &Rule) -> Self {
        // Inner loops are sums: any other the compiler would vectorise by gathering numbers from all lanes.
        let [mut terms, mut powers] = [[R::ZERO; NODES]; 2];
        for order in 0..black_box(NODES) {
            terms[order] = rule.legendre(values, order);
        }
        for power in 0..black_box(NODES) {
            for order in power..NODES {
                powers[power] += terms[order] * rule.powers[order][power];
            }
        }
        Self(powers)
    }

    /// Its value at a share of the interval.
    #[inline(always)]
    pub fn at(&self, share: R) -> R {
        in_powers(&self.0, share * 2.0 - 1.0)
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
            assert!((panel.at(x) - quantity(x)).abs() < 2e-14, "{x}");
        }
    }

    #[test]
    fn what_is_integrated_up_to_a_node_is_exact_for_polynomials() {
        for (index, row) in RULE.up_to_node.iter().enumerate() {
            let (x, _) = node(index);
            for degree in 0..NODES as i32 {
                let found: f64 = row.iter().enumerate().map(|(j, w)| w * node(j).0.powi(degree)).sum();
                assert!((found - x.powi(degree + 1) / f64::from(degree + 1)).abs() < 1e-15, "{index} {degree}");
            }
        }
    }
}
