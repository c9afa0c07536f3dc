//! Numbers that carry their derivatives along (forward mode), for exact sensitivities.
//!
//! Convention at a kink: [`Real::where_positive`] follows the branch of the value, so at the kink itself the derivative is that
//! of the non-positive side; |x| has derivative 0 at 0.

use crate::assign_operators;
use crate::real::{Real, Scalar};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Largest number of derivatives.
const MOST: usize = 12;

/// Evaluates an expression for each derivative, unrolled: a loop per operation would become thousands of loops in an integrator
/// compiled for these numbers and slow the compiler down many times.
macro_rules! each_derivative {
    ($i:ident => $value:expr) => {{
        const { assert!(N <= MOST) };
        let mut out = [0.0; N];
        each_derivative!(out, $i => $value; 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11);
        out
    }};
    ($out:ident, $i:ident => $value:expr; $($index:literal),*) => {
        $(if const { $index < N } {
            let $i: usize = $index;
            $out[$i] = $value;
        })*
    };
}

/// A value and its derivatives with respect to `N` parameters, twelve at the most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// What the same calculation with plain numbers gives.
    pub value: f64,
    /// Derivatives with respect to the N independent variables.
    pub tangent: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The `index`-th independent variable, whose derivative with respect to itself is one.
    #[inline(always)]
    pub fn variable(value: f64, index: usize) -> Self {
        let mut tangent = [0.0; N];
        tangent[index] = 1.0;
        Self { value, tangent }
    }

    /// f(self) with the outer derivative f′.
    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, tangent: each_derivative!(i => slope * self.tangent[i]) }
    }

    /// f(self, other) with both partial derivatives.
    #[inline(always)]
    fn chain2(self, other: Self, value: f64, by_self: f64, by_other: f64) -> Self {
        let tangent = each_derivative!(i => by_self * self.tangent[i] + by_other * other.tangent[i]);
        Self { value, tangent }
    }
}

impl<const N: usize> From<f64> for Dual<N> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self { value, tangent: [0.0; N] }
    }
}

/// Binary operators: the value and its derivatives with respect to both operands.
macro_rules! operators {
    ($($op:ident $method:ident: $a:ident, $b:ident => $value:expr, $by_a:expr, $by_b:expr;)*) => {$(
        impl<const N: usize> $op for Dual<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, o: Self) -> Self {
                let ($a, $b) = (self.value, o.value);
                self.chain2(o, $value, $by_a, $by_b)
            }
        }
    )*};
}
operators! {
    Add add: a, b => a + b, 1.0, 1.0;
    Sub sub: a, b => a - b, 1.0, -1.0;
    Mul mul: a, b => a * b, b, a;
    Div div: a, b => a / b, 1.0 / b, -(a / b) / b;
}
assign_operators!(Dual<N>, const N: usize);

/// Operators with a plain number: the value and its derivative.
macro_rules! operators_with_number {
    ($($op:ident $method:ident: $a:ident, $b:ident => $value:expr, $by_a:expr;)*) => {$(
        impl<const N: usize> $op<f64> for Dual<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, $b: f64) -> Self {
                let $a = self.value;
                self.chain($value, $by_a)
            }
        }
    )*};
}
operators_with_number! {
    Add add: a, b => a + b, 1.0;
    Sub sub: a, b => a - b, 1.0;
    Mul mul: a, b => a * b, b;
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Real for Dual<N> {
    const ZERO: Self = Self { value: 0.0, tangent: [0.0; N] };
    const ONE: Self = Self { value: 1.0, tangent: [0.0; N] };

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let slope = if root > 0.0 { 0.5 / root } else { 0.0 };
        self.chain(root, slope)
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let sign = if self.value > 0.0 {
            1.0
        } else if self.value < 0.0 {
            -1.0
        } else {
            0.0
        };
        self.chain(self.value.abs(), sign)
    }
    #[inline(always)]
    fn where_positive(self, yes: Self, no: Self) -> Self {
        if self.value > 0.0 { yes } else { no }
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self.value > 0.0
    }
    #[inline(always)]
    fn is_zero(self) -> bool {
        self == Self::ZERO
    }
}

impl<const N: usize> Scalar for Dual<N> {
    const DERIVATIVES: usize = N;

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn by_difference(f: impl Fn(f64) -> f64, x: f64) -> f64 {
        let h = x.abs().max(1e-3) * 1e-6;
        (f(x + h) - f(x - h)) / (2.0 * h)
    }

    fn formula<R: Real>(x: R) -> R {
        ((x * x + 1.0).sqrt() / (x + 3.0)).ln().exp() * x.abs() - x.powf(R::from(0.3)).max(x * 0.5) + (-x).min(x)
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_central_differences(x in 0.1..9.0f64) {
            let dual = formula(Dual::<1>::variable(x, 0));
            prop_assert!((dual.value - formula(x)).abs() < 1e-13);
            prop_assert!((dual.tangent[0] - by_difference(formula, x)).abs() < 1e-6);
        }
    }
}
