//! Intervals of parameters that several sets of effects have, where the data cannot tell the sets apart, or where a further
//! effect is evident but removes too little misfit to be named.
//!
//! A chosen set that leaves more than noise lacks something, and what it lacks shows in many blocks alike: they tell as much as fewer
//! independent ones ([`covariance::design_effect`]). With the evidence of so few, all credible sets of the search that determine λ0
//! count as rivals: the missing effect may have moved the chosen set's parameters by as much as the sets differ. Source: F. Pauli,
//! W. Racugno and L. Ventura, Stat. Sinica 21 (2011) 149 (likelihood of correlated data, raised to the power 1/c).
//!
//! Such a parameter follows the mixture of the sets' distributions, each weighted by its odds ([`probability::odds`]); its 95 %
//! interval is that of the mixture, and includes that of the chosen set, whose value stays. Source: J. A. Hoeting
//! et al., Stat. Sci. 14 (1999) 382 (Bayesian model averaging).

use crate::fit::covariance::{self, Estimate, NORMAL_95};
use crate::judge::evidence;
use crate::outcome::estimates::{Estimates, parameters};
use crate::outcome::probability;
use crate::record::data::Data;
use crate::search::{Candidate, Found};
use statrs::distribution::{ContinuousCDF, Normal};

/// The chosen set's parameters with their intervals over all sets that can take its place.
pub fn widened(mut numbers: Estimates, data: &Data, found: &Found, leaves_noise: bool) -> Estimates {
    let others = rivals(data, found, leaves_noise);
    for (name, number) in &mut numbers {
        let same = |(weight, of_set): &(f64, Estimates)| {
            of_set.iter().find(|(other, _)| other == name).map(|(_, estimate)| (*weight, estimate.clone()))
        };
        let mixture: Vec<(f64, Estimate)> =
            std::iter::once((1.0, number.clone())).chain(others.iter().filter_map(same)).collect();
        if mixture.len() > 1 {
            let [low, high] = interval(&mixture);
            // Many others together may leave the chosen set little weight, and be narrower.
            number.ci95 = [low.min(number.ci95[0]), high.max(number.ci95[1])];
        }
    }
    numbers
}

/// Parameters of the sets that can take the chosen one's place, with each set's odds against that one: at most one, since a set
/// with more evidence that was not chosen predicts left-out data no better.
fn rivals(data: &Data, found: &Found, leaves_noise: bool) -> Vec<(f64, Estimates)> {
    let chosen = &found.chosen;
    let numbers = |c: &Candidate| parameters(data, &c.fit, leaves_noise);
    if leaves_noise {
        let odds = |c: &Candidate| probability::odds((c.delta_bic - chosen.delta_bic).min(0.0));
        return alike(found).chain(found.evident_beside_chosen()).map(|c| (odds(c), numbers(c))).collect();
    }
    let design_effect = covariance::design_effect(&chosen.fit);
    let bic = |c: &Candidate| evidence::bic_of_correlated(&c.fit, design_effect);
    let odds = |c: &Candidate| probability::odds((bic(chosen) - bic(c)).min(0.0));
    let counts = |c: &Candidate, of_set: &Estimates| found.alike.contains(&c.model) || determine_lambda0(of_set);
    let others = found.credible_sets().filter(|c| c.model != chosen.model).map(|c| (c, numbers(c)));
    others.filter(|(c, of_set)| counts(c, of_set)).map(|(c, of_set)| (odds(c), of_set)).collect()
}

/// Whether λ0, the first of these parameters, is determined. Where it is not, the set says nothing about it, unless the data cannot tell
/// it from the chosen one.
fn determine_lambda0(numbers: &Estimates) -> bool {
    let [low, high] = numbers[0].1.ci95;
    (high / low).ln() < 2.0 * NORMAL_95 * covariance::HARDLY_DETERMINED
}

/// The sets that the data cannot tell from the chosen one.
fn alike(found: &Found) -> impl Iterator<Item = &Candidate> {
    found.alike.iter().filter_map(|model| found.tried.iter().find(|c| c.model == *model && c.fit.converged))
}

/// 95 % interval of a weighted mixture of normal distributions, each with its own width on either side.
fn interval(mixture: &[(f64, Estimate)]) -> [f64; 2] {
    let ends = |i: usize| mixture.iter().map(move |(_, e)| e.ci95[i]);
    let (low, high) = (ends(0).fold(f64::INFINITY, f64::min), ends(1).fold(f64::NEG_INFINITY, f64::max));
    let normal = Normal::standard();
    if !(low.is_finite() && high.is_finite()) {
        return [low, high];
    }
    let all: f64 = mixture.iter().map(|(weight, _)| weight).sum();
    let below = |x: f64| {
        let each = mixture.iter().map(|(weight, e)| {
            let deviation = (if x < e.value { e.value - e.ci95[0] } else { e.ci95[1] - e.value }) / NORMAL_95;
            weight / all * normal.cdf((x - e.value) / deviation.max(f64::MIN_POSITIVE))
        });
        each.sum::<f64>()
    };
    [0.025, 0.975].map(|share| {
        // The interval of a mixture lies within the hull of its components' intervals.
        let (mut from, mut to) = (low, high);
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            *if below(middle) < share { &mut from } else { &mut to } = middle;
        }
        0.5 * (from + to)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::{self, Verdict};
    use crate::synthetic::Recipe;
    use chamber::effects::GasColumnLength;

    #[test]
    fn a_set_that_leaves_more_than_noise_is_as_uncertain_as_its_rivals_lie_apart() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with_strength(GasColumnLength::INDEX, 1.0);
        let (data, mut found) = search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap();
        let of_truth = parameters(&data, &found.chosen.fit, true)[0].1.value;
        let holds_truth = |e: &Estimate| (e.ci95[0]..e.ci95[1]).contains(&of_truth);
        (found.chosen, found.verdict, found.alike) = (found.baseline.clone(), Verdict::Improved, Vec::new());
        let of_set = parameters(&data, &found.chosen.fit, false);
        let of_all = widened(of_set.clone(), &data, &found, false);
        assert!(!holds_truth(&of_set[0].1) && holds_truth(&of_all[0].1), "{:?} {:?} {of_truth}", of_set[0], of_all[0]);
        assert_eq!(of_all[0].1.value, of_set[0].1.value);
    }

    fn estimate(value: f64, half: f64) -> Estimate {
        Estimate { value, ci95: [value - half, value + half], unit: "W/(m2.K)".to_owned() }
    }

    #[test]
    fn one_set_alone_keeps_its_interval() {
        let [low, high] = interval(&[(1.0, estimate(20.0, 0.5))]);
        assert!((low - 19.5).abs() < 1e-6 && (high - 20.5).abs() < 1e-6, "{low} {high}");
    }

    #[test]
    fn two_values_far_apart_are_both_in_the_interval_if_their_odds_are_high_enough() {
        // Each tail holds 2.5 % of the total: 5 % of a set with half of the odds, 3.125 % and 12.5 % of sets with 0.8 and 0.2.
        let [low, high] = interval(&[(1.0, estimate(20.0, NORMAL_95)), (1.0, estimate(30.0, NORMAL_95))]);
        assert!((low - (20.0 - 1.644_854)).abs() < 1e-5 && (high - (30.0 + 1.644_854)).abs() < 1e-5, "{low} {high}");
        let [low, high] = interval(&[(0.8, estimate(20.0, NORMAL_95)), (0.2, estimate(30.0, NORMAL_95))]);
        assert!((low - (20.0 - 1.862_732)).abs() < 1e-5 && (high - (30.0 + 1.150_349)).abs() < 1e-5, "{low} {high}");
    }

    #[test]
    fn a_set_with_next_to_no_odds_changes_nothing() {
        let [low, high] = interval(&[(1.0, estimate(20.0, 0.5)), (1e-9, estimate(30.0, 0.5))]);
        assert!((low - 19.5).abs() < 1e-5 && (high - 20.5).abs() < 1e-5, "{low} {high}");
    }
}
