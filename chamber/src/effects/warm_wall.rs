//! Warm wall: the wall is warmer than the surroundings, at Tamb + ΔT, as beside a hot machine or in the sun.
//!
//! ΔT in K, either sign. Gas and wall have this temperature at rest, also before a test. Combined with an effect that changes the
//! wall's temperature, ΔT is added.

use super::Effect;
use crate::card::{Balance, Card, ClosedForm, Normal, Parameter, Prior, Unit};
use crate::parts::Conditions;
use crate::real::Real;

/// A wall not at ambient temperature.
pub struct WarmWall;

impl Effect for WarmWall {
    const CARD: Card = Card {
        name: "warm_wall",
        doc: "The wall, and with it the gas at rest, is warmer or colder than the surroundings",
        equation: "Tw = Tamb + dT, T(0) = Tw",
        source: "boundary condition, e.g. a cylinder fixed to a warm machine",
        balance: Balance::Energy,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "temperature_difference",
            unit: Unit::KelvinDifference,
            bounds: -100.0..=200.0,
            typical: 10.0,
            prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 10.0 }),
            doc: "Temperature dT of the wall above that of the surroundings",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn wall_excess<R: Real>(p: &[R]) -> R {
        p[0]
    }

    const OF_WALL: bool = true;

    #[inline(always)]
    fn conditions<R: Real>(p: &[R], _: &[R], at: &mut Conditions<R>) {
        at.wall_temperature += p[0];
    }
}
