//! The grid: the rigs, and the result of each diagnosis.

use crate::options::{Effects, Options};
use chamber::card::Prior;
use chamber::effects::CARDS;
use identify::synthetic::recording::{ALL, Answer, Outcome, Recording, Stated, Wave};
use identify::synthetic::{Random, Recipe, simulated, visibility};
use serde::Serialize;
use serde_json::Value;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

/// An effect is plain if it leaves at least this multiple of the noise beyond what the paper's parameters take up …
const PLAIN: f64 = 2.0;
/// … at one of these strengths; for a property of the gas that the rig file names only the first is tried.
const STRENGTHS: [f64; 3] = [1.0, 2.0, 4.0];
/// Maximum number of rigs in a row of the table.
const MOST_RIGS: u64 = 1000;

/// One diagnosis to be made.
pub struct Job {
    recording: &'static Recording,
    rig: u64,
    kind: &'static str,
    base: Recipe,
    effect: Option<usize>,
    tolerances: bool,
}

/// Result of a diagnosis.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Name of the recording.
    pub recording: &'static str,
    /// Number of the rig within its row.
    pub rig: u64,
    /// `bench` or `wide`.
    pub kind: &'static str,
    /// The rig's effect.
    pub effect: Option<&'static str>,
    /// That effect's strength, relative to what a worn bench shows.
    pub strength: Option<f64>,
    /// What it leaves beyond the paper's parameters, Pa, to first order.
    pub effect_pa: Option<f64>,
    /// Sum of all disturbances of a reading, rms, Pa.
    pub noise_pa: f64,
    /// The verdict; `refused` after an error, `panic` after a panic.
    pub verdict: String,
    /// The error message.
    pub error: Option<String>,
    /// The effects named.
    pub effects: Vec<String>,
    /// Groups of effects that cannot be told apart.
    pub indistinguishable: Vec<Vec<String>>,
    /// `Right`, `Alike`, `WrongName`, `Missed` or `Refused`.
    pub outcome: String,
    /// λ0 of the resulting model, W/(m² K), with its 95 % interval.
    pub lambda0: Option<(f64, [f64; 2])>,
    /// The true λ0.
    pub true_lambda0: f64,
    /// Whether the interval contains the truth, where the model is the true one or cannot be told from it, and λ0 can be right.
    pub lambda0_inside: Option<bool>,
    /// Systematic misfit of the reported model, Pa.
    pub remaining_pa: Option<f64>,
    /// Probability under noise of the best family of missing terms in the remainder of that model.
    pub remaining_probability: Option<f64>,
    /// Duration of the diagnosis, s.
    pub seconds: f64,
}

/// All jobs of the options.
pub fn jobs(options: &Options) -> Vec<Job> {
    let simulated = simulated();
    let chosen = |r: &&Recording| options.only.is_empty() || options.only.iter().any(|name| name == r.name);
    let mut jobs = Vec::new();
    for (number, recording) in ALL.iter().enumerate().filter(|(_, r)| chosen(r)) {
        for rig in options.first..options.first + options.rigs {
            // So that no two rows share a rig, or what its file states.
            let seed = number as u64 * MOST_RIGS + rig;
            let (kind, base) =
                if rig.is_multiple_of(3) { ("wide", Recipe::wide(seed)) } else { ("bench", Recipe::from_seed(seed)) };
            let visible = |e: &&usize| !recording.hides.contains(&CARDS[**e].name);
            let effects: Vec<usize> = simulated.iter().filter(visible).copied().collect();
            let turn = (number * 5 + rig as usize) % effects.len();
            let with: Vec<Option<usize>> = match options.effects {
                Effects::None => vec![None],
                Effects::One => vec![None, Some(effects[turn])],
                Effects::All => std::iter::once(None).chain(effects.into_iter().map(Some)).collect(),
            };
            for effect in with {
                let (base, tolerances) = (base.clone(), options.tolerances);
                jobs.push(Job { recording, rig, kind, base, effect, tolerances });
            }
        }
    }
    jobs
}

impl Job {
    /// The recipe, with an effect strong enough to be plain; the effect's strength, and what it leaves, Pa.
    fn recipe(&self) -> (Recipe, Option<(f64, f64)>) {
        let mut recipe = self.recording.apply(self.base.clone());
        if self.tolerances && recipe.faults.stated == Stated::default() {
            recipe.faults.stated = Stated::drawn(&mut Random::new(recipe.seed ^ 0x701e_4a5ce));
        }
        if self.tolerances && recipe.faults.position_wave.is_none() {
            recipe.faults.position_wave = Some(Wave::drawn(&mut Random::new(recipe.seed ^ 0xbe7)));
        }
        let Some(e) = self.effect else { return (recipe, None) };
        let mut at = (0.0, 0.0);
        let mut with = recipe.clone();
        let is_of_the_gas = CARDS[e].parameters.iter().any(|p| matches!(p.prior, Prior::OfGas(_)));
        for &strength in if is_of_the_gas { &STRENGTHS[..1] } else { &STRENGTHS[..] } {
            with = recipe.clone().with_strength(e, strength);
            at = (strength, visibility::beyond_paper_pa(&with, &recipe));
            if at.1 >= PLAIN * recipe.noise_rms_pa() {
                break;
            }
        }
        (with, Some(at))
    }

    /// Makes the recording and diagnoses it.
    pub fn run(&self) -> Row {
        let (recipe, plain) = self.recipe();
        let rig = recipe.rig();
        let begun = Instant::now();
        let answer = catch_unwind(AssertUnwindSafe(|| identify::diagnose(&rig, &|_, _| ())));
        let seconds = begun.elapsed().as_secs_f64();
        let (json, left, error) = match answer {
            Ok(Ok(found)) => {
                let json = serde_json::to_value(&found.diagnosis).unwrap_or_default();
                (json, Some(found.found.adequacy().clone()), None)
            }
            Ok(Err(error)) => (Value::Null, None, Some(error.to_string())),
            Err(_) => (Value::Null, None, Some("panic".to_owned())),
        };
        let said = answer_of(&json);
        let effect = self.effect.map(|e| CARDS[e].name);
        let panicked = error.as_deref() == Some("panic");
        let outcome = if panicked { Outcome::Refused } else { self.recording.judge(effect, said.as_ref()) };
        let lambda0 = lambda0_of(&json);
        let true_lambda0 = recipe.chamber.heat_transfer.coefficient;
        let is_judged = self.recording.judges_lambda0 && matches!(outcome, Outcome::Right | Outcome::Alike);
        let verdict = match &said {
            Some(said) => said.verdict.clone(),
            None => if panicked { "panic" } else { "refused" }.to_owned(),
        };
        let (effects, indistinguishable) = said.map_or_else(Default::default, |a| (a.effects, a.indistinguishable));
        Row {
            recording: self.recording.name,
            rig: self.rig,
            kind: self.kind,
            effect,
            strength: plain.map(|p| p.0),
            effect_pa: plain.map(|p| p.1),
            noise_pa: recipe.noise_rms_pa(),
            verdict,
            error,
            effects,
            indistinguishable,
            outcome: format!("{outcome:?}"),
            lambda0_inside: lambda0.filter(|_| is_judged).map(|(_, [low, high])| (low..=high).contains(&true_lambda0)),
            lambda0,
            true_lambda0,
            remaining_pa: left.as_ref().map(|left| left.systematic_pa),
            remaining_probability: left.as_ref().map(|left| left.family_probability),
            seconds,
        }
    }
}

impl Row {
    /// Whether the effect is well above the noise; true for a rig without an effect.
    pub fn is_plain(&self) -> bool {
        self.effect_pa.is_none_or(|pa| pa >= PLAIN * self.noise_pa)
    }

    /// The row as one line of text.
    pub fn line(&self) -> String {
        let lambda0 = self.lambda0.map_or_else(String::new, |(value, [low, high])| {
            let percent = |x: f64| 100.0 * (x / self.true_lambda0 - 1.0);
            format!("λ0 {:+.2} % [{:+.2}, {:+.2}]", percent(value), percent(low), percent(high))
        });
        let strength = match (self.strength, self.effect_pa) {
            (Some(s), Some(pa)) => format!(" ×{s} = {:.1} noise", pa / self.noise_pa),
            _ => String::new(),
        };
        format!(
            "{} {} {} {}{strength}: {} {} {} {lambda0} {:.1} s {}",
            self.recording,
            self.kind,
            self.rig,
            self.effect.unwrap_or("none"),
            self.outcome,
            self.verdict,
            self.effects.join("+"),
            self.seconds,
            self.error.as_deref().unwrap_or("")
        )
    }
}

/// The answer in the contract's JSON; `None` without one.
fn answer_of(json: &Value) -> Option<Answer> {
    let texts = |v: &Value| -> Vec<String> {
        v.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect()
    };
    Some(Answer {
        verdict: json.get("verdict")?.as_str()?.to_owned(),
        effects: texts(&json["effects"]),
        indistinguishable: json["indistinguishable"].as_array().into_iter().flatten().map(texts).collect(),
    })
}

fn lambda0_of(json: &Value) -> Option<(f64, [f64; 2])> {
    let lambda0 = json.pointer("/after/parameters/lambda0_w_per_m2_k")?;
    let interval = lambda0.get("ci95")?;
    Some((lambda0.get("value")?.as_f64()?, [interval.get(0)?.as_f64()?, interval.get(1)?.as_f64()?]))
}
