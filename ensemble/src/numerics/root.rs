//! Root finding in lanes by Ridders' method, which linearises an exponential (IEEE Trans. Circuits Syst. 26 (1979) 979).

use crate::lanes::Lanes;
use chamber::real::Real;
use core::hint::black_box;

/// Largest number of rounds: five give all digits for an exponential curve.
const ROUNDS: usize = 6;
/// A value below this fraction of the curve's fall between the ends counts as zero.
const NOTHING: f64 = 1e-13;

/// A function of one variable: a time, s, or a place in a step from 0 to 1.
pub trait Curve {
    /// Value of the function at `place`, by lane.
    fn at(&self, place: Lanes) -> Lanes;

    /// A measure of its rise at `place`: the difference over `beside` to both sides, or the slope.
    #[inline(always)]
    fn rise(&self, place: Lanes, beside: Lanes) -> Lanes {
        self.at(place + beside) - self.at(place - beside)
    }
}

/// Distance of a curve from a value, less a band around that.
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

/// A root between `low`, where the curve is positive, and `high`, where it is not positive.
#[inline(always)]
pub fn root(curve: &impl Curve, low: Lanes, high: Lanes) -> Lanes {
    search::<false>(curve, low, high, None)
}

/// The same with known values of the curve at both places.
#[inline(always)]
pub fn root_between(curve: &impl Curve, [low, high]: [Lanes; 2], values: [Lanes; 2]) -> Lanes {
    search::<false>(curve, low, high, Some(values))
}

/// A root between places where the curve has opposite signs.
#[inline(always)]
pub fn crossing(curve: &impl Curve, low: Lanes, high: Lanes) -> Lanes {
    search::<true>(curve, low, high, None)
}

/// A root between `low` and `high`, where the curve falls or, if `EITHER`, falls or rises. The code contains one copy of the curve: a
/// single loop evaluates it first at both ends, then in each round in the middle and at the root of the linearised curve.
#[inline(always)]
fn search<const EITHER: bool>(curve: &impl Curve, mut low: Lanes, mut high: Lanes, known: Option<[Lanes; 2]>) -> Lanes {
    let [mut at_low, mut at_high, mut nothing, mut middle, mut at_middle] = [Lanes::ZERO; 5];
    // 1 if the curve falls from `low` to `high`, −1 if it rises.
    let mut side = Lanes::ONE;
    let (mut place, mut x) = (low, low);
    // Positive until the root is found: a lane's result must not depend on how long others take.
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
            // Stays between the ends even if rounding gives them the same sign.
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
