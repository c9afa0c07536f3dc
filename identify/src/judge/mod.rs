//! How much a fit is worth: evidence, the error on data left out, what remains, contradictions that only a fit shows.

pub mod adequacy;
pub mod evidence;
pub mod kinds;
pub mod left_out;
pub mod misfit;
pub mod sanity;
