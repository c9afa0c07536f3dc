//! Evidence of a fit: BIC of the whitened blocks.
//!
//! BIC = n ln(S/n) + k ln n, S the sum of squares of the whitened residuals with the stated parameters free within their
//! tolerances ([`Fit::marginal`]), n the number of blocks, k the number of free parameters. The noise level counts as unknown:
//! near the noise, differences of BIC are those of χ²; far above it they are relative, so that a model that misses the shape of
//! the data does not make every correction decisive. Source: G. Schwarz, Ann. Stat. 6 (1978) 461.
//!
//! The model follows the recorded stroke including its noise. Effects that smear or shift a record smooth that noise too, and
//! would be found in many recordings without being there: what they may gain in this way does not count ([`Fit::smoothed`]).

use crate::fit::Fit;

/// BIC of a fit.
pub fn bic(fit: &Fit) -> f64 {
    of_squares(fit.marginal + fit.smoothed, fit.blocks, fit.freedom())
}

/// The same with the tolerances multiplied by `factor`.
pub fn bic_widened(fit: &Fit, factor: f64) -> f64 {
    of_squares(fit.marginal_widened(factor) + fit.smoothed, fit.blocks, fit.freedom())
}

/// BIC of a fit whose n blocks tell as much as n/c independent ones, c being the design effect: (n/c) ln(S/n) + k ln(n/c).
pub fn bic_of_correlated(fit: &Fit, design_effect: f64) -> f64 {
    let (squares, free) = (fit.marginal + fit.smoothed, fit.freedom());
    let independent = fit.blocks as f64 / design_effect;
    of_squares(squares, fit.blocks, 0) / design_effect + free as f64 * independent.ln()
}

/// BIC of this sum of squares of whitened blocks, for this number of free parameters.
pub fn of_squares(squares: f64, blocks: usize, free: usize) -> f64 {
    let n = blocks as f64;
    n * (squares.max(f64::MIN_POSITIVE) / n).ln() + free as f64 * n.ln()
}
