//! Is what a fit leaves no more than noise?
//!
//! Two tests, both against the noise of the quiet parts. The sum of squares of the block means, and, far sharper where
//! the rest has a shape, the largest gain of any family of missing terms ([`crate::missing`]): χ² with the family's rank.
//! Limits are set for well under one false "more than noise" in a thousand clean rigs.

use crate::fit::Fit;
use crate::missing::{Missing, Search};
use crate::prepare::Data;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// A family whose gain has less than this probability under noise is no noise.
const FAMILY_PROBABILITY: f64 = 2e-5;
/// A sum of squares this many standard deviations above its expectation is no noise.
const SQUARES_DEVIATIONS: f64 = 4.5;

/// A fit that leaves less than this share of the baseline's excess over noise has found what there was to find: what
/// remains is the stroke's course between two rows and the like.
const REMAINING_SHARE: f64 = 5e-4;
/// Provided that what remains is not more than this many times the noise's own power,
const REMAINING_POWER: f64 = 1.0;
/// and that the baseline's excess is so large, in units of the noise's power, that a share of it can be told from chance.
const LARGE_EXCESS: f64 = 100.0;

/// What the tests say.
#[derive(Clone, Debug)]
pub struct Adequacy {
    /// Whether the residual is no more than noise.
    pub is_noise: bool,
    /// Power of the residual's block means beyond the noise's, over the noise's.
    pub excess: f64,
    /// Sum of squares of block means above its expectation, in standard deviations.
    pub squares_deviations: f64,
    /// Probability of the best family's gain under noise.
    pub family_probability: f64,
    /// Families of missing terms, most significant first.
    pub families: Vec<Missing>,
}

/// Tests a fit's residual.
pub fn test(data: &Data, fit: &Fit) -> Adequacy {
    let locals: usize = fit.locals.iter().map(Vec::len).sum();
    let freedom = (fit.blocks as f64 - fit.globals.len() as f64 - locals as f64).max(1.0);
    let deviation = (2.0 * freedom + (freedom * data.noise.variance_error).powi(2)).sqrt();
    let squares_deviations = (fit.chi2 - freedom) / deviation;
    let mut families = Search::new(data, fit).map(|s| s.all()).unwrap_or_default();
    families.sort_by(|a, b| probability(a).total_cmp(&probability(b)).then(b.gain.total_cmp(&a.gain)));
    let family_probability = families.first().map_or(1.0, probability);
    Adequacy {
        is_noise: squares_deviations < SQUARES_DEVIATIONS && family_probability > FAMILY_PROBABILITY,
        excess: fit.chi2 / freedom - 1.0,
        squares_deviations,
        family_probability,
        families,
    }
}

impl Adequacy {
    /// Whether nothing worth a name remains of what `baseline` left: noise, or next to nothing beside it.
    pub fn settles(&self, baseline: &Adequacy) -> bool {
        let next_to_nothing = self.excess < REMAINING_POWER.min(REMAINING_SHARE * baseline.excess);
        self.is_noise || (baseline.excess > LARGE_EXCESS && next_to_nothing)
    }
}

/// Probability that noise alone gives a family its gain.
fn probability(m: &Missing) -> f64 {
    ChiSquared::new(m.rank as f64).map_or(1.0, |c| c.sf(m.gain))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(is_noise: bool, excess: f64) -> Adequacy {
        Adequacy { is_noise, excess, squares_deviations: 0.0, family_probability: 1e-9, families: Vec::new() }
    }

    #[test]
    fn more_than_noise_is_settled_only_beside_something_a_thousand_times_as_large() {
        assert!(with(false, 0.4).settles(&with(false, 1e4)));
        assert!(!with(false, 0.4).settles(&with(false, 100.0)));
        assert!(!with(false, 3.0).settles(&with(false, 1e5)));
        // A shape in the residual of a baseline whose squares are small by chance is still a shape.
        let baseline = with(false, -0.02);
        assert!(!baseline.settles(&baseline));
    }
}
