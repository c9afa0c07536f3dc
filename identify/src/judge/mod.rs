//! How much a fit is worth: evidence, the error on data left out, what remains, contradictions that only a fit shows.

pub(crate) mod adequacy;
pub(crate) mod evidence;
pub(crate) mod kinds;
pub(crate) mod left_out;
pub mod misfit;
pub(crate) mod sanity;
