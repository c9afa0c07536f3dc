//! Interval of a per-record parameter that fits best at a bound.
//!
//! A model depends on a short averaging window quadratically: at zero its sensitivity is zero, and an interval from that would
//! just be that of the prior. The interval therefore ends where the sum of squares, including the prior, has grown by as much as
//! at the end of a usual one, with the record's other parameters refitted (profile likelihood).

use crate::fit::Fit;
use crate::fit::covariance::NORMAL_95;
use crate::judge::left_out;
use crate::parameters::{Axis, Hypothesis, RecordSlot};
use crate::record::data::Data;

/// A variance above this fraction of the prior one means that the sensitivity is uninformative.
const UNTOLD: f64 = 0.9;
/// Bisections of the prior's interval: the end is found to a thousandth of that.
const HALVINGS: usize = 10;
/// Standard deviation with which a parameter is held, relative to its prior one.
const FIRMLY: f64 = 1e-3;

/// A per-record parameter in the fit to some of the record's rows.
pub struct RecordFit<'a> {
    /// The prepared data of the fit.
    pub data: &'a Data,
    /// The free parameters of each record.
    pub hypothesis: &'a Hypothesis,
    /// Index of the record.
    pub record: usize,
    /// The row before which its parameters are fitted.
    pub until: usize,
}

impl RecordFit<'_> {
    /// Returns the coordinate at the upper end of the interval of a parameter that fits best at its lower bound; `None` where it
    /// is not there, or where its `variance` is informative.
    pub fn farthest(&self, axis: &Axis<RecordSlot>, best: &Fit, x: f64, variance: f64) -> Option<f64> {
        let [mean, sd] = axis.prior?;
        let RecordSlot::Effect(effect, parameter) = axis.slot else { return None };
        if x > axis.bounds[0] || variance < UNTOLD * sd * sd {
            return None;
        }
        let squares = |x: f64| {
            let mut held = self.hypothesis.clone();
            held.base.effects.of_mut(effect)[parameter] = axis.value(x);
            let axes = held.record_effects.iter_mut().filter(|other| other.slot == axis.slot);
            axes.for_each(|axis| axis.prior = Some([x, FIRMLY * sd]));
            let fit = left_out::fit_record(self.data, &held, self.record, self.until);
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
