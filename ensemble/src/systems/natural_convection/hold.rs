//! The hold with λ ∝ √(P T) |T − Tw|^n, 0 < n, by a series. With v = (T − Tw)/(T + Tw) and L = ln(v0/v), the relaxations so far,
//!
//! r t = ∫₀^L e^(nL) (1 − v)^n/(1 + v) dL,  r = c Aq/√V Tw |v0 Tw/10 K|^n
//!
//! The quotient is a power series Σ h_j v^j; its nearest singularities are v = ±1, where T is zero or infinite. With v = v0 ζ,
//! ζ = e^(−L) and d_j = h_j v0^j/(n − j),
//!
//! r t = e^(nL) Σ d_j ζ^j − Σ d_j
//!
//! As a function of p = (e^(nL) − 1)/n it has the slope (1 − v)^n/(1 + v), which changes little: L at a given time follows by Newton's
//! method in p. For the samples of a record L is interpolated in time ([`super::record`]). Not for n near an integer, where a term has
//! no such integral, nor for gas far from the wall's temperature ([`has_series`]). Temperatures in K, times in s since the push.

use crate::lanes::Lanes;
use crate::lanes::math::in_powers_fused;
use crate::numerics::root::Curve;
use crate::outcome::SETTLED;
use chamber::effects::natural_convection::REFERENCE_DIFFERENCE_K;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Number of terms, and the largest |v| for which they give temperatures with a relative error below 2e-12: the neglected terms are of
/// the order |v|^32.
const TERMS: usize = 32;
const FARTHEST: f64 = 0.43;
/// Smallest distance of n from an integer.
const NEAREST: f64 = 0.01;
/// Largest number of Newton steps, and size of the last one, in relaxations.
const ROUNDS: usize = 12;
const NEARLY: f64 = 5e-7;

/// Whether the series is valid for a hold with an exponent n, from a temperature on, K, and with a wall temperature, K.
pub fn has_series(exponent: f64, temperature: f64, wall: f64) -> bool {
    let v = ((temperature - wall) / (temperature + wall)).abs();
    exponent > 0.0 && (exponent - exponent.round()).abs() > NEAREST && v > 0.0 && v < FARTHEST
}

/// Holds, one per lane.
pub struct Holds {
    /// n.
    pub exponent: Lanes,
    /// c Aq/√V Tw, 1/s.
    pub rate: Lanes,
    /// Temperature of the wall, K.
    pub wall: Lanes,
    /// Temperature at the start, K.
    pub pushed: Lanes,
    /// Durations of push and hold, s.
    pub push: Lanes,
    pub hold: Lanes,
}

/// The ends of the holds.
pub struct Ends {
    /// Temperature at the end, K.
    pub end: Lanes,
    /// Time after which the temperature is within 1 % of its total change from its end, s.
    pub settling: Lanes,
    pub relaxations: Lanes,
    pub series: TimeOfRelaxations,
}

/// The time as a function of relaxations, s: see [`Curve::at`].
pub struct TimeOfRelaxations {
    exponent: Lanes,
    wall: Lanes,
    /// v0.
    first: Lanes,
    /// One over r, s.
    pub slowness: Lanes,
    /// h_j v0^j, and d_j.
    slopes: [Lanes; TERMS],
    terms: [Lanes; TERMS],
    /// Σ h_j v0^j, and Σ d_j.
    first_slope: Lanes,
    sum: Lanes,
}

impl TimeOfRelaxations {
    #[inline(always)]
    fn new(holds: &Holds) -> Self {
        let Holds { exponent, rate, wall, pushed, .. } = *holds;
        let first = (pushed - wall) / (pushed + wall);
        let strength = first.abs() * wall * (2.0 / REFERENCE_DIFFERENCE_K);
        let slowness = (rate * (exponent * strength.ln()).exp()).recip();
        let [mut slopes, mut terms] = [[Lanes::ZERO; TERMS]; 2];
        // Coefficients of (1 − v)^n and of the quotient, and the power of v0.
        let (mut binomial, mut quotient, mut power) = (Lanes::ONE, Lanes::ZERO, Lanes::ONE);
        for j in 0..TERMS {
            if j > 0 {
                binomial = binomial * ((Lanes::from((j - 1) as f64) - exponent) * (1.0 / j as f64));
                power = power * first;
            }
            quotient = binomial - quotient;
            slopes[j] = black_box(quotient * power);
            terms[j] = black_box(slopes[j] / (exponent - j as f64));
        }
        let [first_slope, sum] = [in_powers_fused(&slopes, Lanes::ONE), in_powers_fused(&terms, Lanes::ONE)];
        Self { exponent, wall, first, slowness, slopes, terms, first_slope, sum }
    }

    /// Temperature after a number of relaxations.
    #[inline(always)]
    pub fn temperature(&self, relaxations: Lanes) -> Lanes {
        let v = self.first * (-relaxations).exp();
        self.wall * (Lanes::ONE + v) / (Lanes::ONE - v)
    }

    /// Number of relaxations until a temperature.
    #[inline(always)]
    fn relaxations(&self, temperature: Lanes) -> Lanes {
        (self.first * (temperature + self.wall) / (temperature - self.wall)).ln()
    }

    /// Number of relaxations after a time.
    #[inline(always)]
    pub fn after(&self, time: Lanes) -> Lanes {
        let (asked, per_exponent) = (time / self.slowness, self.exponent.recip());
        // Initially p follows the first slope, finally a slope of one with an offset `ahead`: a hyperbola connects the two, limited to
        // what the slopes in between can give.
        let begun = asked / self.first_slope;
        let (gained, ahead) = (begun - asked, self.sum - self.terms[0]);
        let [fast, slow] = [begun.min(asked), begun.max(asked)];
        let mut p = (asked + gained * ahead / (gained + ahead)).max(fast).min(slow);
        let (mut relaxations, mut open) = (Lanes::ZERO, Lanes::ONE);
        for _ in 0..black_box(ROUNDS) {
            let grown = Lanes::ONE + self.exponent * p;
            relaxations = open.where_positive(grown.ln() * per_exponent, relaxations);
            let left = (-relaxations).exp();
            // Read in place: otherwise the compiler first copies them all.
            let [terms, slopes] = black_box([&self.terms, &self.slopes]);
            let missing = asked + self.sum - grown * in_powers_fused(terms, left);
            let step = missing / in_powers_fused(slopes, left);
            relaxations += open.where_positive(step / grown, Lanes::ZERO);
            open = (step.abs() - grown * NEARLY).where_positive(open, Lanes::ZERO);
            p = open.where_positive((p + step).max(fast).min(slow), p);
            if !open.any_positive() {
                break;
            }
        }
        relaxations
    }

    /// The time as a function of relaxations and its first three derivatives: r t' = e^(nL) (1 − v)^n/(1 + v), and v' = −v.
    #[inline(always)]
    pub fn with_slopes(&self, relaxations: Lanes) -> [Lanes; 4] {
        let n = self.exponent;
        let (left, grown) = ((-relaxations).exp(), (n * relaxations).exp());
        let [terms, slopes] = black_box([&self.terms, &self.slopes]);
        let time = (grown * in_powers_fused(terms, left) - self.sum) * self.slowness;
        let first = grown * in_powers_fused(slopes, left) * self.slowness;
        // First and second derivative of ln t'.
        let v = self.first * left;
        let [per_less, per_more] = [(Lanes::ONE - v).recip(), (Lanes::ONE + v).recip()];
        let growth = n + v * (n * per_less + per_more);
        let bend = -(v * (n * (per_less * per_less) + per_more * per_more));
        [time, first, first * growth, first * (growth * growth + bend)]
    }
}

impl Curve for TimeOfRelaxations {
    #[inline(always)]
    fn at(&self, relaxations: Lanes) -> Lanes {
        let (left, grown) = ((-relaxations).exp(), (self.exponent * relaxations).exp());
        (grown * in_powers_fused(&self.terms, left) - self.sum) * self.slowness
    }
}

/// Solves holds.
pub struct Solve<'a>(pub &'a Holds);

impl WithSimd for Solve<'_> {
    type Output = Ends;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Ends {
        let holds = black_box(self.0);
        let series = black_box(TimeOfRelaxations::new(holds));
        let relaxations = series.after(holds.hold);
        let end = series.temperature(relaxations);
        let settling = series.at(series.relaxations(end + (holds.pushed - end) * SETTLED));
        Ends { end, settling, relaxations, series }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::numerics::gauss::{NODES, node};
    use proptest::prelude::*;
    use pulp::Scalar;

    /// Time, s, from one temperature to another: dt = −dT/(c T (T − Tw) |(T − Tw)/20 K|^n) over ln |T − Tw|, by Gauss–Legendre
    /// quadrature in parts.
    pub fn between(exponent: f64, rate: f64, wall: f64, [from, to]: [f64; 2]) -> f64 {
        let way = ((from - wall) / (to - wall)).ln();
        let parts = (4.0 * way).ceil();
        let nodes = |part: f64| (0..NODES).map(node).map(move |(x, w)| ((part + x) / parts, w / parts));
        let slowness = |share: f64| {
            let difference = (from - wall) * (-way * share).exp();
            wall / (rate * (wall + difference) * (difference.abs() / REFERENCE_DIFFERENCE_K).powf(exponent))
        };
        (0..parts as usize).flat_map(|part| nodes(part as f64)).map(|(x, w)| w * way * slowness(x)).sum()
    }

    proptest! {
        #[test]
        fn the_series_is_the_integral_of_the_heat_balance(
            exponent in 0.02..2.4f64, rate in 0.01..100.0f64, wall in 250.0..350.0f64, ratio in 0.4..2.5f64, left in 1e-3..0.99f64,
        ) {
            let (from, to) = (wall * ratio, wall + wall * (ratio - 1.0) * left);
            prop_assume!(has_series(exponent, from, wall));
            let hold = between(exponent, rate, wall, [from, to]);
            let [exponent, rate, wall, pushed, hold] = [exponent, rate, wall, from, hold].map(Lanes::from);
            let holds = Holds { exponent, rate, wall, pushed, push: Lanes::ONE, hold };
            let Ends { end, settling, .. } = Solve(&holds).with_simd(Scalar::new());
            prop_assert!((end[3] / to - 1.0).abs() < 2e-12, "{} {to}", end[3]);
            let edge = to + (from - to) * SETTLED;
            let expected = between(exponent[3], rate[3], wall[3], [from, edge]);
            // Temperatures are rounded: of a way of less than a kelvin that takes away digits.
            let allowed = 1e-10 / (from - wall[3]).abs().min(1.0);
            prop_assert!((settling[3] / expected - 1.0).abs() < allowed, "{} {expected}", settling[3]);
        }
    }
}
