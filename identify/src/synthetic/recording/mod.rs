//! Recordings as real benches make them: what happens to a rig's ideal readings, and the answer expected of a diagnosis.
//!
//! [`ALL`] lists them. [`Recording::apply`] makes a [`Recipe`] record in this way; [`Recording::judge`] says whether an answer is
//! the one expected for it.

pub mod disturbance;
pub mod faults;
mod list;

pub use disturbance::Disturbance;
pub use faults::{Faults, Filled, Scattered, Stated, Wave, at_rows, own_times, slow_readout};
pub use list::ALL;

use super::{Random, Recipe};

/// The answer expected of a diagnosis for a recording of a rig without any effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// `adequate`, without any named effect.
    Adequate,
    /// One of these names, which describe what was done.
    Named(&'static [&'static str]),
    /// `adequate`, or these names: what was done may lie within the noise.
    AdequateOr(&'static [&'static str]),
    /// Anything but `explained` by an effect: the rig file is wrong beyond its tolerance.
    NotExplained,
    /// An error that says what is wrong with the data.
    Refused,
}

/// How an answer compares with the expected one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As expected.
    Right,
    /// Right within a group that the answer calls indistinguishable.
    Alike,
    /// It names something that is not there.
    WrongName,
    /// Nothing it says is wrong, but it is not the expected answer either.
    Missed,
    /// An error where there should be an answer.
    Refused,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Right, Self::Alike, Self::WrongName, Self::Missed, Self::Refused];
}

/// The parts of an answer that are judged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Verdict of the diagnosis; `refused` if there is none.
    pub verdict: String,
    /// Names of the effects.
    pub effects: Vec<String>,
    /// Indistinguishable groups, each with the chosen names first; names of a set are joined by " + ".
    pub indistinguishable: Vec<Vec<String>>,
}

/// A kind of recording.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    /// Its name, for `--only`.
    pub name: &'static str,
    /// What is done.
    pub what: &'static str,
    /// The answer expected for a rig without any effect.
    pub expected: Expected,
    /// Whether λ0 can be right: not if the rig file is wrong beyond its tolerance.
    pub judges_lambda0: bool,
    /// Effects that are invisible beside what is done, or amount to the same.
    pub hides: &'static [&'static str],
    changes: fn(&mut Recipe, &mut Random),
}

impl Recording {
    /// The recipe, recorded in this way.
    pub fn apply(&self, mut recipe: Recipe) -> Recipe {
        let random = &mut Random::new(recipe.seed ^ 0x7ec0_4d17);
        // A 16 bit converter over 10 bar and a good position sensor, unless changed below.
        recipe.quantisation_pa = 1e6 / 65536.0;
        recipe.noise_pa = random.log_uniform(60.0, 300.0);
        recipe.position_noise_m = recipe.position_noise_m.min(5e-6);
        recipe.position_step_m = recipe.position_step_m.min(1e-6);
        (self.changes)(&mut recipe, random);
        recipe
    }

    /// Compares an answer (`None`: refused) for a rig with this effect (`None`: without any).
    pub fn judge(&self, effect: Option<&str>, answer: Option<&Answer>) -> Outcome {
        let Some(answer) = answer else {
            return if self.expected == Expected::Refused { Outcome::Right } else { Outcome::Refused };
        };
        let names: Vec<&str> = answer.effects.iter().map(String::as_str).collect();
        let outcome = self.judge_names(effect, &answer.verdict, &names);
        if matches!(outcome, Outcome::WrongName | Outcome::Missed) {
            let others = answer.indistinguishable.iter().filter_map(|group| group.split_first());
            let exchanged = others.flat_map(|(chosen, rest)| {
                let kept = names.iter().copied().filter(|n| !chosen.split(" + ").any(|c| c == *n));
                let kept: Vec<&str> = kept.collect();
                rest.iter().map(move |other| [kept.clone(), other.split(" + ").collect()].concat())
            });
            if exchanged.into_iter().any(|set| self.judge_names(effect, &answer.verdict, &set) == Outcome::Right) {
                return Outcome::Alike;
            }
        }
        outcome
    }

    fn judge_names(&self, effect: Option<&str>, verdict: &str, names: &[&str]) -> Outcome {
        let done = match self.expected {
            Expected::Named(done) | Expected::AdequateOr(done) => done,
            _ => &[],
        };
        let is_wrong = |n: &&str| Some(*n) != effect && !done.contains(n) && *n != "empirical";
        let wrong = names.iter().any(is_wrong);
        let found = effect.is_none_or(|e| names.contains(&e));
        let right = match (self.expected, effect) {
            (Expected::Refused, _) => false,
            // Where the model may describe an error within its tolerance, `improved` claims no more than it knows.
            (Expected::NotExplained, None) => !(wrong && verdict == "explained"),
            (Expected::NotExplained, Some(_)) => found,
            (Expected::Adequate, None) => verdict == "adequate",
            (Expected::AdequateOr(_), None) => verdict == "adequate" || !names.is_empty(),
            (Expected::Adequate | Expected::AdequateOr(_), Some(_)) => found && !names.contains(&"empirical"),
            (Expected::Named(done), _) => found && names.iter().any(|n| done.contains(n)),
        };
        match (wrong, right) {
            (true, _) if (self.expected, effect) != (Expected::NotExplained, None) => Outcome::WrongName,
            (true, false) => Outcome::WrongName,
            (_, true) => Outcome::Right,
            (_, false) => Outcome::Missed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use records::extremes;

    fn recording(name: &str) -> &'static Recording {
        ALL.iter().find(|r| r.name == name).unwrap()
    }

    fn answer(verdict: &str, effects: &[&str], alike: &[&[&str]]) -> Answer {
        Answer {
            verdict: verdict.to_owned(),
            effects: effects.iter().map(|e| (*e).to_owned()).collect(),
            indistinguishable: alike.iter().map(|g| g.iter().map(|e| (*e).to_owned()).collect()).collect(),
        }
    }

    #[test]
    fn every_recording_has_a_name_of_its_own() {
        let names: std::collections::BTreeSet<&str> = ALL.iter().map(|r| r.name).collect();
        assert_eq!(names.len(), ALL.len());
    }

    #[test]
    fn the_dead_volume_counts_from_the_recorded_zero_whatever_bends_and_shifts_the_positions() {
        let mut recipe = Recipe::from_seed(7);
        (recipe.position_noise_m, recipe.position_step_m) = (0.0, 1e-15);
        let ends = |recipe: &Recipe| {
            let rig = recipe.rig();
            let traces = rig.experiments.iter().flat_map(|e| &e.traces);
            extremes(&traces.flat_map(|t| t.position_m.iter().copied()).collect::<Vec<_>>())
        };
        let (low, high) = ends(&recipe);
        let mut bent = recipe.clone();
        bent.faults.position_wave = Some(Wave { amplitude: 5e-4, angles: [0.4, 1.9] });
        bent.faults.stated = Stated { position_times: 1.004, position_offset_m: 3e-4, ..Stated::default() };
        let (recorded_low, recorded_high) = ends(&bent);
        let per_recorded = (high - low) / (recorded_high - recorded_low);
        let volume = |recipe: &Recipe, x: f64| {
            let geometry = recipe.chamber_as_recorded().geometry;
            geometry.dead_volume + geometry.piston_area * x
        };
        let (found, expected) = (volume(&bent, recorded_low * per_recorded), volume(&recipe, low));
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn only_the_name_of_what_is_there_is_right() {
        let white = recording("white");
        assert_eq!(white.judge(None, Some(&answer("adequate", &[], &[]))), Outcome::Right);
        assert_eq!(white.judge(None, Some(&answer("unexplained", &[], &[]))), Outcome::Missed);
        assert_eq!(white.judge(None, Some(&answer("improved", &["empirical"], &[]))), Outcome::Missed);
        assert_eq!(white.judge(None, None), Outcome::Refused);
        let leak = Some("leakage");
        assert_eq!(white.judge(leak, Some(&answer("explained", &["leakage"], &[]))), Outcome::Right);
        assert_eq!(white.judge(leak, Some(&answer("adequate", &[], &[]))), Outcome::Missed);
        assert_eq!(white.judge(leak, Some(&answer("explained", &["leakage", "tube_volume"], &[]))), Outcome::WrongName);
        let drift = answer("explained", &["sensor_drift"], &[&["sensor_drift", "leakage"]]);
        assert_eq!(white.judge(leak, Some(&drift)), Outcome::Alike);
    }

    #[test]
    fn a_wrong_bore_may_be_described_but_not_explained() {
        let bore = recording("bore-41-for-40");
        assert_eq!(bore.judge(None, Some(&answer("unexplained", &[], &[]))), Outcome::Right);
        assert_eq!(bore.judge(None, Some(&answer("improved", &["gas_column_length"], &[]))), Outcome::Right);
        assert_eq!(bore.judge(None, Some(&answer("explained", &["gas_column_length"], &[]))), Outcome::WrongName);
    }

    #[test]
    fn a_wrong_unit_must_be_refused() {
        let bar = recording("bar-as-pa");
        assert_eq!(bar.judge(None, None), Outcome::Right);
        assert_eq!(bar.judge(None, Some(&answer("adequate", &[], &[]))), Outcome::Missed);
    }

    #[test]
    fn every_recording_follows_from_the_seed_and_differs_from_the_plain_one() {
        let base = Recipe { repeats: 1, ..Recipe::from_seed(3) };
        let plain = recording("white").apply(base.clone()).rig();
        for r in ALL {
            let rig = r.apply(base.clone()).rig();
            assert!(rig == r.apply(base.clone()).rig(), "{}: the same seed, another rig", r.name);
            assert!(rig != plain || r.name == "white", "{}: nothing is done", r.name);
        }
    }
}
