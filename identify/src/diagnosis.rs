//! What a diagnosis says: the contract's JSON, the numbers of the report, the model that follows.

use crate::error::Error;
use crate::evidence;
use crate::fit::Fit;
use crate::hypothesis::names;
use crate::missing::{Missing, Path, Search};
use crate::prepare::{ASSUMED_AMBIENT_DEVIATION_K, Data};
use crate::separate::{self, NextExperiment};
use crate::tracing::{self, Candidate, Trace, Verdict};
use crate::uncertainty::{self, Estimate, Undetermined};
use chamber::Chamber;
use chamber::effects::{CARDS, EffectSet};
use serde::Serialize;
use std::collections::BTreeMap;

/// Numbers by name, in a fixed order.
pub type Estimates = Vec<(String, Estimate)>;

/// Errors against what the sensor recorded, Pa.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rmse {
    /// On the data fitted.
    pub fit: f64,
    /// On data left out of the fit.
    pub held_out: Option<f64>,
}

/// A model and how far it is off.
#[derive(Clone, Debug, Serialize)]
pub struct Side {
    /// Its errors.
    pub rmse_pa: Rmse,
    /// Its parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// A set of effects that was tried.
#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    /// Its effect, or the two joined by " + ".
    pub effect: String,
    /// BIC of the baseline less its own.
    pub delta_bic: f64,
    /// Error on held-out data, Pa, where it was judged.
    pub held_out_rmse_pa: Option<f64>,
    /// All its parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// How close known effects come to a residual that they do not explain.
#[derive(Clone, Debug, Serialize)]
pub struct Closest {
    /// The effects; each with decisive evidence, together with a lower error on held-out data.
    pub effects: Vec<&'static str>,
    /// Groups of effects that would come as close.
    pub indistinguishable: Vec<Vec<String>>,
    /// BIC of the baseline less that of this set.
    pub delta_bic: f64,
    /// Share of the residual's squares beyond the noise that they take away.
    pub share: f64,
    /// Their errors.
    pub rmse_pa: Rmse,
    /// All parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
}

/// A missing term without a name.
#[derive(Clone, Debug, Serialize)]
pub struct Unnamed {
    /// The balance it belongs to.
    pub balance: &'static str,
    /// What is missing, and its unit.
    pub quantity: &'static str,
    /// Unit of [`Unnamed::value`].
    pub unit: &'static str,
    /// What it follows.
    pub variable: &'static str,
    /// Unit of [`Unnamed::at`].
    pub variable_unit: &'static str,
    /// Values of the variable.
    pub at: Vec<f64>,
    /// The missing term there.
    pub value: Vec<f64>,
    /// Its standard deviation there.
    pub sd: Vec<f64>,
    /// Share of the residual's squares beyond noise that it takes away, to first order.
    pub share: f64,
}

/// The result of `diagnose`.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// adequate, explained or unexplained.
    pub verdict: &'static str,
    /// The effects that explain the residual.
    pub effects: Vec<&'static str>,
    /// Groups of effects that the data cannot tell apart.
    pub indistinguishable: Vec<Vec<String>>,
    /// Where the evidence points.
    pub balance: &'static str,
    /// Noise of the pressure readings, Pa.
    pub noise_pa: f64,
    /// The paper's model.
    pub before: Side,
    /// The explained model; the paper's where there is no effect.
    pub after: Side,
    /// Where the verdict is unexplained: the known effects that come closest, if they come close.
    pub closest: Option<Closest>,
    /// Everything tried, the best evidence first.
    pub candidates: Vec<Tried>,
    /// Number of independent samples.
    pub effective_samples: f64,
    /// What remains of an unexplained residual, as free functions of one variable, the best first.
    pub missing: Vec<Unnamed>,
    /// Parameters, or combinations of them, that the data hardly determines.
    pub undetermined: Vec<Undetermined>,
    /// What to measure next.
    pub next_experiments: Vec<NextExperiment>,
    /// What was assumed.
    pub assumptions: Vec<String>,
}

/// A diagnosis with what a report draws.
pub struct Diagnosed {
    /// The result.
    pub diagnosis: Diagnosis,
    /// The prepared data.
    pub data: Data,
    /// How it was found.
    pub trace: Trace,
    /// Row residuals before, Pa, trace by trace.
    pub residuals_before: Vec<Vec<f64>>,
    /// Row residuals after, Pa.
    pub residuals_after: Vec<Vec<f64>>,
    /// Row residuals with the known effects that come closest, Pa, where there are any.
    pub residuals_closest: Option<Vec<Vec<f64>>>,
    /// The paper's model's variables along each record.
    pub paths: Vec<Path>,
}

impl Diagnosed {
    /// The chamber to go on with: with the effects where the residual is explained, else the paper's model.
    pub fn chamber(&self) -> Chamber {
        settled(&self.trace).fit.chamber()
    }
}

/// Known effects that leave more than noise are worth mention when they take away this share of what is beyond it …
const CLOSE_SHARE: f64 = 0.8;
/// … and bring the error on held-out data below this share of the baseline's.
const CLOSE_HELD_OUT: f64 = 0.6;

impl Diagnosed {
    /// The chamber with the effects of [`Diagnosis::closest`], if there are any.
    pub fn closest_chamber(&self) -> Option<Chamber> {
        self.diagnosis.closest.as_ref().map(|_| self.trace.chosen.fit.chamber())
    }
}

fn closest(data: &Data, trace: &Trace, before: &Side) -> Option<Closest> {
    let c = &trace.chosen;
    if trace.verdict != Verdict::Unexplained || c.effects.is_empty() {
        return None;
    }
    let fit = evidence::rms(&evidence::residuals(data, &c.fit));
    let beyond = |rms: f64| rms * rms - data.noise.sd_pa * data.noise.sd_pa;
    let share = 1.0 - beyond(fit) / beyond(before.rmse_pa.fit);
    let held_out = c.held_out_pa? / before.rmse_pa.held_out?;
    (share > CLOSE_SHARE && held_out < CLOSE_HELD_OUT).then(|| Closest {
        effects: by_evidence(trace, c.effects).into_iter().map(|e| CARDS[e].name).collect(),
        indistinguishable: groups(c.effects, &trace.alike),
        delta_bic: c.delta_bic,
        share,
        rmse_pa: Rmse { fit, held_out: c.held_out_pa },
        parameters: parameters(data, &c.fit, false),
    })
}

fn settled(trace: &Trace) -> &Candidate {
    if trace.verdict == Verdict::Explained { &trace.chosen } else { &trace.baseline }
}

/// Diagnoses a rig. `progress` is told what is being done and how far it is, 0 to 1.
///
/// # Errors
/// [`Error`]: data that cannot be what it should be.
pub fn diagnose(rig: &records::Rig, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Diagnosed, Error> {
    let data = Data::prepare(rig)?;
    let trace = tracing::trace(&data, progress)?;
    Ok(describe(data, trace))
}

/// Puts a finished tracing into words and numbers.
pub fn describe(data: Data, trace: Trace) -> Diagnosed {
    let after = settled(&trace);
    let residuals_before = evidence::residuals(&data, &trace.baseline.fit);
    let residuals_after =
        if after.effects.is_empty() { residuals_before.clone() } else { evidence::residuals(&data, &after.fit) };
    let baseline_is_noise = trace.baseline_adequacy.is_noise;
    let before = side(&data, &trace.baseline, &residuals_before, baseline_is_noise);
    let is_noise = trace.verdict != Verdict::Unexplained && trace.chosen_adequacy.is_noise;
    let after_side = side(&data, after, &residuals_after, is_noise);
    let missing = if trace.verdict == Verdict::Unexplained { unnamed(&data, &trace) } else { Vec::new() };
    let balance = match trace.verdict {
        Verdict::Adequate => "none",
        Verdict::Explained => strongest_balance(&trace, after.effects),
        Verdict::Unexplained => missing.first().map_or("none", |m| m.balance),
    };
    let closest = closest(&data, &trace, &before);
    let candidates = trace.tried.iter().map(|c| tried(&data, c)).collect();
    let paths = Search::new(&data, &trace.baseline.fit).map(|s| s.paths().to_vec()).unwrap_or_default();
    let diagnosis = Diagnosis {
        verdict: match trace.verdict {
            Verdict::Adequate => "adequate",
            Verdict::Explained => "explained",
            Verdict::Unexplained => "unexplained",
        },
        effects: by_evidence(&trace, after.effects).into_iter().map(|e| CARDS[e].name).collect(),
        indistinguishable: if trace.verdict == Verdict::Explained {
            groups(after.effects, &trace.alike)
        } else {
            Vec::new()
        },
        balance,
        noise_pa: data.noise.sd_pa,
        before,
        after: after_side,
        closest,
        candidates,
        effective_samples: trace.samples,
        missing,
        undetermined: uncertainty::undetermined(&after.fit),
        next_experiments: separate::next(&data, &trace),
        assumptions: assumptions(&data),
    };
    let residuals_closest = diagnosis.closest.as_ref().map(|_| evidence::residuals(&data, &trace.chosen.fit));
    Diagnosed { diagnosis, data, residuals_before, residuals_after, residuals_closest, paths, trace }
}

/// Relative standard deviation that an assumed ambient temperature gives λ0: with pressures alone λ0 ∝ Tamb^1.5.
pub fn lambda_extra(data: &Data) -> f64 {
    if data.ambient_temperature_assumed { 1.5 * ASSUMED_AMBIENT_DEVIATION_K / data.ambient_temperature_k } else { 0.0 }
}

/// Values with intervals of a fit.
pub fn parameters(data: &Data, fit: &Fit, residual_is_noise: bool) -> Estimates {
    let covariance = uncertainty::covariance(fit, residual_is_noise);
    let mut out = uncertainty::estimates(fit, &covariance, lambda_extra(data));
    if data.dead_volume_known {
        let value = data.dead_volume_m3;
        out.insert(1, ("dead_volume_m3".to_owned(), Estimate { value, ci95: [value; 2], unit: "m3".to_owned() }));
    }
    out
}

fn side(data: &Data, c: &Candidate, residuals: &[Vec<f64>], is_noise: bool) -> Side {
    let rmse_pa = Rmse { fit: evidence::rms(residuals), held_out: c.held_out_pa };
    Side { rmse_pa, parameters: parameters(data, &c.fit, is_noise) }
}

fn tried(data: &Data, c: &Candidate) -> Tried {
    Tried {
        effect: names(c.effects).join(" + "),
        delta_bic: c.delta_bic,
        held_out_rmse_pa: c.held_out_pa,
        parameters: parameters(data, &c.fit, c.fit.chi2 < 1.2 * c.fit.blocks as f64),
    }
}

/// The effects of a set, the one with the most evidence by itself first.
fn by_evidence(trace: &Trace, set: EffectSet) -> Vec<usize> {
    let alone =
        |e: usize| trace.tried.iter().find(|c| c.effects == EffectSet::one(e)).map_or(f64::MIN, |c| c.delta_bic);
    let mut effects: Vec<usize> = set.iter().collect();
    effects.sort_by(|a, b| alone(*b).total_cmp(&alone(*a)));
    effects
}

fn strongest_balance(trace: &Trace, set: EffectSet) -> &'static str {
    by_evidence(trace, set).first().map_or("none", |e| CARDS[*e].balance.name())
}

/// For each effect of the chosen set, those that could stand in its place; sets that differ in more are written whole.
fn groups(chosen: EffectSet, alike: &[EffectSet]) -> Vec<Vec<String>> {
    let mut out: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for other in alike {
        let gone: Vec<usize> = chosen.iter().filter(|e| !other.has(*e)).collect();
        let new: Vec<usize> = other.iter().filter(|e| !chosen.has(*e)).collect();
        if let ([gone], [new]) = (gone.as_slice(), new.as_slice()) {
            out.entry(CARDS[*gone].name.to_owned()).or_default().push(CARDS[*new].name.to_owned());
        } else {
            out.entry(names(chosen).join(" + ")).or_default().push(names(*other).join(" + "));
        }
    }
    out.into_iter().map(|(first, rest)| [vec![first], rest].concat()).collect()
}

fn unnamed(data: &Data, trace: &Trace) -> Vec<Unnamed> {
    let beyond = (trace.baseline.fit.chi2 - trace.baseline.fit.blocks as f64).max(1.0);
    let mut best: Vec<&Missing> = trace.baseline_adequacy.families.iter().collect();
    let n = trace.samples;
    // What takes away most for its number of coefficients comes first.
    let squares = evidence::squares(data, &trace.baseline.fit);
    let worth = |m: &Missing| -n * ((squares - m.gain).max(1.0) / squares).ln() - m.rank as f64 * n.ln();
    best.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    best.iter()
        .take(6)
        .map(|m| Unnamed {
            balance: m.form.balance().name(),
            quantity: m.form.name().0,
            unit: m.form.name().1,
            variable: m.variable.name().0,
            variable_unit: m.variable.name().1,
            at: m.at.clone(),
            value: m.value.clone(),
            sd: m.sd.clone(),
            share: (m.gain / beyond).min(1.0),
        })
        .collect()
}

/// What was assumed where the rig says nothing.
pub fn assumptions(data: &Data) -> Vec<String> {
    let mut out = Vec::new();
    if data.ambient_temperature_assumed {
        out.push(format!(
            "ambient temperature is not stated: {:.2} K assumed, ± {:.0} K; pressures alone do not determine it (lambda0 follows it to the power 1.5, its interval includes that)",
            data.ambient_temperature_k, ASSUMED_AMBIENT_DEVIATION_K
        ));
    }
    if let Some(stated) = data.noise.stated_pa.filter(|s| (s / data.noise.sd_pa - 1.0).abs() > 0.2) {
        out.push(format!("the rig states a noise of {stated:.1} Pa, the quiet parts show {:.1} Pa", data.noise.sd_pa));
    }
    if data.noise.correlation_rows > 1.5 {
        out.push(format!(
            "neighbouring readings are not independent: {:.1} rows count as one",
            data.noise.correlation_rows
        ));
    }
    for t in data.traces.iter().filter(|t| !t.starts_at_rest) {
        out.push(format!("{} starts in motion: its initial temperature is fitted", t.path.display()));
    }
    out
}

/// Serializes named numbers as one object.
pub(crate) fn as_map<S: serde::Serializer>(numbers: &Estimates, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(numbers.iter().map(|(k, v)| (k, v)))
}
