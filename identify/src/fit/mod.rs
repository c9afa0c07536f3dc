//! All records of a rig at once: weighted least squares by Levenberg–Marquardt with bounds.
//!
//! Minimises Σ v², v the whitened block residuals ([`whiten`]). The normal equations are bordered: each record's own numbers
//! appear in its rows only and are eliminated record by record ([`bordered`]), so that the system solved has the size of the
//! rig's numbers. Sensitivities are exact (dual numbers, in several passes where there are many). Records are simulated in
//! parallel and summed in order: the same data gives the same bits on any number of threads.
//!
//! What the rig states within a tolerance stays as stated in the fit. At its end the problem is linearised in those numbers
//! too, with their priors: [`Fit::chi2`] is the sum of squares at the stated numbers, [`Fit::marginal`] that at the best
//! numbers within the tolerances, their own squares included. The secondary parameters that the effects' cards state take part in
//! the linearised problem too, for the intervals; in sums of squares they stay as stated, and where the records speak for others
//! they are set free.

pub mod bordered;
pub mod covariance;
mod descent;
pub mod whiten;

use crate::forward::Run;
use crate::parameters::{Axis, Hypothesis, Model, Setting, Slot};
use crate::policy;
use crate::record::between_rows::Look;
use crate::record::prepare::{Block, Data, Prepared};
use bordered::System;
use chamber::Chamber;
use chamber::dual::Dual;
use chamber::effects::{self, CARDS, EffectSet, EffectValues};
use chamber::integrate::IntegrationError;
use chamber::real::{Real, Scalar};
use chamber::record::Mesh;
pub use descent::{Descent, Linearised, Until, descend};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::ops::Range;

/// Derivatives in one pass of the simulation at the most.
const WIDEST: usize = 12;

/// Which blocks take part: the number of leading blocks of each record.
pub type Selection = [usize];

/// Residuals and sensitivities of one record's blocks, whitened: each of standard deviation one, independent of the others.
/// Behind the blocks stands a row for each prior of the record's own numbers.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Number of blocks.
    pub blocks: usize,
    /// (mean − model)/σ.
    pub residual: Vec<f64>,
    /// d(model/σ)/d(coordinate of the rig), a row for each block; behind the free ones, where wanted, the stated ones.
    pub by_rig: DMatrix<f64>,
    /// d(model/σ)/d(own coordinate).
    pub by_own: DMatrix<f64>,
    /// The steps of the simulation.
    pub mesh: Mesh,
}

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// What was fitted.
    pub hypothesis: Hypothesis,
    /// The rig's coordinates.
    pub rig: Vec<f64>,
    /// Each record's own coordinates.
    pub own: Vec<Vec<f64>>,
    /// Σ of squares of the whitened residuals.
    pub chi2: f64,
    /// The same where what the rig states may move within its tolerance, squares of those moves included.
    pub marginal: f64,
    /// How far the stated numbers then move, in units of their tolerance.
    pub moved: Vec<f64>,
    /// How far the rig's free coordinates move with them.
    pub follow: Vec<f64>,
    /// Σ of squares that effects which smear or shift the records may take off by smoothing the stroke's noise alone.
    pub smoothed: f64,
    /// Blocks that took part.
    pub blocks: usize,
    /// The linearised problem at the solution, record by record; its columns include the stated numbers.
    pub linear: Vec<Linear>,
    /// Normal matrix of the rig's free and stated numbers, priors included, with the records' own eliminated.
    pub information: DMatrix<f64>,
    /// Free numbers of the rig that ended at a bound.
    pub at_bound: Vec<bool>,
    /// Iterations used.
    pub iterations: usize,
    /// Whether the iteration ended at a minimum rather than at its limit.
    pub converged: bool,
}

impl Fit {
    /// Whether a number of the rig that something was known of beforehand has gone as far from that as it may:
    /// [`policy::DEVIATIONS_BEFOREHAND`].
    pub fn is_beyond_belief(&self) -> bool {
        const NEARLY: f64 = 0.999;
        let most = NEARLY * policy::DEVIATIONS_BEFOREHAND;
        let is_far = |(x, axis): (&f64, &Axis)| axis.prior.is_some_and(|[mean, sd]| (x - mean).abs() > most * sd);
        self.rig.iter().zip(&self.hypothesis.axes).any(is_far)
    }

    /// A number of an effect that has nearly gone to an end of what its card allows, other than one where the effect is off:
    /// [`policy::NEARLY_EXHAUSTED`].
    pub fn exhausted(&self) -> Option<Slot> {
        let is_exhausted = |(x, axis): &(&f64, &Axis)| match axis.slot {
            Slot::Effect(effect, parameter) if axis.prior.is_none() && !axis.logarithmic => {
                let card = &CARDS[effect].parameters[parameter];
                let way = axis.value(**x) - card.neutral;
                let end = if way < 0.0 { card.bounds.start() } else { card.bounds.end() };
                way.abs() > policy::NEARLY_EXHAUSTED * (end - card.neutral).abs()
            }
            _ => false,
        };
        self.rig.iter().zip(&self.hypothesis.axes).find(is_exhausted).map(|(_, axis)| axis.slot)
    }

    /// The fitted chamber.
    pub fn chamber(&self) -> Chamber {
        self.hypothesis.chamber(&self.rig)
    }

    /// The fitted chamber as one can be: a dead volume below zero says that positions are counted from too far, and is zero.
    pub fn possible_chamber(&self) -> Chamber {
        let mut chamber = self.chamber();
        chamber.geometry.dead_volume = chamber.geometry.dead_volume.max(0.0);
        chamber
    }

    /// By how much positions then read too much, m; `None` where the dead volume is not below zero.
    pub fn positions_too_far_m(&self) -> Option<f64> {
        let geometry = self.chamber().geometry;
        (geometry.dead_volume < 0.0).then(|| -geometry.dead_volume / geometry.piston_area)
    }

    /// What a record is simulated with, at the stated numbers.
    pub fn setting(&self, trace: &Prepared, own: &[f64]) -> Setting<f64> {
        self.hypothesis.setting(trace, &self.rig, &[], own)
    }

    /// How each record's readings look at the recorded stroke.
    pub fn looks(&self, data: &Data) -> Vec<Look> {
        let set = self.hypothesis.model.effects;
        let look = |values: &EffectValues| Look {
            window_s: effects::stroke_window(set, values),
            lag_s: effects::lag(set, values),
            late_s: effects::delay(set, values) - effects::stroke_delay(set, values),
            filter_s: effects::stroke_filter(set, values),
        };
        data.traces.iter().zip(&self.own).map(|(t, own)| look(&self.setting(t, own).chamber.effects)).collect()
    }

    /// [`Fit::marginal`] with tolerances so many times as wide.
    pub fn marginal_widened(&self, factor: f64) -> f64 {
        let (free, all) = (self.rig.len(), self.information.nrows());
        let Some((mut matrix, right)) = System::new(&self.linear, all).reduced(0.0) else { return self.chi2 };
        for k in free..all {
            matrix[(k, k)] += 1.0 / (factor * factor);
        }
        best_move(&matrix, &right, |i| self.adapts(i)).map_or(self.chi2, |(gain, _)| (self.chi2 - gain).max(0.0))
    }

    /// Whether a number of the linearised problem, free or stated by the rig, may move to where the records ask for it: it does
    /// not stand at a bound.
    pub fn adapts(&self, place: usize) -> bool {
        adapts(&self.hypothesis, &self.at_bound, place)
    }

    /// Number of free parameters beyond those that every record has.
    pub fn freedom(&self) -> usize {
        self.hypothesis.freedom(self.linear.iter().filter(|l| l.blocks > 0).count())
    }
}

/// See [`Fit::adapts`].
fn adapts(hypothesis: &Hypothesis, at_bound: &[bool], place: usize) -> bool {
    match at_bound.get(place) {
        Some(is_at_bound) => !is_at_bound,
        None => place - at_bound.len() < hypothesis.stated_by_rig(),
    }
}

/// Why a fit failed: the record whose simulation failed at the very begin, and how.
pub type Failure = (usize, IntegrationError);

/// Fits a hypothesis to the selected blocks, beginning from coordinates; where it does not converge, once more from where it
/// stopped.
///
/// # Errors
/// [`Failure`].
pub fn fit(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: Vec<f64>,
    own: Vec<Vec<f64>>,
    selection: &Selection,
) -> Result<Fit, Failure> {
    fit_until(data, hypothesis, rig, own, selection, Until::SETTLED)
}

/// The same until another end.
///
/// # Errors
/// [`Failure`].
pub fn fit_until(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: Vec<f64>,
    own: Vec<Vec<f64>>,
    selection: &Selection,
    until: Until,
) -> Result<Fit, Failure> {
    let first = descend(data, hypothesis, rig, own, selection, until)?;
    let found =
        if first.converged { first } else { descend(data, hypothesis, first.rig, first.own, selection, until)? };
    finish(data, hypothesis, found, selection)
}

/// The sum of squares that the first step from these coordinates promises; `None` where the simulation fails.
pub fn promise(data: &Data, hypothesis: &Hypothesis, rig: &[f64], own: &[Vec<f64>]) -> Option<f64> {
    let linear = linearise(data, hypothesis, rig, own, &all_blocks(data), None).ok()?;
    let step = System::new(&linear, hypothesis.axes.len()).step(hypothesis, rig, 1e-4)?;
    Some((total(&linear) - step.promised).max(0.0))
}

/// Σ of squares that the effects of a model which shift or smear records may take off by smoothing the stroke's noise alone.
pub fn smoothed(data: &Data, model: &Model) -> f64 {
    match model.timings() {
        0 => 0.0,
        count => count as f64 * data.squares_by_position(),
    }
}

/// Linearises in everything at the solution.
fn finish(data: &Data, hypothesis: &Hypothesis, found: Descent, selection: &Selection) -> Result<Fit, Failure> {
    let Descent { rig, own, iterations, converged, at, .. } = found;
    let linear = linearise_in_all(data, hypothesis, &rig, &own, selection, &at)?;
    let chi2 = total(&linear);
    let (free, stated) = (hypothesis.axes.len(), hypothesis.stated.len());
    let at_bound: Vec<bool> =
        rig.iter().zip(&hypothesis.axes).map(|(x, a)| *x <= a.bounds[0] + 1e-9 || *x >= a.bounds[1] - 1e-9).collect();
    let mut information = DMatrix::zeros(free + stated, free + stated);
    let (mut marginal, mut shift, mut follow) = (chi2, vec![0.0; stated], vec![0.0; free]);
    if let Some((mut matrix, right)) = System::new(&linear, free + stated).reduced(0.0) {
        for k in free..free + stated {
            matrix[(k, k)] += 1.0;
        }
        if let Some((gain, x)) = best_move(&matrix, &right, |i| adapts(hypothesis, &at_bound, i)) {
            marginal = (chi2 - gain).max(0.0);
            shift = x[free..].to_vec();
            follow = x[..free].to_vec();
        }
        information = matrix;
    }
    Ok(Fit {
        hypothesis: hypothesis.clone(),
        chi2,
        marginal,
        moved: shift,
        follow,
        smoothed: smoothed(data, &hypothesis.model),
        blocks: linear.iter().map(|l| l.blocks).sum(),
        information,
        rig,
        own,
        linear,
        at_bound,
        iterations,
        converged,
    })
}

/// How much of χ² the best move of all numbers that adapt takes away, and that move.
fn best_move(matrix: &DMatrix<f64>, right: &DVector<f64>, adapts: impl Fn(usize) -> bool) -> Option<(f64, Vec<f64>)> {
    let n = right.len();
    let free: Vec<usize> = (0..n).filter(|&i| adapts(i) && matrix[(i, i)] > 0.0).collect();
    let scale: Vec<f64> = free.iter().map(|&i| 1.0 / matrix[(i, i)].sqrt()).collect();
    let m = free.len();
    let sub = DMatrix::from_fn(m, m, |i, j| {
        matrix[(free[i], free[j])] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
    });
    let rhs = DVector::from_fn(m, |i, _| right[free[i]] * scale[i]);
    let solution = sub.cholesky()?.solve(&rhs);
    let mut x = vec![0.0; n];
    for (i, &f) in free.iter().enumerate() {
        x[f] = solution[i] * scale[i];
    }
    Some((solution.dot(&rhs), x))
}

/// Coordinates after a step, within their bounds.
pub(crate) fn moved(x: &[f64], step: &[f64], bounds: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
    x.iter().zip(step).zip(bounds).map(|((x, step), [low, high])| (x + step).clamp(low, high)).collect()
}

/// Residuals and sensitivities of all selected blocks, or the record whose simulation failed and why; by the steps that the
/// simulations took `near` these coordinates.
fn linearise(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    own: &[Vec<f64>],
    selection: &Selection,
    near: Option<&[Linear]>,
) -> Result<Vec<Linear>, Failure> {
    let new = Mesh::default();
    linearised(data, hypothesis, rig, own, 0, |k, x| {
        let mesh = near.map_or(&new, |near| &near[k].mesh);
        record(&data.traces[k], hypothesis, x, selection[k], mesh)
    })
}

/// The same with the sensitivities by the stated numbers too; where the others are known, by those alone.
fn linearise_in_all(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    own: &[Vec<f64>],
    selection: &Selection,
    at: &Linearised,
) -> Result<Vec<Linear>, Failure> {
    let stated = hypothesis.stated.len();
    linearised(data, hypothesis, rig, own, stated, |k, x| {
        let (t, blocks) = (&data.traces[k], selection[k]);
        match at {
            Linearised::Here(known) => by_stated_too(t, hypothesis, x, blocks, &known[k]),
            Linearised::Near(near) => record(t, hypothesis, x, blocks, &near[k].mesh),
            Linearised::Nowhere => record(t, hypothesis, x, blocks, &Mesh::default()),
        }
    })
}

/// Every record linearised by `record`, the priors of the rig's numbers behind them.
fn linearised<'a>(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &'a [f64],
    own: &'a [Vec<f64>],
    stated: usize,
    record: impl Fn(usize, &Coordinates<'a>) -> Result<Linear, IntegrationError> + Sync,
) -> Result<Vec<Linear>, Failure> {
    let records: Result<Vec<Linear>, Failure> = (0..data.traces.len())
        .into_par_iter()
        .map(|k| record(k, &Coordinates { rig, stated, own: &own[k] }).map_err(|e| (k, e)))
        .collect();
    let mut records = records?;
    records.extend(priors(hypothesis, rig, stated));
    Ok(records)
}

/// The residuals that [`linearise`] would find there by the steps taken `near`, record by record and the priors of the rig's
/// numbers behind them, at a fraction of its cost; `None` where the simulation fails.
fn residuals(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    own: &[Vec<f64>],
    selection: &Selection,
    near: &[Linear],
) -> Option<Vec<Vec<f64>>> {
    let records: Option<Vec<Vec<f64>>> = (0..data.traces.len())
        .into_par_iter()
        .map(|k| residual(&data.traces[k], hypothesis, rig, &own[k], selection[k], &near[k].mesh))
        .collect();
    let mut records = records?;
    records.extend(priors(hypothesis, rig, 0).map(|l| l.residual));
    Some(records)
}

/// One record's whitened residuals, the priors of its own numbers behind them.
fn residual(t: &Prepared, h: &Hypothesis, rig: &[f64], own: &[f64], blocks: usize, mesh: &Mesh) -> Option<Vec<f64>> {
    let selected = &t.blocks[..blocks];
    let mut out = Vec::new();
    if blocks > 0 {
        let setting = h.setting(t, rig, &[], own);
        let (shown, _) = run(t, &setting, h.model.effects).pressures_along(&points(selected), mesh).ok()?;
        let mut shown = shown.into_iter();
        out.extend(selected.iter().map(|block| block.mean_pa - mean(block, &mut shown)));
        t.whitener.apply(&mut out);
    }
    out.extend(own_priors(t, h, blocks).into_iter().map(|(i, [mean, sd])| (mean - own[i]) / sd));
    out.iter().all(|r| r.is_finite()).then_some(out)
}

/// What is known beforehand of a record's own numbers, by their places; nothing where the record takes no part.
fn own_priors(t: &Prepared, h: &Hypothesis, blocks: usize) -> Vec<(usize, [f64; 2])> {
    match blocks {
        0 => Vec::new(),
        _ => h.own_of(t).iter().enumerate().filter_map(|(i, axis)| Some((i, axis.prior?))).collect(),
    }
}

/// What is known of the rig's free numbers beforehand, as one more record without blocks.
fn priors(hypothesis: &Hypothesis, rig: &[f64], stated: usize) -> Option<Linear> {
    let known: Vec<(usize, [f64; 2])> =
        hypothesis.axes.iter().enumerate().filter_map(|(i, axis)| Some((i, axis.prior?))).collect();
    if known.is_empty() {
        return None;
    }
    let bends = hypothesis.bends();
    let mut by_rig = DMatrix::zeros(known.len() + bends.len(), rig.len() + stated);
    let mut residual = Vec::with_capacity(known.len());
    for (row, (i, [mean, sd])) in known.into_iter().enumerate() {
        residual.push((mean - rig[i]) / sd);
        by_rig[(row, i)] = 1.0 / sd;
    }
    for (combination, sd) in bends {
        let row = residual.len();
        residual.push(-combination.iter().map(|(i, weight)| weight * rig[*i]).sum::<f64>() / sd);
        combination.iter().for_each(|(i, weight)| by_rig[(row, *i)] = weight / sd);
    }
    let by_own = DMatrix::zeros(residual.len(), 0);
    Some(Linear { blocks: 0, residual, by_rig, by_own, mesh: Mesh::default() })
}

/// Where one record is linearised.
struct Coordinates<'a> {
    rig: &'a [f64],
    /// How many of the stated numbers take part, each at zero.
    stated: usize,
    own: &'a [f64],
}

impl Coordinates<'_> {
    fn count(&self) -> usize {
        self.rig.len() + self.stated + self.own.len()
    }
}

fn record(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    blocks: usize,
    mesh: &Mesh,
) -> Result<Linear, IntegrationError> {
    // Columns: residual, free, stated, own.
    let (columns, mesh) = columns(t, h, x, 0..x.count(), blocks, mesh)?;
    let priors = own_priors(t, h, blocks);
    let rig = x.rig.len() + x.stated;
    let mut columns = columns.resize_vertically(blocks + priors.len(), 0.0);
    for (k, (i, [mean, sd])) in priors.into_iter().enumerate() {
        columns[(blocks + k, 0)] = (mean - x.own[i]) / sd;
        columns[(blocks + k, 1 + rig + i)] = 1.0 / sd;
    }
    let out = Linear {
        blocks,
        residual: columns.column(0).iter().copied().collect(),
        by_rig: columns.columns(1, rig).into_owned(),
        by_own: columns.columns(1 + rig, x.own.len()).into_owned(),
        mesh,
    };
    if out.residual.iter().all(|r| r.is_finite()) { Ok(out) } else { Err(IntegrationError::StepTooSmall { at: 0.0 }) }
}

/// A record that was linearised by its free and own numbers, by the stated ones as well.
fn by_stated_too(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    blocks: usize,
    known: &Linear,
) -> Result<Linear, IntegrationError> {
    if x.stated == 0 {
        return Ok(known.clone());
    }
    let free = x.rig.len();
    let (columns, _) = columns(t, h, x, free..free + x.stated, blocks, &known.mesh)?;
    let Linear { residual, by_rig, by_own, mesh, .. } = known.clone();
    let mut by_rig = by_rig.resize_horizontally(free + x.stated, 0.0);
    by_rig.view_mut((0, free), (blocks, x.stated)).copy_from(&columns.columns(1, x.stated));
    Ok(Linear { blocks, residual, by_rig, by_own, mesh })
}

/// Whitened columns of the residual and of the derivatives by the coordinates at these places, for the first `blocks` blocks;
/// with the steps taken.
fn columns(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    places: Range<usize>,
    blocks: usize,
    mesh: &Mesh,
) -> Result<(DMatrix<f64>, Mesh), IntegrationError> {
    let mut columns = DMatrix::zeros(blocks, 1 + places.len());
    let mut taken = Mesh::default();
    if blocks == 0 {
        return Ok((columns, taken));
    }
    let width = |first: usize| (places.end - first).min(WIDEST);
    let firsts: Vec<usize> = (places.start..places.end.max(places.start + 1)).step_by(WIDEST).collect();
    let passes: Result<Vec<(DMatrix<f64>, Mesh)>, IntegrationError> = firsts
        .par_iter()
        // No wider than need be.
        .map(|&first| match width(first) {
            ..=4 => pass::<4>(t, h, x, first, blocks, mesh),
            5..=6 => pass::<6>(t, h, x, first, blocks, mesh),
            7..=8 => pass::<8>(t, h, x, first, blocks, mesh),
            _ => pass::<WIDEST>(t, h, x, first, blocks, mesh),
        })
        .collect();
    for (first, (passed, steps)) in firsts.into_iter().zip(passes?) {
        taken = steps;
        columns.set_column(0, &passed.column(0));
        columns.columns_mut(1 + first - places.start, width(first)).copy_from(&passed.columns(1, width(first)));
    }
    t.whitener.apply_to(&mut columns);
    Ok((columns, taken))
}

/// Columns of the residual and of the derivatives by N coordinates from the `first` on, for the first `blocks` blocks.
fn pass<const N: usize>(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    first: usize,
    blocks: usize,
    mesh: &Mesh,
) -> Result<(DMatrix<f64>, Mesh), IntegrationError> {
    let variable = |value: f64, place: usize| -> Dual<N> {
        if (first..first + N).contains(&place) { Dual::variable(value, place - first) } else { Dual::from(value) }
    };
    let behind = x.rig.len() + x.stated;
    let rig: Vec<Dual<N>> = x.rig.iter().enumerate().map(|(i, v)| variable(*v, i)).collect();
    let stated: Vec<Dual<N>> = (0..x.stated).map(|i| variable(0.0, x.rig.len() + i)).collect();
    let own: Vec<Dual<N>> = x.own.iter().enumerate().map(|(i, v)| variable(*v, behind + i)).collect();
    let setting = h.setting(t, &rig, &stated, &own);
    let blocks = &t.blocks[..blocks];
    let (shown, taken) = run(t, &setting, h.model.effects).pressures_along(&points(blocks), mesh)?;
    let mut shown = shown.into_iter();
    let mut columns = DMatrix::zeros(blocks.len(), 1 + N);
    for (row, block) in blocks.iter().enumerate() {
        let model = mean(block, &mut shown);
        columns[(row, 0)] = block.mean_pa - model.value;
        for (column, tangent) in model.tangent.iter().enumerate() {
            columns[(row, 1 + column)] = *tangent;
        }
    }
    Ok((columns, taken))
}

/// The model along a record.
pub fn run<'a, R: Real>(t: &'a Prepared, setting: &'a Setting<R>, set: EffectSet) -> Run<'a, R> {
    let Setting { chamber, start, warmer } = setting;
    let (course, relative_tolerance) = (&t.course, t.relative_tolerance);
    Run { chamber, set, start: *start, warmer: *warmer, course, relative_tolerance }
}

/// Times at which the blocks' means need the model.
pub fn points(blocks: &[Block]) -> Vec<f64> {
    let mut times = Vec::with_capacity(2 * blocks.len());
    for b in blocks {
        times.push(b.points_s[0]);
        if b.rows > 1 {
            times.push(b.points_s[1]);
        }
    }
    times
}

/// The model's mean over a block, from its values at [`points`].
pub fn mean<R: Real>(block: &Block, shown: &mut impl Iterator<Item = R>) -> R {
    let first = shown.next().unwrap_or(R::ZERO);
    if block.rows > 1 { (first + shown.next().unwrap_or(R::ZERO)) * 0.5 } else { first }
}

fn total(linear: &[Linear]) -> f64 {
    linear.iter().flat_map(|l| &l.residual).map(|r| r * r).sum()
}

/// Every block of every record.
pub fn all_blocks(data: &Data) -> Vec<usize> {
    data.traces.iter().map(|t| t.blocks.len()).collect()
}

/// The model's reading at every row of a record, Pa, for plain numbers.
///
/// # Errors
/// Where the state leaves what the equations can follow.
pub fn readings<R: Scalar>(t: &Prepared, setting: &Setting<R>, set: EffectSet) -> Result<Vec<R>, IntegrationError> {
    run(t, setting, set).pressures(&t.time_s)
}
