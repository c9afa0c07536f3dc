//! The missing term as a curve: what a diagnosis says of it.

use crate::discrepancy;
use crate::fit::covariance;
use crate::outcome::unnamed::Unnamed;
use crate::parameters::Slot;
use crate::search::curve::ReadOff;
use serde::Serialize;

/// A missing term read off the data, refitted with everything else.
#[derive(Clone, Debug, Serialize)]
pub struct Empirical {
    /// Whether it is in the model: it predicts experiments left out whole decisively better.
    pub accepted: bool,
    /// What it is, as in model files.
    pub balance: &'static str,
    /// What it is, for people.
    pub quantity: &'static str,
    /// Unit of [`Empirical::values`].
    pub unit: &'static str,
    /// What it follows, for people.
    pub variable: &'static str,
    /// Unit of [`Empirical::knots`].
    pub variable_unit: &'static str,
    /// Values of the variable; between them the term is linear, beyond them constant.
    pub knots: Vec<f64>,
    /// The term there.
    pub values: Vec<f64>,
    /// Its 95 % intervals.
    pub ci95: Vec<[f64; 2]>,
    /// Error on experiments left out whole, Pa rms.
    pub left_out_rmse_pa: LeftOut,
}

impl Empirical {
    /// The same as a term is shown that is not refitted.
    pub fn as_first_order(&self) -> Unnamed {
        Unnamed {
            balance: self.balance,
            quantity: self.quantity,
            unit: self.unit,
            variable: self.variable,
            variable_unit: self.variable_unit,
            at: self.knots.clone(),
            value: self.values.clone(),
            sd: self.ci95.iter().map(|[low, high]| 0.25 * (high - low)).collect(),
            share: 0.0,
        }
    }
}

/// Errors on experiments left out whole, Pa rms.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LeftOut {
    /// Of the model without the curve.
    pub without: f64,
    /// Of the model with it.
    pub with: f64,
}

impl Empirical {
    /// What was found, in words and numbers.
    pub fn of(found: &ReadOff, residual_is_noise: bool) -> Option<Self> {
        let (effect, curve) = (ReadOff::effect()?, found.curve()?);
        let fit = &found.candidate.fit;
        let covariance = covariance::covariance(fit, residual_is_noise);
        let values = fit.hypothesis.axes.iter().zip(covariance::estimates(fit, &covariance));
        let ci95 = values.filter(|(axis, _)| matches!(axis.slot, Slot::Effect(e, _) if e == effect));
        let variable = found.first_order.variable;
        Some(Self {
            accepted: found.accepted,
            balance: curve.term.word(),
            quantity: discrepancy::quantity(curve.term),
            unit: curve.term.unit(),
            variable: variable.name().0,
            variable_unit: variable.name().1,
            knots: curve.knots,
            values: curve.values,
            ci95: ci95.map(|(_, (_, estimate))| estimate.ci95).collect(),
            left_out_rmse_pa: LeftOut { without: found.left_out_pa[0], with: found.left_out_pa[1] },
        })
    }
}
