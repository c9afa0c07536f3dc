//! Intervals of what was fitted, and what the data does not determine.
//!
//! Covariance: inverse of the normal matrix (locals eliminated), whose weights carry the noise's autocorrelation and the
//! position's noise. Where the residual is more than noise, the variance between traces is the larger truth (sandwich
//! estimator with traces as clusters; blocks in a single trace): the wider of the two is reported.

use crate::fit::Fit;
use crate::report::number;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::Serialize;

/// A number with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Its unit.
    pub unit: String,
}

impl Estimate {
    /// Its interval, for people.
    pub fn interval(&self) -> String {
        format!("{} … {}", number(self.ci95[0], 5), number(self.ci95[1], 5))
    }
}

/// A combination of parameters that the data hardly determines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// The parameters, with their shares.
    pub parameters: Vec<(String, f64)>,
    /// Standard deviation of the combination, in relative units.
    pub relative_deviation: f64,
}

impl Undetermined {
    /// The combination and how far it is off, for people.
    pub fn words(&self) -> String {
        let parts: Vec<String> = self.parameters.iter().map(|(name, share)| format!("{share:+.2} {name}")).collect();
        let how = match self.relative_deviation {
            far if far > 100.0 => "not at all".to_owned(),
            near => format!("relative deviation {}", number(near, 2)),
        };
        format!("{} ({how})", parts.join(" "))
    }
}

/// Two-sided 95 % quantile of the normal distribution.
const NORMAL_95: f64 = 1.959_963_985;

/// Covariance of the global coordinates; of no extent in coordinates at a bound.
pub fn covariance(fit: &Fit, residual_is_noise: bool) -> DMatrix<f64> {
    let n = fit.globals.len();
    let free: Vec<usize> = (0..n).filter(|&i| !fit.at_bound[i] && fit.information[(i, i)] > 0.0).collect();
    let m = free.len();
    let information = DMatrix::from_fn(m, m, |i, j| fit.information[(free[i], free[j])]);
    let Some(inverse) = inverse(&information) else { return DMatrix::from_diagonal_element(n, n, f64::INFINITY) };
    let mut covariance = inverse.clone();
    if !residual_is_noise {
        let robust = &inverse * meat(fit, &free) * &inverse;
        let freedom = (fit.blocks as f64 - m as f64).max(1.0);
        let scale = (fit.chi2 / freedom).max(1.0);
        for i in 0..m {
            let wider = (robust[(i, i)] / covariance[(i, i)]).max(scale).sqrt();
            for j in 0..m {
                covariance[(i, j)] *= wider;
                covariance[(j, i)] *= wider;
            }
        }
    }
    let mut out = DMatrix::zeros(n, n);
    for i in 0..m {
        for j in 0..m {
            out[(free[i], free[j])] = covariance[(i, j)];
        }
    }
    out
}

/// Inverse of a symmetric matrix whose rows differ in size.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / matrix[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j] + if i == j { 1e-13 } else { 0.0 });
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// Σ over clusters of score scoreᵀ, locals projected out.
fn meat(fit: &Fit, free: &[usize]) -> DMatrix<f64> {
    const PARTS_OF_ONE: usize = 12;
    let m = free.len();
    let mut sum = DMatrix::<f64>::zeros(m, m);
    let traces = fit.linear.iter().filter(|l| !l.residual.is_empty()).count();
    let mut clusters = 0.0;
    for l in fit.linear.iter().filter(|l| !l.residual.is_empty()) {
        let projected = project_out(&l.by_global, &l.by_local);
        let rows = l.residual.len();
        let size = if traces >= 6 { rows } else { rows.div_ceil(PARTS_OF_ONE) };
        for first in (0..rows).step_by(size.max(1)) {
            let mut score = DVector::<f64>::zeros(m);
            for row in first..(first + size).min(rows) {
                for (i, &f) in free.iter().enumerate() {
                    score[i] += projected[(row, f)] * l.residual[row];
                }
            }
            sum += &score * score.transpose();
            clusters += 1.0;
        }
    }
    let correction: f64 = clusters / (clusters - m as f64).max(1.0);
    sum * correction
}

/// `columns` less their projection on `onto`.
pub fn project_out(columns: &DMatrix<f64>, onto: &DMatrix<f64>) -> DMatrix<f64> {
    if onto.ncols() == 0 || onto.nrows() == 0 {
        return columns.clone();
    }
    match (onto.tr_mul(onto)).cholesky() {
        Some(square) => columns - onto * square.solve(&onto.tr_mul(columns)),
        None => columns.clone(),
    }
}

/// Values and intervals of the globals.
pub fn estimates(fit: &Fit, covariance: &DMatrix<f64>, lambda_extra: f64) -> Vec<(String, Estimate)> {
    let h = &fit.hypothesis;
    h.axes
        .iter()
        .enumerate()
        .map(|(i, axis)| {
            let x = fit.globals[i];
            let extra = if i == 0 { lambda_extra } else { 0.0 };
            let half = NORMAL_95 * (covariance[(i, i)] + extra * extra).sqrt();
            let bounded = |x: f64| axis.value(x.clamp(axis.bounds[0], axis.bounds[1]));
            let estimate = Estimate {
                value: axis.value(x),
                ci95: [bounded(x - half), bounded(x + half)],
                unit: axis.slot.unit().to_owned(),
            };
            (axis.slot.name(), estimate)
        })
        .collect()
}

/// Directions whose relative uncertainty is beyond a third: parameters, or sums and differences of them.
pub fn undetermined(fit: &Fit) -> Vec<Undetermined> {
    const TOO_WIDE: f64 = 0.33;
    let h = &fit.hypothesis;
    let free: Vec<usize> = (0..fit.globals.len()).filter(|&i| !fit.at_bound[i]).collect();
    // In units of each parameter's own size: d ln value, or d value/size.
    let size: Vec<f64> =
        free.iter().map(|&i| if h.axes[i].logarithmic { 1.0 } else { fit.globals[i].abs().max(1e-3) }).collect();
    let n = free.len();
    if n == 0 {
        return Vec::new();
    }
    let relative = DMatrix::from_fn(n, n, |i, j| fit.information[(free[i], free[j])] * size[i] * size[j]);
    let eigen = SymmetricEigen::new(relative);
    (0..n)
        .filter_map(|k| {
            let deviation = 1.0 / eigen.eigenvalues[k].max(1e-300).sqrt();
            (deviation > TOO_WIDE).then(|| {
                let vector = eigen.eigenvectors.column(k);
                let parameters = (0..n)
                    .filter(|&i| vector[i].abs() > 0.2)
                    .map(|i| (h.axes[free[i]].slot.name(), vector[i]))
                    .collect();
                Undetermined { parameters, relative_deviation: deviation }
            })
        })
        .collect()
}
