//! Position averaging: the position record is a moving average of the stroke over a time w, centred.
//!
//! x_rec(t) = (1/w) ∫ x(t + s) ds, s from −w/2 to w/2, is x + (w²/24) x″ + O(w⁴), and so x ≈ x_rec − (w²/24) x_rec″.
//! w ≥ 0 in s. Of a stroke recorded in rows x″ is the second difference over w/2 either side ([`bend`]): it makes noise
//! of the position larger by 5/3 at most, however short the rows. Nearer than w/2 to an end of the record x″ is taken to
//! be that of w/2 from it. A filter's delay is `position_delay`'s matter.
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
        equation: "x = x_rec - (w^2/24) d2x_rec/dt2",
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

/// By how much the average is beside the stroke, m, from what it is half a window before a moment, then and half a window
/// after: (w²/24) x″ with the second difference over half a window, and so a sixth of that.
#[inline]
pub fn bend([before, here, after]: [f64; 3]) -> f64 {
    ((after - here) - (here - before)) * (1.0 / 6.0)
}

/// The moment, s, whose [`bend`] stands for that of `time` where a record with these ends is read `half` a window, s, to
/// either side.
#[inline]
pub fn middle(time: f64, half: f64, [begin, end]: [f64; 2]) -> f64 {
    time.min(end - half).max(begin + half)
}

/// The stroke at a moment, m, from its moving average over `window`, s, as `recorded` between its two ends, s.
pub fn undone(recorded: impl Fn(f64) -> f64, window: f64, ends: [f64; 2], time: f64) -> f64 {
    let half = 0.5 * window;
    let middle = middle(time, half, ends);
    recorded(time) - bend([middle - half, middle, middle + half].map(&recorded))
}

#[cfg(test)]
mod tests {
    use super::*;

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
