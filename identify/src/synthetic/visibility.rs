//! How far an effect shows, before any noise: what the paper's parameters cannot take up.
//!
//! The ideal readings with the effect, less those without it whose λ0, dead volume and initial pressures lie closest to
//! them (least squares by Gauss and Newton): the rms of the rest, Pa. Nothing of the fits is used.

use super::{Faults, Recipe};
use nalgebra::{DMatrix, DVector};

/// Steps to the closest readings; the least rest of them counts.
const STEPS: usize = 4;

/// Root mean square of what an effect leaves, Pa; `with` is `without` with the effect.
pub fn beyond_paper_pa(with: &Recipe, without: &Recipe) -> f64 {
    let goal = ideal(with);
    let mut closest = without.clone();
    let mut least_pa = f64::INFINITY;
    for _ in 0..STEPS {
        let base = ideal(&closest);
        let parameters = 2 + closest.tests.len();
        let columns: Vec<_> = (0..parameters)
            .map(|place| {
                let mut other = closest.clone();
                change(&mut other, place, SMALL);
                column(&ideal(&other), &base) / SMALL
            })
            .collect();
        let difference = column(&goal, &base);
        let (q, r) = DMatrix::from_columns(&columns).qr().unpack();
        let projected = q.transpose() * &difference;
        let rest = &difference - &q * &projected;
        least_pa = least_pa.min(rest.norm() / (rest.len() as f64).sqrt());
        let Some(step) = r.solve_upper_triangular(&projected) else { break };
        step.iter().enumerate().for_each(|(place, by)| change(&mut closest, place, by.clamp(-MOST, MOST)));
    }
    least_pa
}

/// Relative change of a derivative by differences.
const SMALL: f64 = 1e-3;
/// Largest relative change of a parameter in a step.
const MOST: f64 = 0.3;

/// Changes a parameter of the paper's model by this share of it: λ0, the dead volume, an initial pressure.
fn change(recipe: &mut Recipe, place: usize, share: f64) {
    let parameter = match place {
        0 => &mut recipe.chamber.heat_transfer.coefficient,
        1 => &mut recipe.chamber.geometry.dead_volume,
        _ => &mut recipe.tests[place - 2].pressure_pa,
    };
    *parameter *= 1.0 + share;
}

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

    #[test]
    fn what_the_papers_parameters_take_up_does_not_show_and_a_leak_does() {
        let recipe = Recipe::from_seed(4);
        let mut other = recipe.clone();
        other.chamber.heat_transfer.coefficient *= 1.01;
        other.chamber.geometry.dead_volume *= 0.99;
        let leaking = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]);
        let (taken_up, leak) = (beyond_paper_pa(&other, &recipe), beyond_paper_pa(&leaking, &recipe));
        assert!(taken_up < 5.0 && leak > 100.0, "{taken_up} {leak}");
    }
}
