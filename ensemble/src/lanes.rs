//! Several numbers side by side, in a form that the compiler turns into SIMD instructions of whatever width the
//! enclosing function may use (AVX-512, AVX2, NEON, SSE2).

use crate::math;
use chamber::real::Real;
use core::ops::{Add, AddAssign, Div, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// How many numbers stand side by side in [`Lanes`].
pub const WIDTH: usize = 16;

/// [`WIDTH`] numbers that go through the same operations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

/// Evaluates an expression for each lane, written out: a loop in each operation would become thousands of loops in a function
/// of the kernel, which the compiler takes minutes to unroll. No closure either: what closures compile to is not inlined into a
/// function with more instructions than the crate's, and would stay scalar there.
macro_rules! each_lane {
    ($i:ident => $value:expr) => {
        each_lane!($i => $value; 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
    };
    ($i:ident => $value:expr; $($lane:literal),*) => {
        Lanes([$({
            let $i: usize = $lane;
            $value
        }),*])
    };
}
pub(crate) use each_lane;

/// Whether a condition holds in any lane: without branches, so that all lanes are compared at once.
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

impl Lanes {
    /// One number per lane, made from the lane's index.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        let mut out = Self::ZERO;
        let mut lane = 0;
        while lane < WIDTH {
            out[lane] = f(lane);
            lane += 1;
        }
        out
    }
}

impl From<f64> for Lanes {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self([value; WIDTH])
    }
}

impl Index<usize> for Lanes {
    type Output = f64;
    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}
impl IndexMut<usize> for Lanes {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}

macro_rules! lanewise {
    ($($op:ident $method:ident $symbol:tt),*) => {$(
        impl $op for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                each_lane!(i => self.0[i] $symbol o.0[i])
            }
        }
    )*};
}
lanewise![Add add +, Sub sub -, Mul mul *, Div div /];

macro_rules! lanes_with_number {
    ($($op:ident $method:ident $symbol:tt),*) => {$(
        impl $op<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: f64) -> Self {
                each_lane!(i => self.0[i] $symbol o)
            }
        }
    )*};
}
lanes_with_number![Add add +, Sub sub -, Mul mul *];

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        each_lane!(i => -self.0[i])
    }
}
impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
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
