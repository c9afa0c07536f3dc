//! Confidence intervals of the fitted parameters, and combinations that the data does not determine.
//!
//! Covariance: inverse of the normal matrix (per-record parameters eliminated), whose weights contain the coloured noise and the
//! position noise. Where a fit leaves more than noise, even if less than the requested accuracy, each variance is the larger of
//! two: this one times the sum of squares over its expectation, and that of the sandwich estimator, whose clusters are the
//! records, or parts of them if there are fewer than six. The tolerances of the stated parameters are propagated through the fit
//! and added (JCGM 100:2008, equation 10).

use crate::fit::Fit;
use crate::parameters::{Axis, Slot};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use report::digits;
use serde::Serialize;

/// A number with its 95 % interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Best value, in `unit`.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
    /// Unit of value and interval.
    pub unit: String,
}

impl Estimate {
    /// The interval as text.
    pub fn interval(&self) -> String {
        format!("{} … {}", digits(self.ci95[0], 5), digits(self.ci95[1], 5))
    }
}

/// A combination of parameters that the data hardly determines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// The parameters, with their coefficients.
    pub parameters: Vec<(String, f64)>,
    /// Standard deviation of the combination, in relative units.
    pub relative_deviation: f64,
}

impl Undetermined {
    /// The combination and its uncertainty as text.
    pub fn words(&self) -> String {
        let how = match self.relative_deviation {
            far if far > 100.0 => "not determined at all".to_owned(),
            near => format!("relative standard deviation {}", digits(near, 2)),
        };
        if let [(name, _)] = self.parameters.as_slice() {
            return format!("{name} ({how})");
        }
        let parts: Vec<String> = self.parameters.iter().map(|(name, share)| format!("{share:+.2} {name}")).collect();
        format!("{} ({how})", parts.join(" "))
    }
}

/// Relative standard deviation above which the data hardly determine a parameter.
pub const HARDLY_DETERMINED: f64 = 0.33;
/// Two-sided 95 % quantile of the normal distribution.
pub const NORMAL_95: f64 = 1.959_963_985;

/// Covariance of the rig's free coordinates about the values at the stated parameters: the contribution of the records plus the
/// tolerances of the stated parameters, propagated through the fit (JCGM 100:2008, equation 10); zero for coordinates at a bound.
/// The values do not move with the stated parameters, so what the records show of those does not make the values more certain.
pub fn covariance(fit: &Fit, leaves_noise: bool) -> DMatrix<f64> {
    of_all(fit, leaves_noise, |parts| &parts.records + &parts.by_stated * parts.by_stated.transpose())
}

/// The same from the records alone: how far the values may be off in another recording of the same tests.
pub fn by_records(fit: &Fit, leaves_noise: bool) -> DMatrix<f64> {
    of_all(fit, leaves_noise, |parts| parts.records.clone())
}

/// Expands a covariance of the coordinates that are not at a bound to all coordinates.
fn of_all(fit: &Fit, leaves_noise: bool, of: impl Fn(&Parts) -> DMatrix<f64>) -> DMatrix<f64> {
    let n = fit.rig.len();
    let Some(parts) = Parts::of(fit, leaves_noise) else {
        return DMatrix::from_diagonal_element(n, n, f64::INFINITY);
    };
    let among_free = of(&parts);
    let mut out = DMatrix::zeros(n, n);
    for (i, &row) in parts.free.iter().enumerate() {
        for (j, &column) in parts.free.iter().enumerate() {
            out[(row, column)] = among_free[(i, j)];
        }
    }
    out
}

/// Fractions of a coordinate's variance that come from the records and from the tolerance of each stated parameter.
pub fn budget(fit: &Fit, coordinate: usize, leaves_noise: bool) -> Vec<(String, f64)> {
    let Some(parts) = Parts::of(fit, leaves_noise) else { return Vec::new() };
    let Some(index) = parts.free.iter().position(|&i| i == coordinate) else { return Vec::new() };
    let mut shares = vec![("records".to_owned(), parts.records[(index, index)])];
    for (axis, by) in fit.hypothesis.stated.iter().zip(parts.by_stated.row(index).iter()) {
        let name = axis.slot.name();
        match shares.last_mut().filter(|(last, _)| *last == name) {
            Some((_, share)) => *share += by * by,
            None => shares.push((name, by * by)),
        }
    }
    let sum: f64 = shares.iter().map(|(_, v)| v).sum();
    shares.into_iter().map(|(name, v)| (name, if sum > 0.0 { v / sum } else { 0.0 })).collect()
}

/// Error contributions to the rig's free coordinates.
struct Parts {
    /// Indices of the coordinates that are not at a bound.
    free: Vec<usize>,
    /// Their covariance from the records alone.
    records: DMatrix<f64>,
    /// Error of each per tolerance of each stated parameter.
    by_stated: DMatrix<f64>,
}

impl Parts {
    fn of(fit: &Fit, leaves_noise: bool) -> Option<Self> {
        let n = fit.rig.len();
        let free = determined(fit);
        let m = free.len();
        let stated = fit.information.ncols() - n;
        let inverse = inverse_among(fit, &free)?;
        let by_stated = DMatrix::from_fn(m, stated, |i, k| fit.information[(free[i], n + k)]);
        let by_stated = &inverse * by_stated * spread_of_stated(fit, leaves_noise);
        let mut records = inverse.clone();
        if !leaves_noise {
            let scale = excess(fit, m);
            for (i, inflation) in inflations(fit, &free, &inverse).iter().enumerate() {
                let wider = inflation.max(scale).sqrt();
                records.row_mut(i).scale_mut(wider);
                records.column_mut(i).scale_mut(wider);
            }
        }
        Some(Self { free, records, by_stated })
    }
}

/// Free coordinates that are not at a bound and have influence.
fn determined(fit: &Fit) -> Vec<usize> {
    (0..fit.rig.len()).filter(|&i| !fit.at_bound[i] && fit.information[(i, i)] > 0.0).collect()
}

/// Covariance of these coordinates by the noise alone.
fn inverse_among(fit: &Fit, coordinates: &[usize]) -> Option<DMatrix<f64>> {
    let m = coordinates.len();
    inverse(&DMatrix::from_fn(m, m, |i, j| fit.information[(coordinates[i], coordinates[j])]))
}

/// Sum of squares of a fit of this many coordinates over its expectation; at least one.
fn excess(fit: &Fit, coordinates: usize) -> f64 {
    (fit.marginal / (fit.blocks as f64 - coordinates as f64).max(1.0)).max(1.0)
}

/// For each of these coordinates the variance of the sandwich estimator over that by the noise alone, `inverse`.
fn inflations(fit: &Fit, coordinates: &[usize], inverse: &DMatrix<f64>) -> DVector<f64> {
    let robust = inverse * cluster_score_sum(fit, coordinates) * inverse;
    robust.diagonal().component_div(&inverse.diagonal())
}

/// Standard error of each stated parameter, in tolerances. It is one, except for the waves of a position sensor and, in a fit
/// that leaves only noise, for the heat capacity ratio and the position zero, which are moved to the values that the records
/// favour. The records constrain these further: √(variance beside all others + best value²), at most one.
fn spread_of_stated(fit: &Fit, leaves_noise: bool) -> DMatrix<f64> {
    let (free, all) = (fit.rig.len(), fit.information.ncols());
    let adapting: Vec<usize> = (0..all).filter(|&i| fit.adapts[i] && fit.information[(i, i)] > 0.0).collect();
    let count = adapting.len();
    let known = inverse(&DMatrix::from_fn(count, count, |i, j| fit.information[(adapting[i], adapting[j])]));
    let is_searched = |slot| matches!(slot, Slot::HeatCapacityRatio | Slot::PositionZero);
    let shows = |axis: &Axis| axis.slot.is_wave() || leaves_noise && is_searched(axis.slot);
    let left_possible = |k: usize| {
        let index = adapting.iter().position(|&i| i == free + k).filter(|_| shows(&fit.hypothesis.stated[k]))?;
        let variance = known.as_ref()?[(index, index)];
        Some((variance + fit.moved[k] * fit.moved[k]).sqrt().min(1.0))
    };
    DMatrix::from_diagonal(&DVector::from_fn(all - free, |k, _| left_possible(k).unwrap_or(1.0)))
}

/// Design effect of a fit that leaves more than noise: the number of its blocks over that of independent ones which would tell as much.
/// It is the mean, over the free coordinates, of the sandwich estimator's variance over that of independent blocks with the
/// same squares; at least one.
pub fn design_effect(fit: &Fit) -> f64 {
    let free = determined(fit);
    let count = free.len() as f64;
    let Some(inverse) = inverse_among(fit, &free) else { return 1.0 };
    let ratios = inflations(fit, &free, &inverse);
    (ratios.sum() / (count * excess(fit, free.len()))).max(1.0)
}

/// Covariance of a record's coordinates, including the uncertainty of the rig's.
pub fn of_record(fit: &Fit, record: usize, rig: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let l = &fit.linear[record];
    let free = fit.rig.len();
    let of_record = inverse(&l.by_record.tr_mul(&l.by_record))?;
    let follows = &of_record * l.by_record.tr_mul(&l.by_rig.columns(0, free));
    Some(&of_record + &follows * rig * follows.transpose())
}

/// Inverse of a symmetric matrix whose rows differ in scale.
fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / matrix[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j] + if i == j { 1e-13 } else { 0.0 });
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}

/// Σ over clusters of score scoreᵀ (the "meat" of the sandwich estimator), with the per-record parameters projected out.
fn cluster_score_sum(fit: &Fit, free: &[usize]) -> DMatrix<f64> {
    const PARTS_OF_ONE: usize = 12;
    let m = free.len();
    let mut sum = DMatrix::<f64>::zeros(m, m);
    let traces = fit.linear.iter().filter(|l| l.blocks > 0).count();
    let mut clusters = 0.0;
    for l in fit.linear.iter().filter(|l| l.blocks > 0) {
        let projected = project_out(&l.by_rig, &l.by_record);
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

/// `columns` minus their projection on `onto`.
pub fn project_out(columns: &DMatrix<f64>, onto: &DMatrix<f64>) -> DMatrix<f64> {
    if onto.ncols() == 0 || onto.nrows() == 0 {
        return columns.clone();
    }
    match (onto.tr_mul(onto)).cholesky() {
        Some(square) => columns - onto * square.solve(&onto.tr_mul(columns)),
        None => columns.clone(),
    }
}

/// Values and intervals of the rig's free parameters; at a bound, the interval extends to the allowed side.
pub fn estimates(fit: &Fit, covariance: &DMatrix<f64>) -> Vec<(String, Estimate)> {
    let h = &fit.hypothesis;
    let variance = |i: usize| if fit.at_bound[i] { profile_variance(fit, i) } else { covariance[(i, i)] };
    let each = h.axes.iter().zip(&fit.rig).enumerate();
    each.map(|(i, (axis, x))| {
        let mut estimate = estimate(axis, *x, variance(i), h.unit(axis.slot));
        if axis.slot == Slot::DeadVolume {
            // See [`Fit::chamber_of_rig`]: a negative dead volume is reported as zero, with the interval of a value at that
            // bound.
            let missing = (-estimate.value).max(0.0);
            estimate.value += missing;
            estimate.ci95 = estimate.ci95.map(|end| (end + missing).max(0.0));
        }
        (axis.slot.name(), estimate)
    })
    .collect()
}

/// Variance of a coordinate together with the other free ones and the stated parameters within their tolerances; this coordinate
/// counts as free even at a bound. What the records allow on the bound's one side is at most half a normal distribution, 95 % of
/// which lies within the same 1.96 standard deviations. Zero for a parameter without influence.
pub fn profile_variance(fit: &Fit, coordinate: usize) -> f64 {
    let free = fit.rig.len();
    let takes_part = |i: usize| fit.information[(i, i)] > 0.0 && (i >= free || i == coordinate || !fit.at_bound[i]);
    let indices: Vec<usize> = (0..fit.information.nrows()).filter(|&i| takes_part(i)).collect();
    let Some(index) = indices.iter().position(|&i| i == coordinate) else { return 0.0 };
    let n = indices.len();
    let inverse = inverse(&DMatrix::from_fn(n, n, |i, j| fit.information[(indices[i], indices[j])]));
    inverse.map_or(0.0, |inverse| inverse[(index, index)] * excess(fit, n))
}

/// Covariance of the values of the rig's free parameters, in their units, row by row.
pub fn of_values(fit: &Fit, covariance: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let slopes: Vec<f64> = fit.hypothesis.axes.iter().zip(&fit.rig).map(|(axis, x)| axis.slope(*x)).collect();
    let n = slopes.len();
    (0..n).map(|i| (0..n).map(|j| covariance[(i, j)] * slopes[i] * slopes[j]).collect()).collect()
}

/// The value of a coordinate with its interval.
pub fn estimate<S>(axis: &Axis<S>, x: f64, variance: f64, unit: &str) -> Estimate {
    let half = NORMAL_95 * variance.sqrt();
    let bounded = |x: f64| axis.value(x.clamp(axis.bounds[0], axis.bounds[1]));
    Estimate { value: axis.value(x), ci95: [bounded(x - half), bounded(x + half)], unit: unit.to_owned() }
}

/// Directions that the data hardly determine ([`HARDLY_DETERMINED`]): parameters, or sums and differences of them.
pub fn undetermined(fit: &Fit) -> Vec<Undetermined> {
    let h = &fit.hypothesis;
    let free: Vec<usize> = (0..fit.rig.len()).filter(|&i| !fit.at_bound[i]).collect();
    // In units of each parameter's own size: d ln value, or d value/size.
    let size: Vec<f64> =
        free.iter().map(|&i| if h.axes[i].logarithmic { 1.0 } else { fit.rig[i].abs().max(1e-3) }).collect();
    let n = free.len();
    if n == 0 {
        return Vec::new();
    }
    let relative = DMatrix::from_fn(n, n, |i, j| fit.information[(free[i], free[j])] * size[i] * size[j]);
    let eigen = SymmetricEigen::new(relative);
    (0..n)
        .filter_map(|k| {
            let deviation = 1.0 / eigen.eigenvalues[k].max(1e-300).sqrt();
            (deviation > HARDLY_DETERMINED).then(|| {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::data::Data;
    use crate::search::baseline;
    use crate::synthetic::Recipe;

    #[test]
    fn blocks_of_noise_are_independent_and_those_of_a_missing_effect_tell_less() {
        let of = |recipe: Recipe| design_effect(&baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap().1);
        let clean = of(Recipe::from_seed(5));
        let leaking = of(Recipe::from_seed(5).with("leakage", &[2e-11]));
        assert!(clean < 1.1 && leaking > 1.4, "{clean} {leaking}");
    }
}
