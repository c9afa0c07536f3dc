//! Result of a diagnosis: the contract's JSON, the numbers of the report, the resulting model.

use crate::discrepancy::{Families, Path};
use crate::error::Error;
use crate::fit::Fit;
use crate::fit::covariance::{self, Undetermined};
use crate::judge::adequacy::has_squares_of_noise;
use crate::judge::misfit;
use crate::outcome::empirical::Empirical;
use crate::outcome::estimates::{Estimates, Rmse, as_map, parameters, uncertainty};
use crate::outcome::next_experiment::{self, NextExperiment};
use crate::outcome::over_sets;
use crate::outcome::probability;
use crate::outcome::recording::{self, NoiseFound, RecordFound};
use crate::outcome::remainder;
use crate::outcome::rigs;
use crate::outcome::unnamed::{Unnamed, unnamed};
use crate::parameters::{Model, RecordStart, names};
use crate::record::data::Data;
use crate::search::{self, Candidate, Found, Verdict};
use chamber::Chamber;
use chamber::effects::{self, CARDS, EffectSet};
use records::OfEachRecord;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;

/// A model and its errors.
#[derive(Clone, Debug, Serialize)]
pub struct Side {
    /// Errors on fitted and on left-out data, Pa rms.
    pub rmse_pa: Rmse,
    /// Parameters with their 95 % intervals, by name.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// One step of the search: usually a model with one term more than the step before it, or with one term exchanged.
#[derive(Clone, Debug, Serialize)]
pub struct Step {
    /// Names of the effects in the model of this step.
    pub effects: Vec<&'static str>,
    /// All its terms in words, joined by " + ", per-record terms marked as such. Empty for the paper's model.
    pub terms: String,
    /// Errors on fitted and on left-out data, Pa rms.
    pub rmse_pa: Rmse,
    /// The same with each row weighted by the noise's fraction of its expected error, which the positions make large in fast
    /// moves. For reports.
    #[serde(skip)]
    pub weighed_pa: Rmse,
}

/// Errors above this multiple of the weighted ones are those of moves in which the positions leave the pressures uncertain:
/// compared with the noise they would look like a misfit.
const OF_MOVES: f64 = 1.5;

/// A set of terms that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    /// Its terms, joined by " + ".
    pub effect: String,
    /// BIC of the baseline minus its own.
    pub delta_bic: f64,
    /// Error on left-out data, Pa, where it was judged.
    pub held_out_rmse_pa: Option<f64>,
    /// All its parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// A contribution to the variance of λ0.
#[derive(Clone, Debug, Serialize)]
pub struct Budget {
    /// Its source: the records, a stated parameter, or the choice of effects.
    pub source: String,
    /// Its fraction of the variance.
    pub share: f64,
}

/// The result of `diagnose`.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// The verdict; serialised by its name.
    #[serde(serialize_with = "by_name")]
    pub verdict: Verdict,
    /// The effects in the model, the one that entered first at the head.
    pub effects: Vec<&'static str>,
    /// Posterior probability of every effect for which it is worth mentioning.
    #[serde(serialize_with = "as_map")]
    pub probabilities: Vec<(String, f64)>,
    /// The steps from the paper's model to the one found.
    pub steps: Vec<Step>,
    /// Systematic misfit of the model found, Pa.
    pub remaining_pa: f64,
    /// The systematic misfit that does not matter, Pa.
    pub accuracy_pa: f64,
    /// The noise of the recording.
    pub noise: NoiseFound,
    /// Per-record parameters and errors.
    pub records: Vec<RecordFound>,
    /// Groups of effects that the data cannot tell apart.
    pub indistinguishable: Vec<Vec<String>>,
    /// The balance to which the evidence points.
    pub balance: &'static str,
    /// Noise of the pressure readings, all kinds together, Pa.
    pub noise_pa: f64,
    /// The paper's model.
    pub before: Side,
    /// The model found; the paper's where there is no effect.
    pub after: Side,
    /// All sets tried, the best evidence first.
    pub candidates: Vec<Tried>,
    /// Contributions to the interval of λ0.
    pub lambda0_budget: Vec<Budget>,
    /// The missing term as a curve, where no name fits and one could be determined; in the model only if accepted.
    pub empirical: Option<Empirical>,
    /// What remains, as free functions of one variable, the best first; empty if the verdict is `adequate` or `explained`, or the
    /// model is adequate.
    pub missing: Vec<Unnamed>,
    /// Parameters, or combinations of them, that the data hardly determines.
    pub undetermined: Vec<Undetermined>,
    /// What to measure next.
    pub next_experiments: Vec<NextExperiment>,
    /// What was assumed, left out or noticed.
    pub assumptions: Vec<String>,
    /// What remains of the residual, as a clause of a report.
    #[serde(skip)]
    pub remainder: String,
}

fn by_name<S: Serializer>(verdict: &Verdict, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(verdict.name())
}

impl Diagnosis {
    /// The effects of the model found, including per-record ones.
    pub fn effects_of_model(&self) -> &[&'static str] {
        self.steps.last().map_or(&self.effects, |step| &step.effects)
    }

    /// The terms of the model found, in words.
    pub fn terms(&self) -> &str {
        self.steps.last().map_or("", |step| &step.terms)
    }

    /// The same one by one; none for the paper's model.
    pub fn each_term(&self) -> impl Iterator<Item = &str> {
        self.terms().split(" + ").filter(|term| !term.is_empty())
    }

    /// Whether the error of the model found is mostly due to its positions: then the weighted errors show how well it fits.
    pub fn is_error_of_moves(&self) -> bool {
        self.steps.last().is_some_and(|step| step.rmse_pa.fit > OF_MOVES * step.weighed_pa.fit)
    }

    /// What a model gains with its effects, including the conjunction before what remains. Decisive evidence need not show in the
    /// error, unweighted or weighted.
    pub fn gain(&self) -> &'static str {
        let (Some(before), Some(after)) = (self.steps.first(), self.steps.last()) else {
            return "describes the records better, but";
        };
        let errors = [(before.rmse_pa, after.rmse_pa), (before.weighed_pa, after.weighed_pa)];
        match errors.iter().filter_map(|(b, a)| b.held_out.zip(a.held_out)).any(|(before, after)| after < before) {
            true => "predicts left-out data decisively better, but",
            false => "is far likelier, but its error on left-out data is no smaller, and",
        }
    }

    /// Meaning of the effects' probabilities with this verdict.
    pub fn meaning_of_probabilities(&self) -> &'static str {
        probability::meaning(self.verdict)
    }

    /// The balance to which the evidence points, as a clause.
    pub fn pointed_at(&self) -> String {
        match self.balance {
            "none" => "nothing points to one of the balances".to_owned(),
            balance => format!("the evidence points to the {balance} balance"),
        }
    }

    /// Whether a curve is among the effects.
    pub fn has_curve(&self) -> bool {
        self.empirical.as_ref().is_some_and(|e| e.fate.is_accepted())
    }
}

/// A diagnosis with the data that a report draws.
pub struct Diagnosed {
    /// What the JSON file and the report state.
    pub diagnosis: Diagnosis,
    /// The prepared data.
    pub data: Data,
    /// The finished search.
    pub found: Found,
    /// Row residuals of the paper's model, Pa, record by record.
    pub residuals_before: Vec<Vec<f64>>,
    /// Row residuals of the model found, Pa.
    pub residuals_after: Vec<Vec<f64>>,
    /// Variables of the paper's model along each record.
    pub paths: Vec<Path>,
}

impl Diagnosed {
    /// The resulting chamber: with the effects found, else the paper's model.
    pub fn chamber(&self) -> Chamber {
        self.found.reported().fit.chamber_of_rig()
    }

    /// Per-record terms, which that chamber does not contain.
    pub fn of_each_record(&self) -> OfEachRecord {
        let Model { per_record, record_start, .. } = self.found.reported().model;
        OfEachRecord { effects: per_record, initial_temperature: record_start > RecordStart::Nothing }
    }

    /// Uncertainty of that chamber's parameters.
    pub fn uncertainty(&self) -> records::Uncertainty {
        let mut known = uncertainty(&self.found.reported().fit, self.found.adequacy().is_noise);
        let told = &self.diagnosis.after.parameters;
        for (name, ci95) in known.parameters.iter().zip(&mut known.ci95) {
            if let Some((_, estimate)) = told.iter().find(|(other, _)| other == name) {
                *ci95 = estimate.ci95;
            }
        }
        known
    }
}

/// Diagnoses a rig. `progress` receives the current activity and its progress, 0 to 1.
///
/// # Errors
/// [`Error`]: implausible data.
pub fn diagnose(rig: &records::Rig, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Diagnosed, Error> {
    let (data, found) = search::search(Data::prepare(rig)?, progress)?;
    Ok(describe(data, found))
}

/// Describes a finished search in words and numbers.
pub fn describe(data: Data, found: Found) -> Diagnosed {
    let after = found.reported();
    let adequacy = found.adequacy();
    let residuals_before = misfit::residuals(&data, &found.baseline.fit);
    let residuals_after =
        if after.model == Model::PAPER { residuals_before.clone() } else { misfit::residuals(&data, &after.fit) };
    let before = side(&data, &found.baseline, &residuals_before, found.baseline_adequacy.is_noise);
    let mut after_side = side(&data, after, &residuals_after, adequacy.is_noise);
    let of_set = after_side.parameters.clone();
    if found.verdict != Verdict::Unexplained {
        after_side.parameters = over_sets::widened(of_set.clone(), &data, &found, adequacy.is_noise);
    }
    let effects: Vec<&'static str> = in_order(&found, after.model.of_rig());
    let open = matches!(found.verdict, Verdict::Unexplained | Verdict::Improved) && !adequacy.is_adequate();
    let missing = if open { unnamed(after, &adequacy.families) } else { Vec::new() };
    let balance = match (found.verdict, effects.first()) {
        (Verdict::Adequate, _) => "none",
        (Verdict::Unexplained, _) | (_, None) => missing.first().map_or("none", |m| m.balance),
        (_, Some(first)) => match chamber::effects::find(first) {
            Some((effects::Empirical::INDEX, _)) => {
                found.curve_fit.as_ref().map_or("none", |r| r.first_order.term.balance().name())
            }
            Some((_, card)) => card.balance.name(),
            None => "none",
        },
    };
    let steps = steps(&data, &found);
    let by_choice = match () {
        () if !found.alike.is_empty() => "choice_among_indistinguishable_effects",
        () if adequacy.is_adequate() => "effects_within_accuracy",
        () => "missing_effect",
    };
    let lambda0_budget = budget(&after.fit, adequacy.is_noise, [&of_set, &after_side.parameters], by_choice);
    let is_open = found.verdict != Verdict::Explained;
    let of_two_rigs = is_open.then(|| rigs::apart(&data, before.rmse_pa.fit, rigs::Overlap::Levels)).flatten();
    let diagnosis = Diagnosis {
        verdict: found.verdict,
        effects,
        probabilities: probability::of_effects(&found),
        steps,
        remaining_pa: adequacy.systematic_pa,
        accuracy_pa: data.accuracy_pa(),
        noise: NoiseFound::of(&data),
        records: recording::records(&data, &after.fit, &residuals_after, adequacy.is_noise),
        indistinguishable: if after.model == Model::PAPER { Vec::new() } else { groups(&after.model, &found.alike) },
        balance,
        noise_pa: data.noise.total_pa(),
        before,
        after: after_side,
        candidates: each_set_once(&found.tried).map(|c| tried(&data, c)).collect(),
        lambda0_budget,
        empirical: found.curve_fit.as_ref().and_then(|r| Empirical::of(r, r.fate.is_accepted() && adequacy.is_noise)),
        missing,
        undetermined: covariance::undetermined(&after.fit),
        next_experiments: next_experiment::next(&data, &found),
        assumptions: recording::notes(&data, Some(&found)).into_iter().chain(of_two_rigs).collect(),
        remainder: remainder::of(&data, &found, adequacy),
    };
    let paths = Families::new(&data, &found.baseline.fit).map(|families| families.paths().to_vec()).unwrap_or_default();
    Diagnosed { diagnosis, data, residuals_before, residuals_after, paths, found }
}

/// Contributions to the interval of λ0, which is the first parameter both of the set and of the intervals over all sets that can
/// take its place; the contribution of their choice has the source `by_choice`.
fn budget(fit: &Fit, leaves_noise: bool, [of_set, over_sets]: [&Estimates; 2], by_choice: &str) -> Vec<Budget> {
    let width = |numbers: &Estimates| numbers.first().map_or(0.0, |(_, e)| e.ci95[1] - e.ci95[0]);
    let of_set = (width(of_set) / width(over_sets)).powi(2).min(1.0);
    let shares = covariance::budget(fit, 0, leaves_noise).into_iter();
    let mut out: Vec<Budget> = shares.map(|(source, share)| Budget { source, share: of_set * share }).collect();
    if of_set < 1.0 {
        out.push(Budget { source: by_choice.to_owned(), share: 1.0 - of_set });
    }
    out
}

fn side(data: &Data, c: &Candidate, residuals: &[Vec<f64>], leaves_noise: bool) -> Side {
    let rmse_pa = Rmse { fit: misfit::rms(data, residuals), held_out: c.held_out_pa() };
    Side { rmse_pa, parameters: parameters(data, &c.fit, leaves_noise) }
}

fn steps(data: &Data, found: &Found) -> Vec<Step> {
    let kept = if found.verdict == Verdict::Unexplained { 1 } else { found.steps.len() };
    found.steps[..kept]
        .iter()
        .map(|c| {
            let residuals = misfit::residuals(data, &c.fit);
            Step {
                effects: names(c.model.effects),
                terms: c.model.words(),
                rmse_pa: Rmse { fit: misfit::rms(data, &residuals), held_out: c.held_out_pa() },
                weighed_pa: Rmse {
                    fit: misfit::weighed_rms(data, &residuals),
                    held_out: c.held_out.map(|error| error.weighed_pa),
                },
            }
        })
        .collect()
}

/// The best fit of each set of terms: a set may also have been fitted with more secondary parameters free, or from another start.
fn each_set_once(tried: &[Candidate]) -> impl Iterator<Item = &Candidate> {
    let of = |i: usize| tried[i].model.with_nothing_freed();
    (0..tried.len()).filter(move |&i| (0..i).all(|before| of(before) != of(i))).map(|i| &tried[i])
}

fn tried(data: &Data, c: &Candidate) -> Tried {
    Tried {
        effect: c.model.words(),
        delta_bic: c.delta_bic,
        held_out_rmse_pa: c.held_out_pa(),
        parameters: parameters(data, &c.fit, has_squares_of_noise(data, &c.fit)),
    }
}

/// The effects of a set in the order of their entry; those that entered together by the evidence of each alone.
fn in_order(found: &Found, set: EffectSet) -> Vec<&'static str> {
    let step = |e: usize| found.steps.iter().position(|s| s.model.effects.has(e)).unwrap_or(usize::MAX);
    let alone = |e: usize| {
        let single = found.tried.iter().find(|c| c.model == Model::with(EffectSet::one(e)));
        single.map_or(f64::MIN, |c| c.delta_bic)
    };
    let mut effects: Vec<usize> = set.iter().collect();
    effects.sort_by(|a, b| step(*a).cmp(&step(*b)).then(alone(*b).total_cmp(&alone(*a))));
    effects.into_iter().map(|e| CARDS[e].name).collect()
}

/// For each effect of the chosen set, those that could take its place; sets that differ in more are written whole.
fn groups(chosen: &Model, alike: &[Model]) -> Vec<Vec<String>> {
    let mut out: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for other in alike {
        let gone: Vec<usize> = chosen.effects.iter().filter(|e| !other.effects.has(*e)).collect();
        let new: Vec<usize> = other.effects.iter().filter(|e| !chosen.effects.has(*e)).collect();
        if let ([gone], [new]) = (gone.as_slice(), new.as_slice()) {
            out.entry(CARDS[*gone].name.to_owned()).or_default().push(CARDS[*new].name.to_owned());
        } else {
            out.entry(chosen.words()).or_default().push(other.words());
        }
    }
    out.into_iter().map(|(first, rest)| group(first, rest)).collect()
}

/// A group without duplicate names.
fn group(first: String, rest: Vec<String>) -> Vec<String> {
    rest.into_iter().fold(vec![first], |mut names, name| {
        if !names.contains(&name) {
            names.push(name);
        }
        names
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::effects::find;

    fn set(names: &[&str]) -> EffectSet {
        names.iter().map(|name| find(name).unwrap().0).collect()
    }

    #[test]
    fn a_name_stands_once_in_a_group_of_those_that_cannot_be_told_apart() {
        let chosen =
            Model { per_record: set(&["record_delay"]), ..Model::with(set(&["wall_conduction", "record_delay"])) };
        let common = Model::with(set(&["wall_heating", "record_delay"]));
        let per_record = Model { per_record: set(&["record_delay"]), ..common };
        assert_eq!(groups(&chosen, &[common, per_record]), [["wall_conduction", "wall_heating"]]);
        let folded = Model::with(chosen.effects);
        assert_eq!(groups(&chosen, &[folded, folded])[0].len(), 2);
    }
}
