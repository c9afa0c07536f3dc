//! Pressure records laid out for the regression, one per lane, in parts: consecutive samples over which a record is smooth, summed by
//! the few nodes of [`samples`].

use super::least_squares::{Guess, Node, Regressions, least_squares};
use super::samples::{self, Nodes, POINTS, SAMPLE_RATE_HZ, Samples};
use crate::lanes::{Lanes, WIDTH, each_lane};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// A part of a record.
#[derive(Clone, Copy, Debug)]
pub struct RecordPart<R = f64> {
    /// Which samples of the record it covers: the first, and their number.
    pub samples: Samples<R>,
    /// Pressures at the nodes of their sum.
    pub pressure: [R; POINTS],
}

impl RecordPart<Lanes> {
    const NONE: Self =
        Self { samples: Samples { first: Lanes::ZERO, count: Lanes::ZERO }, pressure: [Lanes::ZERO; POINTS] };
}

/// Pressure records, one per lane.
#[derive(Debug, Default)]
pub struct Records {
    parts: Vec<RecordPart<Lanes>>,
    lengths: [usize; WIDTH],
    nodes: Vec<[Node; POINTS]>,
    /// Number of the first sample, and the reference pressure that is subtracted from all.
    begin: [Lanes; 2],
    /// Number of the first sample of the next part.
    next: Lanes,
}

impl Records {
    /// Drops all records; keeps the memory.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.nodes.clear();
        self.lengths = [0; WIDTH];
    }

    /// Begins new records, with the first samples at or after the given times, s.
    #[inline(always)]
    pub fn begin_at(&mut self, times: Lanes) {
        self.begin_with(each_lane!(i => samples::from(times.0[i])));
    }

    /// Begins new records with the samples of these numbers.
    #[inline(always)]
    pub fn begin_with(&mut self, first: Lanes) {
        self.clear();
        self.next = black_box(first);
    }

    /// The nodes of the next part of each record, up to and including a time, s. None if the part is empty in all lanes, except for the
    /// first part.
    #[inline(always)]
    pub fn nodes_up_to(&mut self, times: Lanes) -> Option<Nodes<Lanes>> {
        // Passes through memory: otherwise the compiler computes lane by lane.
        let first = black_box(self.next);
        let next = black_box(each_lane!(i => samples::after(times.0[i])));
        let count = black_box((next - first).max(Lanes::ZERO));
        if self.nodes.is_empty() {
            self.begin[0] = first;
        } else if !count.any_positive() {
            return None;
        }
        self.next = black_box(first.max(next));
        Some(black_box(Samples { first, count }.nodes()))
    }

    /// Appends this part to each record, with the pressures at its nodes.
    #[inline(always)]
    pub fn push(&mut self, nodes: &Nodes<Lanes>, pressure: &[Lanes; POINTS]) {
        if self.nodes.is_empty() {
            self.begin[1] = pressure[0];
        }
        let [origin, reference] = black_box(self.begin);
        let mut all = [Node::NONE; POINTS];
        for k in 0..POINTS {
            // Nodes without weight may lie anywhere, but not where e^(−t/τ) overflows.
            let time = ((nodes.numbers[k] - origin) * (1.0 / SAMPLE_RATE_HZ)).max(Lanes::ZERO);
            all[k] =
                black_box(Node { time, pressure: pressure[k] - reference, weight: nodes.weights[k], ..Node::NONE });
        }
        self.nodes.push(all);
    }

    /// Appends a part to the record of one lane.
    #[inline(always)]
    pub fn add(&mut self, lane: usize, part: RecordPart) {
        let index = self.lengths[lane];
        if index == self.parts.len() {
            self.parts.push(RecordPart::NONE);
        }
        self.lengths[lane] += 1;
        let to = &mut self.parts[index];
        to.samples.first[lane] = part.samples.first;
        to.samples.count[lane] = part.samples.count;
        for node in 0..POINTS {
            to.pressure[node][lane] = part.pressure[node];
        }
    }

    /// The least-squares fit, from a guess of τ.
    pub fn fit(&mut self, arch: Arch, guess: Guess) -> Regressions {
        arch.dispatch(Fitting { records: self, guess })
    }

    /// Appends the parts that were added lane by lane.
    #[inline(always)]
    fn lay_out(&mut self) {
        for index in 0..self.parts.len() {
            let RecordPart { samples, pressure } = *black_box(&self.parts[index]);
            let nodes = black_box(samples.nodes());
            if index == 0 {
                self.begin[0] = samples.first;
            }
            self.push(&nodes, &pressure);
        }
        self.parts.clear();
    }
}

struct Fitting<'a> {
    records: &'a mut Records,
    guess: Guess,
}

impl WithSimd for Fitting<'_> {
    type Output = Regressions;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Regressions {
        self.records.lay_out();
        let Records { nodes, begin, .. } = self.records;
        if I::IS_SCALAR {
            least_squares::<false>(nodes, *begin, &self.guess)
        } else {
            least_squares::<true>(nodes, *begin, &self.guess)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::Regression;
    use crate::regression::time_constant::tests::least;
    use chamber::seven_steps;
    use proptest::prelude::*;

    /// Samples one by one, each a part of its own.
    fn sampled(records: &mut Records, lane: usize, pressures: &[f64]) {
        for (k, p) in pressures.iter().enumerate() {
            let samples = Samples { first: 40.0 + k as f64, count: 1.0 };
            records.add(lane, RecordPart { samples, pressure: [*p; POINTS] });
        }
    }

    /// Σ of the squared residuals of the best Pf and ΔP at that τ, s.
    fn residual(pressures: &[f64], tau: f64) -> f64 {
        let n = pressures.len() as f64;
        let e = |k: usize| (-(k as f64) / SAMPLE_RATE_HZ / tau).exp();
        let mean = |f: &dyn Fn(usize) -> f64| (0..pressures.len()).map(f).sum::<f64>() / n;
        let (mean_e, mean_p) = (mean(&e), mean(&|k| pressures[k]));
        let slope = mean(&|k| (e(k) - mean_e) * (pressures[k] - mean_p)) / mean(&|k| (e(k) - mean_e).powi(2));
        mean(&|k| (pressures[k] - mean_p - slope * (e(k) - mean_e)).powi(2))
    }

    /// τ of the least squares, s.
    fn best(pressures: &[f64], near: f64) -> f64 {
        least(|log_tau| residual(pressures, log_tau.exp()), [0.5, 2.0].map(|off| (near * off).ln())).exp()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn the_time_constant_is_that_of_the_least_squares_found_by_search(
            tau in 0.05..2.0f64, excess in -0.5..0.5f64, off in 0.5..2.0f64, length in 3.0..12.0f64, lane in 0..WIDTH,
        ) {
            prop_assume!(excess.abs() > 0.01);
            let count = (length * tau * SAMPLE_RATE_HZ) as usize;
            let pressure = |k: usize| 3e5 / (1.0 - excess * (-(k as f64) / SAMPLE_RATE_HZ / tau).exp());
            let pressures: Vec<f64> = (0..count).map(pressure).collect();
            let mut records = Records::default();
            sampled(&mut records, (lane + 3) % WIDTH, &pressures[..count / 2]);
            sampled(&mut records, lane, &pressures);
            let found = records.fit(Arch::new(), Guess::TimeConstant(Lanes::from(tau * off))).lane(lane).unwrap();
            let expected = best(&pressures, tau);
            prop_assert!((found.exponential.time_constant_s / expected - 1.0).abs() < 2e-5, "{found:?} {expected}");
        }

        #[test]
        fn an_exponential_is_found_as_it_is_however_its_samples_are_parted(
            tau in 0.05..2.0f64, off in 0.3..3.0f64, parts in 1usize..40,
        ) {
            assert_found(tau, off, parts);
        }
    }

    /// An exponential, its record in parts of `2 parts` samples, is found from a guess of τ that is `off` times too long.
    fn assert_found(tau: f64, off: f64, parts: usize) {
        let mut records = Records::default();
        let (mut first, end) = (12.0, 12.0 + (8.0 * tau * SAMPLE_RATE_HZ).ceil());
        while first < end {
            let count = (2.0 * parts as f64).min(end - first);
            let samples = Samples { first, count };
            let pressure = samples.nodes().numbers.map(|k| 2e5 + 7e4 * (-(k - 12.0) / SAMPLE_RATE_HZ / tau).exp());
            records.add(4, RecordPart { samples, pressure });
            first += count;
        }
        let Regression {
            exponential:
                seven_steps::Regression { final_pressure_pa: pf, pressure_rise_pa: rise, time_constant_s: found },
            ..
        } = records.fit(Arch::new(), Guess::TimeConstant(Lanes::from(tau * off))).lane(4).unwrap();
        assert!((found / tau - 1.0).abs() < 1e-5, "{found} {tau}");
        assert!((pf / 2e5 - 1.0).abs() < 1e-5 && (rise / 7e4 - 1.0).abs() < 1e-5, "{pf} {rise}");
    }

    #[test]
    fn the_misfit_is_the_largest_distance_from_the_exponential_over_the_records_rise() {
        let mut records = Records::default();
        let record = |leak: f64| -> Vec<f64> {
            (0..400).map(|k| f64::from(k) / 50.0).map(|x| 2e5 + 7e4 * (-x).exp() - leak * x).collect()
        };
        let leaks = [0.0, 5e2, 5e3, 1.5e4];
        for (lane, leak) in leaks.into_iter().enumerate() {
            sampled(&mut records, lane, &record(leak));
        }
        let found = records.fit(Arch::new(), Guess::TimeConstant(Lanes::from(0.5)));
        for (lane, leak) in leaks.into_iter().enumerate() {
            let Regression { exponential: found, misfit } = found.lane(lane).unwrap();
            let decay = |k: usize| (-(k as f64) / SAMPLE_RATE_HZ / found.time_constant_s).exp();
            let exponential = |k: usize| found.final_pressure_pa + found.pressure_rise_pa * decay(k);
            let pressures = record(leak);
            let distances = pressures.iter().enumerate().map(|(k, p)| (p - exponential(k)).abs());
            let span = pressures[0] - pressures.iter().copied().fold(f64::INFINITY, f64::min);
            let expected = distances.fold(0.0, f64::max) / span;
            assert!((misfit - expected).abs() < 1e-9, "{leak}: {misfit} {expected}");
        }
    }

    #[test]
    fn a_search_that_would_go_to_and_fro_for_ever_comes_to_its_end() {
        assert_found(0.08236465180989963, 1.8701326716749593, 25);
    }

    #[test]
    fn a_record_that_determines_nothing_gives_none() {
        let mut records = Records::default();
        sampled(&mut records, 0, &[1e5; 50]);
        sampled(&mut records, 1, &[2e5, 1.5e5, 1.2e5, 1.1e5]);
        sampled(&mut records, 3, &[2e5, 1.5e5, 1.25e5, 1.125e5, 1.0625e5, 1.031_25e5]);
        let found = records.fit(Arch::new(), Guess::TimeConstant(Lanes::from(0.02)));
        assert!([0, 1, 2].into_iter().all(|lane| found.lane(lane).is_none()));
        let tau = found.lane(3).unwrap().exponential.time_constant_s;
        assert!((tau - 0.01 / 2f64.ln()).abs() < 1e-9, "{tau}");
    }
}
