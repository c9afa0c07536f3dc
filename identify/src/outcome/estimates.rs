//! Parameters with intervals, and errors, as results state them.

use crate::fit::Fit;
use crate::fit::covariance::{self, Estimate};
use crate::record::data::Data;
use serde::Serialize;

/// Parameters by name, in a fixed order.
pub type Estimates = Vec<(String, Estimate)>;

/// Errors against what the sensor recorded, Pa.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rmse {
    /// On the data fitted.
    pub fit: f64,
    /// On data left out of the fit.
    pub held_out: Option<f64>,
}

/// The uncertainty of a fit in a model file: names, 95 % intervals and covariance of the free parameters, SI units.
pub fn uncertainty(fit: &Fit, leaves_noise: bool) -> records::Uncertainty {
    let covariance = covariance::covariance(fit, leaves_noise);
    let estimates = covariance::estimates(fit, &covariance);
    records::Uncertainty {
        parameters: estimates.iter().map(|(name, _)| name.clone()).collect(),
        ci95: estimates.iter().map(|(_, e)| e.ci95).collect(),
        covariance: covariance::of_values(fit, &covariance),
    }
}

/// Parameters of a fit with their intervals.
pub fn parameters(data: &Data, fit: &Fit, leaves_noise: bool) -> Estimates {
    let covariance = covariance::covariance(fit, leaves_noise);
    let mut out = covariance::estimates(fit, &covariance);
    if data.dead_volume_known {
        let value = data.dead_volume_m3;
        out.insert(1, ("dead_volume_m3".to_owned(), Estimate { value, ci95: [value; 2], unit: "m3".to_owned() }));
    }
    out
}

/// Serializes named numbers as one object.
pub(crate) fn as_map<T: Serialize, S: serde::Serializer>(
    numbers: &[(String, T)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(numbers.iter().map(|(k, v)| (k, v)))
}
