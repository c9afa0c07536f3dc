//! How much a fit is worth: BIC of the whitened blocks.
//!
//! BIC = n ln(S/n) + k ln n, S the sum of squares of the whitened residuals with the stated numbers free within their
//! tolerances ([`Fit::marginal`]), n the number of blocks, k the free numbers. The noise's size counts as unknown: close to
//! noise, differences of BIC are those of χ²; far from it, they are relative, so that a model which misses the data's shape does not
//! make every correction decisive. Source: G. Schwarz, Ann. Stat. 6 (1978) 461.
//!
//! The model follows the recorded stroke, noise and all. What smears or shifts a record smooths that noise too, and would be
//! found in many a recording without it: what it may gain in that way does not count ([`Fit::smoothed`]).

use crate::fit::Fit;

/// BIC of a fit.
pub fn bic(fit: &Fit) -> f64 {
    of_squares(fit.marginal + fit.smoothed, fit.blocks, fit.freedom())
}

/// The same with tolerances so many times as wide.
pub fn bic_widened(fit: &Fit, factor: f64) -> f64 {
    of_squares(fit.marginal_widened(factor) + fit.smoothed, fit.blocks, fit.freedom())
}

/// BIC of so many whitened blocks' sum of squares with that number of free parameters.
pub fn of_squares(squares: f64, blocks: usize, free: usize) -> f64 {
    let n = blocks as f64;
    n * (squares.max(f64::MIN_POSITIVE) / n).ln() + free as f64 * n.ln()
}
