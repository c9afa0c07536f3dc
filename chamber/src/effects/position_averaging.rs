//! Position averaging: the position record is a moving average of the stroke over a time w, centred.
//!
//! x_rec(t) = (1/w) ∫ x(t + s) ds, s from −w/2 to w/2, is x + (w²/24) x″ + (w⁴/1920) x⁗ + O(w⁶), and so
//! x ≈ x_rec − (w²/24) x_rec″ + (7 w⁴/5760) x_rec⁗. w ≥ 0 in s. Of a stroke recorded in rows the derivatives are differences
//! over steps of w/2 ([`bend`]): they make noise of the position larger by 11/5 at most, however short the rows. Nearer than
//! w to an end of the record they are taken to be those of w from it. A filter's delay is `position_delay`'s matter.
//! Source: Taylor's expansion; the gas spring of design finding 5 has w near 0.6 s.

use super::Effect;
use crate::card::{ActsOn, Balance, Card, ClosedForm, Normal, Parameter, Prior, Scope, Unit};
use crate::real::Real;

/// Centred moving average of the position record.
pub struct PositionAveraging;

impl Effect for PositionAveraging {
    const CARD: Card = Card {
        name: "position_averaging",
        doc: "The position record is a moving average of the stroke",
        equation: "x = x_rec - (w^2/24) d2x_rec/dt2 + (7 w^4/5760) d4x_rec/dt4",
        source: "Taylor expansion of a centred moving average",
        balance: Balance::Volume,
        acts_on: ActsOn::RecordedStroke,
        scope: Scope::Record,
        closed_form: ClosedForm::Kept,
        parameters: &[Parameter {
            name: "window",
            unit: Unit::Second,
            bounds: 0.0..=10.0,
            typical: 0.05,
            prior: Prior::Normal(Normal { mean: 0.0, standard_deviation: 0.3 }),
            doc: "Time w over which the recorded position is averaged; zero means the position itself",
            ..Parameter::DEFAULT
        }],
        ..Card::DEFAULT
    };

    #[inline(always)]
    fn stroke_window<R: Real>(p: &[R]) -> R {
        p[0]
    }
}

/// Moments that a record is read at for its [`bend`].
pub const READ: usize = 5;

/// Where these moments lie: windows from the middle one.
pub const PLACES: [f64; READ] = [-1.0, -0.5, 0.0, 0.5, 1.0];

/// By how much the average is beside the stroke, m, from what it is at [`PLACES`] around a moment: a sixth of the second
/// difference less a thirtieth of the fourth, exact for polynomials of degree five.
#[inline]
pub fn bend([before, sooner, here, later, after]: [f64; READ]) -> f64 {
    let second = (later - here) - (here - sooner);
    let fourth = (after + before) - 4.0 * (later + sooner) + 6.0 * here;
    second * (1.0 / 6.0) - fourth * (1.0 / 30.0)
}

/// The moment, s, whose [`bend`] stands for that of `time` in a record with these ends that averages over `window`, s.
#[inline]
pub fn middle(time: f64, window: f64, [begin, end]: [f64; 2]) -> f64 {
    time.min(end - window).max(begin + window)
}

/// The stroke at a moment, m, from its moving average over `window`, s, as `recorded` between its two ends, s.
pub fn undone(recorded: impl Fn(f64) -> f64, window: f64, ends: [f64; 2], time: f64) -> f64 {
    let middle = middle(time, window, ends);
    recorded(time) - bend(PLACES.map(|place| recorded(middle + place * window)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_degree_five_is_found_again_inside_the_record() {
        let window = 0.3;
        let x = |t: f64| 0.1 + t.powi(3) - 2.0 * t.powi(4) + t.powi(5);
        let primitive = |t: f64| 0.1 * t + t.powi(4) / 4.0 - 0.4 * t.powi(5) + t.powi(6) / 6.0;
        let averaged = |t: f64| (primitive(t + 0.5 * window) - primitive(t - 0.5 * window)) / window;
        for t in [-0.6, 0.0, 0.2, 0.7] {
            assert!((averaged(t) - x(t)).abs() > 1e-4, "{t}");
            assert!((undone(averaged, window, [-1.0, 1.0], t) - x(t)).abs() < 1e-14, "{t}");
        }
    }

    #[test]
    fn a_parabola_is_found_again_up_to_the_ends_of_its_record_and_rest_is_rest() {
        let (window, acceleration) = (0.3, -2.0);
        let x = |t: f64| 0.1 + 0.5 * acceleration * t * t;
        let averaged = |t: f64| x(t) + acceleration * window * window / 24.0;
        for t in [-1.0, -0.9, 0.2, 0.95, 1.0] {
            assert!((undone(averaged, window, [-1.0, 1.0], t) - x(t)).abs() < 1e-15, "{t}");
        }
        assert_eq!((undone(|_| 0.1, window, [0.0, 1.0], 0.5), undone(x, 0.0, [0.0, 1.0], 0.2)), (0.1, x(0.2)));
    }
}
