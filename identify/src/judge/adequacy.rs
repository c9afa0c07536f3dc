//! Tests whether a fit leaves no more than noise, or no more than the requested accuracy.
//!
//! Two statistical tests against the recording's noise: the sum of squares of the whitened blocks, and, far more sensitive where
//! the remainder has a shape, the largest gain of any family of missing terms ([`crate::discrepancy`]): χ² with the family's
//! rank. One practical test: the systematic misfit ([`misfit`]) against the rig's accuracy. Passing the first two or the third is
//! enough.

use crate::discrepancy::{Families, Missing};
use crate::fit::Fit;
use crate::judge::misfit;
use crate::policy::{
    FAMILY_PROBABILITY, NEXT_TO_NOTHING, NOISE_MODEL_SHARE, PLAIN_SHAPE, REMAINING_WITHIN_ACCURACY, SQUARES_DEVIATIONS,
    TOLERANCES,
};
use crate::record::data::Data;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Results of the tests.
#[derive(Clone, Debug)]
pub struct Adequacy {
    /// Whether the residual is only noise.
    pub is_noise: bool,
    /// Systematic misfit, Pa.
    pub systematic_pa: f64,
    /// Whether that is less than the requested accuracy.
    pub is_good_enough: bool,
    /// Sum of squares of the whitened blocks minus its expectation, in standard deviations.
    pub squares_deviations: f64,
    /// Probability of the best family's gain under noise.
    pub family_probability: f64,
    /// Families of missing terms, most significant first.
    pub families: Vec<Missing>,
}

/// Tests a fit's residual.
pub fn test(data: &Data, fit: &Fit) -> Adequacy {
    let squares_deviations = squares_deviations(data, fit, fit.marginal);
    let mut families = Families::new(data, fit).map(|families| families.all()).unwrap_or_default();
    families.sort_by(|a, b| probability(a).total_cmp(&probability(b)).then(b.gain.total_cmp(&a.gain)));
    let family_probability = families.first().map_or(1.0, probability);
    let mut systematic_pa = misfit::systematic(data, &misfit::residuals(data, fit));
    // Stated parameters may move within their tolerances only; position waves are already limited by the fit.
    if fit.moved_from_stated().all(|(axis, moved)| axis.slot.is_wave() || moved.abs() < TOLERANCES) {
        systematic_pa = systematic_pa.min(misfit::systematic(data, &misfit::residuals_moved(data, fit)));
    }
    Adequacy {
        is_noise: squares_deviations < SQUARES_DEVIATIONS && family_probability > FAMILY_PROBABILITY,
        systematic_pa,
        is_good_enough: systematic_pa < data.accuracy_pa(),
        squares_deviations,
        family_probability,
        families,
    }
}

/// Sum of squares of a fit's whitened blocks minus its expectation, in standard deviations.
fn squares_deviations(data: &Data, fit: &Fit, squares: f64) -> f64 {
    let of_records: usize = fit.records.iter().map(Vec::len).sum();
    let freedom = (fit.blocks as f64 - fit.hypothesis.axes.len() as f64 - of_records as f64).max(1.0);
    let uncertain = freedom * data.noise.variance_error.max(NOISE_MODEL_SHARE);
    (squares - freedom) / (2.0 * freedom + uncertain * uncertain).sqrt()
}

/// Whether a fit's sum of squares is no more than noise: the part of the test that costs nothing.
pub fn has_squares_of_noise(data: &Data, fit: &Fit) -> bool {
    are_squares_of_noise(data, fit, fit.marginal)
}

/// Whether this sum of squares of a fit's whitened blocks is no more than noise.
pub fn are_squares_of_noise(data: &Data, fit: &Fit, squares: f64) -> bool {
    squares_deviations(data, fit, squares) < SQUARES_DEVIATIONS
}

impl Adequacy {
    /// Whether the model is adequate: what remains is noise, or less than the accuracy.
    pub fn is_adequate(&self) -> bool {
        self.is_noise || self.is_good_enough
    }

    /// Whether an earlier systematic misfit of `before_pa` is accounted for: adequate, or next to nothing of it remains.
    pub fn accounts_for(&self, before_pa: f64) -> bool {
        self.is_adequate() || self.is_next_to_nothing(before_pa)
    }

    /// Whether it explains an earlier systematic misfit of `before_pa`: noise remains, or next to nothing of that misfit, or
    /// little of it that is good enough. Good enough alone does not suffice: a structured remainder that is a large part of the
    /// earlier misfit shows that something else is at work, which the named effects may imitate.
    pub fn explains(&self, before_pa: f64) -> bool {
        let is_minor = self.is_good_enough && self.systematic_pa < REMAINING_WITHIN_ACCURACY * before_pa;
        self.is_noise || self.is_next_to_nothing(before_pa) || is_minor
    }

    /// Whether more than next to nothing remains of a systematic misfit of `before_pa`, with a shape that is certainly not noise.
    pub fn has_plain_shape(&self, before_pa: f64) -> bool {
        !self.is_noise && !self.is_next_to_nothing(before_pa) && self.family_probability < PLAIN_SHAPE
    }

    /// Whether next to nothing remains of an earlier systematic misfit of `before_pa`.
    pub fn is_next_to_nothing(&self, before_pa: f64) -> bool {
        self.systematic_pa < NEXT_TO_NOTHING * before_pa
    }
}

/// Probability that noise alone gives a family its gain.
fn probability(m: &Missing) -> f64 {
    ChiSquared::new(m.rank as f64).map_or(1.0, |c| c.sf(m.gain))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remainder_below_the_accuracy_accounts_for_a_misfit_and_explains_it_only_if_it_is_noise_or_little() {
        let left = |systematic_pa, is_noise| Adequacy {
            is_noise,
            systematic_pa,
            is_good_enough: systematic_pa < 20.0,
            squares_deviations: 1.0,
            family_probability: if is_noise { 0.1 } else { 1e-9 },
            families: Vec::new(),
        };
        let judged = |after: Adequacy| (after.accounts_for(100.0), after.explains(100.0));
        assert_eq!(judged(left(15.0, false)), (true, false));
        assert_eq!(judged(left(15.0, true)), (true, true));
        assert_eq!(judged(left(8.0, false)), (true, true));
        assert_eq!(judged(left(1.5, false)), (true, true));
        assert_eq!(judged(left(30.0, false)), (false, false));
        // A plain shape means something else, unless next to nothing remains.
        let is_plain = |left: Adequacy| Adequacy { family_probability: 1e-25, ..left }.has_plain_shape(100.0);
        assert_eq!([is_plain(left(8.0, false)), is_plain(left(1.5, false))], [true, false]);
        assert!(!left(8.0, false).has_plain_shape(100.0));
    }
}
