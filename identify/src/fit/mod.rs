//! Fit of all records of a rig together: weighted least squares by Levenberg–Marquardt with bounds.
//!
//! Minimises Σ v², v the whitened block residuals (`record::whiten`). The normal equations are bordered: per-record parameters
//! appear only in the rows of their record and are eliminated record by record (`bordered`), so that the system to be solved has
//! the size of the rig parameters. Sensitivities are exact (dual numbers, in several passes if there are many). Records are
//! simulated in parallel and summed in order: the same data gives the same bits on any number of threads.
//!
//! Parameters that the rig states within a tolerance are fixed in the fit. At its end the problem is linearised in them too, with
//! their priors: [`Fit::chi2`] is the sum of squares at the stated values, [`Fit::marginal`] that at the best values within the
//! tolerances, including the squares of their moves. The secondary parameters stated by the effects' cards are part of the
//! linearised problem too, for the intervals; in sums of squares they stay as stated, and where the records favour other values
//! they are freed.

pub(crate) mod bordered;
pub mod covariance;
mod descent;
mod found;
mod linear;
mod room;

use crate::parameters::{Axis, Hypothesis, Model, RecordSlot};
use crate::record::data::Data;
use bordered::System;
pub use descent::{Descent, Until, descend};
pub use found::Fit;
pub use linear::{Failure, Linear, Linearised, Selection, all_blocks, mean, points, readings, run};
use linear::{linearise, linearise_in_all, total};
use nalgebra::{DMatrix, DVector};
use room::Room;

/// Fits a hypothesis to the selected blocks, starting at these coordinates; continues once where the descent did not converge.
///
/// # Errors
/// [`Failure`].
pub fn fit(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: Vec<f64>,
    records: Vec<Vec<f64>>,
    selection: &Selection,
) -> Result<Fit, Failure> {
    fit_until(data, hypothesis, rig, records, selection, Until::SETTLED)
}

/// The same with other stopping criteria.
///
/// # Errors
/// [`Failure`].
pub fn fit_until(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: Vec<f64>,
    records: Vec<Vec<f64>>,
    selection: &Selection,
    until: Until,
) -> Result<Fit, Failure> {
    let mut found = descend(data, hypothesis, rig, records, selection, until)?;
    for _ in 1..until.descents {
        if found.converged || found.given_up {
            break;
        }
        found = descend(data, hypothesis, found.rig, found.records, selection, until)?;
    }
    finish(data, hypothesis, found, selection)
}

/// Sum of squares predicted after the first step from these coordinates; `None` where the simulation fails.
pub fn predicted_squares(data: &Data, hypothesis: &Hypothesis, rig: &[f64], records: &[Vec<f64>]) -> Option<f64> {
    let linear = linearise(data, hypothesis, rig, records, &all_blocks(data), None).ok()?;
    let room = Room::around(hypothesis, &record_axes(data, hypothesis), rig, records);
    let step = System::new(&linear, hypothesis.axes.len()).step(&room, 1e-4)?;
    Some((total(&linear) - step.predicted_decrease).max(0.0))
}

/// Sum of squares that a model's effects which shift or smear records may remove merely by smoothing the noise of the stroke.
pub fn smoothed(data: &Data, model: &Model) -> f64 {
    match model.timings() {
        0 => 0.0,
        count => count as f64 * data.squares_of_position_errors(),
    }
}

/// Linearises in all parameters at the solution.
fn finish(data: &Data, hypothesis: &Hypothesis, found: Descent, selection: &Selection) -> Result<Fit, Failure> {
    let Descent { rig, records, iterations, converged, at, .. } = found;
    let linear = linearise_in_all(data, hypothesis, &rig, &records, selection, &at)?;
    let chi2 = total(&linear);
    let (free, stated) = (hypothesis.axes.len(), hypothesis.stated.len());
    let at_bound: Vec<bool> =
        rig.iter().zip(&hypothesis.axes).map(|(x, a)| *x <= a.bounds[0] + 1e-9 || *x >= a.bounds[1] - 1e-9).collect();
    let mut adapts: Vec<bool> = at_bound.iter().map(|is_at_bound| !is_at_bound).collect();
    adapts.extend(hypothesis.stated.iter().map(|axis| axis.slot.adapts()));
    let normal = System::new(&linear, free + stated).reduced(0.0).map(|(mut matrix, mut right_hand_side)| {
        hypothesis.add_priors_of_stated(&mut matrix, &mut right_hand_side, |_| 1.0);
        (matrix, right_hand_side)
    });
    let (information, right_hand_side) =
        normal.unwrap_or_else(|| (DMatrix::zeros(free + stated, free + stated), DVector::zeros(free + stated)));
    let mut fit = Fit {
        hypothesis: hypothesis.clone(),
        chi2,
        marginal: chi2,
        moved: vec![0.0; stated],
        rig_move: vec![0.0; free],
        smoothed: smoothed(data, &hypothesis.model),
        blocks: linear.iter().map(|l| l.blocks).sum(),
        information,
        right_hand_side,
        ambient_scatter: 0.0,
        rig,
        records,
        linear,
        at_bound,
        adapts,
        iterations,
        converged,
    };
    fit.move_within_tolerances();
    let records: Vec<Vec<f64>> = (0..fit.records.len()).map(|record| fit.record_moved(data, record)).collect();
    fit.ambient_scatter = ambient_scatter(data, hypothesis, &records);
    Ok(fit)
}

/// [`Fit::ambient_scatter`].
fn ambient_scatter(data: &Data, h: &Hypothesis, records: &[Vec<f64>]) -> f64 {
    let deviation = |(axis, x): (Axis<RecordSlot>, f64)| axis.prior.map(|[mean, sd]| (x - mean) / sd);
    let deviations: Vec<f64> =
        h.of_each(data, records, RecordSlot::AmbientTemperature).flatten().filter_map(deviation).collect();
    let squares: f64 = deviations.iter().map(|z| z * z).sum();
    (squares / deviations.len().max(1) as f64).sqrt()
}

/// The per-record parameters of each record.
fn record_axes(data: &Data, hypothesis: &Hypothesis) -> Vec<Vec<Axis<RecordSlot>>> {
    data.traces.iter().map(|t| hypothesis.record_axes(t)).collect()
}

/// Coordinates after a step, clamped to their bounds.
pub(crate) fn stepped(x: &[f64], step: &[f64], bounds: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
    x.iter().zip(step).zip(bounds).map(|((x, step), [low, high])| (x + step).clamp(low, high)).collect()
}
