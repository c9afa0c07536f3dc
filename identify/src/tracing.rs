//! From a rig's residual to the effect that explains it, or to the statement that none of the known ones does.
//!
//! Baseline fit → is the residual noise? → every effect of the list added alone → the best enters if its evidence is
//! decisive (ΔBIC > 10) and the error on held-out data lower → a second one likewise, all pairs of the better ones where
//! one is not enough → what is left is tested again. A set that leaves more than noise is not an explanation.

use crate::adequacy::{self, Adequacy};
use crate::candidates::fit_set;
use crate::error::Error;
use crate::evidence;
use crate::fit::{self, Fit};
use crate::held_out::{self, Fold};
use crate::hypothesis::{self, Hypothesis, Sizes};
use crate::prepare::Data;
use crate::sanity;
use chamber::effects::{self, EffectSet};
use rayon::prelude::*;

/// Evidence from which on an effect may enter.
const DECISIVE: f64 = 10.0;
/// Evidence below which two sets cannot be told apart.
const INDISTINGUISHABLE: f64 = 6.0;
/// How many of the better single effects are tried in pairs.
const PAIRED: usize = 6;
/// How many of the better pairs are looked at more closely.
const JUDGED_PAIRS: usize = 4;

/// A set of effects that was fitted.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The set.
    pub effects: EffectSet,
    /// Its fit.
    pub fit: Fit,
    /// BIC of the baseline less its own.
    pub delta_bic: f64,
    /// Error on held-out data, Pa, where it was judged.
    pub held_out_pa: Option<f64>,
}

/// How the tracing ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The paper's model leaves no more than noise.
    Adequate,
    /// Known effects account for the residual.
    Explained,
    /// Something is there that no known effect accounts for.
    Unexplained,
}

/// All that the tracing found.
#[derive(Clone, Debug)]
pub struct Trace {
    /// How it ended.
    pub verdict: Verdict,
    /// The paper's model.
    pub baseline: Candidate,
    /// Whether its residual is noise.
    pub baseline_adequacy: Adequacy,
    /// Everything tried, best evidence first.
    pub tried: Vec<Candidate>,
    /// The best accepted set, whatever the verdict; the baseline when none was.
    pub chosen: Candidate,
    /// Whether what that leaves is noise.
    pub chosen_adequacy: Adequacy,
    /// Sets of the same size that the data cannot tell from the chosen one, whatever the verdict.
    pub alike: Vec<EffectSet>,
    /// Number of independent samples in the best candidate's residual.
    pub samples: f64,
}

/// Traces a rig's residual. `progress` is told what is being done and how far it is.
///
/// # Errors
/// Where the data contradict the model in a way that has a name: [`Error::Gauge`], [`Error::NegativeDeadVolume`].
pub fn trace(data: &Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Trace, Error> {
    progress("fitting the paper's model", 0.0);
    let baseline = baseline(data)?;
    let sizes = Sizes::of(data, &baseline.chamber());
    let baseline_adequacy = adequacy::test(data, &baseline);
    if !baseline_adequacy.is_noise {
        sanity::gauge(data, &baseline)?;
    }
    let mut tracer = Tracer { data, sizes, folds: held_out::folds(data), samples: 0.0, baseline_bic: 0.0 };

    progress("one effect at a time", 0.1);
    let all: Vec<EffectSet> = effects::all().map(|(i, _)| EffectSet::one(i)).collect();
    let singles = tracer.fit_all(&all, |_| &baseline);
    let best = singles.iter().chain([&baseline]).min_by(|a, b| a.chi2.total_cmp(&b.chi2)).unwrap_or(&baseline);
    tracer.weigh_by(best, &baseline);

    progress("error on held-out data", 0.3);
    let baseline = tracer.judged(tracer.candidate(baseline));
    let mut tried: Vec<Candidate> = singles.into_par_iter().map(|f| tracer.judged(tracer.candidate(f))).collect();
    sort(&mut tried);
    let mut chosen = tried.iter().find(|c| tracer.enters(c, &baseline)).unwrap_or(&baseline).clone();
    let mut chosen_adequacy =
        if chosen.effects.is_empty() { baseline_adequacy.clone() } else { adequacy::test(data, &chosen.fit) };

    if !chosen.effects.is_empty() && !chosen_adequacy.is_noise {
        progress("secondary parameters", 0.5);
        if let Some(freed) = tracer.freed(&chosen) {
            chosen = tracer.judged(freed);
            chosen_adequacy = adequacy::test(data, &chosen.fit);
        }
    }
    if !chosen.effects.is_empty() || !chosen_adequacy.is_noise {
        progress("two effects at a time", 0.6);
        let found = tracer.two_at_a_time(&baseline, &mut tried, &mut chosen, !chosen_adequacy.is_noise);
        let counts = |pair: &&Candidate| each_counts(pair, &tried);
        if let Some(pair) = found.iter().filter(counts).find(|c| tracer.enters(c, &chosen)) {
            chosen = pair.clone();
            chosen_adequacy = adequacy::test(data, &chosen.fit);
        }
        tried.extend(found);
        sort(&mut tried);
    }
    progress("done", 1.0);

    let verdict = match (chosen.effects.is_empty(), chosen_adequacy.settles(&baseline_adequacy)) {
        (true, true) => Verdict::Adequate,
        (false, true) => Verdict::Explained,
        (_, false) => Verdict::Unexplained,
    };
    let settled = if verdict == Verdict::Unexplained { &baseline } else { &chosen };
    sanity::dead_volume(data, &settled.fit)?;
    let alike = alike(&chosen, &tried);
    Ok(Trace { verdict, baseline, baseline_adequacy, tried, chosen, chosen_adequacy, alike, samples: tracer.samples })
}

/// Whether each of a pair is worth its place beside the other, and one of them worth a place without it: two that do
/// nothing alone and much together bend against each other.
fn each_counts(pair: &Candidate, singles: &[Candidate]) -> bool {
    let alone = singles.iter().filter(|single| pair.effects.contains(single.effects)).map(|s| s.delta_bic);
    let best = alone.fold(f64::NEG_INFINITY, f64::max);
    best > DECISIVE && pair.delta_bic - best > DECISIVE
}

/// Sets of as many effects as the chosen one has, which the data cannot tell from it.
fn alike(chosen: &Candidate, tried: &[Candidate]) -> Vec<EffectSet> {
    let size = |c: &Candidate| c.effects.iter().count();
    tried
        .iter()
        .filter(|c| !chosen.effects.is_empty() && c.effects != chosen.effects && size(c) == size(chosen))
        .filter(|c| chosen.delta_bic - c.delta_bic < INDISTINGUISHABLE)
        .map(|c| c.effects)
        .collect()
}

/// The paper's model, fitted to everything.
///
/// # Errors
/// Where its simulation fails at the very begin.
pub fn baseline(data: &Data) -> Result<Fit, Error> {
    let first = hypothesis::first_chamber(data);
    let sizes = Sizes::of(data, &first);
    let h = Hypothesis::new(data, EffectSet::NONE, &first, &sizes);
    let selection = fit::all_blocks(data);
    // λ0 may be far from the first guess: the best of three starts.
    let starts = [0.0, 2.0, -2.0];
    let mut failure = None;
    let fits: Vec<Fit> = starts
        .iter()
        .filter_map(|offset| {
            let mut x = h.coordinates(&first);
            x[0] += offset;
            fit::fit(data, &h, x, fit::first_locals(data), &selection).map_err(|e| failure = Some(e)).ok()
        })
        .collect();
    fits.into_iter().min_by(|a, b| a.chi2.total_cmp(&b.chi2)).ok_or_else(|| match failure {
        Some((k, source)) => Error::Simulation { trace: data.traces[k].path.clone(), source },
        None => Error::Method("no start of the fit could be simulated".to_owned()),
    })
}

struct Tracer<'a> {
    data: &'a Data,
    sizes: Sizes,
    folds: Vec<Fold>,
    samples: f64,
    baseline_bic: f64,
}

impl Tracer<'_> {
    fn fit_all<'b>(&self, sets: &[EffectSet], part: impl Fn(EffectSet) -> &'b Fit + Sync) -> Vec<Fit> {
        let selection = fit::all_blocks(self.data);
        sets.par_iter().filter_map(|set| fit_set(self.data, *set, part(*set), &self.sizes, &selection)).collect()
    }

    /// Counts samples by what this fit leaves: a model that misses the data's shape makes them look dependent.
    fn weigh_by(&mut self, best: &Fit, baseline: &Fit) {
        self.samples =
            evidence::effective_samples(&evidence::residuals(self.data, best), self.data.noise.correlation_rows);
        self.baseline_bic = evidence::bic(self.data, baseline, self.samples);
    }

    /// The evidence of everything, with the samples that the best of it says there are.
    fn weigh_anew(&mut self, baseline: &Candidate, lists: [&mut Vec<Candidate>; 2], chosen: &mut Candidate) {
        let all = lists.iter().flat_map(|list| list.iter()).chain([&*chosen]);
        let Some(best) = all.map(|c| &c.fit).min_by(|a, b| a.chi2.total_cmp(&b.chi2)) else { return };
        self.weigh_by(best, &baseline.fit);
        for c in lists.into_iter().flatten().chain([chosen]) {
            c.delta_bic = self.delta_bic(&c.fit);
        }
    }

    fn delta_bic(&self, fit: &Fit) -> f64 {
        self.baseline_bic - evidence::bic(self.data, fit, self.samples)
    }

    fn candidate(&self, fit: Fit) -> Candidate {
        Candidate { effects: fit.hypothesis.effects, delta_bic: self.delta_bic(&fit), fit, held_out_pa: None }
    }

    fn judged(&self, mut c: Candidate) -> Candidate {
        c.held_out_pa = held_out::rmse(self.data, &c.fit, &self.folds);
        c
    }

    /// Decisive evidence and a lower error on held-out data.
    fn enters(&self, c: &Candidate, over: &Candidate) -> bool {
        let lower = match (c.held_out_pa, over.held_out_pa) {
            (Some(a), Some(b)) => a < b,
            (Some(_), None) => true,
            _ => false,
        };
        c.delta_bic - over.delta_bic > DECISIVE && lower
    }

    /// The same set with its secondary parameters free, where that is decisively better.
    fn freed(&self, c: &Candidate) -> Option<Candidate> {
        let base = c.fit.chamber();
        let h = Hypothesis::with_secondary(self.data, c.effects, c.effects, &base, &self.sizes);
        if h.axes.len() == c.fit.hypothesis.axes.len() {
            return None;
        }
        let x = h.coordinates(&base);
        let fit = fit::fit(self.data, &h, x, c.fit.locals.clone(), &fit::all_blocks(self.data)).ok()?;
        let left = evidence::residuals(self.data, &fit);
        let samples = evidence::effective_samples(&left, self.data.noise.correlation_rows);
        let better = evidence::bic(self.data, &c.fit, samples) - evidence::bic(self.data, &fit, samples);
        (better > DECISIVE).then(|| self.candidate(fit))
    }

    /// Fits pairs, from the better of their two single fits; all evidence, the single ones' too, is weighed anew.
    fn two_at_a_time(
        &mut self,
        baseline: &Candidate,
        tried: &mut Vec<Candidate>,
        chosen: &mut Candidate,
        all: bool,
    ) -> Vec<Candidate> {
        let pairs = self.pairs(tried, chosen, all);
        let part = |set: EffectSet| {
            let single = tried.iter().find(|c| set.contains(c.effects));
            &single.unwrap_or(baseline).fit
        };
        let mut found: Vec<Candidate> = self.fit_all(&pairs, part).into_iter().map(|f| self.candidate(f)).collect();
        self.weigh_anew(baseline, [tried, &mut found], chosen);
        sort(&mut found);
        // The better ones are judged by held-out data too, with all their parameters free where that is better.
        let judged = |(rank, c): (usize, Candidate)| {
            if rank < JUDGED_PAIRS { self.judged(self.freed(&c).unwrap_or(c)) } else { c }
        };
        found = found.into_par_iter().enumerate().map(judged).collect();
        self.weigh_anew(baseline, [tried, &mut found], chosen);
        sort(&mut found);
        found
    }

    /// Pairs to be tried: the chosen effect with every other; among the better single ones too where it is not enough.
    fn pairs(&self, tried: &[Candidate], chosen: &Candidate, all: bool) -> Vec<EffectSet> {
        let mut out: Vec<EffectSet> = Vec::new();
        let mut push = |a: EffectSet, b: EffectSet| {
            let pair = a.union(b);
            if a != b && !out.contains(&pair) {
                out.push(pair);
            }
        };
        for c in tried {
            if !chosen.effects.is_empty() {
                push(chosen.effects, c.effects);
            }
        }
        if all {
            for (i, a) in tried.iter().take(PAIRED).enumerate() {
                for b in tried.iter().take(PAIRED).skip(i + 1) {
                    push(a.effects, b.effects);
                }
            }
        }
        out
    }
}

fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
}
