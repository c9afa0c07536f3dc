//! `validate`: compares a model with records that took no part in finding it.
//!
//! The rig parameters are the model's. Each record has its own initial pressure, initial temperature where it begins in motion or
//! where the model's records had their own, and parameters of recording effects. They are fitted to the record's start, its rest
//! and its first move, and the rest of the record is predicted, with the model's drift; or, with the whole record, to all of it.

use super::at_bound::RecordFit;
use super::estimates::{Estimates, as_map};
use super::recording;
use crate::error::Error;
use crate::fit::covariance;
use crate::judge::{left_out, misfit};
use crate::parameters::{Hypothesis, Model, RecordSlot, Sizes, delays_position};
use crate::policy;
use crate::record::data::{Data, Prepared};
use crate::record::plausibility::outliers;
use crate::record::reconstruction::gaps;
use crate::record::stroke::Phase;
use crate::search::terms;
use chamber::Chamber;
use nalgebra::DMatrix;
use rayon::prelude::*;
use records::{OfEachRecord, Rig};
use report::digits;
use serde::Serialize;

/// Rounds of outlier detection: a fit with outliers can hide others.
const ROUNDS: usize = 3;

/// An error above this multiple of the model's known error, or of the noise, needs a reason...
const UNUSUAL: f64 = 2.0;
/// ...which is the records' initial temperature if fitting that leaves less than this fraction of it.
const BY_WARMTH: f64 = 0.5;

/// Error of the model on one record.
#[derive(Clone, Debug, Serialize)]
pub struct RecordError {
    /// File of the trace.
    pub trace: String,
    /// The per-record parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
    /// Error over the judged rows, Pa rms; none where the record ends with its first move.
    pub rmse_pa: Option<f64>,
    /// Time of the first judged row, s from the record's first row.
    pub judged_from_s: f64,
    /// Number of judged rows.
    pub rows: usize,
}

/// The result of `validate`.
#[derive(Clone, Debug, Serialize)]
pub struct Validation {
    /// Whether the per-record parameters were fitted to whole records.
    pub whole_record: bool,
    /// Error over all judged rows, Pa rms.
    pub rmse_pa: f64,
    /// Noise of the recording, Pa.
    pub noise_pa: f64,
    /// Systematic misfit where whole records are judged, Pa.
    pub systematic_pa: Option<f64>,
    /// Errors record by record.
    pub records: Vec<RecordError>,
    /// What was left out, and why the error differs from that of a prediction.
    pub notes: Vec<String>,
}

/// A validation with the data that a report draws.
pub struct Validated {
    /// Errors of the model on these records.
    pub validation: Validation,
    /// The prepared records.
    pub data: Data,
    /// Measured minus model, row by row, Pa.
    pub residuals: Vec<Vec<f64>>,
}

/// A model for predicting records, and what is known of it.
#[derive(Clone, Copy, Debug)]
pub struct Predictor {
    /// The chamber, without per-record terms.
    pub chamber: Chamber,
    /// Its error on similar data, Pa rms, including noise; zero if unknown.
    pub error_pa: f64,
    /// Per-record terms of the records from which the model was identified.
    pub of_each_record: OfEachRecord,
}

impl Predictor {
    /// A chamber about which nothing else is known.
    pub fn of(chamber: Chamber) -> Self {
        Self { chamber, error_pa: 0.0, of_each_record: OfEachRecord::default() }
    }
}

/// Validates a model on a rig's records.
///
/// # Errors
/// [`Error`]: implausible data, a record that the model cannot follow, records that end with their first move.
pub fn validate(model: &Predictor, rig: &Rig, whole_record: bool) -> Result<Validated, Error> {
    let mut data = Data::prepare(rig)?;
    if !whole_record {
        data.traces.iter_mut().for_each(Prepared::leave_out_behind_gap);
    }
    let mut compared = Compared::of(&data, model, whole_record)?;
    for _ in 0..ROUNDS {
        let found = outliers::in_residuals(&data, &compared.residuals);
        if data.is_without(&found) {
            break;
        }
        data = data.without(&found);
        compared = Compared::of(&data, model, whole_record)?;
    }
    let rmse_pa = compared.rmse_pa().ok_or_else(|| Error::NothingToCompare { rig: rig.path.clone() })?;
    let warm_start = warm_start(&data, model, whole_record, rmse_pa)?;
    let Compared { parameters, residuals, judged_from, squares } = compared;
    let mut records = Vec::with_capacity(parameters.len());
    for ((parameters, (sum, rows)), (t, &from)) in
        parameters.into_iter().zip(squares).zip(data.traces.iter().zip(&judged_from))
    {
        records.push(RecordError {
            trace: t.path.display().to_string(),
            parameters,
            rmse_pa: (rows > 0).then(|| (sum / rows as f64).sqrt()),
            judged_from_s: t.time_s.get(from).copied().unwrap_or(0.0),
            rows,
        });
    }
    let notes = recording::left_out(&data).into_iter().chain(uncompared(&data, whole_record)).chain(warm_start);
    let validation = Validation {
        whole_record,
        rmse_pa,
        noise_pa: data.noise.total_pa(),
        systematic_pa: whole_record.then(|| misfit::systematic(&data, &residuals)),
        records,
        notes: notes.collect(),
    };
    Ok(Validated { validation, data, residuals })
}

/// The note on what is not compared in records with gaps, if any.
fn uncompared(data: &Data, whole_record: bool) -> Option<String> {
    let has_gap = |t: &Prepared| gaps::of(&t.course.motion).next().is_some();
    (!whole_record && data.traces.iter().any(has_gap)).then(|| {
        "the rows after a record's first gap are not compared: the temperature of the gas at the end of the gap cannot be predicted (`--whole-record` fits that too)".to_owned()
    })
}

/// The note on records that begin before gas and wall have the temperature of their surroundings, unknown to the model.
fn warm_start(data: &Data, model: &Predictor, whole_record: bool, rmse_pa: f64) -> Result<Option<String>, Error> {
    let known_pa = model.error_pa.max(data.noise.total_pa());
    if model.of_each_record.initial_temperature || rmse_pa < UNUSUAL * known_pa {
        return Ok(None);
    }
    let of_each_record = OfEachRecord { initial_temperature: true, ..model.of_each_record };
    let warm = Compared::of(data, &Predictor { of_each_record, ..*model }, whole_record)?;
    Ok(warm.rmse_pa().filter(|warm_pa| *warm_pa < BY_WARMTH * rmse_pa).map(|warm_pa| {
        format!(
            "with an initial temperature fitted to each record the model errs by {} Pa rms: gas or wall had not reached the temperature of the surroundings when the records began",
            digits(warm_pa, 3)
        )
    }))
}

/// Each record compared with the model, with its fitted per-record parameters.
struct Compared {
    parameters: Vec<Estimates>,
    /// Measured minus model, row by row, Pa.
    residuals: Vec<Vec<f64>>,
    /// The first judged row.
    judged_from: Vec<usize>,
    /// Sum of squares over the judged rows, Pa², and their number.
    squares: Vec<(f64, usize)>,
}

impl Compared {
    fn of(data: &Data, model: &Predictor, whole_record: bool) -> Result<Self, Error> {
        let hypothesis = hypothesis(data, model, whole_record);
        let weighed = if whole_record { None } else { weighed(data, model.error_pa) };
        let weighed = weighed.as_ref().unwrap_or(data);
        let judged_from: Vec<usize> = data.traces.iter().map(|t| if whole_record { 0 } else { begin_of(t) }).collect();
        let until = |k: usize| if whole_record { usize::MAX } else { judged_from[k] };
        let found: Vec<(Estimates, Vec<f64>)> = (0..data.traces.len())
            .into_par_iter()
            .map(|k| of_record(weighed, &hypothesis, k, until(k)))
            .collect::<Result<_, _>>()?;
        let (parameters, residuals): (Vec<Estimates>, Vec<Vec<f64>>) = found.into_iter().unzip();
        let of_each = data.traces.iter().zip(&residuals).zip(&judged_from);
        let squares = of_each.map(|((t, residual), &from)| misfit::squares(t, residual, from)).collect();
        Ok(Self { parameters, residuals, judged_from, squares })
    }

    /// Error over all judged rows, Pa rms; `None` without any.
    fn rmse_pa(&self) -> Option<f64> {
        let all = self.squares.iter().fold((0.0, 0), |(sum, rows), (more, further)| (sum + more, rows + further));
        (all.1 > 0).then(|| (all.0 / all.1 as f64).sqrt())
    }
}

/// The hypothesis for these records: only per-record parameters are free.
fn hypothesis(data: &Data, model: &Predictor, whole_record: bool) -> Hypothesis {
    let chamber = &model.chamber;
    // Growth with time cannot be determined from a record's start, nor a position delay be told from a pressure delay: they are
    // per-record only where the model or each of its own records has them, and the former only with the whole record.
    let growing = terms::growing_with_time();
    let only_of_model = growing.union(terms::of_record().iter().filter(|e| delays_position(*e)).collect());
    let per_record =
        terms::of_record().without(only_of_model.without(chamber.active().union(model.of_each_record.effects)));
    let per_record = if whole_record { per_record } else { per_record.without(growing) };
    let with = Model::with(chamber.active().union(per_record));
    let record_start = if model.of_each_record.initial_temperature { with.most_of_start() } else { with.record_start };
    let model = Model { per_record, record_start, ..with };
    let mut hypothesis = Hypothesis::new(data, model, chamber, &Sizes::of(data, chamber));
    hypothesis.axes.clear();
    hypothesis.stated.clear();
    // The records of a rig scatter about the model's values for its logger and gauges, by less than loggers and gauges do.
    for axis in &mut hypothesis.record_effects {
        if let (RecordSlot::Effect(e, p), Some([_, sd])) = (axis.slot, axis.prior) {
            let mean = axis.coordinate(chamber.effects.of(e)[p]);
            axis.prior = Some([mean, policy::BETWEEN_RECORDS * sd]);
        }
    }
    hypothesis
}

/// Per-record parameters, fitted to a record's rows before `until`, and the residual.
fn of_record(data: &Data, hypothesis: &Hypothesis, k: usize, until: usize) -> Result<(Estimates, Vec<f64>), Error> {
    let t = &data.traces[k];
    let failed = |source| Error::Simulation { trace: t.path.clone(), source };
    let fit = left_out::fit_record(data, hypothesis, k, until).map_err(failed)?;
    let residual = misfit::of_record(t, &fit.setting(t, &fit.records[k]), hypothesis.model.effects).map_err(failed)?;
    let variance = covariance::of_record(&fit, k, &DMatrix::zeros(0, 0));
    let record_fit = RecordFit { data, hypothesis, record: k, until };
    let estimate = |(i, axis): (usize, &crate::parameters::Axis<RecordSlot>)| {
        let variance = variance.as_ref().map_or(f64::INFINITY, |c| c[(i, i)]);
        let mut estimate = covariance::estimate(axis, fit.records[k][i], variance, axis.slot.unit());
        if let Some(farthest) = record_fit.farthest(axis, &fit, fit.records[k][i], variance) {
            estimate.ci95[1] = axis.value(farthest);
        }
        (axis.slot.name(), estimate)
    };
    Ok((hypothesis.record_axes(t).iter().enumerate().map(estimate).collect(), residual))
}

/// The data with the error of the model beyond noise, Pa rms, added to the noise: where the model errs, a start determines
/// per-record parameters less well. With the noise alone they would be bent to imitate what the model lacks. `None` where there
/// is no such error.
fn weighed(data: &Data, error_pa: f64) -> Option<Data> {
    let left_pa = (error_pa.powi(2) - data.noise.total_pa().powi(2)).max(0.0).sqrt();
    let shortest_s = data.traces.iter().map(Prepared::row_s).fold(f64::INFINITY, f64::min);
    let longest_s = data.traces.iter().filter_map(|t| t.time_s.last().copied()).fold(0.0, f64::max);
    (left_pa > 0.0).then(|| data.clone().with_noise(data.noise.clone().beside(left_pa, [shortest_s, longest_s])))
}

/// The row at which the first whole move of a record ends: its parameters may be fitted up to there.
fn begin_of(t: &Prepared) -> usize {
    let segments = &t.course.motion.segments;
    let whole = segments.iter().skip(usize::from(!t.starts_at_rest)).find(|s| s.phase == Phase::Move);
    whole.or_else(|| segments.iter().find(|s| s.phase == Phase::Move)).map_or(t.time_s.len(), |s| s.end)
}
