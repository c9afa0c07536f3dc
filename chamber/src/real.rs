//! The generic number of the physics: one source serves plain numbers, derivatives and SIMD lanes.
//!
//! Value-dependent branches use [`Real::where_positive`], never `if`: in lanes both sides are evaluated.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number, a number with its derivatives, or several numbers side by side.
pub trait Real:
    Copy
    + Debug
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
{
    /// The number 0.
    const ZERO: Self;
    /// The number 1.
    const ONE: Self;
    /// Whether this is several numbers side by side. A function of such numbers must be inlined: compiled on its own, it would
    /// target the least capable machine.
    const WIDE: bool = false;

    /// Square root; of a negative number, NaN.
    fn sqrt(self) -> Self;
    /// e^self, to 1 ulp or better than 1e-15 relative.
    fn exp(self) -> Self;
    /// Natural logarithm of a positive number.
    fn ln(self) -> Self;
    /// Absolute value; its derivative at zero is zero.
    fn abs(self) -> Self;
    /// `yes` where self > 0, else `no`.
    fn where_positive(self, yes: Self, no: Self) -> Self;
    /// Whether self > 0 in any lane: to skip what no lane needs.
    fn any_positive(self) -> bool;
    /// Whether self is zero in all lanes and all derivatives: to skip what it multiplies.
    fn is_zero(self) -> bool;

    /// The reciprocal, 1/self.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::ONE / self
    }
    /// The larger of the two.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        (self - other).where_positive(self, other)
    }
    /// The smaller of the two.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        (self - other).where_positive(other, self)
    }
    /// self^exponent for a positive self.
    #[inline(always)]
    fn powf(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
}

/// `+=` and `-=` for a number type, from its `+` and `-`.
#[macro_export]
macro_rules! assign_operators {
    ($number:ty $(, $($generics:tt)+)?) => {
        impl$(<$($generics)+>)? core::ops::AddAssign for $number {
            #[inline(always)]
            fn add_assign(&mut self, o: Self) {
                *self = *self + o;
            }
        }
        impl$(<$($generics)+>)? core::ops::SubAssign for $number {
            #[inline(always)]
            fn sub_assign(&mut self, o: Self) {
                *self = *self - o;
            }
        }
    };
}

/// Conversion of a struct of numbers to another number type; the field after the semicolon is copied.
macro_rules! lift {
    ($name:ident: $($number:ident),+ $(; $same:ident)?) => {
        impl<R: $crate::real::Real> $name<R> {
            /// The same in another number type.
            #[inline(always)]
            pub fn lift<S: $crate::real::Real + From<R>>(self) -> $name<S> {
                $name { $($number: self.$number.into(),)+ $($same: self.$same,)? }
            }
        }
    };
}
pub(crate) use lift;

/// The reciprocal of each number with a single division; divisions dominate the cost of the balances (Montgomery's trick, Math.
/// Comp. 48 (1987) 243).
#[inline(always)]
pub fn reciprocals<R: Real, const N: usize>(numbers: [R; N]) -> [R; N] {
    let mut products = numbers;
    for i in 1..N {
        products[i] = products[i - 1] * numbers[i];
    }
    let mut rest = products[N - 1].recip();
    for i in (1..N).rev() {
        products[i] = rest * products[i - 1];
        rest = rest * numbers[i];
    }
    products[0] = rest;
    products
}

/// A [`Real`] with a single value to base decisions on (step sizes, branches of a host): not for lanes.
pub trait Scalar: Real {
    /// Number of derivatives.
    const DERIVATIVES: usize;

    /// The number without its derivatives.
    fn value(self) -> f64;
}

impl Real for f64 {
    const ZERO: f64 = 0.0;
    const ONE: f64 = 1.0;

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    #[inline(always)]
    fn ln(self) -> f64 {
        f64::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn where_positive(self, yes: f64, no: f64) -> f64 {
        if self > 0.0 { yes } else { no }
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self > 0.0
    }
    #[inline(always)]
    fn is_zero(self) -> bool {
        self == 0.0
    }
}

impl Scalar for f64 {
    const DERIVATIVES: usize = 0;

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
}
