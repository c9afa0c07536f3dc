//! Residuals of the records and their sensitivities: simulation in dual numbers, block by block, whitened.

use crate::forward::Run;
use crate::parameters::{Hypothesis, Setting};
use crate::record::blocks::Block;
use crate::record::data::{Data, Prepared};
use chamber::dual::Dual;
use chamber::effects::EffectSet;
use chamber::integrate::IntegrationError;
use chamber::real::{Real, Scalar};
use chamber::record::Mesh;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;

/// Maximum number of derivatives in one pass of the simulation.
const WIDEST: usize = 12;

/// Blocks that are used: the number of leading blocks of each record.
pub type Selection = [usize];

/// Why a fit failed: the record whose simulation failed at the starting point, and the error.
pub type Failure = (usize, IntegrationError);

/// Whitened residuals and sensitivities of one record's blocks: of unit standard deviation and independent. After the blocks
/// follows a row for each prior of the per-record parameters.
#[derive(Clone, Debug)]
pub struct Linear {
    /// Number of blocks.
    pub blocks: usize,
    /// (mean − model)/σ.
    pub residual: Vec<f64>,
    /// d(model/σ)/d(coordinate of the rig), a row for each block; after the free coordinates follow the stated ones, where
    /// wanted.
    pub by_rig: DMatrix<f64>,
    /// d(model/σ)/d(coordinate of the record).
    pub by_record: DMatrix<f64>,
    /// Integration steps of the simulation.
    pub mesh: Mesh,
}

/// Where a problem was linearised.
#[derive(Clone, Debug)]
pub enum Linearised {
    /// At the coordinates themselves.
    Here(Vec<Linear>),
    /// So close to them that the simulations keep their integration steps.
    Near(Vec<Linear>),
    /// Not linearised yet, or far away.
    Nowhere,
}

impl Linearised {
    /// The linearisation that provides the integration steps.
    pub(super) fn near(&self) -> Option<&[Linear]> {
        match self {
            Linearised::Here(linear) | Linearised::Near(linear) => Some(linear),
            Linearised::Nowhere => None,
        }
    }
}

/// Residuals and sensitivities of all selected blocks, or the record whose simulation failed and why. Uses the integration steps
/// of `near`, a linearisation close to these coordinates.
pub(super) fn linearise(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    records: &[Vec<f64>],
    selection: &Selection,
    near: Option<&[Linear]>,
) -> Result<Vec<Linear>, Failure> {
    let new = Mesh::default();
    linearised(data, hypothesis, rig, records, 0, |k, x| {
        let mesh = near.map_or(&new, |near| &near[k].mesh);
        record(&data.traces[k], hypothesis, x, selection[k], mesh)
    })
}

/// The same with the sensitivities to the stated parameters; only these are computed where the others are known.
pub(super) fn linearise_in_all(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    records: &[Vec<f64>],
    selection: &Selection,
    at: &Linearised,
) -> Result<Vec<Linear>, Failure> {
    let stated = hypothesis.stated.len();
    linearised(data, hypothesis, rig, records, stated, |k, x| {
        let (t, blocks) = (&data.traces[k], selection[k]);
        match at {
            Linearised::Here(known) => by_stated_too(t, hypothesis, x, blocks, &known[k]),
            Linearised::Near(near) => record(t, hypothesis, x, blocks, &near[k].mesh),
            Linearised::Nowhere => record(t, hypothesis, x, blocks, &Mesh::default()),
        }
    })
}

/// Linearises every record by `record` and appends the priors of the rig parameters.
fn linearised<'a>(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &'a [f64],
    records: &'a [Vec<f64>],
    stated: usize,
    record: impl Fn(usize, &Coordinates<'a>) -> Result<Linear, IntegrationError> + Sync,
) -> Result<Vec<Linear>, Failure> {
    let linear: Result<Vec<Linear>, Failure> = (0..data.traces.len())
        .into_par_iter()
        .map(|k| record(k, &Coordinates { rig, stated, record: &records[k] }).map_err(|e| (k, e)))
        .collect();
    let mut linear = linear?;
    linear.extend(priors(hypothesis, rig, stated));
    Ok(linear)
}

/// The residuals that [`linearise`] would return with the integration steps of `near`, record by record, followed by the priors
/// of the rig parameters, at a fraction of its cost; `None` where the simulation fails.
pub(super) fn residuals(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: &[f64],
    records: &[Vec<f64>],
    selection: &Selection,
    near: &[Linear],
) -> Option<Vec<Vec<f64>>> {
    let all: Option<Vec<Vec<f64>>> = (0..data.traces.len())
        .into_par_iter()
        .map(|k| residual(&data.traces[k], hypothesis, rig, &records[k], selection[k], &near[k].mesh))
        .collect();
    let mut all = all?;
    all.extend(priors(hypothesis, rig, 0).map(|l| l.residual));
    Some(all)
}

/// One record's whitened residuals, followed by the priors of its parameters.
fn residual(t: &Prepared, h: &Hypothesis, rig: &[f64], record: &[f64], blocks: usize, mesh: &Mesh) -> Option<Vec<f64>> {
    let selected = &t.blocks[..blocks];
    let mut out = Vec::new();
    if blocks > 0 {
        let setting = h.setting(t, rig, &[], record);
        let (shown, _) = run(t, &setting, h.model.effects).pressures_along(&points(selected), mesh).ok()?;
        let mut shown = shown.into_iter();
        out.extend(selected.iter().map(|block| block.mean_pa - mean(block, &mut shown)));
        t.whitener.apply(&mut out);
    }
    out.extend(record_priors(t, h, blocks).into_iter().map(|(i, [mean, sd])| (mean - record[i]) / sd));
    out.iter().all(|r| r.is_finite()).then_some(out)
}

/// Priors of a record's parameters with their indices; empty where the record is not used.
fn record_priors(t: &Prepared, h: &Hypothesis, blocks: usize) -> Vec<(usize, [f64; 2])> {
    match blocks {
        0 => Vec::new(),
        _ => h.record_axes(t).iter().enumerate().filter_map(|(i, axis)| Some((i, axis.prior?))).collect(),
    }
}

/// Priors of the rig's free parameters, as a further record without blocks.
fn priors(hypothesis: &Hypothesis, rig: &[f64], stated: usize) -> Option<Linear> {
    let known: Vec<(usize, [f64; 2])> =
        hypothesis.axes.iter().enumerate().filter_map(|(i, axis)| Some((i, axis.prior?))).collect();
    if known.is_empty() {
        return None;
    }
    let combinations = hypothesis.combinations();
    let mut by_rig = DMatrix::zeros(known.len() + combinations.len(), rig.len() + stated);
    let mut residual = Vec::with_capacity(known.len());
    for (row, (i, [mean, sd])) in known.into_iter().enumerate() {
        residual.push((mean - rig[i]) / sd);
        by_rig[(row, i)] = 1.0 / sd;
    }
    for (combination, sd) in combinations {
        let row = residual.len();
        residual.push(-combination.iter().map(|(i, weight)| weight * rig[*i]).sum::<f64>() / sd);
        combination.iter().for_each(|(i, weight)| by_rig[(row, *i)] = weight / sd);
    }
    let by_record = DMatrix::zeros(residual.len(), 0);
    Some(Linear { blocks: 0, residual, by_rig, by_record, mesh: Mesh::default() })
}

/// Point at which one record is linearised.
struct Coordinates<'a> {
    rig: &'a [f64],
    /// Number of stated parameters included, each at zero.
    stated: usize,
    record: &'a [f64],
}

impl Coordinates<'_> {
    fn count(&self) -> usize {
        self.rig.len() + self.stated + self.record.len()
    }
}

fn record(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    blocks: usize,
    mesh: &Mesh,
) -> Result<Linear, IntegrationError> {
    // Columns: residual, free, stated, per-record.
    let (columns, mesh) = columns(t, h, x, 0..x.count(), blocks, mesh)?;
    let priors = record_priors(t, h, blocks);
    let rig = x.rig.len() + x.stated;
    let mut columns = columns.resize_vertically(blocks + priors.len(), 0.0);
    for (k, (i, [mean, sd])) in priors.into_iter().enumerate() {
        columns[(blocks + k, 0)] = (mean - x.record[i]) / sd;
        columns[(blocks + k, 1 + rig + i)] = 1.0 / sd;
    }
    let out = Linear {
        blocks,
        residual: columns.column(0).iter().copied().collect(),
        by_rig: columns.columns(1, rig).into_owned(),
        by_record: columns.columns(1 + rig, x.record.len()).into_owned(),
        mesh,
    };
    if out.residual.iter().all(|r| r.is_finite()) { Ok(out) } else { Err(IntegrationError::StepTooSmall { at: 0.0 }) }
}

/// Extends the linearisation of a record in its free and per-record parameters by the stated ones.
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
    let Linear { residual, by_rig, by_record, mesh, .. } = known.clone();
    let mut by_rig = by_rig.resize_horizontally(free + x.stated, 0.0);
    by_rig.view_mut((0, free), (blocks, x.stated)).copy_from(&columns.columns(1, x.stated));
    Ok(Linear { blocks, residual, by_rig, by_record, mesh })
}

/// Whitened columns of the residual and of the derivatives with respect to the coordinates at `indices`, for the first `blocks`
/// blocks; and the integration steps.
fn columns(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    indices: Range<usize>,
    blocks: usize,
    mesh: &Mesh,
) -> Result<(DMatrix<f64>, Mesh), IntegrationError> {
    let mut columns = DMatrix::zeros(blocks, 1 + indices.len());
    let mut taken = Mesh::default();
    if blocks == 0 {
        return Ok((columns, taken));
    }
    let width = |first: usize| (indices.end - first).min(WIDEST);
    let firsts: Vec<usize> = (indices.start..indices.end.max(indices.start + 1)).step_by(WIDEST).collect();
    let passes: Result<Vec<(DMatrix<f64>, Mesh)>, IntegrationError> = firsts
        .par_iter()
        // No wider than necessary.
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
        columns.columns_mut(1 + first - indices.start, width(first)).copy_from(&passed.columns(1, width(first)));
    }
    t.whitener.apply_to(&mut columns);
    Ok((columns, taken))
}

/// Columns of the residual and of the derivatives with respect to N coordinates starting at `first`, for the first `blocks`
/// blocks.
fn pass<const N: usize>(
    t: &Prepared,
    h: &Hypothesis,
    x: &Coordinates<'_>,
    first: usize,
    blocks: usize,
    mesh: &Mesh,
) -> Result<(DMatrix<f64>, Mesh), IntegrationError> {
    let variable = |value: f64, index: usize| -> Dual<N> {
        if (first..first + N).contains(&index) { Dual::variable(value, index - first) } else { Dual::from(value) }
    };
    let behind = x.rig.len() + x.stated;
    let rig: Vec<Dual<N>> = x.rig.iter().enumerate().map(|(i, v)| variable(*v, i)).collect();
    let stated: Vec<Dual<N>> = (0..x.stated).map(|i| variable(0.0, x.rig.len() + i)).collect();
    let record: Vec<Dual<N>> = x.record.iter().enumerate().map(|(i, v)| variable(*v, behind + i)).collect();
    let setting = h.setting(t, &rig, &stated, &record);
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

/// The simulation of a record.
pub fn run<'a, R: Real>(t: &'a Prepared, setting: &'a Setting<R>, set: EffectSet) -> Run<'a, R> {
    let Setting { chamber, start, correction } = setting;
    let (course, relative_tolerance) = (&t.course, t.relative_tolerance);
    Run { chamber, set, start: *start, correction: *correction, course, relative_tolerance }
}

/// Times at which the model is needed for the blocks' means.
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

pub(super) fn total(linear: &[Linear]) -> f64 {
    linear.iter().flat_map(|l| &l.residual).map(|r| r * r).sum()
}

/// Every block of every record.
pub fn all_blocks(data: &Data) -> Vec<usize> {
    data.traces.iter().map(|t| t.blocks.len()).collect()
}

/// The model's reading at every row of a record, Pa, without derivatives.
///
/// # Errors
/// Where the state leaves the range of the equations.
pub fn readings<R: Scalar>(t: &Prepared, setting: &Setting<R>, set: EffectSet) -> Result<Vec<R>, IntegrationError> {
    run(t, setting, set).pressures(&t.time_s)
}
