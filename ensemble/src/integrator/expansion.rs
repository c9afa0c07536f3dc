//! Steps by the Taylor series of the solution, for systems whose equations give its coefficients recursively. In x, the time since the
//! start of the step over a time scale u of the system, a step h uses
//!
//! P = Σ y_j x^j,  j from 0 to K,  h/u = min over j = K − 1 and K of (tolerance · |y|/|y_j|)^(1/j)
//!
//! so that neither of the last two terms exceeds the tolerance: two terms, as one may vanish, and before the step, so that none is
//! rejected (À. Jorba and M. Zou, Experimental Mathematics 14 (2005) 99). The truncation error is a fraction of that. A step is also
//! limited to a few decay times of the fastest motion.
//!
//! The first state is the energy of the gas over its heat capacity. The heat received is computed independently, as the integral of the
//! polynomial with the Taylor coefficients of its rate at the start of the step, except for the last, and with the rate f at its end:
//!
//! P(h) − P(0) − (P'(h) − f) h/K
//!
//! so that the energy balance shows the residual of P in the equation.

use crate::lanes::{Lanes, each_lane, multiply_add};
use chamber::real::Real;

/// K. With more coefficients steps would be too long for the polynomials of degree 7 through their ends.
pub const ORDER: usize = 12;
/// Number of coefficients.
pub const TERMS: usize = ORDER + 1;

/// Largest step, in decay times. Keeps a decayed motion decayed: over such a step the polynomial leaves about a tenth of it, whereas
/// longer ones would leave as much as the tolerance allows, which would show in the energy balance at each step.
const FADES: f64 = 4.5;

/// The series of N states.
pub struct Expansion<const N: usize> {
    /// Coefficients in rising powers of x, by state.
    pub terms: [[Lanes; TERMS]; N],
    /// Decay rate of the fastest motion, times u.
    pub decay: Lanes,
    /// u, s, and 1/u, 1/s.
    pub unit: Lanes,
    pub per_unit: Lanes,
}

/// The result of a step.
pub struct Stride<const N: usize> {
    /// States at its end.
    pub end: [Lanes; N],
    /// Rate of the first state at its end, by the series, times the length of the step.
    pub rise: Lanes,
}

impl<const N: usize> Expansion<N> {
    /// The longest step for a relative tolerance, s.
    #[inline(always)]
    pub fn reach(&self, relative: f64) -> Lanes {
        let mut doublings = -logarithm(self.decay * (1.0 / FADES));
        for i in 0..N {
            let terms = &self.terms[i];
            let size = logarithm(terms[0] * relative);
            for j in [ORDER - 1, ORDER] {
                doublings = doublings.min((size - logarithm(terms[j])) * (1.0 / j as f64));
            }
        }
        power_of_two(doublings) * self.unit
    }

    /// A step of the given length, s.
    #[inline(always)]
    pub fn stride(&self, length: Lanes) -> Stride<N> {
        let x = length * self.per_unit;
        let (mut end, mut slope) = ([Lanes::ZERO; N], Lanes::ZERO);
        for i in 0..N {
            end[i] = self.terms[i][ORDER];
        }
        macro_rules! sum {
            ($($power:literal)*) => {$(
                slope = multiply_add::<true>(slope, x, end[0]);
                for i in 0..N {
                    end[i] = multiply_add::<true>(end[i], x, self.terms[i][$power]);
                }
            )*};
        }
        sum![11 10 9 8 7 6 5 4 3 2 1 0];
        Stride { end, rise: slope * x }
    }
}

/// Shift of the bits of a number that turns them into an integer below 2^52, and what a factor of two is there.
const MOVED: u32 = 12;
const DOUBLING: f64 = (1u64 << (f64::MANTISSA_DIGITS - 1 - MOVED)) as f64;
/// 2^52, whose bits are those of its exponent alone.
const WHOLE: f64 = (1u64 << (f64::MANTISSA_DIGITS - 1)) as f64;
/// The biased exponent of 1.
const BIAS: f64 = (f64::MAX_EXP - 1) as f64;

/// lb |x| within 0.09: linear between powers of two.
#[inline(always)]
fn logarithm(x: Lanes) -> Lanes {
    let bits = each_lane!(i => f64::from_bits((x.0[i].abs().to_bits() >> MOVED) | WHOLE.to_bits()));
    (bits - WHOLE) * (1.0 / DOUBLING) - BIAS
}

/// 2^x within 7 % for |x| < 1000, the inverse of [`logarithm`].
#[inline(always)]
fn power_of_two(x: Lanes) -> Lanes {
    let bits = (x + BIAS) * DOUBLING + WHOLE;
    each_lane!(i => f64::from_bits(bits.0[i].to_bits() << MOVED))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rough_logarithms_and_powers_are_so_of_any_number(y in -900.0..900.0f64) {
            let x = Lanes::from(-y.exp2());
            let found = logarithm(x)[3];
            prop_assert!((found - y).abs() < 0.09, "{found} {y}");
            prop_assert!((power_of_two(Lanes::from(y))[7] / y.exp2() - 1.0).abs() < 0.07);
            prop_assert!((power_of_two(logarithm(x))[1] / -x[1] - 1.0).abs() < 1e-9);
        }
    }

    /// Of e^(−3 t) and e^(2 t), in the unit ½ s.
    fn exponentials() -> Expansion<2> {
        let mut terms = [[Lanes::ONE; TERMS]; 2];
        for j in 1..TERMS {
            terms[0][j] = terms[0][j - 1] * (-1.5 / j as f64);
            terms[1][j] = terms[1][j - 1] * (1.0 / j as f64);
        }
        Expansion { terms, decay: Lanes::from(1.5), unit: Lanes::from(0.5), per_unit: Lanes::from(2.0) }
    }

    #[test]
    fn a_step_keeps_the_tolerance_and_one_of_twice_the_length_would_not() {
        let series = exponentials();
        for relative in [1e-6, 1e-9, 1e-12] {
            let longest = series.reach(relative);
            let exact = |length: Lanes| [-3.0, 2.0].map(|rate: f64| (rate * length[0]).exp());
            let error = |length: Lanes| {
                let (end, exact) = (series.stride(length).end, exact(length));
                (0..2).map(|i| (end[i][0] - exact[i]).abs()).fold(0.0, f64::max)
            };
            let rise = -3.0 * longest[0] * exact(longest)[0];
            assert!((series.stride(longest).rise[0] - rise).abs() < ORDER as f64 * relative);
            let longer = error(longest * 2.0);
            assert!(error(longest) < relative && longer > relative, "{relative:e}: {:e} {longer:e}", error(longest));
        }
    }

    #[test]
    fn what_is_dead_stays_so() {
        let mut fading = exponentials();
        for j in 0..TERMS {
            fading.terms[1][j] = if j == 0 { Lanes::ONE } else { Lanes::ZERO };
            fading.terms[0][j] = fading.terms[0][j] * 1e-30;
        }
        fading.terms[0][0] = Lanes::ONE;
        let longest = fading.reach(1e-10);
        assert!((3.9..5.1).contains(&(3.0 * longest[0])), "{}", longest[0]);
        assert!((fading.stride(longest).end[0][0] - 1.0).abs() < 1e-30);
    }

    #[test]
    fn what_stands_is_left_to_stand_for_ever() {
        let mut terms = [[Lanes::ZERO; TERMS]; 1];
        terms[0][0] = Lanes::from(293.0);
        let still = Expansion { terms, decay: Lanes::ZERO, unit: Lanes::ONE, per_unit: Lanes::ONE };
        assert!(still.reach(1e-10)[0] > 1e20);
        assert_eq!(still.stride(Lanes::from(1e3)).end[0][0], 293.0);
    }
}
