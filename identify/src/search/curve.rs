//! The missing term as a curve, where no named effect fits: determined from the residual, refitted with everything else, and kept
//! only if it carries over to left-out experiments.
//!
//! The families that a model can hold ([`discrepancy::Families::curves`]) are ranked by their gain to first order, on the paper's
//! model and on the one with the named effects. The best are refitted with their values free beside all else: as accurately as
//! the judgement needs, the accepted one to its minimum. Any curve easily fits what experiments leave in common, so it must
//! predict whole left-out experiments, decisively better than the model without it: [`policy::PREDICTS_BETTER`]. Two or more
//! named effects that together leave only noise are replaced by a curve that alone is decisively more likely: they only imitated
//! it.

use super::entry::is_credible;
use super::{Candidate, Search, terms};
use crate::discrepancy::{self, Missing};
use crate::fit::{Fit, Until};
use crate::judge::evidence::{bic, bic_widened};
use crate::judge::left_out;
use crate::judge::sanity::has_plausible_coefficient;
use crate::parameters::{Model, curve_of};
use crate::policy;
use crate::search::starts::fit_by_size;
use chamber::effects::Empirical;
use chamber::effects::empirical::Curve;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Number of curves refitted, on each model.
const REFITTED: usize = 4;
/// A curve that to first order removes less than this fraction of the squares beyond noise is not refitted: on left-out
/// experiments it would have to remove three quarters. Where the model fails on those, a small gain on the others may be large
/// there.
const LEAST_SHARE: f64 = 0.5;
/// Maximum evidence of a refitted curve over the model it is added to, as a multiple of that to first order.
const FIRST_ORDER: f64 = 5.0;
/// Number of refitted curves judged on left-out experiments, on each model.
const CURVES_JUDGED: usize = 3;
/// Maximum error on left-out experiments without a name, relative to that with it, for the name to be removed.
const NEARLY_AS_WELL: f64 = 1.1;

/// The best curve found.
#[derive(Clone, Debug)]
pub struct CurveFit {
    /// The term, its variable, and its gain to first order.
    pub first_order: Missing,
    /// The model with the curve.
    pub candidate: Candidate,
    /// Error on experiments left out whole, Pa rms: of the model reported otherwise, and with the curve.
    pub left_out_pa: [f64; 2],
    /// Whether it is in the model, and if not, why.
    pub fate: Fate,
}

/// Outcome for a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is in the model: it predicts experiments left out whole decisively better.
    Accepted,
    /// Its evidence on the fitted records is not decisive, or no longer with wider tolerances.
    NotEvident,
    /// It does not predict experiments left out whole decisively better.
    PredictsNoBetter,
    /// As few named effects are more likely.
    LikelierNames,
    /// The fit with it has an implausible heat transfer coefficient.
    ImpossibleCoefficient,
}

impl Fate {
    /// Whether it is in the model.
    pub fn is_accepted(self) -> bool {
        self == Self::Accepted
    }

    /// The reason, as a clause.
    pub fn words(self) -> &'static str {
        match self {
            Self::Accepted => "it predicts left-out data decisively better",
            Self::NotEvident => "the records hardly ask for it once the geometry may move within its tolerances",
            Self::PredictsNoBetter => "it does not predict left-out data decisively better",
            Self::LikelierNames => "named effects are more likely, with no more terms",
            Self::ImpossibleCoefficient => "no gas has the lambda0 that fits beside it",
        }
    }
}

/// A refitted curve.
#[derive(Clone)]
struct JudgedCurve {
    first_order: Missing,
    candidate: Candidate,
    /// Error on experiments left out whole, Pa rms.
    left_out_pa: f64,
    /// Whether its evidence on the fitted records is decisive, also with the geometry far more uncertain.
    is_evident: bool,
}

impl JudgedCurve {
    /// Whether its coefficient is plausible for a gas: a curve can take the place of most of the heat transfer.
    fn is_possible(&self) -> bool {
        has_plausible_coefficient(&self.candidate.fit)
    }
}

fn by_bic(a: &Candidate, b: &Candidate) -> Ordering {
    a.delta_bic.total_cmp(&b.delta_bic)
}

impl CurveFit {
    /// The refitted curve.
    pub fn curve(&self) -> Option<Curve> {
        curve_of(Empirical::INDEX, &self.candidate.fit.chamber())
    }
}

impl Search {
    /// A curve in place of several named effects that together leave only noise: if it alone fits the records decisively better,
    /// the effects only imitate it.
    pub(super) fn curve_instead_of(&self, named: &Candidate) -> Option<CurveFit> {
        let curves = self.curves_on(&self.baseline, named.delta_bic + policy::DECISIVE, 0.0);
        let evident = curves.into_iter().filter(|c| c.is_evident && c.is_possible());
        let best = self.refitted_fully(evident.max_by(|a, b| by_bic(&a.candidate, &b.candidate))?);
        let left_out_pa = self.left_out(named)?;
        best.is_possible().then(|| self.curve_fit(best, left_out_pa, Fate::Accepted))
    }

    /// Looks for a curve beside the model reported otherwise; `None` where none can be fitted.
    pub(super) fn fit_curve(&self, otherwise: &Candidate) -> Option<CurveFit> {
        let mut parts = vec![&self.baseline];
        if self.chosen.model != Model::PAPER {
            parts.push(&self.chosen);
        }
        let (otherwise_pa, paper_pa) = (self.left_out(otherwise)?, self.left_out(&self.baseline)?);
        let fails_on_others = self.data.experiments.len() > 1 && !self.predicts_as_it_fits(otherwise, otherwise_pa);
        let least_share = if fails_on_others { 0.0 } else { LEAST_SHARE };
        let curves_on = |part| self.curves_on(part, otherwise.delta_bic, least_share);
        let mut curves: Vec<JudgedCurve> = parts.into_par_iter().flat_map_iter(curves_on).collect();
        // Whether names are replaced is judged by the error on the usual folds.
        let in_place_of_names = curves.par_iter_mut().filter(|c| c.candidate.model.terms() <= otherwise.model.terms());
        in_place_of_names.for_each(|c| self.hold_out(&mut c.candidate));
        let acceptable = |c: &&JudgedCurve| {
            c.is_evident
                && c.is_possible()
                && if c.candidate.model.terms() > otherwise.model.terms() {
                    self.predicts_better([otherwise_pa, c.left_out_pa])
                } else {
                    // In place of names: decisively better than without either, and better than the names.
                    self.predicts_better([paper_pa, c.left_out_pa])
                        && c.candidate.errs_less(otherwise, self.least_gain())
                }
        };
        let evident = curves.iter().filter(acceptable).map(|c| c.candidate.delta_bic).fold(f64::NEG_INFINITY, f64::max);
        let alike = |c: &&JudgedCurve| c.candidate.delta_bic > evident - policy::DECISIVE;
        let by_terms = |a: &&JudgedCurve, b: &&JudgedCurve| {
            let (a, b) = (&a.candidate, &b.candidate);
            a.model.terms().cmp(&b.model.terms()).then(by_bic(b, a))
        };
        let accepted = curves.iter().filter(acceptable).filter(alike).min_by(by_terms);
        let reported = accepted.or_else(|| curves.iter().min_by(|a, b| a.left_out_pa.total_cmp(&b.left_out_pa)))?;
        let best =
            if accepted.is_some() { self.pruned(self.refitted_fully(reported.clone())) } else { reported.clone() };
        let fate = match accepted {
            _ if !best.is_possible() => Fate::ImpossibleCoefficient,
            Some(_) if self.has_likelier_names(&best.candidate) => Fate::LikelierNames,
            Some(_) => Fate::Accepted,
            None if !best.is_evident => Fate::NotEvident,
            None => Fate::PredictsNoBetter,
        };
        Some(self.curve_fit(best, otherwise_pa, fate))
    }

    /// Whether named effects are more likely than a model with a curve, with no more terms.
    fn has_likelier_names(&self, with_curve: &Candidate) -> bool {
        let mut as_few = self.tried.iter().filter(|c| c.model.terms() <= with_curve.model.terms());
        as_few.any(|c| c.delta_bic > with_curve.delta_bic && is_credible(&c.fit))
    }

    fn curve_fit(&self, curve: JudgedCurve, otherwise_pa: f64, fate: Fate) -> CurveFit {
        CurveFit {
            first_order: curve.first_order,
            fate,
            candidate: self.judged(curve.candidate),
            left_out_pa: [otherwise_pa, curve.left_out_pa],
        }
    }

    /// Whether there is a single experiment, left out in the same parts as in every other judgement.
    fn has_one_experiment(&self) -> bool {
        self.data.experiments.len() < 2
    }

    /// Error on experiments left out whole, Pa rms.
    fn left_out(&self, c: &Candidate) -> Option<f64> {
        let known = c.held_out_pa().filter(|_| self.has_one_experiment());
        let by_experiment = || left_out::error(&self.data, &c.fit, &left_out::by_experiment(&self.data));
        known.or_else(|| by_experiment().map(|error| error.rmse_pa))
    }

    /// Removes the names that imitated part of the curve: those no longer decisive beside it.
    fn pruned(&self, mut best: JudgedCurve) -> JudgedCurve {
        let curve = Empirical::SET;
        loop {
            let less = terms::without_one(&best.candidate.model).into_par_iter().filter(|m| m.effects.contains(curve));
            let refitted = |model| self.refitted_without(&best.candidate.fit, model).filter(|fit| fit.converged);
            let fits: Vec<Fit> = less.filter_map(refitted).collect();
            let Some(candidate) = fits.into_iter().map(|fit| self.candidate(fit)).max_by(by_bic) else { return best };
            let left_out_pa = self.left_out(&candidate).unwrap_or(f64::INFINITY);
            if best.candidate.delta_bic - candidate.delta_bic > policy::DECISIVE
                || left_out_pa > NEARLY_AS_WELL * best.left_out_pa
            {
                return best;
            }
            best = JudgedCurve { candidate, left_out_pa, ..best };
        }
    }

    /// Refits the curves that remove most of what a model leaves, at least this fraction of it, and judges those with more than
    /// this evidence.
    fn curves_on(&self, part: &Candidate, least_bic: f64, least_share: f64) -> Vec<JudgedCurve> {
        let Some(families) = discrepancy::Families::new(&self.data, &part.fit) else { return Vec::new() };
        let mut curves = families.curves();
        curves.sort_by(|a, b| b.worth(&part.fit).total_cmp(&a.worth(&part.fit)));
        curves.truncate(REFITTED);
        let may_enter = |curve: &Missing| {
            curve.share(&part.fit) >= least_share && part.delta_bic + FIRST_ORDER * curve.worth(&part.fit) > least_bic
        };
        curves.retain(may_enter);
        let mut refitted: Vec<(Missing, Candidate)> = curves
            .into_par_iter()
            .filter_map(|missing| {
                let fit = self.refitted_with(part, &missing.flat()?)?;
                fit.converged.then(|| (missing, self.candidate(fit)))
            })
            .collect();
        refitted.retain(|(_, candidate)| candidate.delta_bic > least_bic);
        refitted.sort_by(|a, b| by_bic(&b.1, &a.1));
        refitted.truncate(CURVES_JUDGED);
        let judged = |(first_order, mut candidate): (Missing, Candidate)| {
            if self.has_one_experiment() {
                self.hold_out(&mut candidate);
            }
            let left_out_pa = self.left_out(&candidate)?;
            let gain = |bic: &dyn Fn(&Fit) -> f64| bic(&part.fit) - bic(&candidate.fit);
            let is_evident = gain(&bic) > policy::DECISIVE + (REFITTED as f64).ln()
                && gain(&|fit| bic_widened(fit, policy::GEOMETRY_WIDENED)) > policy::DECISIVE;
            Some(JudgedCurve { first_order, candidate, left_out_pa, is_evident })
        };
        refitted.into_par_iter().filter_map(judged).collect()
    }

    /// Whether the error on left-out experiments falls decisively, and by more than `least_gain`.
    fn predicts_better(&self, [before, after]: [f64; 2]) -> bool {
        self.leaves_less([before, after], policy::PREDICTS_BETTER)
            && before * before - after * after > self.least_gain().powi(2)
    }

    /// Fits a model roughly with this curve beside all else, starting from zero.
    fn refitted_with(&self, part: &Candidate, curve: &Curve) -> Option<Fit> {
        let mut from = part.fit.clone();
        from.hypothesis.base.effects.of_mut(Empirical::INDEX).copy_from_slice(&curve.parameters());
        let effects = part.model.effects.union(Empirical::SET);
        let model = Model { effects, ..part.model };
        fit_by_size(&self.data, model, &from, &self.sizes, Until::ROUGHLY)
    }

    /// Fits a roughly refitted curve to its minimum.
    fn refitted_fully(&self, rough: JudgedCurve) -> JudgedCurve {
        let Some(fit) = self.refit(&rough.candidate.fit, Until::SETTLED).filter(|fit| fit.converged) else {
            return rough;
        };
        let candidate = self.judged(self.candidate(fit));
        let left_out_pa = self.left_out(&candidate).unwrap_or(rough.left_out_pa);
        JudgedCurve { candidate, left_out_pa, ..rough }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Outside, Recipe};

    #[test]
    fn a_curve_with_an_implausible_coefficient_is_not_possible() {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(41) }.with_outside(Outside::FrictionHeat(0.05));
        let search = Search::after_first_fit(&recipe);
        let curves = search.curves_on(&search.baseline, 0.0, 0.0);
        let mut best = curves.into_iter().next().unwrap();
        assert!(best.is_possible());
        best.candidate.fit.rig[0] -= 1e3f64.ln();
        assert!(!best.is_possible());
    }
}
