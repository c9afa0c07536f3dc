//! A root in each lane by Ridders' method, which straightens an exponential (IEEE Trans. Circuits Syst. 26 (1979) 979).

use crate::lanes::Lanes;
use chamber::real::Real;
use core::hint::black_box;

/// Rounds at most: where the curve is an exponential, five give all digits.
const ROUNDS: usize = 6;
/// Share of a curve's fall between the ends at which its value counts as nothing.
const NOTHING: f64 = 1e-13;

/// A function of one variable: a time, s, or a share of a step.
pub trait Curve {
    /// Value of the function at `place`, by lane.
    fn at(&self, place: Lanes) -> Lanes;

    /// A measure of its rise around `place`, positive where it rises: over a short way to both sides, or its slope.
    #[inline(always)]
    fn rise(&self, place: Lanes, beside: Lanes) -> Lanes {
        self.at(place + beside) - self.at(place - beside)
    }
}

/// How far a curve is from a value, beyond a band around it.
pub struct Beyond<'a, C> {
    pub curve: &'a C,
    pub value: Lanes,
    pub band: Lanes,
}

impl<C: Curve> Curve for Beyond<'_, C> {
    #[inline(always)]
    fn at(&self, place: Lanes) -> Lanes {
        (self.curve.at(place) - self.value).abs() - self.band
    }
}

/// A root between `low`, where the curve is positive, and `high`, where it is not.
#[inline(always)]
pub fn root(curve: &impl Curve, low: Lanes, high: Lanes) -> Lanes {
    search::<false>(curve, low, high, None)
}

/// The same where the curve's values at both places are known.
#[inline(always)]
pub fn root_between(curve: &impl Curve, [low, high]: [Lanes; 2], values: [Lanes; 2]) -> Lanes {
    search::<false>(curve, low, high, Some(values))
}

/// A root between places where the curve has either sign.
#[inline(always)]
pub fn crossing(curve: &impl Curve, low: Lanes, high: Lanes) -> Lanes {
    search::<true>(curve, low, high, None)
}

/// A root between places from the first to the second of which the curve falls, or where `EITHER` falls or rises. All its values come
/// from one place in the code, which so has one copy of the curve: first those at both ends, then in each round that in the middle
/// and that at the root of the straightened curve.
#[inline(always)]
fn search<const EITHER: bool>(curve: &impl Curve, mut low: Lanes, mut high: Lanes, known: Option<[Lanes; 2]>) -> Lanes {
    let [mut at_low, mut at_high, mut nothing, mut middle, mut at_middle] = [Lanes::ZERO; 5];
    // 1 where the curve falls from `low` to `high`, −1 where it rises.
    let mut side = Lanes::ONE;
    let (mut place, mut x) = (low, low);
    // Positive where the root is not found yet: a lane's digits do not depend on how long the others take.
    let mut open = Lanes::ONE;
    let mut begin = 0;
    if let Some(known) = known {
        [at_low, at_high] = known;
        nothing = (at_low - at_high) * NOTHING;
        middle = (low + high) * 0.5;
        (place, begin) = (middle, 2);
    }
    for evaluation in black_box(begin)..black_box(2 + 2 * ROUNDS) {
        let mut value = curve.at(place);
        if EITHER {
            if evaluation == 0 {
                side = value.where_positive(Lanes::ONE, -Lanes::ONE);
            }
            value = value * side;
        }
        if evaluation == 0 {
            (at_low, place) = (value, high);
            continue;
        }
        if evaluation % 2 == 0 {
            at_middle = value;
            // Where rounding leaves both ends on one side, no place beyond them is looked at.
            let apart = (-(at_low * at_high)).max(Lanes::ZERO);
            let straight = (at_middle * at_middle + apart + f64::MIN_POSITIVE).sqrt();
            x = open.where_positive(middle + (middle - low) * at_middle / straight, x);
            place = x;
            continue;
        }
        if evaluation == 1 {
            at_high = value;
            nothing = (at_low - at_high) * NOTHING;
        } else {
            open = open.where_positive(value.abs() - nothing, open);
            if !open.any_positive() {
                break;
            }
            for (place, at_place) in [(middle, at_middle), (x, value)] {
                let inside = (place - low).min(high - place);
                let to_low = at_place.where_positive(inside, Lanes::ZERO);
                let to_high = at_place.where_positive(Lanes::ZERO, inside);
                (low, at_low) = (to_low.where_positive(place, low), to_low.where_positive(at_place, at_low));
                (high, at_high) = (to_high.where_positive(place, high), to_high.where_positive(at_place, at_high));
            }
        }
        middle = (low + high) * 0.5;
        place = middle;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Level(f64);

    impl Curve for Level {
        fn at(&self, _: Lanes) -> Lanes {
            Lanes::from(self.0)
        }
    }

    #[test]
    fn where_a_curve_is_level_to_rounding_the_root_stays_between_its_bounds() {
        for level in [-1e-6, -1e-300, 0.0, 1e-300, 1e-6] {
            let found = root(&Level(level), Lanes::from(2.0), Lanes::from(3.0));
            assert!((0..crate::lanes::WIDTH).all(|lane| (2.0..=3.0).contains(&found[lane])), "{level:e}: {found:?}");
        }
    }
}
