//! The uncertainty of a model's parameters as distributions: what `from = "model"` draws from.
//!
//! `identify` and `diagnose` fit some parameters on a linear and some on a logarithmic scale, and write the covariance of their
//! values with 95 % intervals. On the scale of the fit the parameters are jointly normal; the scale follows from the interval, v
//! ± 1.96 s or v exp(± 1.96 s/v). Each parameter is truncated at the bounds of its quantity.

use super::copula::Copula;
use super::distribution::{Distribution, Limits};
use super::point::Point;
use super::{Allowed, Base, all};
use nalgebra::DMatrix;
use records::Model;

/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// An uncertain parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in the model's `[uncertainty]`.
    pub name: String,
    /// Its index in [`all`].
    pub quantity: usize,
    /// Distribution of its value.
    pub distribution: Distribution,
}

/// The uncertain parameters of a model, and their correlations.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertain {
    /// The parameters, without those of zero variance, which a fit left at a bound.
    pub parameters: Vec<Parameter>,
    /// Their correlations on the scales of the fit.
    pub correlation: DMatrix<f64>,
}

impl Uncertain {
    /// Uncertain parameters of a model.
    ///
    /// # Errors
    /// Why there are none, in words that follow "the model".
    pub fn of(model: &Model) -> Result<Self, String> {
        let Some(uncertainty) = &model.uncertainty else {
            return Err("has no [uncertainty]: `identify` and `diagnose` write it".to_owned());
        };
        let (mut parameters, mut kept) = (Vec::new(), Vec::new());
        let point = Point::of_model(model);
        for (i, (name, ci95)) in uncertainty.parameters.iter().zip(&uncertainty.ci95).enumerate() {
            let sd = uncertainty.covariance[i][i].sqrt();
            if sd == 0.0 {
                continue;
            }
            let quantity = index_of(name)
                .ok_or_else(|| format!("has `{name}` in its [uncertainty], which is no number that can vary"))?;
            let allowed = &all()[quantity].allowed;
            let distribution = margin(point.0[quantity], sd, *ci95, allowed);
            if let Some(problem) = distribution.problem() {
                return Err(format!("has an [uncertainty] that does not fit: `{name}` {problem}"));
            }
            parameters.push(Parameter { name: name.clone(), quantity, distribution });
            kept.push(i);
        }
        let covariance = |i: usize, j: usize| uncertainty.covariance[kept[i]][kept[j]];
        let correlation = DMatrix::from_fn(kept.len(), kept.len(), |i, j| {
            if i == j { 1.0 } else { covariance(i, j) / (covariance(i, i) * covariance(j, j)).sqrt() }
        });
        Ok(Self { parameters, correlation })
    }

    /// Only the parameters for which `keep` is true; the others are marginalised.
    pub fn marginal(&self, keep: impl Fn(&Parameter) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.parameters.len()).filter(|i| keep(&self.parameters[*i])).collect();
        Self {
            parameters: kept.iter().map(|i| self.parameters[*i].clone()).collect(),
            correlation: self.correlation.select_rows(&kept).select_columns(&kept),
        }
    }
}

/// The copula of parameters with these correlations, in the columns with these indices.
///
/// # Errors
/// The correlations contradict each other; worded to follow "the model".
pub fn copula(columns: Vec<usize>, correlation: &DMatrix<f64>) -> Result<Copula, String> {
    Copula::new(columns, correlation).ok_or_else(|| {
        "has a covariance in its [uncertainty] that no numbers can have: its correlations contradict each other"
            .to_owned()
    })
}

/// Index of the quantity for a name in `[uncertainty]`.
fn index_of(name: &str) -> Option<usize> {
    let base = match name {
        "lambda0_w_per_m2_k" => Base::Coefficient,
        "dead_volume_m3" => Base::DeadVolume,
        "bore_m" => Base::Bore,
        "ambient_temperature_k" => Base::AmbientTemperature,
        _ => {
            let full = format!("effect.{name}");
            return all().iter().position(|q| q.name == full);
        }
    };
    Some(base as usize)
}

/// The distribution of a parameter from its value, standard deviation and interval.
fn margin(value: f64, sd: f64, ci95: [f64; 2], allowed: &Allowed) -> Distribution {
    let (from, to) = match allowed {
        Allowed::Above(least) => (Some(least.next_up()), None),
        Allowed::AtLeast(least) => (Some(*least), None),
        Allowed::Within(bounds) => (Some(*bounds.start()), Some(*bounds.end())),
    };
    let limits = Limits { from, to };
    let within = |x: f64| x.clamp(from.unwrap_or(f64::MIN), to.unwrap_or(f64::MAX));
    let misses = |ends: [f64; 2]| (within(ends[0]) - ci95[0]).abs() + (within(ends[1]) - ci95[1]).abs();
    let (half, ratio) = (NORMAL_95 * sd, (NORMAL_95 * sd / value).exp());
    let logarithmic = value > 0.0 && misses([value / ratio, value * ratio]) < misses([value - half, value + half]);
    if logarithmic {
        Distribution::LogNormal { median: value, sd_log: sd / value, limits }
    } else {
        Distribution::Normal { mean: value, sd, limits }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Allowed = Allowed::AtLeast(0.0);

    #[test]
    fn the_interval_shows_on_which_scale_a_parameter_was_fitted() {
        let (value, sd) = (30.0f64, 6.0f64);
        let logarithmic = [value / (NORMAL_95 * sd / value).exp(), value * (NORMAL_95 * sd / value).exp()];
        assert!(matches!(margin(value, sd, logarithmic, &ANY), Distribution::LogNormal { median: 30.0, .. }));
        let linear = [value - NORMAL_95 * sd, value + NORMAL_95 * sd];
        assert!(matches!(margin(value, sd, linear, &ANY), Distribution::Normal { mean: 30.0, sd: 6.0, .. }));
        // An interval cut off at a bound is classified by its other end.
        let cut = [0.0, value + NORMAL_95 * 25.0];
        assert!(matches!(margin(value, 25.0, cut, &ANY), Distribution::Normal { .. }));
    }

    #[test]
    fn a_drawn_parameter_has_the_interval_that_the_model_states() {
        for (value, sd) in [(30.0, 2.0), (1e-5, 1e-6)] {
            for logarithmic in [false, true] {
                let ratio = (NORMAL_95 * sd / value).exp();
                let ci95 = if logarithmic {
                    [value / ratio, value * ratio]
                } else {
                    [value - NORMAL_95 * sd, value + NORMAL_95 * sd]
                };
                let distribution = margin(value, sd, ci95, &ANY);
                for (probability, end) in [(0.025, ci95[0]), (0.975, ci95[1])] {
                    assert!((distribution.quantile(probability) / end - 1.0).abs() < 1e-6, "{distribution:?}");
                }
            }
        }
    }
}
