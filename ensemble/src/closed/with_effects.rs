//! The closed form with effects that keep it: heat transfer that depends on volume and piston speed alone, and a wall of constant
//! temperature.
//!
//! du/dt + (b Tw − (γ − 1) V̇/V) u = b with u = 1/T and b = c f(V) A(V)/√V, where f is the effects' factor of λ and A the area with
//! the effects, at the speed of the ramp or at rest. Over a ramp, with q = √V as the variable, b dt = d c f A dx for x from 0 to 1
//! (d the dwell, see [`Closed::ramp_part`](chamber::exact::Closed::ramp_part)). The logarithm of the homogeneous solution up to each
//! node of a 16-point Gauss–Legendre rule is the integral of Tw d c f A − 2 (γ − 1) q'/q, computed by a matrix: the integrals of the
//! polynomial through the nodes. The same matrix yields 1/T at the nodes.
//!
//! If c f A is linear in V, equation and solution are the paper's with other constants ([`Exchange::line`]).

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

/// c f A, K^-1 s^-1 m^1.5, and the wall's temperature, K, for chambers with effects that keep the closed form.
#[derive(Clone, Copy, Debug)]
pub struct Exchange<'a> {
    set: EffectSet,
    /// c/λ0; multiplied by λ and the area it gives c f A.
    per_coefficient: Lanes,
    balance: &'a Balances<Lanes>,
    /// Piston velocity and ambient temperature; these effects depend on nothing else but the volume.
    boundary: Boundary<Lanes>,
}

/// Relative deviation from a line up to which c f A counts as linear.
const ROUNDING: f64 = 4e-15;

impl<'a> Exchange<'a> {
    /// For resting pistons, given the closed form without the effects and the ambient temperature, K.
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
        // Excludes the code of all other effects.
        let set = set.intersection(EFFECTS);
        Self { set, per_coefficient: closed.expansion / scale, balance, boundary }
    }

    /// Sets the piston's velocity, m/s.
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

    /// c f A over a ramp between two volumes, m³, as a line over V like [`Closed::exchange`], and its deviation from that line at the
    /// end beyond rounding: linear if that is not positive. `ends` are the values at both volumes. The line goes through the start
    /// and a third volume, as both ends may coincide.
    #[inline(always)]
    pub fn line(&self, [from, to]: [Lanes; 2], ends: [Lanes; 2]) -> ([Lanes; 2], Lanes) {
        let slope = (self.at(from + to) - ends[0]) / to;
        let missed = (ends[0] + slope * (to - from) - ends[1]).abs();
        ([slope, ends[0] - slope * from], missed - (ends[0] + ends[1]) * ROUNDING)
    }
}

/// Heat exchange with a wall at a rate that depends, over a ramp, on the volume alone. A trait, as closures would be compiled without
/// the wide instructions.
pub trait Heat: Sized {
    /// c f A at a volume, m³.
    fn at(&self, volume: Lanes) -> Lanes;

    /// 1/T at the end of a part of a ramp, from 1/T at its start.
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

/// One of the parts of a ramp, which are equal in √V.
#[derive(Clone, Copy, Debug)]
pub struct RampPart {
    /// √V at its start.
    pub root: Lanes,
    /// Change of √V.
    pub step: Lanes,
    /// The dwell, s m^-½.
    pub dwell: Lanes,
    /// Temperature of the wall, K.
    pub wall: Lanes,
    /// γ − 1.
    pub expansion: Lanes,
}

impl RampPart {
    /// Writes b dt/dx at the nodes, 1/K, to `exchange` and the derivative of the homogeneous solution's logarithm to `rates`. Returns
    /// the factor of the homogeneous solution over the whole part. (Arrays of lanes are too large to return.)
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

    /// 1/T at its end, from 1/T at its start.
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

    /// Writes 1/T at its nodes to `values` and returns 1/T at its end, from 1/T at its start.
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
