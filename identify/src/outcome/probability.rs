//! Probability of each effect: posterior odds over all sets of terms that were tried.
//!
//! P(set) ∝ p^terms e^(−BIC/(2 T)); that of an effect is the sum over the sets that contain it. Each term has the prior
//! probability p, about one over the number of terms, so that one which adds nothing to a set gains nothing by being tried. T = 1
//! would be the textbook value (Raftery, 1995); `TEMPER` is larger, as the noise is itself a model. In BIC the gas is known only
//! within its tolerance. Sets with a curve are left out.
//!
//! Where the chosen set explains the records, none counts as likelier than it: what speaks against the others, such as their
//! error on left-out records or an impossible parameter value, is not part of their BIC.

use crate::search::{Candidate, Found, Verdict};
use chamber::effects::{CARDS, COUNT};

/// Factor by which log-odds are reduced from the textbook's.
const TEMPER: f64 = 1.5;
/// Prior probability of a term.
const PRIOR: f64 = 0.05;
/// Smaller probabilities are not reported.
const WORTH_MENTION: f64 = 0.01;

/// Odds of two sets, with a BIC smaller by `gain` for the former.
pub fn odds(gain: f64) -> f64 {
    (gain / (2.0 * TEMPER)).exp()
}

/// Meaning of the probabilities with a verdict: they are those of the cause only where a set of effects is needed and leaves no
/// more than noise. Beside a model that is adequate without any, they are hints. Otherwise they compare sets none of which is
/// adequate, and the best of them may have 100 %.
pub fn meaning(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Adequate => {
            "hints of effects, none of which is needed (without them the residual is noise, or below the accuracy)"
        }
        Verdict::Explained => "probable effects",
        Verdict::Improved | Verdict::Unexplained => "best of the effects tried, none of which explains the records",
    }
}

/// Probability of each effect of the rig, the most probable first. For a named one, sets with per-record parameters of it count
/// too: they contain it, and only say that records differ.
pub fn of_effects(found: &Found) -> Vec<(String, f64)> {
    // A curve is a description, not a named hypothesis.
    let has_name = |c: &&Candidate| c.model.effects.iter().all(|e| CARDS[e].is_candidate());
    let sets = found.tried.iter().chain([&found.baseline, &found.chosen]).filter(has_name);
    let most = if found.verdict == Verdict::Explained { found.chosen.delta_bic } else { f64::MAX };
    let gain = |c: &Candidate| c.delta_bic.min(most);
    let best = sets.clone().map(gain).fold(f64::MIN, f64::max);
    let (mut sum, mut each) = (0.0, [0.0; COUNT]);
    let named = found.chosen.model.of_rig();
    let mut seen = Vec::new();
    for c in sets {
        if seen.contains(&c.model) {
            continue;
        }
        seen.push(c.model);
        let weight = odds(gain(c) - best) * PRIOR.powi(c.model.terms() as i32);
        sum += weight;
        let held = c.model.of_rig().union(c.model.effects.intersection(named));
        held.iter().for_each(|e| each[e] += weight);
    }
    let mut out: Vec<(String, f64)> =
        (0..COUNT).map(|e| (CARDS[e].name.to_owned(), each[e] / sum)).filter(|(_, p)| *p >= WORTH_MENTION).collect();
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Model;
    use crate::record::data::Data;
    use crate::search;
    use crate::synthetic::Recipe;
    use chamber::effects::WallHeating;

    #[test]
    fn the_explaining_set_is_as_probable_as_a_refused_set_with_more_evidence() {
        let recipe = Recipe::from_seed(5).with("leakage", &[2e-11]);
        let (_, mut found) = search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap();
        assert_eq!(found.verdict, Verdict::Explained);
        let mut refused = found.chosen.clone();
        (refused.model, refused.delta_bic) = (Model::with(WallHeating::SET), refused.delta_bic + 100.0);
        found.tried.insert(0, refused);
        let probability = |found: &Found, name: &str| of_effects(found).into_iter().find(|(n, _)| n == name).unwrap().1;
        let [leak, wall] = ["leakage", "wall_heating"].map(|name| probability(&found, name));
        assert!((leak / wall - 1.0).abs() < 0.1 && leak > 0.4, "{leak} {wall}");
        found.verdict = Verdict::Improved;
        assert!(probability(&found, "wall_heating") > 0.99);
    }

    #[test]
    fn effects_are_called_probable_only_where_they_leave_no_more_than_noise() {
        let probable = |verdict: Verdict| meaning(verdict).contains("probable");
        assert!(probable(Verdict::Explained) && !probable(Verdict::Improved) && !probable(Verdict::Unexplained));
        // An effect that the paper's model does without is a hint, however large its odds.
        assert!(!probable(Verdict::Adequate) && meaning(Verdict::Adequate).contains("none of which is needed"));
    }
}
