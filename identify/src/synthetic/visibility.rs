//! Visibility of an effect without noise: what the other parameters cannot take up.
//!
//! The rms difference, Pa, between the ideal readings with the effect and the closest ones without it, whose other parameters are
//! fitted (least squares by Gauss and Newton). No code of the fits is used.

use super::{Faults, Recipe};
use chamber::card::Fitted;
use chamber::effects::{CARDS, PARAMETER_OFFSETS};
use nalgebra::{DMatrix, DVector};

/// Gauss–Newton steps; the smallest remainder of them counts.
const STEPS: usize = 4;

/// Root mean square of an effect that the paper's parameters do not take up, Pa; `with` is `without` with the effect.
pub fn beyond_paper_pa(with: &Recipe, without: &Recipe) -> f64 {
    beyond_pa(with, without, &paper(without))
}

/// Root mean square that an effect leaves beside the rig's other effects, Pa: what the paper's parameters, theirs and the
/// temperature of the surroundings do not take up.
pub fn beside_others_pa(with: &Recipe, effect: usize) -> f64 {
    let neutral: Vec<f64> = CARDS[effect].parameters.iter().map(|p| p.neutral).collect();
    let without = with.clone().with(CARDS[effect].name, &neutral);
    let mut free = paper(&without);
    free.push(Parameter::AmbientTemperature);
    for e in without.chamber.active().iter() {
        let fitted = CARDS[e].fitted(Fitted::Always);
        free.extend(fitted.map(|(i, _)| Parameter::OfEffect(PARAMETER_OFFSETS[e] + i)));
    }
    beyond_pa(with, &without, &free)
}

/// A parameter of a recipe that may adapt.
#[derive(Clone, Copy)]
enum Parameter {
    Coefficient,
    DeadVolume,
    AmbientTemperature,
    /// Initial pressure of a test.
    InitialPressure(usize),
    /// Index among the parameters of all effects.
    OfEffect(usize),
}

impl Parameter {
    fn of(self, recipe: &mut Recipe) -> &mut f64 {
        match self {
            Self::Coefficient => &mut recipe.chamber.heat_transfer.coefficient,
            Self::DeadVolume => &mut recipe.chamber.geometry.dead_volume,
            Self::AmbientTemperature => &mut recipe.ambient_k,
            Self::InitialPressure(test) => &mut recipe.tests[test].pressure_pa,
            Self::OfEffect(place) => &mut recipe.chamber.effects.0[place],
        }
    }
}

fn paper(recipe: &Recipe) -> Vec<Parameter> {
    let pressures = (0..recipe.tests.len()).map(Parameter::InitialPressure);
    [Parameter::Coefficient, Parameter::DeadVolume].into_iter().chain(pressures).collect()
}

fn beyond_pa(with: &Recipe, without: &Recipe, free: &[Parameter]) -> f64 {
    let goal = ideal(with);
    let mut closest = without.clone();
    let mut least_pa = f64::INFINITY;
    for _ in 0..STEPS {
        let base = ideal(&closest);
        let columns: Vec<_> = free
            .iter()
            .map(|parameter| {
                let mut other = closest.clone();
                *parameter.of(&mut other) *= 1.0 + SMALL;
                column(&ideal(&other), &base) / SMALL
            })
            .collect();
        let difference = column(&goal, &base);
        let (q, r) = DMatrix::from_columns(&columns).qr().unpack();
        let projected = q.transpose() * &difference;
        let rest = &difference - &q * &projected;
        least_pa = least_pa.min(rest.norm() / (rest.len() as f64).sqrt());
        let Some(step) = r.solve_upper_triangular(&projected) else { break };
        for (parameter, by) in free.iter().zip(step.iter()) {
            *parameter.of(&mut closest) *= 1.0 + by.clamp(-MOST, MOST);
        }
    }
    least_pa
}

/// Relative change for a derivative by differences.
const SMALL: f64 = 1e-3;
/// Largest relative change of a parameter in a step.
const MOST: f64 = 0.3;

fn column(a: &[f64], b: &[f64]) -> DVector<f64> {
    DVector::from_iterator(a.len(), a.iter().zip(b).map(|(a, b)| a - b))
}

/// Pressures of one repeat of all tests, recorded perfectly.
fn ideal(recipe: &Recipe) -> Vec<f64> {
    let perfect = Recipe {
        repeats: 1,
        noise_pa: 0.0,
        quantisation_pa: 1e-6,
        rate_hz: 100.0,
        faults: Faults::default(),
        ..recipe.clone()
    };
    let rig = perfect.rig();
    rig.experiments.into_iter().flat_map(|e| e.traces).flat_map(|t| t.pressure_pa.unwrap_or_default()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chamber::effects;

    #[test]
    fn an_effect_that_the_papers_parameters_absorb_is_invisible_and_a_leak_is_not() {
        let recipe = Recipe::from_seed(4);
        let mut other = recipe.clone();
        other.chamber.heat_transfer.coefficient *= 1.01;
        other.chamber.geometry.dead_volume *= 0.99;
        let leaking = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]);
        let (taken_up, leak) = (beyond_paper_pa(&other, &recipe), beyond_paper_pa(&leaking, &recipe));
        assert!(taken_up < 5.0 && leak > 100.0, "{taken_up} {leak}");
    }

    #[test]
    fn of_two_effects_a_leak_is_visible_beside_the_other_and_a_warm_wall_is_not() {
        let recipe = Recipe::from_seed(4);
        let two = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]).with("warm_wall", &[5.0]);
        let [leak, wall] = ["leakage", "warm_wall"].map(|name| beside_others_pa(&two, effects::find(name).unwrap().0));
        assert!(leak > 100.0 && wall < 5.0, "{leak} {wall}");
    }
}
