//! Wall heating: the wall is a lumped heat capacity that the gas warms and the surroundings cool.
//!
//! C_w dTw/dt = −Q̇ + G (Tamb − Tw),  Tw(0) = Tamb
//! C_w  J/K  participating heat capacity of the wall; G  W/K  conductance from wall to surroundings.
//! C_w = 0 means off: the wall stays at ambient temperature, as in the paper. Source: lumped-capacity model,
//! e.g. Incropera et al., Fundamentals of Heat and Mass Transfer, chapter 5.

use super::Effect;
use crate::card::{Balance, Card, OwnState, Parameter, Unit};
use crate::parts::{Conditions, Flows, Rates};
use crate::real::Real;

/// Lumped wall capacity.
pub struct WallHeating;

/// `number` over the wall's capacity; zero where the effect is off.
#[inline(always)]
fn by_capacity<R: Real>(p: &[R], number: R) -> R {
    let capacity = p[0];
    capacity.where_positive(number / capacity.where_positive(capacity, R::ONE), R::ZERO)
}

impl Effect for WallHeating {
    const CARD: Card = Card {
        name: "wall_heating",
        doc: "The wall warms and cools with the heat it takes from the gas",
        equation: "C_w dTw/dt = -Q + G (Tamb - Tw), Tw(0) = Tamb",
        source: "lumped heat capacity, Incropera et al., Fundamentals of Heat and Mass Transfer, chapter 5",
        balance: Balance::Energy,
        parameters: &[
            Parameter {
                name: "capacity",
                unit: Unit::JoulePerKelvin,
                bounds: 0.0..=1e9,
                typical: 1.0,
                doc: "Heat capacity C_w of the wall that takes part; zero holds the wall at ambient temperature",
                ..Parameter::DEFAULT
            },
            Parameter {
                name: "outer_conductance",
                unit: Unit::WattPerKelvin,
                bounds: 0.0..=1e6,
                typical: 0.05,
                doc: "Conductance G from the wall to the surroundings; of no influence while the capacity is zero",
                ..Parameter::DEFAULT
            },
        ],
        states: &[OwnState {
            name: "wall_temperature",
            unit: Unit::Kelvin,
            nominal: 300.0,
            doc: "Wall temperature Tw",
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn initial<R: Real>(at: &Conditions<R>, own: &mut [R]) {
        own[0] = at.ambient_temperature;
    }

    const OF_WALL: bool = true;

    #[inline(always)]
    fn conditions<R: Real>(p: &[R], own: &[R], at: &mut Conditions<R>) {
        at.wall_temperature = p[0].where_positive(own[0], at.ambient_temperature);
    }

    #[inline(always)]
    fn own_rates<R: Real>(p: &[R], own: &[R], at: &Conditions<R>, _: &Flows<R>, rates: &Rates<R>, out: &mut [R]) {
        out[0] = by_capacity(p, p[1] * (at.ambient_temperature - own[0]) - rates.heat_flow);
    }

    fn decays<R: Real>(p: &[R], _: &Conditions<R>, out: &mut [R]) {
        out[0] = by_capacity(p, p[1]);
    }

    fn heated<R: Real>(p: &[R], _: &Conditions<R>, _: R, heat: R, own: &mut [R]) {
        own[0] -= by_capacity(p, heat);
    }
}
