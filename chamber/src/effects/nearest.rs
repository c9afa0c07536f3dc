//! First of several values between two limits, for a step that meets the kinks of an effect.

use crate::real::Real;

/// `value` if it lies between `from` and `to`, else `to`.
#[inline(always)]
pub fn nearer<R: Real>(value: R, from: R, to: R) -> R {
    ((value - from) * (to - value)).where_positive(value, to)
}

/// First of these values after `from` and before `to`; `to` if there is none.
#[inline(always)]
pub fn nearest<R: Real>(values: &[R], from: R, to: R) -> R {
    let mut first = to;
    for value in values {
        first = nearer(*value, from, first);
    }
    first
}
