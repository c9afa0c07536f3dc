//! A stated number that the records ask for elsewhere within its tolerance: when all is searched again with it moved, and which search
//! counts. The numbers are the gas's heat capacity ratio (`in_gas`) and the zero of the positions (`at_zero`).

use super::Found;
use crate::error::Error;
use crate::fit::Fit;
use crate::judge::evidence;
use crate::parameters::Slot;
use crate::policy;
use crate::record::data::Data;

/// How many tolerances a stated number is off, where a fit has decisive evidence of it and it is no contradiction.
pub(super) fn asked(fit: &Fit, slot: Slot) -> Option<f64> {
    let (tolerances, left) = fit.asked(slot)?;
    let bic = |squares| evidence::of_squares(squares, fit.blocks, 0);
    (bic(left) - bic(fit.marginal) > policy::DECISIVE && tolerances.abs() < policy::TOLERANCES).then_some(tolerances)
}

/// What counts of a search and of that with the number moved.
pub(super) fn which_counts(first: (Data, Found), moved: Result<(Data, Found), Error>) -> (Data, Found) {
    moved.ok().filter(|(_, there)| !is_likelier(&first.1, there)).unwrap_or(first)
}

/// Whether the set that was found has decisively more evidence than what was found with the number moved: it may only have become too
/// small to be minded there.
pub(super) fn is_likelier(found: &Found, there: &Found) -> bool {
    let same = there.tried.iter().find(|c| c.model == found.reported().model);
    same.is_some_and(|same| same.delta_bic > there.reported().delta_bic + policy::DECISIVE)
}
