//! The closed form where effects keep it: a heat transfer that depends on the volume and the piston's speed alone, a wall of
//! constant temperature.
//!
//! du/dt + (b Tw − (γ − 1) V̇/V) u = b with u = 1/T and b = c f(V) A(V)/√V, where f and A are what the effects make of
//! λ and of the area at the speed of the ramp, or at rest. Over a ramp, with q = √V as the variable, b dt = d c f A dx for x
//! from 0 to 1 (d the dwell, see [`Closed::ramp_part`](chamber::exact::Closed::ramp_part)). How much 1/T grows up to each node
//! of a 16-point Gauss–Legendre rule is that rule's own integral of Tw d c f A − 2 (γ − 1) q'/q, by a matrix: the integrals of
//! the polynomial through the nodes. By the same matrix 1/T follows at the nodes.
//!
//! Where c f A is linear in V the equation is the paper's with other constants, and so is its solution ([`Exchange::line`]).

use crate::lanes::Lanes;
use crate::numerics::gauss::{Mirrored, NODES, RULE, node};
use chamber::balance::{Balances, Boundary, Conditions, Contents};
use chamber::card::ClosedForm;
use chamber::effects::{EffectSet, OWN_STATES};
use chamber::effects_where;
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;

/// Effects that keep the closed form.
pub const EFFECTS: EffectSet = effects_where!(card => matches!(card.closed_form, ClosedForm::Kept));

/// c f A, K^-1 s^-1 m^1.5, and the wall's temperature, K, of chambers with effects that keep the closed form.
#[derive(Clone, Copy, Debug)]
pub struct Exchange<'a> {
    set: EffectSet,
    /// c/λ0, to be multiplied by λ and the area.
    per_coefficient: Lanes,
    balance: &'a Balances<Lanes>,
    /// A state of the gas: what the effects look at beside the volume does not matter.
    boundary: Boundary<Lanes>,
}

/// By how much, over itself, c f A may miss a line through it that stands for it.
const ROUNDING: f64 = 4e-15;

impl<'a> Exchange<'a> {
    /// Of a chamber in surroundings of that temperature, K, whose closed form without the effects is `closed`, while its
    /// piston rests.
    #[inline(always)]
    pub fn new(
        set: EffectSet,
        balance: &'a Balances<Lanes>,
        closed: &Closed<Lanes>,
        ambient_temperature: Lanes,
    ) -> Self {
        let law = &balance.chamber.heat_transfer;
        let scale = (closed.mass_gas_constant * law.reference_pressure * law.reference_temperature).sqrt();
        let boundary = Boundary::closed(Lanes::ZERO, ambient_temperature, Lanes::from(1e5));
        // So that the code has no others.
        let set = set.intersection(EFFECTS);
        Self { set, per_coefficient: closed.expansion / scale, balance, boundary }
    }

    /// From now on of a piston with that velocity, m/s.
    #[inline(always)]
    pub fn move_at(&mut self, velocity: Lanes) {
        self.boundary.velocity = velocity;
    }

    #[inline(always)]
    fn conditions(&self, volume: Lanes) -> Conditions<Lanes> {
        let contents = Contents::new(Lanes::from(1e-3), Lanes::from(1e2), volume);
        let mut at = self.balance.conditions(self.set, &self.boundary, &contents);
        self.balance.chamber.effects.conditions(self.set, &[Lanes::ZERO; OWN_STATES], &mut at);
        at
    }

    /// Temperature of the wall, K.
    #[inline(always)]
    pub fn wall(&self) -> Lanes {
        self.conditions(Lanes::from(1e-3)).wall_temperature
    }

    /// c f A over a ramp between two volumes, m³, where its values at these are `ends`, as a line over V like
    /// [`Closed::exchange`], and by how much it misses that line at the end, less than what is rounding: none where it is not
    /// positive. The line goes through the start and a third place, as both ends may be one.
    #[inline(always)]
    pub fn line(&self, [from, to]: [Lanes; 2], ends: [Lanes; 2]) -> ([Lanes; 2], Lanes) {
        let slope = (self.at(from + to) - ends[0]) / to;
        let missed = (ends[0] + slope * (to - from) - ends[1]).abs();
        ([slope, ends[0] - slope * from], missed - (ends[0] + ends[1]) * ROUNDING)
    }
}

/// Heat that is exchanged with a wall at a rate that depends, over a ramp, on the volume alone. What differs is a trait's, not closures:
/// these would be compiled for any machine.
pub trait Heat: Sized {
    /// c f A at a volume, m³.
    fn at(&self, volume: Lanes) -> Lanes;

    /// 1/T at the end of one of the equal parts of a ramp, from that at its start.
    #[inline(always)]
    fn end(&self, part: &RampPart, inverse: Lanes) -> Lanes {
        part.end(self, inverse)
    }
}

impl Heat for Exchange<'_> {
    #[inline(always)]
    fn at(&self, volume: Lanes) -> Lanes {
        let at = self.conditions(volume);
        let chamber = &self.balance.chamber;
        let coefficient = chamber.effects.heat_transfer_factor(self.set, &at, chamber.heat_transfer.coefficient);
        self.per_coefficient * coefficient * self.balance.area_of(self.set, volume)
    }
}

impl Heat for Closed<Lanes> {
    #[inline(always)]
    fn at(&self, volume: Lanes) -> Lanes {
        self.exchange[0] * volume + self.exchange[1]
    }

    #[inline(always)]
    fn end(&self, part: &RampPart, inverse: Lanes) -> Lanes {
        self.ramp_part(inverse, part.root, part.step, part.dwell)
    }
}

/// One of the equal parts, in √V, of a ramp.
#[derive(Clone, Copy, Debug)]
pub struct RampPart {
    /// √V at its start, and its rise.
    pub root: Lanes,
    /// The rise of √V.
    pub step: Lanes,
    /// The dwell, s m^-½.
    pub dwell: Lanes,
    /// Temperature of the wall, K.
    pub wall: Lanes,
    /// γ − 1.
    pub expansion: Lanes,
}

impl RampPart {
    /// At the nodes b dt/dx, in 1/K, into `exchange`, and how fast ln(1/T) grows where nothing is fed into `rates`; the
    /// factor by which 1/T so grows over the whole. (Arrays of lanes are too large to be handed back.)
    #[inline(always)]
    fn along(&self, heat: &impl Heat, exchange: &mut [Lanes; NODES], rates: &mut [Lanes; NODES]) -> Lanes {
        let (mut exchanged, expansion) = (Lanes::ZERO, self.expansion * 2.0);
        for index in 0..black_box(NODES) {
            let (x, weight) = node(index);
            let q = self.root + self.step * x;
            exchange[index] = self.dwell * heat.at(q * q);
            rates[index] = self.wall * exchange[index] - expansion * self.step / q;
            exchanged += exchange[index] * weight;
        }
        (self.wall * exchanged - expansion * (Lanes::ONE + self.step / self.root).ln()).exp()
    }

    /// 1/T at its end, from that at its start.
    #[inline(always)]
    fn end(&self, heat: &impl Heat, inverse: Lanes) -> Lanes {
        let [mut exchange, mut grown] = [[Lanes::ZERO; NODES]; 2];
        let total = self.along(heat, &mut exchange, &mut grown);
        RULE.up_to_nodes(&Mirrored::new(&grown), &mut grown);
        let mut integral = Lanes::ZERO;
        for index in 0..black_box(NODES) {
            integral += exchange[index] * grown[index].exp() * node(index).1;
        }
        (inverse + integral) / total
    }

    /// 1/T at its nodes, from that at its start, into `values`, and at its end.
    #[inline(always)]
    pub fn nodes(&self, heat: &impl Heat, inverse: Lanes, values: &mut [Lanes; NODES]) -> Lanes {
        let (rule, mut grown, mut integral) = (&*RULE, [Lanes::ZERO; NODES], Lanes::ZERO);
        let total = self.along(heat, values, &mut grown);
        rule.up_to_nodes(&Mirrored::new(&grown), &mut grown);
        for index in 0..black_box(NODES) {
            grown[index] = black_box(grown[index].exp());
            values[index] = black_box(values[index] * grown[index]);
            integral += values[index] * node(index).1;
        }
        rule.up_to_nodes(&Mirrored::new(values), values);
        for index in 0..black_box(NODES) {
            values[index] = black_box((inverse + values[index]) / grown[index]);
        }
        (inverse + integral) / total
    }
}
