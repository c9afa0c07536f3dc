//! Where a step meets a corner of the rates: a pressure, Pa, at which a flow or a curve bends ([`effects::corner`]). An error
//! estimate is blind to what happens between two stages, so steps end at corners, as near as a share of the pressure.

use crate::lanes::Lanes;
use chamber::effects::{self, EffectSet, EffectValues};
use chamber::real::Real;

/// A corner within this share of the pressure at either end of a step is met by that end.
const BESIDE: f64 = 2e-4;
/// Rounds of Newton's method, for a cubic from its secant.
const ROUNDS: usize = 3;
/// Added to divisors that may be zero.
const TINY: f64 = 1e-300;
/// Shares at which a step may be cut.
const INSIDE: [f64; 2] = [1e-3, 0.999];

/// Share of a step at which it meets its first corner, 1 where it meets none, from the pressures at both its ends and
/// their slopes there, Pa for the whole step.
#[inline(always)]
pub fn met(
    set: EffectSet,
    values: &EffectValues<Lanes>,
    ambient_pressure: Lanes,
    [from, to]: [Lanes; 2],
    slope: [Lanes; 2],
) -> Lanes {
    let way = to - from;
    let beside = (from * BESIDE).min(way.abs() * 0.5);
    let inward = way.where_positive(beside, -beside);
    let (begin, end) = (from + inward, to - inward);
    let corner = effects::corner(set, values, ambient_pressure, begin, end);
    let meets = (end - corner).abs();
    if !meets.any_positive() {
        return Lanes::ONE;
    }
    // On the cubic through both ends.
    let (bend, twist) = (way * 3.0 - slope[0] * 2.0 - slope[1], slope[0] + slope[1] - way * 2.0);
    let mut x = (corner - from) / (way + TINY);
    let mut round = 0;
    while round < ROUNDS {
        let value = ((twist * x + bend) * x + slope[0]) * x + from - corner;
        let rate = (twist * x * 3.0 + bend * 2.0) * x + slope[0];
        x -= value / rate;
        round += 1;
    }
    meets.where_positive(x.max(Lanes::from(INSIDE[0])).min(Lanes::from(INSIDE[1])), Lanes::ONE)
}
