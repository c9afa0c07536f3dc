//! The missing term as a curve, as a diagnosis reports it.

use crate::fit::covariance;
use crate::outcome::unnamed::Subject;
use crate::parameters::Slot;
use crate::search::curve::{CurveFit, Fate};
use chamber::effects;
use serde::{Serialize, Serializer};

/// A missing term as a curve, refitted with everything else.
#[derive(Clone, Debug, Serialize)]
pub struct Empirical {
    /// Whether it is in the model, and if not, why; only the former is serialised.
    #[serde(rename = "accepted", serialize_with = "is_accepted")]
    pub fate: Fate,
    /// Its keyword in model files.
    #[serde(rename = "balance")]
    pub word: &'static str,
    /// The missing quantity and its variable.
    #[serde(flatten)]
    pub subject: Subject,
    /// Values of the variable; between them the term is linear, beyond them constant.
    pub knots: Vec<f64>,
    /// The term at the knots.
    pub values: Vec<f64>,
    /// Their 95 % intervals.
    pub ci95: Vec<[f64; 2]>,
    /// Error on experiments left out whole, Pa rms.
    pub left_out_rmse_pa: LeftOut,
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
    /// The curve that the search found; `None` without one.
    pub fn of(found: &CurveFit, leaves_noise: bool) -> Option<Self> {
        let (effect, curve) = (effects::Empirical::INDEX, found.curve()?);
        let fit = &found.candidate.fit;
        let covariance = covariance::covariance(fit, leaves_noise);
        let values = fit.hypothesis.axes.iter().zip(covariance::estimates(fit, &covariance));
        let ci95 = values.filter(|(axis, _)| matches!(axis.slot, Slot::Effect(e, _) if e == effect));
        Some(Self {
            fate: found.fate,
            word: curve.term.word(),
            subject: Subject { term: curve.term, variable: found.first_order.variable },
            knots: curve.knots,
            values: curve.values,
            ci95: ci95.map(|(_, (_, estimate))| estimate.ci95).collect(),
            left_out_rmse_pa: LeftOut { without: found.left_out_pa[0], with: found.left_out_pa[1] },
        })
    }
}

fn is_accepted<S: Serializer>(fate: &Fate, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(fate.is_accepted())
}
