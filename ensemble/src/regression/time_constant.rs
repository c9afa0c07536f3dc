//! A guess of the time constant of the paper's step 1: the least-squares τ of a sealed relaxation, P = Pf/(1 − ε e^(−k t)), sampled at
//! infinite frequency. Then k τ depends only on ε at the first sample and on the record's length in relaxations. A polynomial in
//! ρ = −ln(1 − ε) = ln(P/Pf) and v = 3/(3 + length) approximates it within 0.2 % for ρ from −0.4 to 1.1 (a push to a ninth of the
//! volume) and 0.3 relaxations or more.

use crate::lanes::Lanes;
use chamber::real::Real;

/// Coefficients of ln(k τ): one row for each power of (ρ − 0.35)/0.75, with the coefficients of the powers of 2 v − 1.
const LOG_TIME_CONSTANT: [[f64; 7]; 6] = [
    [-0.2448, -0.2259, -0.1696, 0.0243, 0.0321, -0.0216, -0.0015],
    [-0.4983, -0.3678, -0.2989, 0.0061, 0.0618, -0.0423, -0.0274],
    [0.042, 0.2064, 0.127, -0.0794, -0.0602, -0.0069, -0.0189],
    [-0.0232, -0.0674, -0.0342, 0.0477, 0.0135, -0.0167, 0.0068],
    [0.0057, 0.0265, 0.0428, 0.0399, 0.0294, -0.0015, -0.0137],
    [0.0001, -0.007, -0.0448, -0.0482, 0.0185, 0.0048, -0.0257],
];
/// Shortest record that the polynomial is valid for, in relaxations.
const SHORTEST: f64 = 0.3;

/// Returns ln τ of the exponential fitted to a sealed relaxation over `length`, s, whose ε = 1 − Pf/P decays from `excess` at the rate
/// k, 1/s.
#[inline(always)]
pub fn logarithm_of_guess(rate: Lanes, excess: Lanes, length: Lanes) -> Lanes {
    let relaxations = (length * rate).max(Lanes::from(SHORTEST));
    let logarithm = -(Lanes::ONE - excess).ln();
    let x = ((logarithm - 0.35) * (1.0 / 0.75)).max(-Lanes::ONE).min(Lanes::ONE);
    let y = Lanes::from(6.0) / (relaxations + 3.0) - 1.0;
    let mut sum = Lanes::ZERO;
    for row in LOG_TIME_CONSTANT.iter().rev() {
        let mut factor = Lanes::ZERO;
        for term in row.iter().rev() {
            factor = factor * y + *term;
        }
        sum = sum * x + factor;
    }
    sum - rate.ln()
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Where a function between two places is least, by golden section.
    pub fn least(of: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (c, d) = (b - golden * (b - a), a + golden * (b - a));
            if of(c) < of(d) { b = d } else { a = c }
        }
        0.5 * (a + b)
    }

    /// ln τ of the least squares over 2000 points of a relaxation with k = 1.
    fn best(excess: f64, length: f64) -> f64 {
        const POINTS: usize = 2000;
        let time = |i: usize| (i as f64 + 0.5) * length / POINTS as f64;
        let pressures: Vec<f64> = (0..POINTS).map(|i| 1.0 / (1.0 - excess * (-time(i)).exp())).collect();
        let residual = |log_tau: f64| {
            let decays: Vec<f64> = (0..POINTS).map(|i| (-time(i) / log_tau.exp()).exp()).collect();
            let mean = |of: &[f64]| of.iter().sum::<f64>() / POINTS as f64;
            let (at, of) = (mean(&decays), mean(&pressures));
            let products = |a: &[f64], b: &[f64], [at, of]: [f64; 2]| -> f64 {
                a.iter().zip(b).map(|(a, b)| (a - at) * (b - of)).sum()
            };
            let common = products(&decays, &pressures, [at, of]);
            products(&pressures, &pressures, [of, of]) - common * common / products(&decays, &decays, [at, at])
        };
        least(residual, [-2.0, 2.0])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_guess_is_the_least_squares_time_constant_within_a_fifth_of_a_percent(
            logarithm in -0.4..1.1f64, length in 0.3..30.0f64, rate in 0.1..10.0f64,
        ) {
            let excess = 1.0 - (-logarithm).exp();
            prop_assume!(excess.abs() > 0.01);
            let guess = logarithm_of_guess(Lanes::from(rate), Lanes::from(excess), Lanes::from(length / rate))[3];
            let expected = best(excess, length) - rate.ln();
            prop_assert!((guess - expected).abs() < 2e-3, "{guess} {expected}");
        }
    }
}
