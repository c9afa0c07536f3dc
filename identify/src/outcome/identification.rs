//! `identify`: heat transfer coefficient, dead volume and mass of a rig by the paper's model, with intervals.
//!
//! Two methods: `exact`, the fit of all traces at once through moves and holds; `time-constant`, the paper's seven steps on each
//! trace alone, with averaged results.

use crate::error::Error;
use crate::fit::covariance::{Estimate, Undetermined, undetermined};
use crate::judge::{left_out, misfit, sanity};
use crate::outcome::estimates::{Estimates, Rmse, as_map, parameters, uncertainty};
use crate::outcome::recording::{notes, positions_too_far};
use crate::outcome::rigs;
use crate::parameters::{Hypothesis, Model, Sizes, first_chamber};
use crate::record::data::{Data, Prepared};
use crate::record::papers_steps;
use crate::search;
use chamber::{Chamber, HeatTransfer};
use paper::time_constant::TimeConstant;
use records::Rig;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Method of identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// All traces at once, through moves and holds.
    Exact,
    /// The paper's seven steps on each trace.
    TimeConstant,
}

impl Method {
    /// Both methods.
    pub const ALL: [Method; 2] = [Method::Exact, Method::TimeConstant];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Exact => "exact",
            Method::TimeConstant => "time-constant",
        }
    }
}

/// One kind of test, with means over its repeats.
#[derive(Clone, Debug, Serialize)]
pub struct ExperimentResult {
    /// Name of the experiment in the rig file.
    pub name: String,
    /// Pf of P = Pf + ΔP e^(−t/τ), Pa; absent where a trace is not a push and a hold.
    pub final_pressure_pa: Option<f64>,
    /// ΔP, Pa.
    pub pressure_rise_pa: Option<f64>,
    /// τ, s.
    pub time_constant_s: Option<f64>,
    /// Mass of the gas, kg.
    pub mass_kg: Option<f64>,
    /// λ0 by the seven steps, W/(m² K).
    pub steps_lambda0_w_per_m2_k: Option<f64>,
    /// Why the paper's steps fail, in a sentence.
    pub steps_refused: Option<String>,
}

/// The result of `identify`.
#[derive(Clone, Debug, Serialize)]
pub struct Identification {
    /// `exact` or `time-constant`.
    pub method: &'static str,
    /// The identified parameters.
    #[serde(serialize_with = "as_map")]
    pub parameters: Estimates,
    /// Errors against what the sensor recorded.
    pub rmse_pa: Rmse,
    /// Noise of the pressure readings, Pa.
    pub noise_pa: f64,
    /// Whether the remainder is no more than noise, or below the requested accuracy; never for the published steps.
    pub residual_is_noise: bool,
    /// Each kind of test.
    pub experiments: Vec<ExperimentResult>,
    /// Parameters, or combinations of them, that the data hardly determines.
    pub undetermined: Vec<Undetermined>,
    /// What was assumed.
    pub assumptions: Vec<String>,
    /// The identified chamber, as the model file holds it.
    #[serde(skip)]
    pub chamber: Chamber,
    /// Ambient temperature, K.
    #[serde(skip)]
    pub ambient_temperature_k: f64,
    /// Intervals and covariance, if the method provides them.
    #[serde(skip)]
    pub uncertainty: Option<records::Uncertainty>,
}

/// Identifies a rig.
///
/// # Errors
/// [`Error`]: implausible data, or no trace that the method can evaluate.
pub fn identify(rig: &Rig, method: Method) -> Result<Identification, Error> {
    let data = Data::prepare(rig)?;
    match method {
        Method::Exact => exact(data),
        Method::TimeConstant => {
            // Outliers and noise are those of the exact fit, if it succeeds.
            let data = search::paper(data.clone()).map_or(data, |(data, ..)| data);
            published(&data)
        }
    }
}

/// The paper's steps for each trace, with its experiment.
fn steps(data: &Data) -> Vec<(usize, Result<TimeConstant, paper::Error>)> {
    data.traces.iter().map(|t| (t.experiment, papers_steps::of(data, t))).collect()
}

type Steps = [(usize, Result<TimeConstant, paper::Error>)];

fn exact(data: Data) -> Result<Identification, Error> {
    let (data, fit, adequacy) = search::paper(data)?;
    sanity::coefficient(&data, &fit)?;
    if !adequacy.is_adequate() {
        sanity::reference(&data, &fit)?;
    }
    sanity::dead_volume(&data, &fit)?;
    let chamber = fit.chamber();
    let mut parameters = parameters(&data, &fit, adequacy.is_noise);
    let first_volume = |t: &Prepared| {
        let position = t.course.motion.segments[0].stroke.at(0.0, &Default::default()).0;
        chamber.geometry.volume(position)
    };
    let masses: Vec<f64> = data
        .traces
        .iter()
        .zip(&fit.records)
        .map(|(t, record)| {
            let start = fit.setting(t, record).start;
            start.pressure * first_volume(t) / (chamber.gas.gas_constant * start.temperature)
        })
        .collect();
    // The mass is proportional to the volume in which it was measured: its relative interval is the dead volume's over that
    // volume.
    let mass = masses.iter().sum::<f64>() / masses.len() as f64;
    let relative = parameters
        .iter()
        .find(|(name, _)| name == "dead_volume_m3")
        .map_or(0.0, |(_, e)| 0.5 * (e.ci95[1] - e.ci95[0]) / first_volume(&data.traces[0]));
    parameters.push(("mass_kg".to_owned(), interval(mass, relative * mass, "kg")));
    let residuals = misfit::residuals(&data, &fit);
    let rms_pa = misfit::rms(&data, &residuals);
    let of_two_rigs = rigs::apart(&data, rms_pa, rigs::Overlap::LevelsAndPositions);
    Ok(Identification {
        method: Method::Exact.name(),
        parameters,
        rmse_pa: Rmse {
            fit: rms_pa,
            held_out: left_out::error(&data, &fit, &left_out::folds(&data)).map(|error| error.rmse_pa),
        },
        noise_pa: data.noise.total_pa(),
        residual_is_noise: adequacy.is_adequate(),
        experiments: experiments(&data, &steps(&data), Some(&masses)),
        undetermined: undetermined(&fit),
        assumptions: notes(&data, None)
            .into_iter()
            .chain(positions_too_far(&fit, adequacy.is_adequate()))
            .chain(of_two_rigs)
            .collect(),
        uncertainty: Some(uncertainty(&fit, adequacy.is_noise)),
        chamber: fit.chamber_of_rig(),
        ambient_temperature_k: data.ambient_temperature_k,
    })
}

fn published(data: &Data) -> Result<Identification, Error> {
    let steps = steps(data);
    let found: Vec<&TimeConstant> = steps.iter().filter_map(|(_, s)| s.as_ref().ok()).collect();
    if found.is_empty() {
        let mut refused = data.traces.iter().zip(&steps).filter_map(|(t, (_, s))| Some((t, s.as_ref().err()?)));
        let first = refused.next().map_or(String::new(), |(t, why)| format!(" ({}: {why})", t.path.display()));
        return Err(Error::NoPushAndHold { first });
    }
    let of = |f: &dyn Fn(&TimeConstant) -> (f64, [f64; 2])| {
        mean_with_interval(&found.iter().map(|s| f(s)).collect::<Vec<_>>())
    };
    let number = |e: &paper::Estimate| (e.value, e.ci95);
    let lambda = of(&|s| number(&s.steps.coefficient_0_w_per_m2_k));
    let dead = of(&|s| number(&s.steps.dead_volume_m3));
    let mut parameters: Estimates = Vec::new();
    let mut add = |name: &str, unit: &str, (value, half): (f64, f64)| {
        parameters.push((name.to_owned(), interval(value, half, unit)));
    };
    add("lambda0_w_per_m2_k", "W/(m2.K)", lambda);
    add("dead_volume_m3", "m3", dead);
    add("mass_kg", "kg", of(&|s| number(&s.steps.mass_kg)));
    add("lambda_av_w_per_m2_k", "W/(m2.K)", of(&|s| number(&s.steps.coefficient_av_w_per_m2_k)));
    add("conductance_av_w_per_k", "W/K", of(&|s| number(&s.steps.conductance_av_w_per_k)));
    let mut chamber = first_chamber(data);
    chamber.geometry.dead_volume = dead.0.max(0.0);
    chamber.heat_transfer = HeatTransfer::at_paper_reference(lambda.0);
    // Prediction with the method's values, through moves and holds.
    let residuals = predicted(data, &chamber)?;
    Ok(Identification {
        method: Method::TimeConstant.name(),
        parameters,
        rmse_pa: Rmse { fit: misfit::rms(data, &residuals), held_out: None },
        noise_pa: data.noise.total_pa(),
        residual_is_noise: false,
        experiments: experiments(data, &steps, None),
        undetermined: Vec::new(),
        assumptions: notes(data, None),
        uncertainty: None,
        chamber,
        ambient_temperature_k: data.ambient_temperature_k,
    })
}

/// Row residuals of a chamber that was not fitted to the records, from each record's first pressure.
fn predicted(data: &Data, chamber: &Chamber) -> Result<Vec<Vec<f64>>, Error> {
    let h = Hypothesis::new(data, Model::PAPER, chamber, &Sizes::of(data, chamber));
    let rig = h.coordinates(chamber);
    data.traces
        .iter()
        .map(|t| {
            let setting = h.setting(t, &rig, &[], &h.record_guess(t));
            misfit::of_record(t, &setting, h.model.effects)
                .map_err(|source| Error::Simulation { trace: t.path.clone(), source })
        })
        .collect()
}

fn experiments(data: &Data, steps: &Steps, masses: Option<&[f64]>) -> Vec<ExperimentResult> {
    data.experiments
        .iter()
        .enumerate()
        .map(|(e, name)| {
            let of_test: Vec<&TimeConstant> =
                steps.iter().filter(|(k, _)| *k == e).filter_map(|(_, s)| s.as_ref().ok()).collect();
            let mut of_experiment = steps.iter().filter(|(k, _)| *k == e);
            let refused = of_experiment.find_map(|(_, s)| s.as_ref().err()).map(ToString::to_string);
            let mean = |f: &dyn Fn(&TimeConstant) -> f64| {
                (!of_test.is_empty()).then(|| of_test.iter().map(|s| f(s)).sum::<f64>() / of_test.len() as f64)
            };
            let fitted: Option<Vec<f64>> = masses
                .map(|m| m.iter().zip(&data.traces).filter(|(_, t)| t.experiment == e).map(|(m, _)| *m).collect());
            ExperimentResult {
                name: name.clone(),
                final_pressure_pa: mean(&|s| s.regression.final_pressure_pa.value),
                pressure_rise_pa: mean(&|s| s.regression.pressure_rise_pa.value),
                time_constant_s: mean(&|s| s.regression.time_constant_s.value),
                mass_kg: fitted
                    .filter(|m| !m.is_empty())
                    .map(|m| m.iter().sum::<f64>() / m.len() as f64)
                    .or_else(|| mean(&|s| s.steps.mass_kg.value)),
                steps_lambda0_w_per_m2_k: mean(&|s| s.steps.coefficient_0_w_per_m2_k.value),
                steps_refused: refused.filter(|_| of_test.is_empty()),
            }
        })
        .collect()
}

/// Mean of several estimates and half its 95 % interval: from their scatter, or that of a single one.
fn mean_with_interval(estimates: &[(f64, [f64; 2])]) -> (f64, f64) {
    let n = estimates.len() as f64;
    let mean = estimates.iter().map(|e| e.0).sum::<f64>() / n;
    if estimates.len() < 2 {
        return (mean, 0.5 * (estimates[0].1[1] - estimates[0].1[0]));
    }
    let variance = estimates.iter().map(|e| (e.0 - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let quantile = StudentsT::new(0.0, 1.0, n - 1.0).map_or(2.0, |t| t.inverse_cdf(0.975));
    (mean, quantile * (variance / n).sqrt())
}

fn interval(value: f64, half: f64, unit: &str) -> Estimate {
    Estimate { value, ci95: [value - half, value + half], unit: unit.to_owned() }
}
