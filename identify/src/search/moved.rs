//! Moves of a stated parameter within its tolerance that the records favour: when the search is repeated with it moved, and which
//! result counts. The parameters are the gas's heat capacity ratio (`in_gas`) and the position zero (`at_zero`).

use super::Found;
use crate::error::Error;
use crate::fit::Fit;
use crate::judge::evidence;
use crate::parameters::Slot;
use crate::policy;
use crate::record::data::Data;

/// Move of a stated parameter, in tolerances, where a fit has decisive evidence of it and it is no contradiction.
pub(super) fn favoured_move(fit: &Fit, slot: Slot) -> Option<f64> {
    let (tolerances, left) = fit.favoured_move(slot)?;
    let bic = |squares| evidence::of_squares(squares, fit.blocks, 0);
    (bic(left) - bic(fit.marginal) > policy::DECISIVE && tolerances.abs() < policy::TOLERANCES).then_some(tolerances)
}

/// Returns the result with the parameter moved, unless it failed or the first one is likelier.
pub(super) fn which_counts(first: (Data, Found), moved: Result<(Data, Found), Error>) -> (Data, Found) {
    moved.ok().filter(|(_, there)| !is_likelier(&first.1, there)).unwrap_or(first)
}

/// Whether the set found first has decisively more evidence with the parameter moved, too, than what was found there: it may only
/// have become too small to matter.
pub(super) fn is_likelier(found: &Found, there: &Found) -> bool {
    let same = there.tried.iter().find(|c| c.model == found.reported().model);
    same.is_some_and(|same| same.delta_bic > there.reported().delta_bic + policy::DECISIVE)
}
