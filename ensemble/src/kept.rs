//! The closed form where effects keep it: a heat transfer that depends on the volume alone, a wall of constant temperature.
//!
//! du/dt + (b Tw − (γ − 1) V̇/V) u = b with u = 1/T and b = c f(V) A(V)/√V, where f and A are what the effects make of
//! λ and of the area. Over a ramp, with q = √V as the variable, b dt = d c f A dx for x from 0 to 1 (d the dwell, see
//! [`Closed::ramp_part`](chamber::exact::Closed::ramp_part)); what is exchanged up to each node of a 16-point
//! Gauss–Legendre rule is that rule's own integral, by a matrix: the integrals of the polynomial through the nodes. By the
//! same matrix 1/T follows at the nodes, and along the ramp from the polynomial through them ([`Panel`]).

use chamber::Chamber;
use chamber::balance::{Balance, Boundary, Conditions, Contents};
use chamber::card::ClosedForm;
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::exact::{Closed, GAUSS_16};
use chamber::real::Real;
use core::hint::black_box;
use std::sync::LazyLock;

/// Nodes of the rule.
pub const NODES: usize = 16;

/// Effects that keep the closed form.
pub static EFFECTS: LazyLock<EffectSet> = LazyLock::new(|| {
    effects::all().filter(|(_, card)| card.closed_form == ClosedForm::Kept).map(|(place, _)| place).collect()
});

/// What the rule makes of values at its nodes.
struct Rule {
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
    fn up_to_node<R: Real>(&self, values: &[R; NODES], index: usize) -> R {
        let mut sum = R::ZERO;
        for node in 0..NODES {
            sum += values[node] * self.up_to_node[index][node];
        }
        sum
    }
}

static RULE: LazyLock<Rule> = LazyLock::new(|| {
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
}

/// Heat that is exchanged with a wall at a rate that depends on the volume alone.
pub trait Heat<R: Real> {
    /// c f A at a volume, m³.
    fn at(&self, volume: R) -> R;
}

impl<R: Real> Heat<R> for Exchange<R> {
    #[inline(always)]
    fn at(&self, volume: R) -> R {
        self.at(volume)
    }
}

impl<R: Real> Heat<R> for Closed<R> {
    #[inline(always)]
    fn at(&self, volume: R) -> R {
        self.exchange[0] * volume + self.exchange[1]
    }
}

/// One of the equal parts, in √V, of a ramp.
#[derive(Clone, Copy, Debug)]
pub struct Part<R> {
    /// √V at its begin, and its rise.
    pub root: R,
    /// The rise of √V.
    pub step: R,
    /// The dwell, s m^-½.
    pub dwell: R,
    /// Temperature of the wall, K.
    pub wall: R,
    /// γ − 1.
    pub expansion: R,
}

/// What is exchanged over a part: at the nodes, and the sum.
struct Exchanged<R> {
    at: [R; NODES],
    total: R,
}

impl<R: Real> Part<R> {
    /// By how much 1/T grows up to a share of the part over which that much is exchanged.
    #[inline(always)]
    fn growth(&self, exchanged: R, share: f64) -> R {
        (self.wall * exchanged - self.expansion * 2.0 * (R::ONE + self.step * share / self.root).ln()).exp()
    }

    #[inline(always)]
    fn exchanged(&self, heat: &impl Heat<R>) -> Exchanged<R> {
        let mut all = Exchanged { at: [R::ZERO; NODES], total: R::ZERO };
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            let q = self.root + self.step * x;
            all.at[index] = self.dwell * heat.at(q * q);
            all.total += all.at[index] * weight;
        }
        all
    }

    /// 1/T at its end, from that at its begin.
    #[inline(always)]
    pub fn end(&self, heat: &impl Heat<R>, inverse: R) -> R {
        let Exchanged { at: exchange, total } = self.exchanged(heat);
        let (rule, mut integral) = (&*RULE, R::ZERO);
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            integral += exchange[index] * self.growth(rule.up_to_node(&exchange, index), x) * weight;
        }
        (inverse + integral) / self.growth(total, 1.0)
    }

    /// 1/T along it, from that at its begin, and at its end.
    #[inline(always)]
    pub fn panel(&self, heat: &impl Heat<R>, inverse: R) -> (Panel<R>, R) {
        let Exchanged { at: exchange, total } = self.exchanged(heat);
        let rule = &*RULE;
        let (mut growth, mut source, mut integral) = ([R::ZERO; NODES], [R::ZERO; NODES], R::ZERO);
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            growth[index] = self.growth(rule.up_to_node(&exchange, index), x);
            source[index] = exchange[index] * growth[index];
            integral += source[index] * weight;
        }
        let mut values = [R::ZERO; NODES];
        for index in 0..black_box(NODES) {
            values[index] = (inverse + rule.up_to_node(&source, index)) / growth[index];
        }
        (Panel::through(&values, rule), (inverse + integral) / self.growth(total, 1.0))
    }
}

/// A quantity along a part: coefficients in powers of its place from −1 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Panel<R>([R; NODES]);

impl<R: Real> Panel<R> {
    /// The polynomial through values at the nodes. By way of Legendre's series, whose terms fall so fast that powers lose
    /// no digits.
    #[inline(always)]
    fn through(values: &[R; NODES], rule: &Rule) -> Self {
        // Inner loops are sums: any other the compiler would vectorise by gathering numbers from all lanes.
        let [mut terms, mut powers] = [[R::ZERO; NODES]; 2];
        for order in 0..black_box(NODES) {
            for index in 0..NODES {
                terms[order] += values[index] * rule.legendre[order][index];
            }
        }
        for power in 0..black_box(NODES) {
            for order in 0..NODES {
                powers[power] += terms[order] * rule.powers[order][power];
            }
        }
        Self(powers)
    }

    /// Its value at a share of the part.
    #[inline(always)]
    pub fn at(&self, share: R) -> R {
        let place = share * 2.0 - 1.0;
        let mut sum = self.0[NODES - 1];
        for power in (0..NODES - 1).rev() {
            sum = sum * place + self.0[power];
        }
        sum
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
