//! The nearest of several places between two, as a step meets the corners of an effect.

use crate::real::Real;

/// `value` where it lies between the two, else `to`.
#[inline(always)]
pub fn nearer<R: Real>(value: R, from: R, to: R) -> R {
    ((value - from) * (to - value)).where_positive(value, to)
}

/// The first of these after `from` and before `to`; the latter where there is none.
#[inline(always)]
pub fn nearest<R: Real>(places: &[R], from: R, to: R) -> R {
    let mut first = to;
    for place in places {
        first = nearer(*place, from, first);
    }
    first
}
