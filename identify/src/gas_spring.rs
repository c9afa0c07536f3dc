//! The study of a measured gas spring: which effects a real chamber shows, what they are worth on a record that took no
//! part, and how well the first half of a hold forecasts the second.
//!
//! Two records of the same machine, two chambers. For each chamber the model is fitted to one record with the paper's
//! law, with every effect, with the best pairs and the best triples; each fit then predicts the other record with its
//! parameters as they are (only the initial state is that record's own). Pressures are reported in psi, as recorded.

use crate::diagnosis::{Estimates, as_map, parameters};
use crate::error::Error;
use crate::evidence;
use crate::fit::{self, Fit};
use crate::held_out;
use crate::hypothesis::{Sizes, names};
use crate::motion::{Phase, extent};
use crate::prepare::{Data, Prepared};
use crate::tracing::{self, Candidate};
use chamber::effects::{self, EffectSet};
use rayon::prelude::*;
use serde::Serialize;

/// Pa in a psi.
const PSI_PA: f64 = 6_894.757_293_168;
/// A hold's forecast begins this long after the stop, s.
const AFTER_STOP_S: f64 = 0.4;

/// A set of effects on one record, and what it predicts of the other.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The set.
    pub effects: Vec<&'static str>,
    /// BIC of the paper's model less its own.
    pub delta_bic: f64,
    /// Error on the record fitted, psi rms.
    pub fit_rms_psi: f64,
    /// Error on the other record, psi rms; `None` where it cannot be followed.
    pub other_rms_psi: Option<f64>,
    /// Its parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// One chamber on one record.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// The record fitted.
    pub fitted: String,
    /// The record predicted.
    pub predicted: String,
    /// Noise of the pressure, psi.
    pub noise_psi: f64,
    /// The paper's model first, then by evidence.
    pub rows: Vec<Row>,
}

/// One final hold, forecast from its first half by laws of three numbers each: Pf, ΔP and a time.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    /// The record.
    pub record: String,
    /// Window of the fit, s of the record.
    pub fitted_s: [f64; 2],
    /// Window of the forecast, s.
    pub forecast_s: [f64; 2],
    /// The paper's exponential: error of the forecast, psi rms.
    pub exponential_psi: f64,
    /// λ ∝ √(P T) exactly, 1 − Pf/P exponential: the same.
    pub eichelberg_psi: f64,
    /// λ ∝ |T − Tw|^¼, (1 + t/4τ)^−4: the same.
    pub natural_convection_psi: f64,
}

/// Fits one chamber to record `own` and predicts `other`.
///
/// # Errors
/// [`Error`]: data that cannot be what it should be.
pub fn record(own: &Data, other: &Data) -> Result<Record, Error> {
    let trace = tracing::trace(own, &|_, _| ())?;
    let sizes = Sizes::of(own, &trace.baseline.fit.chamber());
    let mut all: Vec<Candidate> = trace.tried.clone();
    // Triples: the three best pairs with every other effect.
    let pairs: Vec<&Candidate> = trace.tried.iter().filter(|c| c.effects.iter().count() == 2).take(3).collect();
    let mut sets: Vec<(EffectSet, &Fit)> = Vec::new();
    for pair in pairs {
        for (e, _) in effects::all() {
            let set = pair.effects.union(EffectSet::one(e));
            if set != pair.effects && !sets.iter().any(|(s, _)| *s == set) {
                sets.push((set, &pair.fit));
            }
        }
    }
    let selection = fit::all_blocks(own);
    let baseline_bic = evidence::bic(own, &trace.baseline.fit, trace.samples);
    let triples: Vec<Candidate> = sets
        .par_iter()
        .filter_map(|(set, part)| crate::candidates::fit_set(own, *set, part, &sizes, &selection))
        .map(|fit| Candidate {
            effects: fit.hypothesis.effects,
            delta_bic: baseline_bic - evidence::bic(own, &fit, trace.samples),
            fit,
            held_out_pa: None,
        })
        .collect();
    all.extend(triples);
    all.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
    // The paper's model, the best of each size, and every effect alone.
    let of_size = |n: usize, most: usize| all.iter().filter(move |c| c.effects.iter().count() == n).take(most);
    let shown: Vec<&Candidate> = std::iter::once(&trace.baseline)
        .chain(of_size(3, 4))
        .chain(of_size(2, 6))
        .chain(of_size(1, effects::COUNT))
        .collect();
    let rows = shown.par_iter().map(|c| row(own, other, c)).collect();
    let file = |d: &Data| d.traces[0].path.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
    Ok(Record { fitted: file(own), predicted: file(other), noise_psi: own.noise.sd_pa / PSI_PA, rows })
}

fn row(own: &Data, other: &Data, c: &Candidate) -> Row {
    Row {
        effects: names(c.effects),
        delta_bic: c.delta_bic,
        fit_rms_psi: evidence::rms(&evidence::residuals(own, &c.fit)) / PSI_PA,
        other_rms_psi: held_out::on_other(&c.fit, other).map(|r| evidence::rms(&r) / PSI_PA),
        parameters: parameters(own, &c.fit, false),
    }
}

/// When the piston stops for the last time, s: from then on it stays within a five-thousandth of the record's stroke, or its
/// position's noise, over seven rows. `None` where the record does not end in a hold.
fn stop(t: &Prepared) -> Option<f64> {
    const REACH: usize = 3;
    const SHARE: f64 = 2e-4;
    let segments = &t.course.motion.segments;
    segments.last().filter(|s| s.phase == Phase::Hold)?;
    let near = std::cell::Cell::new(0);
    let position: Vec<f64> =
        segments.iter().flat_map(|s| t.time_s[s.first..s.end].iter().map(|time| s.stroke.at(*time, &near).0)).collect();
    let (low, high) = extent(&position);
    let most = (SHARE * (high - low)).max(8.0 * t.course.motion.noise_m);
    let moves = |i: &usize| {
        let (low, high) = extent(&position[i.saturating_sub(REACH)..(i + REACH + 1).min(position.len())]);
        high - low > most
    };
    (0..position.len()).rev().find(moves).and_then(|last| t.time_s.get(last + 1).copied())
}

/// The final hold of a record: its first half forecasts its second. `None` where the record does not end in a hold.
pub fn forecast(t: &Prepared) -> Option<Forecast> {
    let stop = stop(t)?;
    let rows: Vec<usize> = (0..t.time_s.len()).filter(|&i| t.time_s[i] >= stop + AFTER_STOP_S).collect();
    let (begin, end) = (t.time_s[*rows.first()?], t.time_s[*rows.last()?]);
    let middle = 0.5 * (begin + end);
    let points = |first: bool| -> Vec<(f64, f64)> {
        rows.iter()
            .filter(|&&i| (t.time_s[i] < middle) == first)
            .map(|&i| (t.time_s[i] - begin, t.pressure_pa[i] / PSI_PA))
            .collect()
    };
    let (fitted, judged) = (points(true), points(false));
    let exponential = |t: f64, tau: f64| (-t / tau).exp();
    let quarter = |t: f64, tau: f64| (1.0 + t / (4.0 * tau)).powi(-4);
    let inverse = |p: &[(f64, f64)]| -> Vec<(f64, f64)> { p.iter().map(|(t, p)| (*t, 1.0 / p)).collect() };
    let eichelberg = {
        let law = Law::fit(&inverse(&fitted), exponential);
        rms(&judged, |t| 1.0 / law.at(t))
    };
    let by = |shape: fn(f64, f64) -> f64| {
        let law = Law::fit(&fitted, shape);
        rms(&judged, |t| law.at(t))
    };
    Some(Forecast {
        record: t.path.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned()),
        fitted_s: [begin, middle],
        forecast_s: [middle, end],
        exponential_psi: by(exponential),
        eichelberg_psi: eichelberg,
        natural_convection_psi: by(quarter),
    })
}

fn rms(points: &[(f64, f64)], law: impl Fn(f64) -> f64) -> f64 {
    (points.iter().map(|(t, p)| (p - law(*t)).powi(2)).sum::<f64>() / points.len().max(1) as f64).sqrt()
}

/// y = end + rise · shape(t, τ).
struct Law<F> {
    end: f64,
    rise: f64,
    tau: f64,
    shape: F,
}

impl<F: Fn(f64, f64) -> f64> Law<F> {
    /// Least squares: two numbers enter linearly, τ is searched on a logarithmic scale, then by golden section.
    fn fit(points: &[(f64, f64)], shape: F) -> Self {
        let solve = |tau: f64| {
            let n = points.len() as f64;
            let (mut s, mut ss, mut y, mut sy) = (0.0, 0.0, 0.0, 0.0);
            for (t, p) in points {
                let f = shape(*t, tau);
                s += f;
                ss += f * f;
                y += p;
                sy += f * p;
            }
            let rise = (sy - s * y / n) / (ss - s * s / n);
            let end = (y - rise * s) / n;
            let misfit: f64 = points.iter().map(|(t, p)| (p - end - rise * shape(*t, tau)).powi(2)).sum();
            (misfit, end, rise)
        };
        let longest = points.last().map_or(1.0, |p| p.0);
        let grid: Vec<f64> = (0..60).map(|k| longest * 10f64.powf(-2.5 + f64::from(k) * 0.065)).collect();
        let best = (0..grid.len()).min_by(|a, b| solve(grid[*a]).0.total_cmp(&solve(grid[*b]).0)).unwrap_or(30);
        let (mut low, mut high) = (grid[best.saturating_sub(1)].ln(), grid[(best + 1).min(grid.len() - 1)].ln());
        for _ in 0..60 {
            let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
            if solve(a.exp()).0 < solve(b.exp()).0 {
                high = b;
            } else {
                low = a;
            }
        }
        let tau = (0.5 * (low + high)).exp();
        let (_, end, rise) = solve(tau);
        Self { end, rise, tau, shape }
    }

    fn at(&self, t: f64) -> f64 {
        self.end + self.rise * (self.shape)(t, self.tau)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_that_made_the_points_is_found_again() {
        let quarter = |t: f64, tau: f64| (1.0 + t / (4.0 * tau)).powi(-4);
        let points: Vec<(f64, f64)> =
            (0..300).map(|k| f64::from(k) * 0.02).map(|t| (t, 88.0 + 6.5 * quarter(t, 1.7))).collect();
        let law = Law::fit(&points, quarter);
        assert!((law.tau / 1.7 - 1.0).abs() < 1e-5 && (law.end - 88.0).abs() < 1e-5 && (law.rise - 6.5).abs() < 1e-4);
        assert!(rms(&points, |t| law.at(t)) < 1e-8);
    }
}
