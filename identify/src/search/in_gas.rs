//! Repeats the search in the gas that the records favour.
//!
//! The heat capacity ratio stays as stated in every fit; only for the evidence does it move within its tolerance, to first order.
//! Moist air differs from dry air by a tolerance or more, which matters with quiet records: at the stated ratio a leak that the
//! records show may be fitted as zero, parameters are biased, and even the right effects predict left-out data badly. Where the
//! result leaves only noise and its ratio has decisive evidence, the search is therefore repeated in the gas with that ratio. The
//! prior stays at the stated value.

use super::{Found, at_zero, moved};
use crate::error::Error;
use crate::parameters::Slot;
use crate::record::data::Data;

/// Searches in the stated gas, and again in another one where the records favour it; returns the result that counts.
///
/// # Errors
/// As [`at_zero::search`].
pub(super) fn search(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    let (data, found) = at_zero::search(data, progress)?;
    let Some(tolerances) = favoured_move(&found) else { return Ok((data, found)) };
    let again = |what: &str, share: f64| progress(&format!("{what}, in the gas that the records ask for"), share);
    let elsewhere = at_zero::search(data.clone().in_gas_moved(tolerances), &again);
    Ok(moved::which_counts((data, found), elsewhere))
}

/// Move of the gas, in tolerances, where the result leaves only noise and little doubt of the move.
fn favoured_move(found: &Found) -> Option<f64> {
    found.adequacy().is_noise.then(|| moved::favoured_move(&found.reported().fit, Slot::HeatCapacityRatio))?
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::covariance;
    use crate::search::{Verdict, baseline};
    use crate::synthetic::Recipe;
    use chamber::effects::EffectSet;

    /// A quiet rig whose stated gas is off by this many tolerances.
    fn in_gas_off_by(tolerances: f64) -> Recipe {
        let mut recipe = Recipe { repeats: 1, noise_pa: 15.0, ..Recipe::from_seed(5) };
        recipe.faults.stated.heat_capacity_ratio_times = 1.0 + 5e-4 * tolerances;
        recipe
    }

    fn found_of(recipe: &Recipe) -> (Data, Found) {
        search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap()
    }

    #[test]
    fn a_gas_as_stated_is_kept() {
        let (data, found) = found_of(&in_gas_off_by(0.0));
        assert_eq!(data.gas_moved, 0.0);
        assert_eq!(found.reported().model.effects, EffectSet::NONE);
    }

    #[test]
    fn parameters_are_those_in_the_gas_that_the_records_favour() {
        let leaky = |tolerances: f64| {
            let recipe = in_gas_off_by(tolerances);
            let (data, found) = found_of(&recipe.clone().with("leakage", &[recipe.leak_of(0.3)]));
            let chamber = found.reported().fit.chamber();
            (data.gas_moved, chamber.heat_transfer.coefficient)
        };
        let [(_, right), (moved, off)] = [0.0, 1.5].map(leaky);
        assert!((moved + 1.5).abs() < 0.1, "{moved}");
        assert!((off / right - 1.0).abs() < 2e-3, "{off} {right}");
    }

    #[test]
    fn a_set_that_has_decisively_more_evidence_in_the_other_gas_too_is_kept() {
        let recipe = in_gas_off_by(0.0);
        let (_, found) = found_of(&recipe.clone().with("leakage", &[recipe.leak_of(1.0)]));
        // There the paper's model is reported.
        let there = Found { verdict: Verdict::Unexplained, ..found.clone() };
        assert!(moved::is_likelier(&found, &there) && !moved::is_likelier(&found, &found));
    }

    #[test]
    fn the_gas_has_its_whole_tolerance_until_it_is_moved_to_where_the_records_favour_it() {
        let data = Data::prepare(&in_gas_off_by(1.5).rig()).unwrap();
        let variance_by_gas = |tolerances: f64| {
            let (_, fit) = baseline::fitted(data.clone().in_gas_moved(tolerances)).unwrap();
            let share = |(name, share): (String, f64)| (name == "heat_capacity_ratio").then_some(share);
            let share = covariance::budget(&fit, 0, true).into_iter().find_map(share).unwrap();
            share * covariance::covariance(&fit, true)[(0, 0)]
        };
        let [stated, moved] = [0.0, -1.5].map(variance_by_gas);
        assert!(moved < 0.1 * stated, "{moved:e} {stated:e}");
        // A tolerance of γ moves ln λ0 by about this in a fit.
        let by_tolerance = |moved: f64| baseline::fitted(data.clone().in_gas_moved(moved)).unwrap().1.rig[0];
        let slope = by_tolerance(0.5) - by_tolerance(-0.5);
        assert!((stated.sqrt() / slope.abs() - 1.0).abs() < 0.2, "{} {slope}", stated.sqrt());
    }

    #[test]
    fn evidence_is_the_same_wherever_in_its_tolerance_the_gas_is_put() {
        let data = Data::prepare(&in_gas_off_by(1.0).rig()).unwrap();
        let least = |tolerances: f64| {
            let (_, fit) = baseline::fitted(data.clone().in_gas_moved(tolerances)).unwrap();
            fit.marginal
        };
        let [stated, moved] = [0.0, -1.0].map(least);
        assert!((moved - stated).abs() < 0.2, "{moved} {stated}");
    }
}
