//! The closed form where effects keep it: a heat transfer that depends on the volume and the piston's speed alone, a wall of
//! constant temperature.
//!
//! du/dt + (b Tw − (γ − 1) V̇/V) u = b with u = 1/T and b = c f(V) A(V)/√V, where f and A are what the effects make of
//! λ and of the area at the speed of the ramp, or at rest. Over a ramp, with q = √V as the variable, b dt = d c f A dx for x
//! from 0 to 1 (d the dwell, see [`Closed::ramp_part`](chamber::exact::Closed::ramp_part)). How much 1/T grows up to each node
//! of a 16-point Gauss–Legendre rule is that rule's own integral of Tw d c f A − 2 (γ − 1) q'/q, by a matrix: the integrals of
//! the polynomial through the nodes. By the same matrix 1/T follows at the nodes, and along the ramp from the polynomial
//! through them ([`Panel`]).
//!
//! Where c f A is linear in V the equation is the paper's with other constants, and so is its solution ([`Exchange::line`]).

use crate::gauss::{NODES, Panel, RULE, node};
use chamber::Chamber;
use chamber::balance::{Balance, Boundary, Conditions, Contents};
use chamber::card::ClosedForm;
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;
use std::sync::LazyLock;

/// Effects that keep the closed form.
pub static EFFECTS: LazyLock<EffectSet> = LazyLock::new(|| {
    effects::all().filter(|(_, card)| card.closed_form == ClosedForm::Kept).map(|(place, _)| place).collect()
});

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

/// By how much, over itself, c f A may miss a line through it that stands for it.
const ROUNDING: f64 = 4e-15;

impl<R: Real> Exchange<R> {
    /// Of a chamber in surroundings of that temperature, K, whose closed form without the effects is `closed`, while its
    /// piston rests.
    #[inline(always)]
    pub fn new(set: EffectSet, chamber: &Chamber<R>, closed: &Closed<R>, ambient_temperature: R) -> Self {
        let law = &chamber.heat_transfer;
        let scale = (closed.mass_gas_constant * law.reference_pressure * law.reference_temperature).sqrt();
        let boundary = Boundary::closed(R::ZERO, ambient_temperature, R::from(1e5));
        Self { set, per_coefficient: closed.expansion / scale, balance: Balance::of(*chamber), boundary }
    }

    /// From now on of a piston with that velocity, m/s.
    #[inline(always)]
    pub fn move_at(&mut self, velocity: R) {
        self.boundary.velocity = velocity;
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

    /// c f A over a ramp between two volumes, m³, where its values at these are `ends`, as a line over V like
    /// [`Closed::exchange`], and by how much it misses that line at the end, less than what is rounding: none where it is not
    /// positive. The line goes through the begin and a third place, as both ends may be one.
    #[inline(always)]
    pub fn line(&self, [from, to]: [R; 2], ends: [R; 2]) -> ([R; 2], R) {
        let slope = (self.at(from + to) - ends[0]) / to;
        let missed = (ends[0] + slope * (to - from) - ends[1]).abs();
        ([slope, ends[0] - slope * from], missed - (ends[0] + ends[1]) * ROUNDING)
    }
}

/// Heat that is exchanged with a wall at a rate that depends, over a ramp, on the volume alone.
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

/// What happens along a part.
struct Along<R> {
    /// b dt/dx at the nodes, 1/K.
    exchange: [R; NODES],
    /// By which factors 1/T grows up to the nodes, and over the whole, where nothing is fed.
    growth: [R; NODES],
    total: R,
}

impl<R: Real> Part<R> {
    #[inline(always)]
    fn along(&self, heat: &impl Heat<R>) -> Along<R> {
        let zero = [R::ZERO; NODES];
        let (mut exchange, mut growth, mut rates, mut exchanged) = (zero, zero, zero, R::ZERO);
        let expansion = self.expansion * 2.0;
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            let q = self.root + self.step * x;
            exchange[index] = self.dwell * heat.at(q * q);
            rates[index] = self.wall * exchange[index] - expansion * self.step / q;
            exchanged += exchange[index] * weight;
        }
        for index in 0..black_box(NODES) {
            growth[index] = RULE.up_to_node(&rates, index).exp();
        }
        let total = (self.wall * exchanged - expansion * (R::ONE + self.step / self.root).ln()).exp();
        Along { exchange, growth, total }
    }

    /// 1/T at its end, from that at its begin.
    #[inline(always)]
    pub fn end(&self, heat: &impl Heat<R>, inverse: R) -> R {
        let Along { exchange, growth, total } = self.along(heat);
        let mut integral = R::ZERO;
        for index in 0..NODES {
            integral += exchange[index] * growth[index] * node(index).1;
        }
        (inverse + integral) / total
    }

    /// 1/T along it, from that at its begin, and at its end.
    #[inline(always)]
    pub fn panel(&self, heat: &impl Heat<R>, inverse: R) -> (Panel<R>, R) {
        let Along { exchange, growth, total } = self.along(heat);
        let (rule, mut source, mut integral) = (&*RULE, [R::ZERO; NODES], R::ZERO);
        for index in 0..black_box(NODES) {
            source[index] = exchange[index] * growth[index];
            integral += source[index] * node(index).1;
        }
        let mut values = [R::ZERO; NODES];
        for index in 0..black_box(NODES) {
            values[index] = (inverse + rule.up_to_node(&source, index)) / growth[index];
        }
        (Panel::through(&values, rule), (inverse + integral) / total)
    }
}
