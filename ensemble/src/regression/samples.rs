//! Sums over consecutive samples by four nodes, the analogue of a Gauss rule for integrals.
//!
//! For N samples at distance 1, centred at 0, the polynomials orthogonal with respect to their sum are those of Gram
//! (discrete Chebyshev), p(k+1) = x p(k) − b(k) p(k−1) with b(k) = k² (N² − k²)/(4 (4k² − 1)); the zeros of
//! p4 = x⁴ − (b1 + b2 + b3) x² + b1 b3 are the nodes of the rule that sums polynomials up to degree 7 exactly
//! (W. Gautschi, Orthogonal Polynomials: Computation and Approximation, Oxford 2004, sections 1.4 and 1.5). For N up to 4
//! the same formula gives the samples themselves, so that short parts need no special case.

use crate::lanes::Lanes;
use crate::numerics::root::Curve;
use chamber::real::Real;
use core::hint::black_box;

/// Sample rate of the record for the regression, Hz.
pub const SAMPLE_RATE_HZ: f64 = 100.0;
/// Number of nodes of the rule.
pub const POINTS: usize = 4;
/// A time within this fraction of a sample interval counts as that of the sample.
const SAME: f64 = 1e-9;

/// Number of the first sample after a time, s.
#[inline(always)]
pub fn after(time: f64) -> f64 {
    (time * SAMPLE_RATE_HZ + SAME).floor() + 1.0
}

/// Number of the first sample at or after a time, s.
#[inline(always)]
pub fn from(time: f64) -> f64 {
    (time * SAMPLE_RATE_HZ - SAME).ceil()
}

/// Consecutive samples of a record.
#[derive(Clone, Copy, Debug)]
pub struct Samples<R = f64> {
    /// Index of the first sample, counted from the record's start.
    pub first: R,
    /// Number of samples, an integer.
    pub count: R,
}

/// Nodes of a sum.
#[derive(Clone, Copy, Debug)]
pub struct Nodes<R = f64> {
    /// Positions of the nodes as (fractional) sample indices.
    pub numbers: [R; POINTS],
    /// Number of samples each node represents.
    pub weights: [R; POINTS],
}

impl<R: Real> Samples<R> {
    /// The nodes of their sum.
    #[inline(always)]
    pub fn nodes(&self) -> Nodes<R> {
        let squared = self.count * self.count;
        let b1 = (squared - 1.0) * (1.0 / 12.0);
        let b2 = (squared - 4.0) * (4.0 / 60.0);
        let b3 = (squared - 9.0) * (9.0 / 140.0);
        let half = (b1 + b2 + b3) * 0.5;
        let root = (half * half - b1 * b3).sqrt();
        // Squared distances from the centre; negative, for fewer than three samples, only without weight.
        let [outer, inner] = [half + root, half - root];
        let outer_weight = self.count * (b1 - inner) / (root * 4.0);
        let inner_weight = self.count * 0.5 - outer_weight;
        let [outer, inner] = [outer.max(R::ZERO).sqrt(), inner.max(R::ZERO).sqrt()];
        let middle = self.first + (self.count - 1.0) * 0.5;
        Nodes {
            numbers: [middle - outer, middle - inner, middle + inner, middle + outer],
            weights: [outer_weight, inner_weight, inner_weight, outer_weight],
        }
    }
}

impl Nodes<Lanes> {
    /// Values at the nodes, times a factor, of a curve over the place from 0 to 1 in the part of the record from `begin`, s, on.
    #[inline(always)]
    pub fn values(&self, curve: &impl Curve, begin: Lanes, length: Lanes, factor: Lanes) -> [Lanes; POINTS] {
        // Passes through memory: otherwise the compiler computes lane by lane.
        let per_length = black_box(length.where_positive(length, Lanes::ONE).recip());
        let mut values = [Lanes::ZERO; POINTS];
        for k in 0..POINTS {
            let share = (self.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - begin) * per_length;
            values[k] = black_box(curve.at(share) * factor);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Lanes;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn polynomials_of_degree_seven_are_summed_exactly(count in 0u32..2000, short in 0u32..12, pick in any::<bool>()) {
            let count = if pick { short } else { count };
            let Nodes { numbers, weights } = Samples { first: -0.5 * f64::from(count), count: f64::from(count) }.nodes();
            let scale = 2.0 / f64::from(count.max(1));
            for degree in 0..8 {
                let power = |x: f64| (x * scale).powi(degree);
                let all: f64 = (0..count).map(|k| power(f64::from(k) - 0.5 * f64::from(count))).sum();
                let ours: f64 = numbers.iter().zip(weights).map(|(x, w)| w * power(*x)).sum();
                prop_assert!((ours - all).abs() <= 1e-13 * f64::from(count), "{count} {degree}: {ours} {all}");
            }
        }
    }

    #[test]
    fn up_to_four_samples_are_their_own_nodes() {
        for count in 1..=4 {
            let Nodes { numbers, weights } = Samples { first: 7.0, count: f64::from(count) }.nodes();
            for k in 0..count {
                let at = f64::from(7 + k);
                let weight: f64 =
                    numbers.iter().zip(weights).filter(|(x, _)| (*x - at).abs() < 1e-6).map(|(_, w)| w).sum();
                assert!((weight - 1.0).abs() < 1e-12, "{count} {numbers:?} {weights:?}");
            }
        }
    }

    #[test]
    fn lanes_have_the_same_nodes() {
        let one = Samples { first: 3.0, count: 50.0 }.nodes();
        let all = Samples { first: Lanes::from(3.0), count: Lanes::from(50.0) }.nodes();
        for k in 0..POINTS {
            assert_eq!((all.numbers[k][5], all.weights[k][5]), (one.numbers[k], one.weights[k]));
        }
    }

    #[test]
    fn a_sample_at_a_time_is_from_it_on_and_not_after_it() {
        assert_eq!((from(0.3), after(0.3)), (30.0, 31.0));
        assert_eq!((from(0.303), after(0.303)), (31.0, 31.0));
        assert_eq!((from(0.0), after(0.0)), (0.0, 1.0));
    }
}
