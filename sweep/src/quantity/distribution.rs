//! The distribution of an uncertain quantity, by its quantile function: it maps a probability to a value, so that every sampled
//! design can draw from it.
//!
//! The standard normal and the triangular distribution are those of `statrs`. A truncated normal or log-normal
//! distribution keeps its shape between its limits: z = Φ⁻¹(Φ(a) + u (Φ(b) − Φ(a))).

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal, Triangular};
use std::ops::RangeInclusive;

/// Probability in each tail beyond the extreme values drawn, for an unbounded distribution: 8.2 standard deviations of a normal
/// one, the limit of a double's resolution near one.
const TAIL: f64 = 1.0 / (1u64 << 53) as f64;
/// Minimum probability between the limits of a truncated distribution: below it, digits are lost.
const LEAST_MASS: f64 = 1e-9;

/// A distribution of one quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "distribution", rename_all = "kebab-case")]
pub enum Distribution {
    /// Normal, truncated at its limits, if any.
    Normal {
        /// Mean before truncation.
        mean: f64,
        /// Standard deviation before truncation.
        sd: f64,
        /// Truncation limits.
        #[serde(flatten)]
        limits: Limits,
    },
    /// Log-normal, truncated at its limits, if any.
    LogNormal {
        /// Median before truncation.
        median: f64,
        /// Standard deviation of the natural logarithm.
        sd_log: f64,
        /// Truncation limits.
        #[serde(flatten)]
        limits: Limits,
    },
    /// Density that rises linearly from `from` to `mode` and falls linearly to `to`.
    Triangular {
        /// Minimum.
        from: f64,
        /// The most probable value.
        mode: f64,
        /// Maximum.
        to: f64,
    },
    /// Measured values: uniform density between neighbouring values, each interval equally probable.
    Empirical {
        /// The measured values, ascending.
        values: Vec<f64>,
    },
}

/// Truncation limits of a distribution, if any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Limits {
    /// Minimum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Maximum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
}

impl Distribution {
    /// Why the distribution is invalid, if it is: "has an `sd` of 0: …".
    pub fn problem(&self) -> Option<String> {
        match self {
            Distribution::Normal { sd, .. } if *sd <= 0.0 => Some(format!("has an `sd` of {sd}: it has to be above 0")),
            Distribution::LogNormal { median, .. } if *median <= 0.0 => {
                Some(format!("has a `median` of {median}: a log-normal quantity is above 0"))
            }
            Distribution::LogNormal { sd_log, .. } if *sd_log <= 0.0 => {
                Some(format!("has an `sd_log` of {sd_log}: it has to be above 0"))
            }
            Distribution::Normal { limits, .. } | Distribution::LogNormal { limits, .. } => {
                if let (Some(from), Some(to)) = (limits.from, limits.to)
                    && from >= to
                {
                    return Some(format!("runs from {from} to {to}: `from` has to be below `to`"));
                }
                let ends = self.standard_limits();
                (mass(ends) < LEAST_MASS).then(|| "has next to no probability between `from` and `to`".to_owned())
            }
            Distribution::Triangular { from, mode, to } if from >= to || !(from..=to).contains(&mode) => {
                Some(format!("has `from` {from}, `mode` {mode} and `to` {to}: they have to be in ascending order"))
            }
            Distribution::Triangular { .. } => None,
            Distribution::Empirical { values } => {
                let same = values.first() == values.last();
                same.then(|| "needs at least two different values".to_owned())
            }
        }
    }

    /// The quantile at a probability. Probabilities of 0 and 1 are replaced by the nearest ones with a finite value.
    pub fn quantile(&self, probability: f64) -> f64 {
        let probability = probability.clamp(TAIL, 1.0 - TAIL);
        match self {
            Distribution::Normal { mean, sd, limits } => limits.clamp(mean + sd * self.standard_quantile(probability)),
            Distribution::LogNormal { median, sd_log, limits } => {
                limits.clamp(median * (sd_log * self.standard_quantile(probability)).exp())
            }
            Distribution::Triangular { from, mode, to } => match Triangular::new(*from, *to, *mode) {
                Ok(triangular) => triangular.inverse_cdf(probability),
                Err(_) => f64::NAN,
            },
            Distribution::Empirical { values } => {
                let position = probability * (values.len() - 1) as f64;
                let before = (position as usize).min(values.len() - 2);
                let (a, b) = (values[before], values[before + 1]);
                a + (position - before as f64) * (b - a)
            }
        }
    }

    /// Smallest and largest value drawn.
    pub fn bounds(&self) -> RangeInclusive<f64> {
        self.quantile(0.0)..=self.quantile(1.0)
    }

    /// Limits of the standard normal variable behind a normal or log-normal distribution.
    fn standard_limits(&self) -> [f64; 2] {
        let ends = |limits: &Limits| [limits.from.unwrap_or(f64::NEG_INFINITY), limits.to.unwrap_or(f64::INFINITY)];
        match self {
            Distribution::Normal { mean, sd, limits } => ends(limits).map(|x| (x - mean) / sd),
            Distribution::LogNormal { median, sd_log, limits } => {
                ends(limits).map(|x| (x.max(0.0) / median).ln() / sd_log)
            }
            Distribution::Triangular { .. } | Distribution::Empirical { .. } => ends(&Limits::default()),
        }
    }

    /// Quantile of the standard normal variable between its limits, computed from the tail that preserves the digits.
    fn standard_quantile(&self, probability: f64) -> f64 {
        let [a, b] = self.standard_limits();
        let between = |a: f64, b: f64, probability: f64| {
            normal_quantile(normal(a) * (1.0 - probability) + normal(b) * probability)
        };
        if a > 0.0 { -between(-b, -a, 1.0 - probability) } else { between(a, b, probability) }
    }
}

impl Limits {
    fn clamp(self, value: f64) -> f64 {
        let value = self.from.map_or(value, |from| value.max(from));
        self.to.map_or(value, |to| value.min(to))
    }
}

/// Probability of a standard normal variable between two limits.
fn mass([a, b]: [f64; 2]) -> f64 {
    if a > 0.0 { normal(-a) - normal(-b) } else { normal(b) - normal(a) }
}

/// Probability that a standard normal variable is below x.
pub fn normal(x: f64) -> f64 {
    Normal::standard().cdf(x)
}

/// The standard normal quantile of a probability.
pub fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use statrs::distribution::{Continuous, LogNormal};

    const FREE: Limits = Limits { from: None, to: None };

    /// ∫ f dF from the quantile function by the midpoint rule.
    fn mean_of(distribution: &Distribution, f: impl Fn(f64) -> f64) -> f64 {
        let n = 200_000;
        (0..n).map(|i| f(distribution.quantile((f64::from(i) + 0.5) / f64::from(n)))).sum::<f64>() / f64::from(n)
    }

    #[test]
    fn moments_are_those_of_the_textbooks() {
        for (distribution, mean, variance) in [
            (Distribution::Normal { mean: 3.0, sd: 0.5, limits: FREE }, 3.0, 0.25),
            (
                Distribution::LogNormal { median: 2.0, sd_log: 0.3, limits: FREE },
                2.0 * 0.045f64.exp(),
                4.0 * 0.09f64.exp() * (0.09f64.exp() - 1.0),
            ),
            (
                Distribution::Triangular { from: 1.0, mode: 2.0, to: 5.0 },
                8.0 / 3.0,
                (1.0 + 4.0 + 25.0 - 2.0 - 5.0 - 10.0) / 18.0,
            ),
            // The pieces between the values are uniform: means 1.5 and 4, variances 1/12 and 4²/12, probability one half each.
            (Distribution::Empirical { values: vec![1.0, 2.0, 6.0] }, 2.75, 17.0 / 24.0 + 1.25 * 1.25),
            // Half a normal distribution: mean √(2/π), variance 1 − 2/π.
            (
                Distribution::Normal { mean: 0.0, sd: 1.0, limits: Limits { from: Some(0.0), to: None } },
                std::f64::consts::FRAC_2_PI.sqrt(),
                1.0 - std::f64::consts::FRAC_2_PI,
            ),
        ] {
            let found = mean_of(&distribution, |x| x);
            assert!((found / mean - 1.0).abs() < 2e-5, "{distribution:?}: {found} {mean}");
            let spread = mean_of(&distribution, |x| (x - mean) * (x - mean));
            assert!((spread / variance - 1.0).abs() < 2e-4, "{distribution:?}: {spread} {variance}");
        }
    }

    #[test]
    fn a_log_normal_quantile_is_that_of_statrs() {
        let ours = Distribution::LogNormal { median: 2.0, sd_log: 0.3, limits: FREE };
        let theirs = LogNormal::new(2f64.ln(), 0.3).unwrap();
        for probability in [1e-12, 0.025, 0.5, 0.975, 1.0 - 1e-12] {
            assert!((ours.quantile(probability) / theirs.inverse_cdf(probability) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn a_distribution_without_ends_is_drawn_from_as_far_as_doubles_resolve_probabilities() {
        let bounds = Distribution::Normal { mean: 0.0, sd: 1.0, limits: FREE }.bounds();
        assert!((-8.3..-8.1).contains(bounds.start()) && (8.1..8.3).contains(bounds.end()), "{bounds:?}");
    }

    proptest! {
        #[test]
        fn a_truncated_distribution_keeps_its_shape_within_its_limits(
            from in -5.0..5.0f64, length in 0.01..8.0f64, probability in 0.001..0.999f64,
        ) {
            let limits = Limits { from: Some(from), to: Some(from + length) };
            let distribution = Distribution::Normal { mean: 0.0, sd: 1.0, limits };
            prop_assume!(distribution.problem().is_none());
            let x = distribution.quantile(probability);
            prop_assert!((from..=from + length).contains(&x));
            // dx/du = mass/density.
            let step = 1e-5;
            let slope = (distribution.quantile(probability + step) - distribution.quantile(probability - step)) / (2.0 * step);
            let expected = mass([from, from + length]) / Normal::standard().pdf(x);
            prop_assert!((slope / expected - 1.0).abs() < 1e-3, "{slope} {expected}");
        }
    }
}
