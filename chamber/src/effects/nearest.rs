//! First of several values between two limits, for a step that meets the corners of an effect.

use crate::real::Real;

/// `value` if it lies between `from` and `to`, else `to`.
#[inline(always)]
pub fn nearer<R: Real>(value: R, from: R, to: R) -> R {
    ((value - from) * (to - value)).where_positive(value, to)
}

/// First of these values after `from` and before `to`; `to` if there is none.
#[inline(always)]
pub fn nearest<R: Real>(places: &[R], from: R, to: R) -> R {
    let mut first = to;
    for place in places {
        first = nearer(*place, from, first);
    }
    first
}
