//! Taylor series truncated after K coefficients, as a number type: equations applied to the series of their states give the series of
//! the rates, which yield one more coefficient of the states (R. E. Moore, Methods and Applications of Interval Analysis, 1979, 3.4).
//!
//! Branches of a law are chosen by the value at another place, which each series carries along: a step that begins or ends at a corner
//! of the law lies on one side of it.

use crate::lanes::Lanes;
use chamber::real::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Coefficients of the powers from 0 to K − 1, by lane, and the value that chooses branches.
#[derive(Clone, Copy, Debug)]
pub struct Series<const K: usize> {
    /// In ascending powers.
    pub coefficients: [Lanes; K],
    /// Value at the place where branches are chosen.
    pub side: Lanes,
}

impl<const K: usize> From<Lanes> for Series<K> {
    /// A constant.
    #[inline(always)]
    fn from(value: Lanes) -> Self {
        let mut coefficients = [Lanes::ZERO; K];
        coefficients[0] = value;
        Self { coefficients, side: value }
    }
}

impl<const K: usize> From<f64> for Series<K> {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::from(Lanes::from(value))
    }
}

impl<const K: usize> Series<K> {
    /// Σ a_j b_(k−j) over j from `first` to `last`.
    #[inline(always)]
    fn product(a: &[Lanes; K], b: &[Lanes; K], k: usize, first: usize, last: usize) -> Lanes {
        let mut sum = Lanes::ZERO;
        let mut j = first;
        while j <= last {
            sum += a[j] * b[k - j];
            j += 1;
        }
        sum
    }

    /// (Σ j a_j b_(k−j))/k over j from 1 to `last`: the recursion for functions defined by their derivative.
    #[inline(always)]
    fn moment(a: &[Lanes; K], b: &[Lanes; K], k: usize, last: usize) -> Lanes {
        let mut sum = Lanes::ZERO;
        let mut j = 1;
        while j <= last {
            sum += a[j] * b[k - j] * j as f64;
            j += 1;
        }
        sum * (1.0 / k as f64)
    }
}

macro_rules! term_by_term {
    ($($op:ident $method:ident $assign:tt),*) => {$(
        impl<const K: usize> $op for Series<K> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, o: Self) -> Self {
                for k in 0..K {
                    self.coefficients[k] $assign o.coefficients[k];
                }
                self.side $assign o.side;
                self
            }
        }
    )*};
}
term_by_term![Add add +=, Sub sub -=];
chamber::assign_operators!(Series<K>, const K: usize);

impl<const K: usize> Mul for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        let mut out = self;
        for k in 0..K {
            out.coefficients[k] = Self::product(&self.coefficients, &o.coefficients, k, 0, k);
        }
        out.side = self.side * o.side;
        out
    }
}
impl<const K: usize> Div for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn div(self, o: Self) -> Self {
        let (mut out, per) = (self, o.coefficients[0].recip());
        for k in 0..K {
            let rest =
                if k == 0 { Lanes::ZERO } else { Self::product(&out.coefficients, &o.coefficients, k, 0, k - 1) };
            out.coefficients[k] = (self.coefficients[k] - rest) * per;
        }
        out.side = self.side / o.side;
        out
    }
}
impl<const K: usize> Neg for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}
impl<const K: usize> Mul<f64> for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, o: f64) -> Self {
        for k in 0..K {
            self.coefficients[k] = self.coefficients[k] * o;
        }
        self.side = self.side * o;
        self
    }
}
impl<const K: usize> Add<f64> for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, o: f64) -> Self {
        self.coefficients[0] = self.coefficients[0] + o;
        self.side = self.side + o;
        self
    }
}
impl<const K: usize> Sub<f64> for Series<K> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: f64) -> Self {
        self + -o
    }
}

impl<const K: usize> Real for Series<K> {
    const ZERO: Self = Self { coefficients: [Lanes::ZERO; K], side: Lanes::ZERO };
    const ONE: Self = {
        let mut coefficients = [Lanes::ZERO; K];
        coefficients[0] = Lanes::ONE;
        Self { coefficients, side: Lanes::ONE }
    };
    const WIDE: bool = true;

    #[inline(always)]
    fn sqrt(self) -> Self {
        let mut out = self;
        out.coefficients[0] = self.coefficients[0].sqrt();
        out.side = self.side.sqrt();
        if K > 1 {
            let half = (out.coefficients[0] + out.coefficients[0]).recip();
            for k in 1..K {
                let crossed = Self::product(&out.coefficients, &out.coefficients, k, 1, k - 1);
                out.coefficients[k] = (self.coefficients[k] - crossed) * half;
            }
        }
        out
    }
    #[inline(always)]
    fn exp(self) -> Self {
        let mut out = self;
        out.coefficients[0] = self.coefficients[0].exp();
        out.side = self.side.exp();
        for k in 1..K {
            out.coefficients[k] = Self::moment(&self.coefficients, &out.coefficients, k, k);
        }
        out
    }
    #[inline(always)]
    fn ln(self) -> Self {
        let (mut out, per) = (self, self.coefficients[0].recip());
        out.coefficients[0] = self.coefficients[0].ln();
        out.side = self.side.ln();
        for k in 1..K {
            let crossed = Self::moment(&out.coefficients, &self.coefficients, k, k - 1);
            out.coefficients[k] = (self.coefficients[k] - crossed) * per;
        }
        out
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.where_positive(self, -self)
    }
    #[inline(always)]
    fn where_positive(self, mut yes: Self, no: Self) -> Self {
        for k in 0..K {
            yes.coefficients[k] = self.side.where_positive(yes.coefficients[k], no.coefficients[k]);
        }
        yes.side = self.side.where_positive(yes.side, no.side);
        yes
    }
    #[inline(always)]
    fn any_positive(self) -> bool {
        self.side.any_positive()
    }
    #[inline(always)]
    fn is_zero(self) -> bool {
        self.side.is_zero() && self.coefficients.iter().all(|c| c.is_zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the formula at places near to 1 by its series there are those of the formula.
    #[test]
    fn a_series_goes_where_its_formula_does() {
        fn formula<R: Real>(x: R) -> R {
            let bent = (x * x + 3.0).sqrt() / (x - 4.0) - (x * 0.5).exp() * x.ln();
            (bent * -1.0).abs() + (x + 1.0).powf(R::from(0.3)).recip()
        }
        let x = Series::<3> { coefficients: [1.0, 1.0, 0.0].map(Lanes::from), side: Lanes::from(1.1) };
        let [a, b, c] = formula(x).coefficients.map(|c| c[5]);
        for h in [-1e-3, 2e-3] {
            let error = a + h * (b + h * c) - formula(1.0 + h);
            assert!(error.abs() < 1.0 * h.abs().powi(3), "{h}: {error:e}");
        }
        assert_eq!(formula(x).side[5], formula(1.1));
    }

    #[test]
    fn branches_are_chosen_at_the_side() {
        let x = Series::<2> { coefficients: [1.0, 1.0].map(Lanes::from), side: Lanes::from(-1.0) };
        let [value, slope] = x.max(Series::ZERO).coefficients;
        assert_eq!((value[0], slope[0]), (0.0, 0.0));
        let [value, slope] = x.abs().coefficients;
        assert_eq!((value[0], slope[0]), (-1.0, -1.0));
    }
}
