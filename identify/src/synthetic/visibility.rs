//! How far an effect shows, before any noise: what the paper's parameters cannot take up, to first order.
//!
//! The difference that an effect makes to the ideal readings, less its projection on the changes that λ0, the dead
//! volume and each record's initial pressure make: the rms of the rest, Pa. Nothing of the fits is used.

use super::{Faults, Recipe};
use nalgebra::{DMatrix, DVector};

/// Root mean square of what an effect leaves, Pa; `with` is `without` with the effect.
pub fn beyond_paper_pa(with: &Recipe, without: &Recipe) -> f64 {
    let base = ideal(without);
    let changed = |change: &dyn Fn(&mut Recipe)| {
        let mut other = without.clone();
        change(&mut other);
        column(&ideal(&other), &base)
    };
    let mut columns = vec![
        changed(&|r| r.chamber.heat_transfer.coefficient *= 1.001),
        changed(&|r| r.chamber.geometry.dead_volume *= 1.001),
    ];
    for k in 0..without.tests.len() {
        columns.push(changed(&|r| r.tests[k].pressure_pa *= 1.0001));
    }
    let difference = column(&ideal(with), &base);
    let q = DMatrix::from_columns(&columns).qr().q();
    let rest = &difference - &q * (q.transpose() * &difference);
    rest.norm() / (rest.len() as f64).sqrt()
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
