//! Result of a fit: parameters, residuals and the linearised problem at the solution.

use super::linear::{Linear, readings};
use crate::parameters::{Axis, Hypothesis, Setting, Slot};
use crate::policy;
use crate::record::data::{Data, Prepared};
use crate::record::reconstruction::between_rows::SensorTiming;
use chamber::Chamber;
use chamber::effects::{CARDS, EffectValues, ForcedConvection};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The hypothesis that was fitted.
    pub hypothesis: Hypothesis,
    /// The rig's coordinates.
    pub rig: Vec<f64>,
    /// Each record's coordinates.
    pub records: Vec<Vec<f64>>,
    /// Sum of squares of the whitened residuals.
    pub chi2: f64,
    /// The same with the stated parameters free within their tolerances, including the squares of their moves.
    pub marginal: f64,
    /// These moves of the stated parameters, in tolerances.
    pub moved: Vec<f64>,
    /// The moves of the rig's free coordinates with them.
    pub rig_move: Vec<f64>,
    /// Sum of squares that effects which smear or shift the records may remove merely by smoothing the noise of the stroke.
    pub smoothed: f64,
    /// Number of blocks used.
    pub blocks: usize,
    /// The linearised problem at the solution, record by record; its columns include the stated parameters.
    pub linear: Vec<Linear>,
    /// Normal matrix of the rig's free and stated parameters, including priors, with the per-record parameters eliminated.
    pub information: DMatrix<f64>,
    /// Right-hand side of these normal equations.
    pub right_hand_side: DVector<f64>,
    /// Which free parameters of the rig ended at a bound.
    pub at_bound: Vec<bool>,
    /// Which parameters of the linearised problem, free or stated, may move to the values that the records favour: all but those
    /// at a bound and those stated by a card.
    pub adapts: Vec<bool>,
    /// Root mean square deviation of the records' ambient temperatures from the rig's, in prior standard deviations, with the
    /// stated parameters moved.
    pub ambient_scatter: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Whether the iteration converged rather than reached its limit.
    pub converged: bool,
}

impl Fit {
    /// Whether a rig parameter with a prior has reached the end of its allowed range: [`policy::DEVIATIONS_BEFOREHAND`].
    pub fn is_at_prior_limit(&self) -> bool {
        const NEARLY: f64 = 0.999;
        let most = NEARLY * policy::DEVIATIONS_BEFOREHAND;
        let is_far = |(x, axis): (&f64, &Axis)| axis.prior.is_some_and(|[mean, sd]| (x - mean).abs() > most * sd);
        self.rig.iter().zip(&self.hypothesis.axes).any(is_far)
    }

    /// Returns an effect parameter close to a limit of its plausible values, other than a limit at which the effect is off:
    /// [`policy::NEARLY_EXHAUSTED`].
    pub fn exhausted(&self) -> Option<Slot> {
        let geometry = self.chamber().geometry;
        let is_exhausted = |(x, axis): &(&f64, &Axis)| match axis.slot {
            Slot::Effect(effect, parameter) if axis.prior.is_none() && !axis.logarithmic => {
                let card = &CARDS[effect].parameters[parameter];
                let offset = axis.value(**x) - card.neutral;
                let plausible = card.plausible_values(&geometry);
                let end = if offset < 0.0 { plausible.start() } else { plausible.end() };
                offset.abs() > policy::NEARLY_EXHAUSTED * (end - card.neutral).abs()
            }
            _ => false,
        };
        self.rig.iter().zip(&self.hypothesis.axes).find(is_exhausted).map(|(_, axis)| axis.slot)
    }

    /// Whether moving the stated parameters removes a large part of the squares beyond noise:
    /// [`policy::EXCESS_REMOVED_BY_MOVES`].
    pub fn is_improved_by_moves(&self) -> bool {
        self.chi2 - self.marginal > policy::EXCESS_REMOVED_BY_MOVES * (self.chi2 - self.blocks as f64)
    }

    /// Whether the records' ambient temperatures would have to scatter by more than is credible: [`policy::TOLERANCES`].
    pub fn needs_other_surroundings(&self) -> bool {
        self.ambient_scatter > policy::TOLERANCES
    }

    /// The rig's coordinates with the stated parameters at their best move.
    pub fn rig_moved(&self) -> Vec<f64> {
        super::stepped(&self.rig, &self.rig_move, self.hypothesis.axes.iter().map(|axis| axis.bounds))
    }

    /// A record's coordinates at that move, to first order from the normal equations.
    pub fn record_moved(&self, data: &Data, record: usize) -> Vec<f64> {
        let (l, x) = (&self.linear[record], &self.records[record]);
        let all: Vec<f64> = self.rig_move.iter().chain(&self.moved).copied().collect();
        let left = DVector::from_column_slice(&l.residual) - &l.by_rig * DVector::from_vec(all);
        let step = l.by_record.tr_mul(&l.by_record).cholesky().map(|square| square.solve(&l.by_record.tr_mul(&left)));
        let bounds = self.hypothesis.record_axes(&data.traces[record]).into_iter().map(|axis| axis.bounds);
        step.map_or_else(|| x.clone(), |step| super::stepped(x, step.as_slice(), bounds))
    }

    /// The fitted chamber.
    pub fn chamber(&self) -> Chamber {
        self.hypothesis.chamber(&self.rig)
    }

    /// The fitted chamber as a property of the rig: without the per-record effects, whose entries hold the fit's starting values.
    /// A negative dead volume means that positions read too high, and is set to zero.
    pub fn chamber_of_rig(&self) -> Chamber {
        let mut chamber = self.chamber();
        chamber.effects = chamber.effects.without(self.hypothesis.model.per_record);
        chamber.geometry.dead_volume = chamber.geometry.dead_volume.max(0.0);
        chamber
    }

    /// How much the positions then read too high, m; `None` where the dead volume is not negative.
    pub fn positions_too_far_m(&self) -> Option<f64> {
        let geometry = self.chamber().geometry;
        (geometry.dead_volume < 0.0).then(|| -geometry.dead_volume / geometry.piston_area)
    }

    /// The simulation setting of a record, at the stated parameters.
    pub fn setting(&self, trace: &Prepared, record: &[f64]) -> Setting<f64> {
        self.hypothesis.setting(trace, &self.rig, &[], record)
    }

    /// Timing of each record's readings relative to the recorded stroke.
    pub fn sensor_timings(&self, data: &Data) -> Vec<SensorTiming> {
        let set = self.hypothesis.model.effects;
        let timing = |values: &EffectValues| SensorTiming {
            window_s: values.stroke_window(set),
            lag_s: values.lag(set),
            delay_s: values.delay(set) - values.stroke_delay(set),
            filter_s: values.stroke_filter(set),
        };
        data.traces
            .iter()
            .zip(&self.records)
            .map(|(t, record)| timing(&self.setting(t, record).chamber.effects))
            .collect()
    }

    /// Response of the pressure in each row to a relative change of the forced-convection heat, Pa per unit, record by record;
    /// empty where the model lacks that effect.
    pub fn convection_responses_pa(&self, data: &Data) -> Vec<Vec<f64>> {
        const SMALL: f64 = 0.05;
        let set = self.hypothesis.model.effects;
        let of_record = |(t, record): (&Prepared, &Vec<f64>)| -> Option<Vec<f64>> {
            let setting = self.setting(t, record);
            let mut more = setting;
            more.chamber.effects.of_mut(ForcedConvection::INDEX)[0] *= 1.0 + SMALL;
            let (here, there) = (readings(t, &setting, set).ok()?, readings(t, &more, set).ok()?);
            Some(there.iter().zip(here).map(|(there, here)| (there - here) / SMALL).collect())
        };
        if !set.has(ForcedConvection::INDEX) {
            return vec![Vec::new(); data.traces.len()];
        }
        data.traces.par_iter().zip(&self.records).map(|record| of_record(record).unwrap_or_default()).collect()
    }

    /// Moves the stated parameters that adapt to the values that the records favour, within their tolerances.
    pub(super) fn move_within_tolerances(&mut self) {
        let mut adapts = std::mem::take(&mut self.adapts);
        if let Some((left, x)) = self.credible_move(&mut adapts) {
            let (rig_move, moved) = x.split_at(self.rig.len());
            (self.marginal, self.moved, self.rig_move) = (left, moved.to_vec(), rig_move.to_vec());
        }
        self.adapts = adapts;
    }

    /// Each stated parameter with the distance of its moved from its stated value, in tolerances.
    pub fn moved_from_stated(&self) -> impl Iterator<Item = (&Axis, f64)> {
        self.hypothesis.stated.iter().zip(&self.moved).map(|(axis, moved)| (axis, moved - axis.mean()))
    }

    /// The move of a stated parameter that the records favour, in tolerances, and [`Fit::marginal`] without it.
    pub fn favoured_move(&self, slot: Slot) -> Option<(f64, f64)> {
        let (index, mut adapts) = (self.index_of_stated(slot)?, self.adapts.clone());
        adapts[self.rig.len() + index] = false;
        let (left, _) = self.best_weighed(&self.unit_weights(), &adapts)?;
        Some((self.moved[index], left))
    }

    /// [`Fit::marginal`] with the tolerances multiplied by this factor, except that of the gas.
    pub fn marginal_widened(&self, factor: f64) -> f64 {
        let mut weights = vec![1.0 / (factor * factor); self.moved.len()];
        self.index_of_stated(Slot::HeatCapacityRatio).into_iter().for_each(|gas| weights[gas] = 1.0);
        self.best_weighed(&weights, &self.adapts).map_or(self.chi2, |(left, _)| left)
    }

    /// [`Fit::marginal`] with the tolerance of the position's nonlinearity multiplied by this factor, and the largest amplitude
    /// then reached, in tolerances.
    pub fn marginal_with_nonlinear_positions(&self, factor: f64) -> Option<(f64, f64)> {
        let (mut weights, mut adapts) = (self.unit_weights(), self.adapts.clone());
        for wave in self.waves() {
            weights[wave] = 1.0 / (factor * factor);
            adapts[self.rig.len() + wave] = true;
        }
        let (left, x) = self.best_weighed(&weights, &adapts)?;
        Some((left, self.farthest_wave(&x)))
    }

    /// The best credible move and the sum of squares that it leaves.
    ///
    /// A move of the heat capacity ratio costs the same whatever the misfit: the evidence treats the noise level as unknown, so
    /// beside squares far above those of noise a move of many tolerances would count for little.
    ///
    /// The waves of a position sensor are credible up to [`policy::TOLERANCES`]: a larger amplitude has another cause. Over the
    /// next tolerance their tolerance shrinks to zero, and beyond that none of them adapts: with a hard limit, any parameter that
    /// brings one below it would gain everything that the waves remove.
    fn credible_move(&self, adapts: &mut [bool]) -> Option<(f64, Vec<f64>)> {
        /// In tolerances.
        const FADES_WITHIN: f64 = 1.0;
        /// After this many rounds the sum of squares no longer changes.
        const ROUNDS: usize = 3;
        let mut weights = self.unit_weights();
        let mut best = self.best_weighed(&weights, adapts)?;
        if let Some(gas) = self.index_of_stated(Slot::HeatCapacityRatio) {
            for _ in 0..ROUNDS {
                weights[gas] = (best.0 / self.blocks.max(1) as f64).max(1.0);
                best = self.best_weighed(&weights, adapts)?;
            }
        }
        let belief = (policy::TOLERANCES - self.farthest_wave(&best.1)) / FADES_WITHIN + 1.0;
        if belief >= 1.0 {
            return Some(best);
        }
        for wave in self.waves() {
            if belief > 0.0 {
                weights[wave] = 1.0 / (belief * belief);
            } else {
                adapts[self.rig.len() + wave] = false;
            }
        }
        self.best_weighed(&weights, adapts)
    }

    /// Sum of squares left by the best move of all adapting parameters, including the move's own squares, and that move, with
    /// these weights of the stated parameters' squares.
    fn best_weighed(&self, weights: &[f64], adapts: &[bool]) -> Option<(f64, Vec<f64>)> {
        let (mut matrix, mut right) = (self.information.clone(), self.right_hand_side.clone());
        self.hypothesis.add_priors_of_stated(&mut matrix, &mut right, |k| weights[k] - 1.0);
        let of_prior = |(axis, weight): (&Axis, &f64)| weight * axis.mean() * axis.mean();
        let unmoved = self.chi2 + self.hypothesis.stated.iter().zip(weights).map(of_prior).sum::<f64>();
        let (gain, x) = best_move(&matrix, &right, adapts)?;
        Some(((unmoved - gain).max(0.0), x))
    }

    /// Unit weights: the squares of the stated parameters in their tolerances.
    fn unit_weights(&self) -> Vec<f64> {
        vec![1.0; self.moved.len()]
    }

    /// Index of a stated parameter.
    fn index_of_stated(&self, slot: Slot) -> Option<usize> {
        self.hypothesis.stated.iter().position(|axis| axis.slot == slot)
    }

    /// Indices of the position sensor's waves among the stated parameters.
    fn waves(&self) -> impl Iterator<Item = usize> {
        self.hypothesis.stated.iter().enumerate().filter(|(_, axis)| axis.slot.is_wave()).map(|(k, _)| k)
    }

    /// Largest wave amplitude in a move, in tolerances.
    fn farthest_wave(&self, x: &[f64]) -> f64 {
        self.waves().map(|wave| x[self.rig.len() + wave].abs()).fold(0.0, f64::max)
    }

    /// Number of free parameters, not counting those that every record has.
    pub fn freedom(&self) -> usize {
        let takes_part = |k: &usize| self.linear[*k].blocks > 0;
        self.hypothesis.freedom((0..self.records.len()).filter(takes_part))
    }
}

/// Decrease of χ² by the best move of all adapting parameters, and that move.
fn best_move(matrix: &DMatrix<f64>, right: &DVector<f64>, adapts: &[bool]) -> Option<(f64, Vec<f64>)> {
    let n = right.len();
    let free: Vec<usize> = (0..n).filter(|&i| adapts[i] && matrix[(i, i)] > 0.0).collect();
    let scale: Vec<f64> = free.iter().map(|&i| 1.0 / matrix[(i, i)].sqrt()).collect();
    let m = free.len();
    let sub = DMatrix::from_fn(m, m, |i, j| {
        matrix[(free[i], free[j])] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
    });
    let rhs = DVector::from_fn(m, |i, _| right[free[i]] * scale[i]);
    let solution = sub.cholesky()?.solve(&rhs);
    let mut x = vec![0.0; n];
    for (i, &f) in free.iter().enumerate() {
        x[f] = solution[i] * scale[i];
    }
    Some((solution.dot(&rhs), x))
}

#[cfg(test)]
mod tests {
    use crate::parameters::Slot;
    use crate::record::data::Data;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use crate::synthetic::recording::Wave;
    use std::f64::consts::TAU;

    #[test]
    fn waves_of_the_positions_beyond_their_credible_amplitude_remove_ever_less_of_the_misfit() {
        let left = |tolerances: f64| {
            let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
            recipe.faults.position_wave = Some(Wave { amplitude: 2e-4 * tolerances, angles: [0.0, TAU] });
            let (data, fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
            assert_eq!(data.tolerance.position_linearity, 2e-4);
            (fit.marginal - fit.blocks as f64) / (fit.chi2 - fit.blocks as f64)
        };
        let left: Vec<f64> = (0..12).map(|k| left(2.7 + 0.15 * f64::from(k))).collect();
        assert!(left[0] < 0.05 && left[11] > 0.9, "{left:?}");
        assert!(left.windows(2).all(|pair| pair[1] - pair[0] < 0.6), "{left:?}");
    }

    #[test]
    fn a_heat_capacity_ratio_that_is_off_within_its_tolerance_accounts_for_its_misfit() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.faults.stated.heat_capacity_ratio_times = 1.001;
        let (_, fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        let index = fit.hypothesis.stated.iter().position(|axis| axis.slot == Slot::HeatCapacityRatio).unwrap();
        let blocks = fit.blocks as f64;
        assert!((fit.marginal - blocks) < 0.1 * (fit.chi2 - blocks));
        assert!((fit.moved[index] + 2.0).abs() < 0.3, "{:?}", fit.moved);
    }

    #[test]
    fn the_move_of_the_gas_does_not_grow_with_the_remaining_misfit() {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) }.with("leakage", &[5e-11]);
        recipe.faults.stated.heat_capacity_ratio_times = 1.001;
        let mut data = Data::prepare(&recipe.rig()).unwrap();
        data.tolerance.position_linearity = 0.0;
        let (_, fit) = baseline::fitted(data).unwrap();
        let index = fit.hypothesis.stated.iter().position(|axis| axis.slot == Slot::HeatCapacityRatio).unwrap();
        let over_noise = fit.marginal / fit.blocks as f64;
        assert!(over_noise > 10.0, "{over_noise}");
        // The move if all squares are scaled to the remaining misfit, which makes them less certain.
        let mut scaled = fit.clone();
        scaled.information *= 1.0 / over_noise;
        scaled.right_hand_side *= 1.0 / over_noise;
        let gas = fit.rig.len() + index;
        scaled.information[(gas, gas)] += 1.0 - 1.0 / over_noise;
        let (_, x) = super::best_move(&scaled.information, &scaled.right_hand_side, &fit.adapts).unwrap();
        assert!((fit.moved[index] / x[gas] - 1.0).abs() < 0.01, "{} {}", fit.moved[index], x[gas]);
    }

    #[test]
    fn surroundings_need_not_differ_between_records_for_a_gas_that_is_off_within_its_tolerance() {
        let mut recipe = Recipe { noise_pa: 20.0, ..Recipe::from_seed(5) };
        recipe.faults.stated.heat_capacity_ratio_times = 1.001;
        let (_, fit) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
        assert!(fit.ambient_scatter < 2.0, "{}", fit.ambient_scatter);
        assert!(!fit.needs_other_surroundings());
    }
}
