//! Position averaging: the position record is a moving average of the stroke over a time w, centred.
//!
//! x_rec(t) = (1/w) ∫ x(t + s) ds, s from −w/2 to w/2, is x + (w²/24) x″ + O(w⁴), and so x ≈ x_rec − (w²/24) x_rec″.
//! w ≥ 0 in s. Of a stroke recorded in rows x″ is the second difference over w/2 either side ([`undone`]): it makes noise
//! of the position larger by 5/3 at most, however short the rows. A filter's delay is `position_delay`'s matter.
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
        candidate: false,
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

/// Times, s, relative to the moment asked for, at which [`undone`] reads the record.
pub fn shifts(window: f64) -> [f64; 3] {
    [0.0, 0.5 * window, -0.5 * window]
}

/// The stroke at a moment from its moving average over `window`, s, `recorded` that time, s, after the moment:
/// x − (1/6) (x₊ − 2 x + x₋), with the second difference over half a window.
pub fn undone(recorded: impl Fn(f64) -> f64, window: f64) -> f64 {
    let [here, after, before] = shifts(window).map(recorded);
    here - ((after - here) - (here - before)) * (1.0 / 6.0)
}

/// The same of a smooth record: position and velocity from the record's value and its first three derivatives, in m, m/s,
/// m/s² and m/s³.
pub fn undone_smooth<R: Real>(recorded: [R; 4], window: R) -> [R; 2] {
    let share = window * window * (1.0 / 24.0);
    [recorded[0] - share * recorded[2], recorded[1] - share * recorded[3]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_agree_on_a_parabola_and_on_rest() {
        let (window, acceleration) = (0.3, -2.0);
        let x = |t: f64| 0.1 + 0.5 * acceleration * t * t;
        let smooth = undone_smooth([x(0.2), acceleration * 0.2, acceleration, 0.0], window);
        assert!((undone(|shift| x(0.2 + shift), window) - smooth[0]).abs() < 1e-15);
        assert_eq!((undone(|_| 0.1, window), undone(|shift| x(0.2 + shift), 0.0)), (0.1, x(0.2)));
    }
}
