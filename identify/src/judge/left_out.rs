//! Error on data that took no part in the fit, Pa rms: repeats left out in turn; without repeats, records left out in turn, in at
//! most four groups; for a single record the last third, simulated from the record's start.
//!
//! From several records, whole ones are left out: the last third of a long hold shows nothing of an effect that acts only in
//! moves.
//!
//! A left-out record has its own initial pressure (and temperature, if it starts in motion). No row is judged with values that
//! were fitted to it: the rows are split into two halves of alternating runs, and each half is judged with the per-record
//! parameters fitted to the other, given their priors. The mean before the first move alone would carry the noise of a few rows,
//! several times larger after a push.

use crate::fit::{self, Fit, Until, readings};
use crate::judge::misfit;
use crate::parameters::{Hypothesis, RecordSlot};
use crate::record::data::{Data, Prepared};
use chamber::dual::Dual;
use chamber::integrate::IntegrationError;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;
use records::extremes;

/// One way of leaving data out: the blocks that are fitted, and the rows that are judged.
#[derive(Clone, Debug)]
pub struct Fold {
    /// Leading blocks of each trace that are fitted.
    pub selection: Vec<usize>,
    /// First judged row of each trace (0: all rows; the trace's length: none).
    pub judged_from: Vec<usize>,
}

/// The folds of a rig: each repeat of all experiments in turn; without repeats each record in turn; for a single record the last
/// third.
pub fn folds(data: &Data) -> Vec<Fold> {
    /// Records are left out in groups, so that there are no more folds than this.
    const MOST_FOLDS: usize = 4;
    let repeats = data.traces.iter().map(|t| t.repeat).max().unwrap_or(0) + 1;
    if repeats > 1 {
        let has_repeats: Vec<bool> =
            (0..data.experiments.len()).map(|e| data.traces.iter().filter(|t| t.experiment == e).count() > 1).collect();
        return (0..repeats)
            .map(|repeat| without(data, |_, t| t.repeat == repeat && has_repeats[t.experiment]))
            .filter(|f| f.selection.contains(&0) && f.selection.iter().any(|n| *n > 0))
            .collect();
    }
    if data.traces.len() > 1 {
        let folds = data.traces.len().min(MOST_FOLDS);
        return (0..folds).map(|fold| without(data, |k, _| k % folds == fold)).collect();
    }
    let cut = |t: &Prepared| 2 * t.time_s.len() / 3;
    vec![Fold {
        selection: data.traces.iter().map(|t| t.blocks.iter().filter(|b| b.end <= cut(t)).count()).collect(),
        judged_from: data.traces.iter().map(cut).collect(),
    }]
}

/// Whether the fitted records cover what the left-out ones show: repeats of them, or enough others. It is no fault of an effect
/// if one or two records leave open what the next one shows.
pub fn are_representative(data: &Data) -> bool {
    /// With this many records each has enough others.
    const FEWEST_RECORDS: usize = 4;
    data.traces.len() >= FEWEST_RECORDS || data.traces.iter().any(|t| t.repeat > 0)
}

/// Leaves out each experiment whole, several at a time if there are many: what an unnamed term has to predict. For a single
/// experiment the same as [`folds`].
pub fn by_experiment(data: &Data) -> Vec<Fold> {
    const MOST_FOLDS: usize = 5;
    let folds = data.experiments.len().min(MOST_FOLDS);
    if folds < 2 {
        return self::folds(data);
    }
    (0..folds).map(|fold| without(data, |_, t| t.experiment % folds == fold)).collect()
}

/// Leaves out whole records and judges all their rows. A record unlike its repeats is never judged.
fn without(data: &Data, out: impl Fn(usize, &Prepared) -> bool) -> Fold {
    let is_out = |k: usize, t: &Prepared| t.readout.unlike_others.is_none() && out(k, t);
    let kept = data.traces.iter().enumerate().map(|(k, t)| (t, !is_out(k, t)));
    let (selection, judged_from) =
        kept.map(|(t, kept)| if kept { (t.blocks.len(), t.time_s.len()) } else { (0, 0) }).unzip();
    Fold { selection, judged_from }
}

/// Error on data that took no part in the fit, Pa rms.
#[derive(Clone, Copy, Debug)]
pub struct HeldOut {
    /// Over all judged rows with equal weight: the reported one, which is compared with the error on the fitted data.
    pub rmse_pa: f64,
    /// The same with each row's square weighted by the noise's fraction of its variance, the rest being due to the positions. The
    /// unknown course between the few rows of a fast move makes errors that no model removes and that hide what a model does
    /// elsewhere.
    pub weighed_pa: f64,
}

impl HeldOut {
    /// Whether, in one of its two forms, its square is smaller than the other's by more than that of `by_pa`, Pa rms.
    pub fn is_less(&self, than: &Self, by_pa: f64) -> bool {
        let by = |ours: f64, theirs: f64| theirs * theirs - ours * ours > by_pa * by_pa;
        by(self.rmse_pa, than.rmse_pa) || by(self.weighed_pa, than.weighed_pa)
    }

    /// Whether, in the weighted form, its square is larger than the other's by more than that of `by_pa`, Pa rms.
    pub fn is_more(&self, than: &Self, by_pa: f64) -> bool {
        self.weighed_pa.powi(2) - than.weighed_pa.powi(2) > by_pa * by_pa
    }
}

/// Sums of squared errors over rows, Pa²: unweighted and weighted.
#[derive(Clone, Copy, Default)]
struct Squares {
    sum: f64,
    weighed: f64,
    rows: f64,
}

impl Squares {
    fn of_row(error: f64, weight: f64) -> Self {
        let square = error * error;
        Self { sum: square, weighed: weight * square, rows: 1.0 }
    }

    fn and(self, other: Self) -> Self {
        Self { sum: self.sum + other.sum, weighed: self.weighed + other.weighed, rows: self.rows + other.rows }
    }

    /// `None` where no row is judged.
    fn held_out(self) -> Option<HeldOut> {
        let rms = |squares: f64| (squares / self.rows).sqrt();
        (self.rows > 0.0).then(|| HeldOut { rmse_pa: rms(self.sum), weighed_pa: rms(self.weighed) })
    }
}

/// Error of measured − predicted over all judged rows of all folds; `None` where a fold cannot be fitted.
pub fn error(data: &Data, fitted: &Fit, folds: &[Fold]) -> Option<HeldOut> {
    let mut all = Squares::default();
    let effects = fitted.hypothesis.model.effects;
    for fold in folds {
        let refit = without_left_out(data, fitted, fold)?;
        let parts: Option<Vec<Squares>> = (0..data.traces.len())
            .into_par_iter()
            .filter(|&k| fold.judged_from[k] < data.traces[k].time_s.len())
            .map(|k| {
                let t = &data.traces[k];
                let left = if fold.selection[k] == 0 {
                    by_other_half(data, &refit, k)?
                } else {
                    misfit::of_record(t, &refit.setting(t, &refit.records[k]), effects).ok()?
                };
                let weights = misfit::weights(data, t);
                let judged = (fold.judged_from[k]..t.time_s.len()).filter(|&i| t.readout.is_data(i));
                Some(judged.map(|i| Squares::of_row(left[i], weights[i])).fold(Squares::default(), Squares::and))
            })
            .collect();
        all = parts?.into_iter().fold(all, Squares::and);
    }
    all.held_out()
}

/// Fits what a fold keeps, starting from the fit to all records. Stated parameters have no part in a prediction. A single descent
/// is enough: along a narrow valley another one would creep on without predicting better.
fn without_left_out(data: &Data, fitted: &Fit, fold: &Fold) -> Option<Fit> {
    let h = Hypothesis { stated: Vec::new(), ..fitted.hypothesis.clone() };
    let (rig, records) = (fitted.rig.clone(), fitted.records.clone());
    fit::fit_until(data, &h, rig, records, &fold.selection, Until::ONE_DESCENT).ok()
}

/// Returns the squares that records left out whole add to a fit's sum of squares, per degree of freedom (their blocks less their
/// per-record parameters), over those of the other records per degree of freedom: one where the others predict them, however
/// uncertain that prediction is for lack of data. `None` where parts of records are left out, or a fold cannot be fitted. Source:
/// G. C. Chow, Econometrica 28 (1960) 591.
pub fn squares_added(data: &Data, fitted: &Fit, folds: &[Fold]) -> Option<f64> {
    let count = |k: &usize| fitted.records[*k].len();
    let (mut added, mut others) = ([0.0; 2], [0.0; 2]);
    for fold in folds {
        let (out, kept): (Vec<usize>, Vec<usize>) = (0..data.traces.len()).partition(|&k| fold.selection[k] == 0);
        if kept.iter().any(|&k| fold.judged_from[k] < data.traces[k].time_s.len()) {
            return None;
        }
        let refit = without_left_out(data, fitted, fold)?;
        added[0] += fitted.chi2 - refit.chi2;
        added[1] += (fitted.blocks - refit.blocks) as f64 - out.iter().map(count).sum::<usize>() as f64;
        others[0] += refit.chi2;
        others[1] += refit.blocks as f64 - (fitted.rig.len() + kept.iter().map(count).sum::<usize>()) as f64;
    }
    let mean = |[squares, freedom]: [f64; 2]| squares / freedom.max(1.0);
    Some(mean(added) / mean(others))
}

/// Residual of a left-out record by row, Pa, each half with the per-record parameters fitted to the other half.
fn by_other_half(data: &Data, fitted: &Fit, k: usize) -> Option<Vec<f64>> {
    let record = record_numbers(data, fitted, k)?;
    match record.len() {
        ..=4 => halves::<4>(data, fitted, k, &record),
        5..=8 => halves::<8>(data, fitted, k, &record),
        9..=12 => halves::<12>(data, fitted, k, &record),
        _ => None,
    }
}

fn halves<const N: usize>(data: &Data, fitted: &Fit, k: usize, record: &[f64]) -> Option<Vec<f64>> {
    let (t, h) = (&data.traces[k], &fitted.hypothesis);
    let variables: Vec<Dual<N>> = record.iter().enumerate().map(|(i, x)| Dual::variable(*x, i)).collect();
    let rig: Vec<Dual<N>> = fitted.rig.iter().map(|x| Dual::from(*x)).collect();
    let model = readings(t, &h.setting(t, &rig, &[], &variables), h.model.effects).ok()?;
    // Runs longer than the correlation of the noise, but several of them in each half.
    let memory = (4.0 * data.noise.correlation_s() / t.row_s()) as usize;
    let length = RUN.max(memory).min(t.time_s.len() / 8).max(1);
    let values: Vec<f64> = model.iter().map(|m| m.value).collect();
    let half = alternating(&values, length);
    let variance = data.noise.total_pa().powi(2);
    // Close to the optimum the readings are linear in the per-record parameters: one step suffices.
    let steps: Option<Vec<SVector<f64, N>>> = (0..2)
        .map(|other| {
            let (mut square, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
            for i in (0..model.len()).filter(|&i| half[i] == other && t.readout.is_data(i)) {
                let slope = SVector::<f64, N>::from(model[i].tangent);
                square += slope * slope.transpose();
                right += slope * (t.pressure_pa[i] - model[i].value);
            }
            for (i, axis) in h.record_axes(t).iter().enumerate() {
                if let Some([mean, sd]) = axis.prior {
                    square[(i, i)] += variance / (sd * sd);
                    right[i] += variance * (mean - record[i]) / (sd * sd);
                }
            }
            for i in record.len()..N {
                square[(i, i)] = 1.0;
            }
            Some(square.cholesky()?.solve(&right))
        })
        .collect();
    let steps = steps?;
    let left = |i: usize| {
        let step = &steps[1 - half[i]];
        t.pressure_pa[i] - model[i].value - SVector::<f64, N>::from(model[i].tangent).dot(step)
    };
    Some((0..model.len()).map(left).collect())
}

/// Minimum rows of a run where the pressure hardly changes.
const RUN: usize = 16;
/// Number of runs in a move through the whole range of a record's pressure: eight in each half, so that each half determines when
/// the move took place.
const RUNS_IN_RANGE: f64 = 16.0;

/// Assigns each row to one of two halves in alternating runs: of `rows` rows, or fewer where the model's pressure changes fast. A
/// record's delay or average shows in its moves, so each half needs part of every move.
fn alternating(model: &[f64], rows: usize) -> Vec<usize> {
    let (low, high) = extremes(model);
    let change = ((high - low) / RUNS_IN_RANGE).max(f64::MIN_POSITIVE);
    let mut half = 0;
    let (mut begun, mut changed) = (0, 0.0);
    (0..model.len())
        .map(|i| {
            changed += (model[i] - model[i.saturating_sub(1)]).abs();
            if i - begun >= rows || changed >= change {
                (half, begun, changed) = (1 - half, i, 0.0);
            }
            half
        })
        .collect()
}

/// Per-record parameters fitted to the whole record, with the rig's held.
fn record_numbers(data: &Data, fitted: &Fit, k: usize) -> Option<Vec<f64>> {
    let mut held = fitted.hypothesis.clone();
    held.base = fitted.chamber();
    held.axes.clear();
    held.stated.clear();
    fit_record(data, &held, k, usize::MAX).ok().map(|mut fit| fit.records.swap_remove(k))
}

/// Fits one record's parameters to its rows before `until`; the hypothesis leaves no rig parameter free.
///
/// # Errors
/// Where the simulation fails at the very start.
pub fn fit_record(data: &Data, held: &Hypothesis, k: usize, until: usize) -> Result<Fit, IntegrationError> {
    let t = &data.traces[k];
    let selection: Vec<usize> = (0..data.traces.len())
        .map(|i| if i == k { t.blocks.iter().filter(|b| b.end <= until).count() } else { 0 })
        .collect();
    let mut first = held.record_guesses(data);
    // Start from the initial pressure that matches the rest.
    if let Some(begin) = from_rest(t, held, &first[k]) {
        let index = held.record_axes(t).iter().position(|a| a.slot == RecordSlot::Pressure);
        index.into_iter().for_each(|i| first[k][i] = begin);
    }
    fit::fit(data, held, Vec::new(), first, &selection).map_err(|(_, source)| source)
}

/// Initial pressure, relative to its first guess, for which the model's mean over the rest equals the measured one.
fn from_rest(t: &Prepared, held: &Hypothesis, record: &[f64]) -> Option<f64> {
    let rest = t.course.motion.segments.first().map_or(1, |s| s.end).max(1);
    let run = fit::run(t, &held.setting(t, &[], &[], record), held.model.effects).pressures(&t.time_s[..rest]).ok()?;
    Some(t.pressure_pa[..rest].iter().sum::<f64>() / run.iter().sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::{Model, Sizes};
    use crate::search::{baseline, starts};
    use crate::synthetic::Recipe;
    use chamber::effects::find;

    #[test]
    fn records_are_left_out_whole_from_two_on_and_of_a_single_one_the_last_third_is() {
        let folds_of = |records: usize| {
            let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
            recipe.tests.truncate(records);
            let data = Data::prepare(&recipe.rig()).unwrap();
            (folds(&data), are_representative(&data))
        };
        for records in [2, 3, 4] {
            let (folds, representative) = folds_of(records);
            let whole = folds.iter().filter(|f| f.selection.iter().filter(|blocks| **blocks == 0).count() == 1).count();
            assert_eq!((folds.len(), whole, representative), (records, records, records == 4));
        }
        let (folds, _) = folds_of(1);
        assert!(folds.len() == 1 && folds[0].selection[0] > 0 && folds[0].judged_from[0] > 0);
    }

    #[test]
    fn a_record_that_is_unlike_its_repeats_is_neither_left_out_nor_judged() {
        let (data, fit) = baseline::fitted(Data::prepare(&Recipe::from_seed(5).rig()).unwrap()).unwrap();
        let data = data.without_records(&[4]);
        let all = folds(&data);
        let blocks = data.traces[4].blocks.len();
        assert!(all.iter().all(|f| (f.selection[4], f.judged_from[4]) == (blocks, data.traces[4].time_s.len())));
        assert!(error(&data, &fit, &all).is_some_and(|error| error.rmse_pa < 1.2 * data.noise.total_pa()));
    }

    #[test]
    fn left_out_records_add_as_many_squares_per_degree_of_freedom_only_if_the_others_predict_them() {
        let mut recipe = Recipe::from_seed(5).with("leakage", &[2e-11]);
        let added = |recipe: &Recipe, names: &[&str]| {
            let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
            let sizes = Sizes::of(&data, &paper.chamber());
            let effects = names.iter().map(|name| find(name).unwrap().0).collect();
            let fit = starts::fit_model(&data, Model::with(effects), &paper, &sizes).unwrap();
            squares_added(&data, &fit, &folds(&data))
        };
        let of_cause = added(&recipe, &["leakage"]).unwrap();
        assert!((0.9..1.1).contains(&of_cause), "{of_cause}");
        // Without repeats each record shows what the others do not.
        recipe.repeats = 1;
        let [of_cause, of_none] = [&["leakage"][..], &[]].map(|names| added(&recipe, names).unwrap());
        assert!((0.8..1.2).contains(&of_cause) && of_none > 1.3, "{of_cause} {of_none}");
        recipe.tests.truncate(1);
        assert_eq!(added(&recipe, &["leakage"]), None);
    }

    #[test]
    fn the_uncertainty_of_fast_moves_of_few_rows_hides_no_error_elsewhere() {
        let mut recipe = Recipe { repeats: 2, rate_hz: 50.0, position_noise_m: 2e-4, ..Recipe::from_seed(5) };
        recipe.noise_pa = 60.0;
        let (data, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let HeldOut { rmse_pa, weighed_pa } = error(&data, &paper, &folds(&data)).unwrap();
        let noise_pa = data.noise.total_pa();
        assert!(rmse_pa > 1.3 * noise_pa && weighed_pa < 1.1 * noise_pa, "{rmse_pa} {weighed_pa}, noise {noise_pa}");
        // A held piston at a well-known position leaves nothing uncertain.
        recipe.position_noise_m = 0.0;
        let (data, _) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let t = &data.traces[0];
        let held = t.course.motion.segments.last().unwrap();
        assert!(misfit::weights(&data, t)[held.first + 20..].iter().all(|weight| *weight > 0.95));
    }

    #[test]
    fn both_halves_contain_part_of_a_move_of_few_rows_and_runs_at_rest_are_longer_than_the_noise_correlation() {
        let model: Vec<f64> = (0..400).map(|i| 1e5 + 5e4 * f64::from((i - 103).clamp(0, 6))).collect();
        let half = alternating(&model, 50);
        let of_move = &half[103..110];
        assert_eq!(of_move.iter().filter(|h| **h == of_move[0]).count().abs_diff(3), 1, "{of_move:?}");
        assert_eq!(half[..50], [0; 50]);
        assert_eq!(half[50..100], [1; 50]);
        assert_eq!(half[120..150], [half[120]; 30]);
    }
}
