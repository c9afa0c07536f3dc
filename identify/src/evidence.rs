//! How much a fit is worth: BIC with the effective number of independent samples.
//!
//! BIC = n ln(S/n) + k ln n, S the weighted sum of squares of all rows (blocks and what lies within them), k the free
//! globals, n the number of independent samples: rows over 1 + 2 Σ ρ_j, ρ_j the autocorrelation of the residual that the
//! best model at hand leaves. White residuals count in full, a model that misses the data's shape is worth less.

use crate::fit::{Fit, readings};
use crate::prepare::Data;
use rayon::prelude::*;

/// Row residuals (measured − model), Pa, trace by trace.
pub fn residuals(data: &Data, fit: &Fit) -> Vec<Vec<f64>> {
    let chamber = fit.chamber();
    data.traces
        .par_iter()
        .zip(&fit.locals)
        .map(|(t, local)| match readings(t, &chamber, local) {
            Ok(model) => t.pressure_pa.iter().zip(model).map(|(y, m)| y - m).collect(),
            Err(_) => vec![f64::NAN; t.pressure_pa.len()],
        })
        .collect()
}

/// Root mean square over all rows.
pub fn rms(residuals: &[Vec<f64>]) -> f64 {
    let rows: usize = residuals.iter().map(Vec::len).sum();
    (residuals.iter().flatten().map(|r| r * r).sum::<f64>() / rows.max(1) as f64).sqrt()
}

/// Σ of squares of all rows, in units of the noise's variance, per independent sample.
pub fn squares(data: &Data, fit: &Fit) -> f64 {
    fit.chi2 + data.within.0 / data.noise.correlation_rows
}

/// Number of independent samples in row residuals.
pub fn effective_samples(residuals: &[Vec<f64>], correlation_rows: f64) -> f64 {
    let rows: f64 = residuals.iter().map(|r| r.len() as f64).sum();
    let product = |lag: usize| -> f64 {
        residuals
            .iter()
            .filter(|r| r.len() > lag)
            .map(|r| r.iter().zip(&r[lag..]).map(|(a, b)| a * b).sum::<f64>())
            .sum()
    };
    let power = product(0);
    let longest = residuals.iter().map(Vec::len).max().unwrap_or(0) / 4;
    let mut rows_per_sample = 1.0;
    let significant = 2.5 / rows.sqrt();
    // Lags in steps that grow, each standing for those around it.
    let mut lag = 1;
    while lag < longest {
        let step = (lag / 4).max(1);
        let rho = product(lag) / power;
        if rho.is_nan() || rho < significant {
            break;
        }
        rows_per_sample += 2.0 * rho * step as f64;
        lag += step;
    }
    (rows / rows_per_sample.max(correlation_rows)).max(2.0)
}

/// BIC of a fit.
pub fn bic(data: &Data, fit: &Fit, samples: f64) -> f64 {
    samples * squares(data, fit).ln() + fit.globals.len() as f64 * samples.ln()
}
