//! The paper's model fitted to all data, with outliers left out and the noise that its residual shows.

use crate::error::Error;
use crate::fit::{self, Failure, Fit};
use crate::judge::misfit;
use crate::parameters::{Hypothesis, Model, Sizes, first_chamber};
use crate::policy::FIRST_GUESS_REACH;
use crate::record::colour;
use crate::record::data::Data;
use crate::record::noise::Noise;
use crate::record::plausibility::outliers;
use crate::record::plausibility::unlike_repeats;
use rayon::prelude::*;

/// Fits the paper's model; returns the data without outliers and with the noise that the fit shows.
///
/// # Errors
/// Where its simulation fails at the starting point.
pub fn fitted(data: Data) -> Result<(Data, Fit), Error> {
    let (data, first, residuals) = without_unlike_repeats(data)?;
    let found = outliers::in_residuals(&data, &residuals);
    let cleaned = !data.is_without(&found);
    let data = if cleaned { data.without(&found) } else { data };
    let noise = colour::estimate(&data, &residuals, &data.noise);
    if !cleaned && is_alike(&noise, &data.noise) {
        return Ok((data, first));
    }
    let data = data.with_noise(noise);
    let again = fit::fit(&data, &first.hypothesis, first.rig.clone(), first.records.clone(), &fit::all_blocks(&data));
    let fit = again.map_err(|(k, source)| Error::Simulation { trace: data.traces[k].path.clone(), source })?;
    Ok((data, fit))
}

/// The paper's model fitted without records unlike their repeats, and its residuals on all, Pa.
fn without_unlike_repeats(data: Data) -> Result<(Data, Fit, Vec<Vec<f64>>), Error> {
    let first = from_scratch(&data)?;
    let residuals = misfit::residuals(&data, &first);
    let unlike = unlike_repeats::among(&data, &residuals);
    if unlike.is_empty() {
        return Ok((data, first, residuals));
    }
    let fitted = |data: Data| {
        let fit = from_scratch(&data)?;
        let residuals = misfit::residuals(&data, &fit);
        Ok((data, fit, residuals))
    };
    let without = fitted(data.without_records(&unlike))?;
    let better = unlike_repeats::better_of_pairs(&without.0, &without.2, &unlike);
    if better.is_empty() { Ok(without) } else { fitted(without.0.with_records_again(&better)) }
}

/// Whether two noise estimates weight data alike.
pub fn is_alike(a: &Noise, b: &Noise) -> bool {
    const NEARLY: f64 = 0.05;
    let near = |x: f64, y: f64| (x - y).abs() <= NEARLY * x.abs().max(y.abs());
    near(a.white_pa, b.white_pa)
        && a.colours.len() == b.colours.len()
        && a.colours.iter().zip(&b.colours).all(|(a, b)| near(a.sd_pa, b.sd_pa) && near(a.time_s, b.time_s))
        && a.hum.is_some() == b.hum.is_some()
}

fn from_scratch(data: &Data) -> Result<Fit, Error> {
    let first = first_chamber(data);
    let h = Hypothesis::new(data, Model::PAPER, &first, &Sizes::of(data, &first));
    let selection = fit::all_blocks(data);
    let from = |offset: f64| {
        let mut x = h.coordinates(&first);
        x[0] += offset;
        fit::fit(data, &h, x, h.record_guesses(data), &selection)
    };
    // λ0 may be far from the first guess: the best of three starts.
    let farther = || [FIRST_GUESS_REACH, -FIRST_GUESS_REACH].into_par_iter().map(from).collect::<Vec<_>>();
    let (near, farther) = rayon::join(|| from(0.0), farther);
    let best = farther.into_iter().fold(near, better);
    best.map_err(|(k, source)| Error::Simulation { trace: data.traces[k].path.clone(), source })
}

/// The fit with the smaller χ²; of two that failed, the latter.
fn better(one: Result<Fit, Failure>, other: Result<Fit, Failure>) -> Result<Fit, Failure> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok(if other.chi2 < one.chi2 { other } else { one }),
        (one, Err(_)) if one.is_ok() => one,
        (_, other) => other,
    }
}
