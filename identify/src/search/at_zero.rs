//! Repeats the search with the position zero that the records favour, where the dead volume is known.
//!
//! The zero stays as stated in every fit; only for the evidence does it move within its tolerance, to first order. What this
//! leaves of an offset of a millimetre near the end of the chamber is many times the noise of quiet records, and an effect takes
//! it up (`tube_volume`). Where the reported model, or that without one of its terms, favours another zero with decisive
//! evidence, the search is therefore repeated with the dead volume counted from there. The zero's prior stays at the stated
//! value. An unknown dead volume is free and contains the zero.

use super::{Candidate, Found, moved, search_as_stated, terms};
use crate::error::Error;
use crate::parameters::Slot;
use crate::record::data::Data;

/// Searches with the zero as stated, and again with another one where the records favour it; returns the result that counts.
///
/// # Errors
/// As [`search_as_stated`].
pub(super) fn search(data: Data, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<(Data, Found), Error> {
    let (data, found) = search_as_stated(data, progress)?;
    let Some(tolerances) = favoured_move(&found) else { return Ok((data, found)) };
    let again = |what: &str, share: f64| progress(&format!("{what}, with the positions' zero moved"), share);
    let elsewhere = search_as_stated(data.clone().with_zero_moved(tolerances), &again);
    Ok(moved::which_counts((data, found), elsewhere))
}

/// Move of the zero, in tolerances, where the records leave little doubt of it.
fn favoured_move(found: &Found) -> Option<f64> {
    let reported = &found.reported().model;
    let is_near = |c: &&Candidate| terms::is_part(&c.model, reported) && c.model.terms() + 1 >= reported.terms();
    let near = found.tried.iter().chain([&found.baseline, found.reported()]).filter(is_near);
    let favoured = near.filter_map(|c| Some((c.delta_bic, moved::favoured_move(&c.fit, Slot::PositionZero)?)));
    favoured.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, tolerances)| tolerances)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::Verdict;
    use crate::synthetic::Recipe;
    use chamber::effects::EffectSet;
    use records::DeadVolume;

    #[test]
    fn positions_that_are_off_within_their_tolerance_are_no_effect_where_the_dead_volume_is_known() {
        for off_m in [0.0, 9e-4, -9e-4] {
            let recipe = Recipe { repeats: 2, noise_pa: 100.0, ..Recipe::from_seed(5) };
            let mut rig = recipe.rig();
            let known_m3 = recipe.chamber.geometry.dead_volume;
            rig.dead_volume = Some(DeadVolume { value_m3: known_m3, known: true });
            let positions = rig.experiments.iter_mut().flat_map(|e| &mut e.traces).flat_map(|t| &mut t.position_m);
            positions.for_each(|x| *x += off_m);
            let (data, found) = search(Data::prepare(&rig).unwrap(), &|_, _| ()).unwrap();
            let reported = found.reported();
            assert_eq!((found.verdict, reported.model.effects), (Verdict::Adequate, EffectSet::NONE), "{off_m}");
            let zero_m3 = recipe.chamber.geometry.piston_area * off_m;
            assert!((data.dead_volume_m3 - (known_m3 - zero_m3)).abs() <= 0.1 * zero_m3.abs(), "{off_m}");
            let lambda0 = reported.fit.chamber().heat_transfer.coefficient;
            assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.01, "{off_m}: {lambda0}");
        }
    }
}
