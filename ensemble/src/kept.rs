//! The closed form where effects keep it: a heat transfer that depends on the volume alone, a wall of constant temperature.
//!
//! du/dt + (b Tw − (γ − 1) V̇/V) u = b with u = 1/T and b = c f(V) A(V)/√V, where f and A are what the effects make of
//! λ and of the area. Over a ramp, with q = √V as the variable, b dt = d c f A dx for x from 0 to 1 (d the dwell, see
//! [`Closed::ramp_part`](chamber::exact::Closed::ramp_part)); what is exchanged up to each node of a 16-point
//! Gauss–Legendre rule is that rule's own integral, by a matrix: the integrals of the polynomial through the nodes.

use chamber::Chamber;
use chamber::balance::{Balance, Boundary, Conditions, Contents};
use chamber::card::ClosedForm;
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::exact::{Closed, GAUSS_16};
use chamber::real::Real;
use core::hint::black_box;
use std::sync::LazyLock;

/// Nodes of the rule.
const NODES: usize = 16;

/// Effects that keep the closed form.
pub static EFFECTS: LazyLock<EffectSet> = LazyLock::new(|| {
    effects::all().filter(|(_, card)| card.closed_form == ClosedForm::Kept).map(|(place, _)| place).collect()
});

/// The rule's own integrals, from 0 to each node, of the polynomials through the nodes: to be multiplied by their values.
static UP_TO_NODE: LazyLock<[[f64; NODES]; NODES]> = LazyLock::new(|| {
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
    nodes.map(|(x, _)| {
        let up_to = legendre(x);
        nodes.map(|(y, weight)| {
            let at = legendre(y);
            let series: f64 = (1..NODES).map(|n| at[n] * (up_to[n + 1] - up_to[n - 1])).sum();
            weight * (x + 0.5 * series)
        })
    })
});

/// Place, from 0 to 1, and weight of a node.
fn node(index: usize) -> (f64, f64) {
    let (x, weight) = GAUSS_16[index / 2];
    let side = if index.is_multiple_of(2) { -0.5 } else { 0.5 };
    (0.5 + side * x, 0.5 * weight)
}

/// c f A, K^-1 s^-1 m^1.5, and the wall's temperature, K, of chambers with effects that keep the closed form.
#[derive(Clone, Copy, Debug)]
pub struct Exchange<R> {
    set: EffectSet,
    /// c/λ0, to be multiplied by λ and the area.
    per_coefficient: R,
    balance: Balance<R>,
    /// A state of the gas: what the effects look at beside the volume does not matter.
    boundary: Boundary<R>,
}

impl<R: Real> Exchange<R> {
    /// Of a chamber in surroundings of that temperature, K, whose closed form without the effects is `closed`.
    #[inline(always)]
    pub fn new(set: EffectSet, chamber: &Chamber<R>, closed: &Closed<R>, ambient_temperature: R) -> Self {
        let law = &chamber.heat_transfer;
        let scale = (closed.mass_gas_constant * law.reference_pressure * law.reference_temperature).sqrt();
        let boundary = Boundary {
            position: R::ZERO,
            velocity: R::ZERO,
            mass_flow_in: R::ZERO,
            temperature_in: ambient_temperature,
            mass_flow_out: R::ZERO,
            ambient_temperature,
            ambient_pressure: R::from(1e5),
        };
        Self { set, per_coefficient: closed.expansion / scale, balance: Balance::of(*chamber), boundary }
    }

    #[inline(always)]
    fn conditions(&self, volume: R) -> Conditions<R> {
        let contents = Contents::new(R::from(1e-3), R::from(1e2), volume);
        let mut at = self.balance.conditions(self.set, &self.boundary, &contents);
        effects::conditions(self.set, &self.balance.chamber.effects, &[R::ZERO; OWN_STATES], &mut at);
        at
    }

    /// Temperature of the wall, K.
    #[inline(always)]
    pub fn wall(&self) -> R {
        self.conditions(R::from(1e-3)).wall_temperature
    }

    /// c f A at a volume, m³.
    #[inline(always)]
    pub fn at(&self, volume: R) -> R {
        let at = self.conditions(volume);
        let Balance { chamber, area, .. } = &self.balance;
        let coefficient = chamber.heat_transfer.coefficient;
        let coefficient = effects::heat_transfer_factor(self.set, &chamber.effects, &at, coefficient);
        let of_law = chamber.geometry.wetted_volume(volume) * area[0] + area[1];
        self.per_coefficient * coefficient * effects::heat_transfer_area(self.set, &chamber.effects, of_law)
    }

    /// 1/τ_f, 1/s, with the piston held at a volume, m³.
    #[inline(always)]
    pub fn rate(&self, volume: R) -> R {
        self.wall() * self.at(volume) / volume.sqrt()
    }

    /// One of the equal parts, in √V, of a ramp: 1/T at its end, from 1/T and √V at its begin, the part's rise of √V and
    /// the dwell, s m^-½.
    #[inline(always)]
    pub fn ramp_part(&self, wall: R, inverse: R, root: R, step: R, dwell: R) -> R {
        let mut exchange = [R::ZERO; NODES];
        let mut total = R::ZERO;
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            let q = root + step * x;
            exchange[index] = dwell * self.at(q * q);
            total += exchange[index] * weight;
        }
        let expansion = self.balance.expansion * 2.0;
        let growth = |exchanged: R, x: f64| (wall * exchanged - expansion * (R::ONE + step * x / root).ln()).exp();
        let (up_to_node, mut integral) = (&*UP_TO_NODE, R::ZERO);
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            let mut exchanged = R::ZERO;
            for (value, share) in exchange.iter().zip(&up_to_node[index]) {
                exchanged += *value * *share;
            }
            integral += exchange[index] * growth(exchanged, x) * weight;
        }
        (inverse + integral) / growth(total, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_integrated_up_to_a_node_is_exact_for_polynomials() {
        for (index, row) in UP_TO_NODE.iter().enumerate() {
            let (x, _) = node(index);
            for degree in 0..NODES as i32 {
                let found: f64 = row.iter().enumerate().map(|(j, w)| w * node(j).0.powi(degree)).sum();
                assert!((found - x.powi(degree + 1) / f64::from(degree + 1)).abs() < 1e-15, "{index} {degree}");
            }
        }
    }
}
