//! Lanes as numbers for the chamber's equations.

use crate::lanes::math;
use crate::lanes::{Lanes, WIDTH, each_lane};
use chamber::real::Real;

/// Whether a condition holds in any lane; without branches, so that all lanes are compared at once.
macro_rules! any_lane {
    ($i:ident => $condition:expr) => {
        any_lane!($i => $condition; 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
    };
    ($i:ident => $condition:expr; $($lane:literal),*) => {
        false $(| {
            let $i: usize = $lane;
            $condition
        })*
    };
}

impl Real for Lanes {
    const ZERO: Self = Self([0.0; WIDTH]);
    const ONE: Self = Self([1.0; WIDTH]);
    const WIDE: bool = true;

    #[inline(always)]
    fn sqrt(self) -> Self {
        each_lane!(i => f64::sqrt(self.0[i]))
    }
    #[inline(always)]
    fn exp(self) -> Self {
        math::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        math::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        each_lane!(i => f64::abs(self.0[i]))
    }
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        each_lane!(i => if self.0[i] > o.0[i] { self.0[i] } else { o.0[i] })
    }
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        each_lane!(i => if self.0[i] > o.0[i] { o.0[i] } else { self.0[i] })
    }
    #[inline(always)]
    fn where_positive(self, yes: Self, no: Self) -> Self {
        each_lane!(i => if self.0[i] > 0.0 { yes.0[i] } else { no.0[i] })
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        any_lane!(i => self.0[i] > 0.0)
    }
    #[inline(always)]
    fn is_zero(self) -> bool {
        !any_lane!(i => self.0[i] != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_lane_equals_the_plain_number(x in prop::array::uniform::<_, WIDTH>(1e-3..1e3f64), y in 1e-3..1e3f64) {
            let (a, b) = (Lanes(x), Lanes::from(y));
            let all = (a * b + a / b - a.sqrt()).max(b).where_positive(a.abs(), -b);
            for i in 0..WIDTH {
                let plain = (x[i] * y + x[i] / y - x[i].sqrt()).max(y).where_positive(x[i].abs(), -y);
                prop_assert_eq!(all[i].to_bits(), plain.to_bits());
                prop_assert!((a.ln()[i] - x[i].ln()).abs() <= 4e-16 * x[i].ln().abs().max(1.0));
                prop_assert!((a.ln().exp()[i] / x[i] - 1.0).abs() < 4e-15);
            }
        }
    }
}
