//! Location of corners of the rates: pressures, Pa, at which a flow or a curve has a kink
//! ([`Effect::pressure_kink`](chamber::effects::Effect::pressure_kink)). Error estimates do not see what happens between two stages, so steps end at
//! corners, to within a fraction of the pressure.
//!
//! A corner is predicted from P w⁶ with w = V^(1/4), which is linear in the transformed time
//! ([`crate::integrator::time_transformation`]): over a push P V^γ, for air P w^5.6, is nearly constant, so that P w⁶ is nearly
//! linear; while the piston rests it is proportional to P.

use crate::integrator::step::extrapolated;
use crate::lanes::Lanes;
use chamber::real::{Real, reciprocals};

/// A corner within this distance of an end of a step, relative to the pressure, coincides with that end.
const BESIDE: f64 = 2e-4;
/// Newton steps for a root of a cubic, starting from its secant.
const ROUNDS: usize = 3;
/// Added to divisors that may be zero.
const TINY: f64 = 1e-300;
/// Range of the fractions at which a step may be cut.
const INSIDE: [f64; 2] = [1e-3, 0.999];

/// Predicts pressure, Pa, and slope a step of length `h` ahead, from those now, `at`, and w'/w now. `before` are those a time `since`
/// ago; `since` is zero if there are none.
#[inline(always)]
pub fn ahead(h: Lanes, at: [Lanes; 2], widening: Lanes, before: [Lanes; 2], since: Lanes) -> [Lanes; 2] {
    let past = since.where_positive(since, Lanes::ONE);
    if !widening.abs().any_positive() {
        return extrapolated(h, at, before, [past, past.recip()]);
    }
    // w then and a step ahead, relative to w now.
    let (wide, narrow) = (Lanes::ONE - widening * since, widening * h + 1.0);
    let [per_past, per_narrow] = reciprocals([past, narrow]);
    // The same bits whatever the neighbouring lanes are.
    let per_narrow = widening.abs().where_positive(per_narrow, Lanes::ONE);
    let [pressure, slope] = before;
    let even = [at[0], at[1] + at[0] * widening * 6.0];
    let fifth = fifth_power(wide);
    let even_before = [pressure * fifth * wide, (slope * wide + pressure * widening * 6.0) * fifth];
    let bent = extrapolated(h, even, even_before, [past, per_past]);
    let value = since.where_positive(bent[0], even[0] + even[1] * h);
    let rise = since.where_positive(bent[1], even[1]);
    let per_sixth = fifth_power(per_narrow) * per_narrow;
    [value * per_sixth, (rise - value * widening * per_narrow * 6.0) * per_sixth]
}

#[inline(always)]
fn fifth_power(x: Lanes) -> Lanes {
    let square = x * x;
    square * square * x
}

/// The range of pressures in which a step looks for corners, Pa, from the pressures at its ends.
#[inline(always)]
pub fn inside(from: Lanes, to: Lanes) -> [Lanes; 2] {
    let way = to - from;
    let beside = (from * BESIDE).min(way.abs() * 0.5);
    let inward = way.where_positive(beside, -beside);
    [from + inward, to - inward]
}

/// Fraction of a step of length `h` at which it meets its first corner, 1 if none. `corner` is the first one before `end` of
/// [`inside`], or `end` itself, Pa. Interpolates with the pressures and slopes at both ends of the step and w'/w at its start.
#[inline(always)]
pub fn met(
    [corner, end]: [Lanes; 2],
    h: Lanes,
    [[from, slope], [to, end_slope]]: [[Lanes; 2]; 2],
    widening: Lanes,
) -> Lanes {
    let (slope, end_slope) = (slope * h, end_slope * h);
    let way = to - from;
    let meets = (end - corner).abs();
    if !meets.any_positive() {
        return Lanes::ONE;
    }
    let mut x = (corner - from) / (way + TINY);
    // On the cubic through both ends, with w = 1 at the start.
    let rise = widening * h;
    let moves = rise.abs().any_positive();
    let narrowing = rise + 1.0;
    let fifth = fifth_power(narrowing);
    let slopes = [slope + from * rise * 6.0, (end_slope * narrowing + to * rise * 6.0) * fifth];
    let way = to * fifth * narrowing - from;
    let (bend, twist) = (way * 3.0 - slopes[0] * 2.0 - slopes[1], slopes[0] + slopes[1] - way * 2.0);
    let (mut round, mut per_rate) = (0, Lanes::ONE);
    while round < ROUNDS {
        let (mut there, mut rising) = (corner, Lanes::ZERO);
        if moves {
            let root = rise * x + 1.0;
            let fifth = corner * fifth_power(root);
            (there, rising) = (fifth * root, fifth * rise * 6.0);
        }
        let value = ((twist * x + bend) * x + slopes[0]) * x + from - there;
        let rate = (twist * x * 3.0 + bend * 2.0) * x + slopes[0] - rising;
        // The reciprocal of a rate that hardly changes, by Newton's method as well.
        per_rate = if round == 0 { rate.recip() } else { per_rate * (Lanes::from(2.0) - rate * per_rate) };
        x -= value * per_rate;
        round += 1;
    }
    meets.where_positive(x.max(Lanes::from(INSIDE[0])).min(Lanes::from(INSIDE[1])), Lanes::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::effects::{EffectValues, Leakage};

    #[test]
    fn what_is_foreseen_of_a_piston_at_rest_does_not_depend_on_those_beside() {
        let [h, since] = [0.7, 0.3].map(Lanes::from);
        let [at, before] = [[2e5, -3e4], [2.1e5, -3.3e4]].map(|of: [f64; 2]| of.map(Lanes::from));
        let beside = Lanes::from_fn(|lane| if lane == 3 { 0.0 } else { -0.3 });
        let [alone, amid] = [Lanes::ZERO, beside].map(|widening| ahead(h, at, widening, before, since));
        assert_eq!(alone.map(|of| of[3]), amid.map(|of| of[3]));
    }

    #[test]
    fn an_adiabatic_push_is_foreseen_and_cut_where_it_meets_a_corner() {
        // P w^5.6 is a constant, and w falls evenly.
        let (root, rate) = (|t: f64| 1.0 - 0.3 * t, -0.3);
        let pressure = |t: f64| 2e5 * root(t).powf(-5.6);
        let at = |t: f64| [pressure(t), -5.6 * pressure(t) * rate / root(t)].map(Lanes::from);
        let widening = |t: f64| Lanes::from(rate / root(t));
        let foreseen =
            |before: f64| ahead(Lanes::from(0.3), at(0.3), widening(0.3), at(before), Lanes::from(0.3 - before));
        for (before, allowed) in [(0.3, 5e-3), (0.2, 1e-5)] {
            let (found, expected) = (foreseen(before), at(0.6));
            for of in 0..2 {
                let error = (found[of][3] / expected[of][3] - 1.0).abs();
                assert!(error < allowed * if of == 0 { 1.0 } else { 20.0 }, "{before}: {error:e}");
            }
        }
        // A leak to 1 bar chokes at b = 0.3.
        let ends = [at(0.1), at(0.5)];
        let [begin, end] = inside(ends[0][0], ends[1][0]);
        let corner = EffectValues::NEUTRAL.lift().pressure_kink(Leakage::SET, Lanes::from(1e5), begin, end);
        let share = met([corner, end], Lanes::from(0.4), ends, widening(0.1))[3];
        let error = (pressure(0.1 + 0.4 * share) * 0.3 / 1e5 - 1.0).abs();
        assert!(error < 0.5 * BESIDE, "{error:e}");
    }
}
