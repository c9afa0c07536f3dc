//! Minimisation of the sum of squares: Levenberg–Marquardt with bounds and a second-order correction of failed steps.
//!
//! A step v solves (JᵀJ + μ D) v = Jᵀρ, ρ the residuals, D the diagonal of JᵀJ. Where the sum of squares has a narrow curved
//! valley, such a step leads up its wall, and the damping μ makes all further steps short. A failed step is therefore retried
//! with the curvature that it revealed: ρ(x + v) − (ρ − J v) is −½ of the model's second derivative along it, and
//! (JᵀJ + μ D)⁻¹ Jᵀ times that is added to the step. Source: M. K. Transtrum and J. P. Sethna, arXiv:1201.5885 (2012) (geodesic
//! acceleration, here with the whole step as the difference).

use super::bordered::{Step, System};
use super::linear::{Failure, Linear, Linearised, Selection, linearise, residuals, total};
use super::room::Room;
use super::{record_axes, stepped};
use crate::parameters::{Axis, Hypothesis, RecordSlot};
use crate::policy;
use crate::record::data::Data;
use nalgebra::DVector;

/// Stopping criteria of a descent, and of a fit, which consists of descents.
#[derive(Clone, Copy, Debug)]
pub struct Until {
    /// Maximum number of iterations.
    pub iterations: usize,
    /// A descent ends when the predicted decrease of χ² is less than this, times χ² over its expectation (the measure in which the
    /// evidence counts χ²).
    pub gain: f64,
    /// It also ends after this many successive iterations that gained less.
    pub slow_iterations: usize,
    /// Maximum number of descents in a fit, each starting where the previous one stopped without converging.
    pub descents: usize,
    /// χ² of the best known fit. A descent that stays far above it and progresses too slowly is given up.
    pub best: f64,
}

impl Until {
    /// At a minimum: a step with this gain in χ² moves no parameter by more than a twentieth of its standard deviation (√0.002).
    /// The iteration limit only ends a fit that creeps.
    pub const SETTLED: Self = Self { iterations: 40, gain: 2e-3, slow_iterations: 1, descents: 2, best: f64::INFINITY };
    /// The same with a single descent, converged or not.
    pub const ONE_DESCENT: Self = Self { descents: 1, ..Self::SETTLED };
    /// Where steps gain next to nothing compared with decisive evidence: not to the far end of a narrow valley. A single
    /// iteration may gain little because its step was damped.
    pub const ROUGHLY: Self = Self { gain: 1e-3 * policy::DECISIVE, slow_iterations: 2, ..Self::SETTLED };

    /// After this many iterations at the latest.
    pub const fn after(iterations: usize) -> Self {
        Self { iterations, ..Self::SETTLED }
    }

    /// At a minimum, unless it stays far above a fit with this χ².
    pub const fn beside(best: f64) -> Self {
        Self { best, ..Self::SETTLED }
    }
}

/// A step that reduces χ² by less than this fraction is so short that the simulations keep their integration steps: with newly
/// chosen ones χ² scatters by more than the last iterations gain.
const NEAR: f64 = 0.01;
/// A fit whose χ² exceeds that of the best known one by this factor is far above it: no difference in parameters makes up for
/// that...
const FAR_BEHIND: f64 = 2.0;
/// ...and is given up if it gains less than this fraction of the distance in each of this many successive iterations: all
/// iterations of its descents would not reach the best one.
const CREEPING: (f64, usize) = (0.01, 3);
/// Maximum number of dampings tried in an iteration.
const MOST_DAMPINGS: usize = 12;
/// The second-order correction is applied to this many of them: with more damping the steps are short and nearly straight.
const BENT: usize = 3;

/// Initial damping, relative to the diagonal of JᵀJ: almost none, since fits begin near a minimum or at one of several starts.
const FIRST_DAMPING: f64 = 1e-4;
/// Factor on the damping after a failed step: three failures take it from a value that bends a step to one that shortens it.
const MORE: f64 = 10.0;
/// After a step that gains more than the fraction `KEPT` of its prediction, the damping is multiplied by `LESS`: there the
/// problem is practically linear, and an undamped step is best.
const KEPT: f64 = 0.7;
const LESS: f64 = 0.1;
/// Minimum damping after a failure: starting from less, several successive steps would be the same.
const LEAST_AFTER_FAILURE: f64 = 1e-3;
/// Minimum damping for a singular system: it lifts singular directions above the round-off of JᵀJ.
const LEAST_OF_SINGULAR: f64 = 1e-6;
/// Minimum damping: less changes no step, given the accuracy of the sensitivities.
const LEAST_DAMPING: f64 = 1e-9;
/// Maximum damping: with more, steps are so short that only the accuracy of the simulation keeps them from leading down.
const MOST_DAMPING: f64 = 1e8;

/// State of a descent.
#[derive(Clone, Debug)]
pub struct Descent {
    /// The rig's coordinates.
    pub rig: Vec<f64>,
    /// Each record's coordinates.
    pub records: Vec<Vec<f64>>,
    /// Σ of squares.
    pub chi2: f64,
    /// Iterations used.
    pub iterations: usize,
    /// Whether it converged to a minimum.
    pub converged: bool,
    /// Whether it was given up far above the best known fit.
    pub given_up: bool,
    /// The last linearisation.
    pub at: Linearised,
}

impl Descent {
    /// A descent that begins at these coordinates.
    pub fn at(rig: Vec<f64>, records: Vec<Vec<f64>>) -> Self {
        Self {
            rig,
            records,
            chi2: f64::INFINITY,
            iterations: 0,
            converged: false,
            given_up: false,
            at: Linearised::Nowhere,
        }
    }
}

/// Minimises the sum of squares and returns where the descent ends; also used to choose among starts.
///
/// # Errors
/// [`Failure`].
pub fn descend(
    data: &Data,
    hypothesis: &Hypothesis,
    rig: Vec<f64>,
    records: Vec<Vec<f64>>,
    selection: &Selection,
    until: Until,
) -> Result<Descent, Failure> {
    let problem = Problem { data, hypothesis, selection, record_axes: record_axes(data, hypothesis) };
    let mut here = Descent::at(rig, records);
    let (mut damping, mut slow_iterations, mut creeping) = (FIRST_DAMPING, 0, 0);
    while here.iterations < until.iterations && !here.converged && !here.given_up {
        let linear = linearise(data, hypothesis, &here.rig, &here.records, selection, here.at.near())?;
        here.chi2 = total(&linear);
        here.iterations += 1;
        let blocks: usize = linear.iter().map(|l| l.blocks).sum();
        let settled = until.gain * (here.chi2 / blocks.max(1) as f64).max(1.0);
        match problem.lower(&here, &linear, &mut damping, settled) {
            Next::Lower(trial) => {
                let gain = here.chi2 - trial.chi2;
                slow_iterations = if gain < settled { slow_iterations + 1 } else { 0 };
                here.converged = slow_iterations >= until.slow_iterations;
                let creeps = here.chi2 > FAR_BEHIND * until.best && gain < CREEPING.0 * (here.chi2 - until.best);
                creeping = if creeps { creeping + 1 } else { 0 };
                here.given_up = creeping >= CREEPING.1;
                here.at = if gain < NEAR * here.chi2 { Linearised::Near(linear) } else { Linearised::Nowhere };
                (here.rig, here.records, here.chi2) = (trial.rig, trial.records, trial.chi2);
            }
            Next::Minimum => (here.converged, here.at) = (true, Linearised::Here(linear)),
            Next::Nowhere => {
                here.at = Linearised::Here(linear);
                break;
            }
        }
    }
    Ok(here)
}

/// Coordinates that were tried, and their residuals.
struct Trial {
    rig: Vec<f64>,
    records: Vec<Vec<f64>>,
    residuals: Vec<Vec<f64>>,
    chi2: f64,
}

/// How an iteration ends.
enum Next {
    /// A step led to a lower sum of squares.
    Lower(Trial),
    /// No step is predicted to gain significantly, or none leads down within the accuracy of the simulation.
    Minimum,
    /// The maximum number of dampings was reached.
    Nowhere,
}

/// The problem to be minimised.
struct Problem<'a> {
    data: &'a Data,
    hypothesis: &'a Hypothesis,
    selection: &'a Selection,
    record_axes: Vec<Vec<Axis<RecordSlot>>>,
}

impl Problem<'_> {
    /// Returns the first step that leads down, starting with the damping of the last successful one.
    fn lower(&self, here: &Descent, linear: &[Linear], damping: &mut f64, settled: f64) -> Next {
        let system = System::new(linear, self.hypothesis.axes.len());
        let room = self.room(&here.rig, &here.records);
        let leads_down = |trial: &Trial| trial.chi2 < here.chi2;
        for attempt in 0..MOST_DAMPINGS {
            let Some(step) = system.step(&room, *damping) else {
                *damping = (*damping * MORE).max(LEAST_OF_SINGULAR);
                continue;
            };
            if step.predicted_decrease < settled {
                return Next::Minimum;
            }
            let straight = self.trial(here, linear, &step);
            let predicted = step.predicted_decrease;
            let bent = match &straight {
                Some(trial) if attempt < BENT && !leads_down(trial) => system
                    .with_residuals(linear, &missed(linear, &step, &trial.residuals))
                    .step(&self.room(&trial.rig, &trial.records), *damping)
                    .and_then(|bend| self.trial(here, linear, &step.bent_by(&bend))),
                _ => None,
            };
            if let Some(trial) = straight.into_iter().chain(bent).find(leads_down) {
                if here.chi2 - trial.chi2 > KEPT * predicted {
                    *damping *= LESS;
                }
                *damping = damping.max(LEAST_DAMPING);
                return Next::Lower(trial);
            }
            *damping = (*damping * MORE).max(LEAST_AFTER_FAILURE);
            if *damping > MOST_DAMPING {
                return Next::Minimum;
            }
        }
        Next::Nowhere
    }

    fn room(&self, rig: &[f64], records: &[Vec<f64>]) -> Room {
        Room::around(self.hypothesis, &self.record_axes, rig, records)
    }

    /// Evaluates a step within the bounds; `None` where the simulation fails. Only residuals are computed, at a fraction of the
    /// cost of the sensitivities.
    fn trial(&self, from: &Descent, linear: &[Linear], step: &Step) -> Option<Trial> {
        let rig = stepped(&from.rig, &step.rig, self.hypothesis.axes.iter().map(|axis| axis.bounds));
        let steps = from.records.iter().zip(&step.records).zip(&self.record_axes);
        let records: Vec<Vec<f64>> =
            steps.map(|((x, step), axes)| stepped(x, step, axes.iter().map(|axis| axis.bounds))).collect();
        let residuals = residuals(self.data, self.hypothesis, &rig, &records, self.selection, linear)?;
        let chi2 = residuals.iter().flatten().map(|r| r * r).sum();
        Some(Trial { rig, records, residuals, chi2 })
    }
}

/// Residuals after a step minus those predicted by the linearised problem.
fn missed(linear: &[Linear], step: &Step, after: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let rig = DVector::from_column_slice(&step.rig);
    let of_record = |((l, record), after): ((&Linear, &Vec<f64>), &Vec<f64>)| {
        let predicted = &l.by_rig * &rig + &l.by_record * DVector::from_column_slice(record);
        (0..after.len()).map(|i| after[i] - (l.residual[i] - predicted[i])).collect()
    };
    linear.iter().zip(&step.records).zip(after).map(of_record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::all_blocks;
    use crate::parameters::{Model, Sizes, first_chamber};
    use crate::synthetic::Recipe;
    use chamber::record::Mesh;
    use nalgebra::DMatrix;

    #[test]
    fn the_second_order_correction_raises_the_order_of_a_step_by_one() {
        // Model x + x²/2 in two blocks, starting from zero.
        let model = |x: f64| x + 0.5 * x * x;
        let error = |target: f64| {
            let residual = |x: f64| vec![model(target) - model(x); 2];
            let linear = Linear {
                blocks: 2,
                residual: residual(0.0),
                by_rig: DMatrix::from_element(2, 1, 1.0),
                by_record: DMatrix::zeros(2, 0),
                mesh: Mesh::default(),
            };
            let straight = model(target);
            let step = Step { rig: vec![straight], records: vec![Vec::new()], predicted_decrease: 0.0 };
            let bend = missed(&[linear], &step, &[residual(straight)])[0][0];
            assert!((bend + 0.5 * straight * straight).abs() < 1e-15, "{bend}");
            [straight, straight + bend].map(|x| (x - target).abs())
        };
        let (far, near) = (error(0.2), error(0.1));
        assert!(far[1] < 0.25 * far[0] && near[1] < 0.12 * near[0], "{far:?} {near:?}");
        assert!((far[0] / near[0]).log2() > 1.9 && (far[1] / near[1]).log2() > 2.7, "{far:?} {near:?}");
    }

    #[test]
    fn a_fit_that_stays_far_behind_the_best_known_one_is_given_up_and_one_beside_it_is_not() {
        let data = Data::prepare(&Recipe { repeats: 1, ..Recipe::from_seed(5) }.rig()).unwrap();
        let first = first_chamber(&data);
        let h = Hypothesis::new(&data, Model::PAPER, &first, &Sizes::of(&data, &first));
        let descent = |until: Until| {
            descend(&data, &h, h.coordinates(&first), h.record_guesses(&data), &all_blocks(&data), until).unwrap()
        };
        let settled = descent(Until::SETTLED);
        assert!(settled.converged && settled.iterations > CREEPING.1);
        let beside = descent(Until::beside(0.9 * settled.chi2));
        assert!(beside.converged && beside.chi2 == settled.chi2);
        let far_behind = descent(Until::beside(-1e15));
        assert!(far_behind.given_up && !far_behind.converged && far_behind.iterations == CREEPING.1);
    }
}
