//! The curve of an empirical term: value, slope and knots.

use super::table::{FIRST_KNOT, FIRST_VALUE, KNOTS, PARAMETERS};
use crate::effects::nearest::nearest;
use crate::real::Real;

/// Value and slope at x.
#[inline(always)]
pub fn curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    if R::WIDE { inlined_curve(p, x) } else { called_curve(p, x) }
}

/// One shared function: inlined into every hook of every integrator, it would be as much code as all other effects.
#[inline(never)]
fn called_curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    inlined_curve(p, x)
}

/// Evaluates only the piece that contains x: its division costs as much as the search. The search always runs over all knots:
/// branch prediction would miss an early exit each time.
#[inline(always)]
fn inlined_curve<R: Real>(p: &[R], x: R) -> [R; 2] {
    let (knots, values) = (&p[FIRST_KNOT..FIRST_VALUE], &p[FIRST_VALUE..PARAMETERS]);
    // Knots and values at the start and end of that piece.
    let (mut from, mut to) = (knots[0], knots[0]);
    let (mut begin, mut end) = (values[0], values[0]);
    let mut open = R::ONE;
    for k in 1..KNOTS {
        // The first knot not above the one before it ends the table.
        open = open.min(knots[k] - knots[k - 1]).min(x - knots[k - 1]);
        from = open.where_positive(knots[k - 1], from);
        to = open.where_positive(knots[k], to);
        begin = open.where_positive(values[k - 1], begin);
        end = open.where_positive(values[k], end);
    }
    // Below the first knot there is no piece: both ends are that knot, and the value is the first.
    let inside = (to - from).min(to - x);
    let steepness = (end - begin) / inside.where_positive(to - from, R::ONE);
    [inside.where_positive(begin + steepness * (x - from), end), inside.where_positive(steepness, R::ZERO)]
}

/// The first knot after `from` and before `to` where `counts` is positive; else `to`.
#[inline(always)]
pub fn first_knot<R: Real>(p: &[R], counts: R, from: R, to: R) -> R {
    if !counts.any_positive() {
        return to;
    }
    counts.where_positive(nearest(&p[FIRST_KNOT..FIRST_VALUE], from, to), to)
}
