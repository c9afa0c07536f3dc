//! e^x and ln x in lanes, without branches, within about one unit in the last place; and x^n to thirteen digits, in half the time of
//! these two.
//!
//! exp: x = k ln 2 + r, |r| ≤ ½ ln 2 (Cody and Waite, 1980), Taylor polynomial of degree 13 in r.
//! ln: x = 2^k m, m in [√½, √2), the odd series in s = (m − 1)/(m + 1) (as in fdlibm, 1993, here with its exact
//! coefficients 2/(2i + 1)).
//! x^n = 2^(n lb x): the same series, shorter. And x^(−1/8) to the few per cent needed for the length of a step.

use crate::lanes::{Lanes, each_lane, multiply_add};
use chamber::real::Real;
use core::f64::consts::{LN_2, LOG2_E};

const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5·2^52: adding it leaves an integer in the low bits

/// Coefficients of e^r from r² on: 1/(i + 2)!.
const INVERSE_FACTORIALS: [f64; 12] = {
    let (mut all, mut factorial, mut i) = ([0.0; 12], 1.0, 0);
    while i < 12 {
        factorial *= (i + 2) as f64;
        all[i] = 1.0 / factorial;
        i += 1;
    }
    all
};

/// Coefficients of ln m over s in powers of s², without the first one: 2/(2i + 3), and zero at the end.
const ODD_SERIES: [f64; 12] = {
    let (mut all, mut i) = ([0.0; 12], 0);
    while i < 11 {
        all[i] = 2.0 / (2 * i + 3) as f64;
        i += 1;
    }
    all
};

/// x^(−1/8) within a few per cent, for x > 0: by a shift of the number's bits.
#[inline(always)]
pub fn inverse_eighth_root(x: Lanes) -> Lanes {
    const ONE: u64 = 0x3ff0_0000_0000_0000;
    each_lane!(i => f64::from_bits((ONE + ONE / 8).wrapping_sub(x.0[i].to_bits() >> 3)))
}

/// e^x for x in [−708, 709]; outside, the value at the nearer bound.
#[inline(always)]
pub fn exp(x: Lanes) -> Lanes {
    let x = x.min(Lanes::from(709.0)).max(Lanes::from(-708.0));
    let shifted = x * LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (x - k * LN2_HIGH) - k * LN2_LOW;
    let square = r * r;
    let p = polynomial(r, square, INVERSE_FACTORIALS);
    let result = r + square * p + 1.0;
    result * power_of_two(shifted)
}

/// e^(−x) for x ≥ 0, within 1e-11: as [`exp`], with fewer terms.
#[inline(always)]
pub fn decay<const FUSED: bool>(x: Lanes) -> Lanes {
    const TERMS: [f64; 9] =
        [1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 1.0 / 2.0, 1.0, 1.0];
    let x = each_lane!(i => if x.0[i] < 700.0 { x.0[i] } else { 700.0 });
    let shifted = multiply_add::<FUSED>(x, Lanes::from(-LOG2_E), Lanes::from(ROUND));
    let k = shifted - ROUND;
    let r = multiply_add::<FUSED>(k, Lanes::from(-LN_2), -x);
    let mut p = Lanes::from(1.0 / 362_880.0);
    for term in TERMS {
        p = multiply_add::<FUSED>(p, r, Lanes::from(term));
    }
    p * power_of_two(shifted)
}

/// Natural logarithm of a positive, normal x; arbitrary for other x.
#[inline(always)]
pub fn ln(x: Lanes) -> Lanes {
    let [k, m] = exponent_and_mantissa(x);
    let f = m - 1.0;
    let s = f / (m + 1.0);
    let z = s * s;
    let p = polynomial(z, z * z, ODD_SERIES);
    let half_square = f * f * 0.5;
    // ln m = f − (f²/2 − s (f²/2 + z p)): in this form the leading term is exact.
    k * LN2_HIGH - ((half_square - (s * (half_square + z * p) + k * LN2_LOW)) - f)
}

/// k and m of x = 2^k m, m in [√½, √2).
#[inline(always)]
fn exponent_and_mantissa(x: Lanes) -> [Lanes; 2] {
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    let m = each_lane!(i => f64::from_bits(
        (x.0[i].to_bits().wrapping_sub(SQRT_HALF) & 0x000f_ffff_ffff_ffff).wrapping_add(SQRT_HALF)
    ));
    // The biased exponent as a number, through the bits of 2^52 + n (no integer conversion, which AVX2 lacks).
    let biased = each_lane!(i => f64::from_bits(
        (x.0[i].to_bits().wrapping_sub(SQRT_HALF).wrapping_add(0x4000_0000_0000_0000) >> 52) | 0x4330_0000_0000_0000
    ));
    [biased - (4_503_599_627_370_496.0 + 1024.0), m]
}

/// 2^k, where `shifted` is k + [`ROUND`].
#[inline(always)]
fn power_of_two(shifted: Lanes) -> Lanes {
    each_lane!(i => f64::from_bits(shifted.0[i].to_bits().wrapping_sub(ROUND.to_bits() - 1023) << 52))
}

/// x^n of a positive, normal x, |n lb x| < 1000, to thirteen digits. For machines with fused multiply-add.
#[inline(always)]
pub fn power(x: Lanes, n: Lanes) -> Lanes {
    let [k, m] = exponent_and_mantissa(x);
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let square = z * z;
    let low = fused(linear(z, LB[2], LB[3]), square, linear(z, LB[0], LB[1]));
    let high = fused(linear(z, LB[6], LB[7]), square, linear(z, LB[4], LB[5]));
    let y = n * fused(s, fused(high, square * square, low), k);
    let shifted = y + ROUND;
    let r = (y - (shifted - ROUND)) * LN_2;
    let square = r * r;
    let fourth = square * square;
    let low = fused(linear(r, EXP[2], EXP[3]), square, linear(r, EXP[0], EXP[1]));
    let middle = fused(linear(r, EXP[6], EXP[7]), square, linear(r, EXP[4], EXP[5]));
    let p = fused(fused(linear(r, EXP[8], EXP[9]), fourth, middle), fourth, low);
    (fused(square, p, r) + 1.0) * power_of_two(shifted)
}

/// Coefficients of lb m in powers of s², over s: 2/((2i + 1) ln 2).
const LB: [f64; 8] = {
    let (mut all, mut i) = ([0.0; 8], 0);
    while i < 8 {
        all[i] = 2.0 / ((2 * i + 1) as f64 * LN_2);
        i += 1;
    }
    all
};

/// Coefficients of e^r from r² on: 1/(i + 2)!.
const EXP: [f64; 10] = {
    let (mut all, mut i) = ([0.5; 10], 1);
    while i < 10 {
        all[i] = all[i - 1] / (i + 2) as f64;
        i += 1;
    }
    all
};

/// a b + c, rounded once.
#[inline(always)]
fn fused(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    each_lane!(i => a.0[i].mul_add(b.0[i], c.0[i]))
}

#[inline(always)]
fn linear(x: Lanes, constant: f64, slope: f64) -> Lanes {
    each_lane!(i => x.0[i].mul_add(slope, constant))
}

/// A polynomial in x with an even number of coefficients: even and odd powers separately, with half the dependency chain of Horner's
/// scheme.
#[inline(always)]
pub fn in_powers<R: Real, const N: usize>(terms: &[R; N], x: R) -> R {
    let square = x * x;
    let (mut even, mut odd) = (terms[N - 2], terms[N - 1]);
    for pair in (0..N / 2 - 1).rev() {
        even = even * square + terms[2 * pair];
        odd = odd * square + terms[2 * pair + 1];
    }
    even + odd * x
}

/// The same in four sums, for machines with fused multiply-add.
#[inline(always)]
pub fn in_powers_fused<const N: usize>(terms: &[Lanes; N], x: Lanes) -> Lanes {
    let (square, fourth) = (x * x, (x * x) * (x * x));
    let mut sums = [terms[N - 4], terms[N - 3], terms[N - 2], terms[N - 1]];
    for four in (0..N / 4 - 1).rev() {
        for i in 0..4 {
            sums[i] = fused(sums[i], fourth, terms[4 * four + i]);
        }
    }
    fused(fused(sums[3], x, sums[2]), square, fused(sums[1], x, sums[0]))
}

/// A polynomial of degree 11 in x, with coefficients in ascending order, by Estrin's scheme: its dependency chain is a third of
/// Horner's (G. Estrin, Western Joint Computer Conference, 1960).
#[inline(always)]
fn polynomial(x: Lanes, square: Lanes, c: [f64; 12]) -> Lanes {
    let fourth = square * square;
    // Written out: closures would not be inlined, see `each_lane`.
    let low = (x * c[3] + c[2]) * square + (x * c[1] + c[0]);
    let middle = (x * c[7] + c[6]) * square + (x * c[5] + c[4]);
    let high = (x * c[11] + c[10]) * square + (x * c[9] + c[8]);
    (high * fourth + middle) * fourth + low
}

#[cfg(test)]
mod tests {
    use super::{Lanes, decay, exp as exp_lanes, in_powers, in_powers_fused, ln as ln_lanes, power};
    use proptest::prelude::*;

    fn exp(x: f64) -> f64 {
        exp_lanes(Lanes::from(x))[3]
    }
    fn ln(x: f64) -> f64 {
        ln_lanes(Lanes::from(x))[5]
    }

    proptest! {
        #[test]
        fn exp_is_within_two_units_in_the_last_place(x in -700.0..700.0f64) {
            prop_assert!((exp(x) / x.exp() - 1.0).abs() < 4.5e-16, "{} {}", exp(x), x.exp());
        }

        #[test]
        fn a_power_is_that_of_the_standard_library(y in -30.0..30.0f64, n in -2.0..2.0f64) {
            let expected = y.exp().powf(n);
            prop_assert!((power(Lanes::from(y.exp()), Lanes::from(n))[2] / expected - 1.0).abs() < 1e-13, "{y} {n}");
        }

        #[test]
        fn ln_is_within_two_units_in_the_last_place(y in -700.0..700.0f64) {
            let x = y.exp();
            prop_assert!((ln(x) - x.ln()).abs() <= 4.5e-16 * x.ln().abs().max(1e-3), "{} {}", ln(x), x.ln());
        }
    }

    #[test]
    fn a_polynomial_in_parts_is_that_of_horner() {
        let terms = [3.0, -1.0, 0.5, 2.0, -4.0, 1.0, 0.25, -2.0];
        let horner = |x: f64| terms.iter().rev().fold(0.0, |sum, term| sum * x + term);
        for x in [-2.0, -0.3, 0.0, 1.0, 1.7] {
            assert!((in_powers(&terms, x) - horner(x)).abs() < 1e-13, "{x}");
            let fused = in_powers_fused(&terms.map(Lanes::from), Lanes::from(x))[1];
            assert!((fused - horner(x)).abs() < 1e-13, "{x}");
        }
    }

    #[test]
    fn the_quick_exponential_is_good_to_eleven_digits() {
        for k in 0..70_000 {
            let x = f64::from(k) * 0.009_7;
            assert!((decay::<false>(Lanes::from(x))[3] / (-x).exp() - 1.0).abs() < 1e-11, "{x}");
        }
    }

    #[test]
    fn neutral_exponents_give_exactly_one() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(0.0 * ln(5.65e5)), 1.0);
        assert_eq!(ln(1.0), 0.0);
    }
}
