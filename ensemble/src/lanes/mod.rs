//! Arrays of numbers in a form that the compiler turns into SIMD instructions of the width that the enclosing function may use (AVX-512,
//! AVX2, NEON, SSE2).

pub(crate) mod math;
mod real;

use core::ops::{Add, Div, Index, IndexMut, Mul, Neg, Sub};

/// Number of lanes in [`Lanes`].
pub const WIDTH: usize = 16;

/// [`WIDTH`] numbers that undergo the same operations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; WIDTH]);

/// Evaluates an expression for each lane, unrolled: a loop in each operation would become thousands of loops in a function of the
/// kernel, which the compiler takes minutes to unroll. Not a closure either: closures are not inlined into a function with more
/// target features than the crate's, and would stay scalar there.
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

/// Loads fields of one system, given by name, into a lane.
macro_rules! put {
    ($to:expr, $lane:expr, $from:expr; $($($name:ident).+),+ $(,)?) => {
        $($to.$($name).+[$lane] = $from.$($name).+;)+
    };
}
pub(crate) use put;

/// a b + c, rounded once if `FUSED`: only for machines with the instruction, as it is a slow call elsewhere.
#[inline(always)]
pub fn multiply_add<const FUSED: bool>(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    if FUSED { each_lane!(i => a.0[i].mul_add(b.0[i], c.0[i])) } else { a * b + c }
}

impl Lanes {
    /// Computes each lane from its index.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        let mut out = Self([0.0; WIDTH]);
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
chamber::assign_operators!(Lanes);
