//! Assessment of a fit: evidence, error on left-out data, remaining misfit, contradictions that only a fit shows.

pub(crate) mod adequacy;
pub(crate) mod evidence;
pub(crate) mod left_out;
pub mod misfit;
pub(crate) mod sanity;
pub(crate) mod test_dependence;
