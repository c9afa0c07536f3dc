//! How far a record's own number may lie from the bound at which it fits best.
//!
//! A model depends on a short averaging window by its square: at zero its sensitivity is zero, and an interval from that would be
//! what was assumed beforehand. The interval therefore ends where the sum of squares, the prior among them, is larger by as much as
//! at the end of a usual one, with the record's other numbers fitted anew (profile likelihood).

use crate::fit::Fit;
use crate::fit::covariance::NORMAL_95;
use crate::judge::left_out;
use crate::parameters::{Axis, Hypothesis, Own};
use crate::record::data::Data;

/// A variance of more than this share of the one beforehand says that the sensitivity tells nothing.
const UNTOLD: f64 = 0.9;
/// Halvings of the interval assumed beforehand: its end is known to a thousandth of that.
const HALVINGS: usize = 10;
/// How firmly a number is held, of its standard deviation beforehand.
const FIRMLY: f64 = 1e-3;

/// A record's own number in the fit to some of its rows.
pub struct OwnFit<'a> {
    /// Prepared as the fit has them.
    pub data: &'a Data,
    /// What is free of each of them.
    pub hypothesis: &'a Hypothesis,
    /// Place of the record among them.
    pub record: usize,
    /// The row before which its own numbers are fitted.
    pub until: usize,
}

impl OwnFit<'_> {
    /// The coordinate up to which a number that fits best at its lower bound may go; `None` where it does not lie there, or where
    /// its `variance` tells.
    pub fn farthest(&self, axis: &Axis<Own>, best: &Fit, x: f64, variance: f64) -> Option<f64> {
        let [mean, sd] = axis.prior?;
        let Own::Effect(effect, parameter) = axis.slot else { return None };
        if x > axis.bounds[0] || variance < UNTOLD * sd * sd {
            return None;
        }
        let squares = |x: f64| {
            let mut held = self.hypothesis.clone();
            held.base.effects.of_mut(effect)[parameter] = axis.value(x);
            let own = held.own.iter_mut().filter(|own| own.slot == axis.slot);
            own.for_each(|own| own.prior = Some([x, FIRMLY * sd]));
            let fit = left_out::own_fit(self.data, &held, self.record, self.until);
            fit.map_or(f64::INFINITY, |fit| fit.chi2 + ((x - mean) / sd).powi(2))
        };
        let is_within = |x: f64| squares(x) < best.chi2 + NORMAL_95 * NORMAL_95;
        let (mut within, mut beyond) = (x, (mean + NORMAL_95 * sd).min(axis.bounds[1]));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (within + beyond);
            *if is_within(middle) { &mut within } else { &mut beyond } = middle;
        }
        Some(beyond)
    }
}
