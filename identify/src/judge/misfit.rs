//! Residuals of a fit, in Pa: their total, and the systematic part.
//!
//! The systematic part is what remains beyond noise. Where an experiment has repeats, it is what their residuals have in common,
//! √(mean of products), less what the rounding of their positions may contribute. Elsewhere, and in a record where the model errs
//! by far more than noise, it is √(rms² − variance expected from noise and position). Readings that stick to a step are those of
//! a model within half a step: what lies beyond tells how far it is off. Source: lack of fit and pure error, e.g. Draper and
//! Smith, Applied Regression Analysis (1998), chapter 2.

use crate::fit::{Fit, readings};
use crate::parameters::Setting;
use crate::policy::FAR_BEYOND_NOISE;
use crate::record::blocks::Block;
use crate::record::data::{Data, Prepared};
use crate::record::repeats;
use crate::record::stroke::{Phase, Segment};
use chamber::effects::EffectSet;
use chamber::integrate::IntegrationError;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Row residuals (measured − model) of one record, Pa.
///
/// # Errors
/// Where the simulation of the record fails.
pub fn of_record(t: &Prepared, setting: &Setting<f64>, set: EffectSet) -> Result<Vec<f64>, IntegrationError> {
    let model = readings(t, setting, set)?;
    Ok(t.pressure_pa.iter().zip(model).map(|(y, m)| y - m).collect())
}

/// Row residuals, Pa, record by record; NaN where the simulation fails.
pub fn residuals(data: &Data, fit: &Fit) -> Vec<Vec<f64>> {
    each_record(data, fit, |k| fit.setting(&data.traces[k], &fit.records[k]))
}

/// The same with the stated parameters moved within their tolerances, as the fit favours.
pub fn residuals_moved(data: &Data, fit: &Fit) -> Vec<Vec<f64>> {
    // The free rig and per-record parameters adapt to the stated ones, to first order from the normal equations.
    each_record(data, fit, |k| {
        fit.hypothesis.setting(&data.traces[k], &fit.rig_moved(), &fit.moved, &fit.record_moved(data, k))
    })
}

fn each_record(data: &Data, fit: &Fit, setting: impl Fn(usize) -> Setting<f64> + Sync) -> Vec<Vec<f64>> {
    let set = fit.hypothesis.model.effects;
    data.traces
        .par_iter()
        .enumerate()
        .map(|(k, t)| of_record(t, &setting(k), set).unwrap_or_else(|_| vec![f64::NAN; t.pressure_pa.len()]))
        .collect()
}

/// Sum of squared residuals over the data rows starting at row `from`, and their number.
pub fn squares(t: &Prepared, residual: &[f64], from: usize) -> (f64, usize) {
    let rows = (from..residual.len()).filter(|&i| t.readout.is_data(i));
    rows.fold((0.0, 0), |(sum, n), i| (sum + residual[i] * residual[i], n + 1))
}

/// Root mean square over all data rows, Pa.
pub fn rms(data: &Data, residuals: &[Vec<f64>]) -> f64 {
    let each = data.traces.iter().zip(residuals).map(|(t, residual)| squares(t, residual, 0));
    let (sum, rows) = each.fold((0.0, 0), |(sum, rows), (s, n)| (sum + s, rows + n));
    (sum / rows.max(1) as f64).sqrt()
}

/// The same with each row's square weighted: see [`weights`].
pub fn weighed_rms(data: &Data, residuals: &[Vec<f64>]) -> f64 {
    rms(data, &data.traces.iter().zip(residuals).map(|(t, residual)| weighed(data, t, residual)).collect::<Vec<_>>())
}

/// The same for one record.
pub fn weighed_rms_of(data: &Data, t: &Prepared, residual: &[f64]) -> f64 {
    let (sum, rows) = squares(t, &weighed(data, t, residual), 0);
    (sum / rows.max(1) as f64).sqrt()
}

/// A record's residual, each row times the root of its weight.
fn weighed(data: &Data, t: &Prepared, residual: &[f64]) -> Vec<f64> {
    residual.iter().zip(weights(data, t)).map(|(r, weight)| r * weight.sqrt()).collect()
}

/// Whether a record's weighted residual is far more than noise: then the record, or the model of it, is faulty.
fn is_far_beyond_noise(data: &Data, t: &Prepared, residual: &[f64]) -> bool {
    weighed_rms_of(data, t, residual) > FAR_BEYOND_NOISE * data.noise.total_pa().hypot(data.accuracy_pa())
}

/// The systematic misfit, Pa.
pub fn systematic(data: &Data, residuals: &[Vec<f64>]) -> f64 {
    let [mut held, mut moving] = [(0.0, 0.0); 2];
    for experiment in 0..data.experiments.len() {
        let of_experiment = repeats::of(data, experiment);
        let traces: Vec<&Prepared> = of_experiment.iter().map(|&k| &data.traces[k]).collect();
        let in_segment = |(segment, s): (usize, &Segment)| {
            (s.phase != Phase::Move).then(|| in_common(data, residuals, &of_experiment, segment))
        };
        let shared: Vec<Option<f64>> = match repeats::are_alike(&traces) {
            true => traces[0].course.motion.segments.iter().enumerate().map(in_segment).collect(),
            false => Vec::new(),
        };
        for (&k, t) in of_experiment.iter().zip(&traces) {
            let alone = is_far_beyond_noise(data, t, &residuals[k]);
            for (segment, s) in t.course.motion.segments.iter().enumerate() {
                let rows = (s.end - s.first) as f64;
                let mean = match shared.get(segment).copied().flatten().filter(|_| !alone) {
                    // Repeats held at the same place share its rounding error.
                    Some(shared) if shared > 0.0 => (shared - by_rounding(t, segment)).max(0.0),
                    Some(shared) => shared,
                    None => beyond_noise(data, t, &residuals[k], segment),
                };
                let (sum, all) = if s.phase == Phase::Move { &mut moving } else { &mut held };
                *sum += mean * rows;
                *all += rows;
            }
        }
    }
    // Repeats that start at the same level share its rounding error, too.
    let beyond = beyond_steps(data, residuals).map(|mean| mean * held.1);
    let of_held = beyond.filter(|beyond| held.0 > *beyond).unwrap_or(held.0);
    // The contribution of the position in a move is an upper limit: it must not offset what holds leave.
    let mean = (of_held + f64::max(moving.0, 0.0)) / f64::max(held.1 + moving.1, 1.0);
    // A NaN residual is not small.
    if mean.is_finite() { mean.max(0.0).sqrt() } else { f64::INFINITY }
}

/// Square of the systematic misfit in rests and holds for readings that stick to a step, Pa²; `None` for others. A correct model
/// is farther from such a reading than half a step s only because of noise, which gives a mean square excess of 4σ³/(3s√(2π)), σ
/// the standard deviation. A model that is off by b adds b³/(3s).
fn beyond_steps(data: &Data, residuals: &[Vec<f64>]) -> Option<f64> {
    if !data.noise.sticks {
        return None;
    }
    let (step, noise) = (data.noise.step_pa, data.noise.white_pa.hypot(data.noise.coloured_pa()));
    let held = data.traces.iter().zip(residuals).flat_map(|(t, residual)| {
        let rests = t.course.motion.segments.iter().filter(|s| s.phase != Phase::Move);
        rests.flat_map(|s| s.first..s.end).filter(|&i| t.readout.is_data(i)).map(|i| residual[i])
    });
    let squares = held.map(|r| (r.abs() - 0.5 * step).max(0.0).powi(2));
    let (sum, rows) = squares.fold((0.0, 0usize), |(sum, n), square| (sum + square, n + 1));
    let by_noise = 4.0 * noise.powi(3) / (3.0 * step * (2.0 * PI).sqrt());
    let off_pa = (3.0 * step * (sum / rows.max(1) as f64 - by_noise).max(0.0)).cbrt();
    Some(off_pa.powi(2))
}

/// Mean product of the residuals of different repeats at corresponding rows of a segment, Pa².
fn in_common(data: &Data, residuals: &[Vec<f64>], of_experiment: &[usize], segment: usize) -> f64 {
    let traces: Vec<&Prepared> = of_experiment.iter().map(|&k| &data.traces[k]).collect();
    let rows = repeats::aligned_data_rows(&traces, segment);
    let length = rows[0].len();
    let aligned: Vec<Vec<f64>> =
        of_experiment.iter().zip(&rows).map(|(&k, rows)| rows.iter().map(|&i| residuals[k][i]).collect()).collect();
    let (mut sum, mut pairs) = (0.0, 0.0);
    for (i, a) in aligned.iter().enumerate() {
        for b in &aligned[i + 1..] {
            sum += a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
            pairs += length as f64;
        }
    }
    sum / f64::max(pairs, 1.0)
}

/// Pressure variance in a segment due to the rounding of the held piston's position, Pa².
fn by_rounding(t: &Prepared, segment: usize) -> f64 {
    let held = t.blocks.iter().filter(|b| b.segment == segment);
    let (sum, rows) =
        held.fold((0.0, 0), |(sum, n), b| (sum + b.rows as f64 * b.position_rounding_sd_pa.powi(2), n + b.rows));
    sum / rows.max(1) as f64
}

/// Mean square of a segment's residual less the variance due to noise and position, Pa².
fn beyond_noise(data: &Data, t: &Prepared, residual: &[f64], segment: usize) -> f64 {
    let noise = data.noise.total_pa().powi(2);
    let (mut sum, mut rows) = (0.0, 0usize);
    for b in t.blocks.iter().filter(|b| b.segment == segment) {
        for i in (b.first..b.end).filter(|&i| t.readout.is_data(i)) {
            sum += residual[i].powi(2) - noise - position_variance(t, b, i);
            rows += 1;
        }
    }
    sum / rows.max(1) as f64
}

/// Variance of the pressure at a row of a block due to the positions, Pa².
fn position_variance(t: &Prepared, b: &Block, row: usize) -> f64 {
    let (low, high) = (row.saturating_sub(1), (row + 1).min(t.pressure_pa.len() - 1));
    let rate = (t.pressure_pa[high] - t.pressure_pa[low]) / (t.time_s[high] - t.time_s[low]);
    let shift_s = t.course.motion.segments[b.segment].shift_s;
    let common: f64 = b.common_sd_pa.iter().map(|c| c * c).sum();
    b.position_sd_pa.powi(2) + common + (rate * shift_s).powi(2)
}

/// Weight of each row of a record, from 0 to 1: the noise's fraction of its variance, the rest being due to the positions.
pub fn weights(data: &Data, t: &Prepared) -> Vec<f64> {
    let noise = data.noise.total_pa().powi(2);
    let mut out = vec![1.0; t.pressure_pa.len()];
    for b in &t.blocks {
        for (weight, row) in out[b.first..b.end].iter_mut().zip(b.first..) {
            *weight = noise / (noise + position_variance(t, b, row));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::baseline;
    use crate::synthetic::Recipe;

    #[test]
    fn a_rounding_error_that_repeats_share_is_no_misfit_and_a_model_error_is() {
        // Eight bits over ten bars.
        let recipe = Recipe { quantisation_pa: 1e6 / 256.0, noise_pa: 50.0, ..Recipe::from_seed(5) };
        let (data, fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        assert!(data.noise.sticks);
        let residuals = residuals(&data, &fit);
        let off_by = |off_pa: f64| {
            let moved = residuals.iter().map(|of_record| of_record.iter().map(|r| r + off_pa).collect());
            systematic(&data, &moved.collect::<Vec<_>>())
        };
        assert!(off_by(0.0) < data.accuracy_pa(), "{} of {}", off_by(0.0), data.accuracy_pa());
        assert!((off_by(1500.0) / 1500.0 - 1.0).abs() < 0.2, "{}", off_by(1500.0));
        assert_eq!(off_by(f64::NAN), f64::INFINITY);
    }

    #[test]
    fn the_misfit_of_a_single_record_is_not_hidden_by_its_repeats() {
        let (data, fit) = baseline::fitted(Data::prepare(&Recipe::from_seed(5).rig()).unwrap()).unwrap();
        let mut residuals = residuals(&data, &fit);
        let noise_pa = data.noise.total_pa();
        let systematic_pa = systematic(&data, &residuals);
        // In its hold only, as moves are judged record by record.
        let hold = data.traces[4].course.motion.segments.last().unwrap().first..residuals[4].len();
        let mut wave = |size: f64| {
            hold.clone().for_each(|row| residuals[4][row] += size * noise_pa * (0.03 * row as f64).sin());
            systematic(&data, &residuals)
        };
        // A wave that may be noise of an unknown kind, and one that is not noise.
        let [small_pa, large_pa] = [wave(2.0), wave(8.0)];
        assert!((small_pa - systematic_pa).abs() < data.accuracy_pa(), "{small_pa} {systematic_pa}");
        let rows = hold.len() as f64 / data.traces.iter().map(|t| t.time_s.len()).sum::<usize>() as f64;
        assert!((large_pa / (50.0 * rows).sqrt() / noise_pa - 1.0).abs() < 0.1, "{large_pa}");
    }
}
