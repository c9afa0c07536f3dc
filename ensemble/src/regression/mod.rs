//! Step 1 of the paper, P = Pf + ΔP e^(−t/τ) by least squares over the samples, for as many records as there are lanes.
//!
//! A record stands in parts: samples in a row over which it is smooth, summed by the few nodes of [`samples`].
//! Pf and ΔP enter linearly and are eliminated (variable projection: G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10
//! (1973) 413); what is left is Newton's method in ln τ, which from a good guess takes one step. Pressures in Pa, times in s.

pub mod fit;
pub mod followed;
pub mod relaxing;
pub mod samples;
mod time_constant;

use crate::lanes::math::decay;
use crate::lanes::{Lanes, WIDTH, each_lane, multiply_add};
use crate::regression::samples::{Nodes, POINTS, SAMPLE_RATE_HZ, Samples};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

const ITERATIONS: usize = 60;
/// Change of ln τ after which the next one would be its square or less.
const CONVERGED: f64 = 2e-3;
/// Least share of the Gauss–Newton curvature that Newton's must have to be believed.
const CONVEX: f64 = 0.3;
/// Farthest from the guess, in ln τ.
const FARTHEST: f64 = 12.0;
/// A node of less weight is none.
const NO_WEIGHT: f64 = 1e-6;
/// A record of fewer samples determines nothing.
const FEWEST: f64 = 5.0;

/// A record between two of its samples.
#[derive(Clone, Copy, Debug)]
pub struct RecordPart<R = f64> {
    /// Those from one knot to the next, with their count and times.
    pub samples: Samples<R>,
    /// Pressure at the nodes of their sum.
    pub pressure: [R; POINTS],
}

impl RecordPart<Lanes> {
    const NONE: Self =
        Self { samples: Samples { first: Lanes::ZERO, count: Lanes::ZERO }, pressure: [Lanes::ZERO; POINTS] };
}

/// A node of all records: time after the first sample, pressure less the first one, how many samples it stands for, and e^(−t/τ)
/// with the last τ.
#[derive(Clone, Copy, Debug)]
struct Node {
    time: Lanes,
    pressure: Lanes,
    weight: Lanes,
    decay: Lanes,
}

impl Node {
    const NONE: Self = Self { time: Lanes::ZERO, pressure: Lanes::ZERO, weight: Lanes::ZERO, decay: Lanes::ONE };
}

/// Where the search for τ begins.
// Made once for as many records as there are lanes, and not kept.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
pub enum Guess {
    /// At this τ, s.
    TimeConstant(Lanes),
    /// At that of a sealed relaxation, whose ε = 1 − Pf/P decays with this rate.
    Relaxation {
        /// k, 1/s.
        rate: Lanes,
        /// ε at the time `from`.
        excess: Lanes,
        /// From the start of the test on, s.
        from: Lanes,
    },
}

/// Pressure records to regress, one in each lane, as parts of a curve.
#[derive(Debug, Default)]
pub struct Records {
    parts: Vec<RecordPart<Lanes>>,
    lengths: [usize; WIDTH],
    nodes: Vec<[Node; POINTS]>,
    /// Number of the first sample, and the pressure that all others are less by.
    begin: [Lanes; 2],
    /// Number of the first sample of the next part.
    next: Lanes,
}

/// What the least squares of one record are.
#[derive(Clone, Copy, Debug)]
pub struct Regression {
    /// Pf, Pa.
    pub final_pressure: f64,
    /// ΔP, Pa.
    pub rise: f64,
    /// τ, s.
    pub time_constant: f64,
    /// How far the record is from the exponential at most, as a share of its own rise.
    pub misfit: f64,
}

/// Pf and ΔP, Pa, and τ, s, by lane, NaN where the record determines none; and how far the record is from that
/// exponential at most, as a share of its own rise.
#[derive(Clone, Copy, Debug)]
pub struct Regressions([Lanes; 4]);

impl Regressions {
    /// The regression of one lane; `None` where its record determines none.
    pub fn lane(&self, lane: usize) -> Option<Regression> {
        let [final_pressure, rise, time_constant, misfit] = self.0.map(|found| found[lane]);
        let found = [final_pressure, rise, time_constant].iter().all(|v| v.is_finite());
        found.then_some(Regression { final_pressure, rise, time_constant, misfit })
    }
}

impl Records {
    /// Drops all records; the memory stays allocated.
    pub fn clear(&mut self) {
        self.parts.clear();
        self.nodes.clear();
        self.lengths = [0; WIDTH];
    }

    /// Begins records in place of those that there are, with the first samples at or after some times, s.
    #[inline(always)]
    pub fn begin_at(&mut self, times: Lanes) {
        self.begin_with(each_lane!(i => samples::from(times.0[i])));
    }

    /// The same with samples of these numbers.
    #[inline(always)]
    pub fn begin_with(&mut self, first: Lanes) {
        self.clear();
        self.next = black_box(first);
    }

    /// The nodes of the next part of each record, up to and at a time, s. None of a part that is empty in all of them, but the first.
    #[inline(always)]
    pub fn nodes_up_to(&mut self, times: Lanes) -> Option<Nodes<Lanes>> {
        // Results pass through memory: else the compiler computes them lane by lane.
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

    /// Appends that part to each record, with the pressures at its nodes.
    #[inline(always)]
    pub fn push(&mut self, nodes: &Nodes<Lanes>, pressure: &[Lanes; POINTS]) {
        if self.nodes.is_empty() {
            self.begin[1] = pressure[0];
        }
        let [origin, reference] = black_box(self.begin);
        let mut all = [Node::NONE; POINTS];
        for k in 0..POINTS {
            // Nodes without weight may stand anywhere, but not where e^(−t/τ) has no value.
            let time = ((nodes.numbers[k] - origin) * (1.0 / SAMPLE_RATE_HZ)).max(Lanes::ZERO);
            all[k] =
                black_box(Node { time, pressure: pressure[k] - reference, weight: nodes.weights[k], ..Node::NONE });
        }
        self.nodes.push(all);
    }

    /// Appends a part to one record.
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

    /// Least squares from a guess of τ on.
    pub fn fit(&mut self, arch: Arch, guess: Guess) -> Regressions {
        arch.dispatch(Fitting { records: self, guess })
    }

    /// Appends the parts that were added record by record.
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

/// Sums over a record's samples, with e = e^(−t/τ) and its derivatives by ln τ in parts: g = (t/τ) e, h = (t/τ) g.
#[derive(Clone, Copy)]
struct Sums {
    e: Lanes,
    g: Lanes,
    h: Lanes,
    ee: Lanes,
    eg: Lanes,
    gg: Lanes,
    pe: Lanes,
    pg: Lanes,
    ph: Lanes,
}

impl Sums {
    const NONE: Self = Self {
        e: Lanes::ZERO,
        g: Lanes::ZERO,
        h: Lanes::ZERO,
        ee: Lanes::ZERO,
        eg: Lanes::ZERO,
        gg: Lanes::ZERO,
        pe: Lanes::ZERO,
        pg: Lanes::ZERO,
        ph: Lanes::ZERO,
    };

    #[inline(always)]
    fn add<const FUSED: bool>(&mut self, node: &mut Node, rate: Lanes) {
        let (p, w) = (node.pressure, node.weight);
        let x = node.time * rate;
        let e = decay::<FUSED>(x);
        node.decay = e;
        let g = x * e;
        let (we, wg) = (w * e, w * g);
        let wh = wg * x;
        self.e += we;
        self.g += wg;
        self.h += wh;
        self.ee = multiply_add::<FUSED>(we, e, self.ee);
        self.eg = multiply_add::<FUSED>(we, g, self.eg);
        self.gg = multiply_add::<FUSED>(wg, g, self.gg);
        self.pe = multiply_add::<FUSED>(we, p, self.pe);
        self.pg = multiply_add::<FUSED>(wg, p, self.pg);
        self.ph = multiply_add::<FUSED>(wh, p, self.ph);
    }
}

/// What the sums at one τ tell.
struct Solution {
    /// Newton's step of ln τ.
    step: Lanes,
    /// ΔP and Pf less the reference, after the step.
    linear: [Lanes; 2],
}

/// Newton's step, from the sums of the weights and of the pressures beside.
#[inline(always)]
fn newton(s: &Sums, count: Lanes, pressure: Lanes) -> Solution {
    let share = count.recip();
    // Without the constant's part; Σ h e is Σ g².
    let (mean_e, mean_g, mean_h) = (s.e * share, s.g * share, s.h * share);
    let (ee, eg, gg, he) = (s.ee - mean_e * s.e, s.eg - mean_e * s.g, s.gg - mean_g * s.g, s.gg - mean_h * s.e);
    let (pe, pg, ph) = (s.pe - mean_e * pressure, s.pg - mean_g * pressure, s.ph - mean_h * pressure);
    let rise = pe / ee;
    let per_rise = rise.recip();
    // What the residuals, relative to ΔP, have in common with g and with dg/d ln τ = h − g.
    let with_g = pg * per_rise - eg;
    let with_bend = ph * per_rise - he - with_g;
    let per_ee = ee.recip();
    let gauss_newton = gg - eg * eg * per_ee;
    let coupling = (eg - with_g) * per_ee;
    let newton = gg - with_bend - (eg - with_g) * coupling;
    let curvature = (newton - gauss_newton * CONVEX).where_positive(newton, gauss_newton);
    let step = with_g / curvature;
    let after = rise - rise * coupling * step;
    Solution { step, linear: [after, (pressure - after * s.e - rise * step * s.g) * share] }
}

/// The least squares, lane by lane as if it were alone.
#[inline(always)]
fn least_squares<const FUSED: bool>(
    nodes: &mut [[Node; POINTS]],
    [first, reference]: [Lanes; 2],
    guess: &Guess,
) -> Regressions {
    let (mut count, mut pressure) = (Lanes::ZERO, Lanes::ZERO);
    for node in nodes.as_flattened() {
        count += node.weight;
        pressure = multiply_add::<FUSED>(node.weight, node.pressure, pressure);
    }
    let begin = black_box(match *black_box(guess) {
        Guess::TimeConstant(tau) => tau.ln(),
        Guess::Relaxation { rate, excess, from } => {
            // The sum over the samples is the integral from half an interval before the first to half of one after the last.
            let since = (first - 0.5) * (1.0 / SAMPLE_RATE_HZ) - from;
            time_constant::logarithm_of_guess(rate, excess * (-(rate * since)).exp(), count * (1.0 / SAMPLE_RATE_HZ))
        }
    });
    let mut log_tau = begin;
    let mut found = [Lanes::from(f64::NAN); 3];
    // The step before, and how long the next may be: each turn back at most half as long.
    let (mut last, mut longest) = (Lanes::ZERO, Lanes::ONE);
    // Positive where the search goes on.
    let mut open = black_box(count - (FEWEST - 0.5)).where_positive(Lanes::ONE, Lanes::ZERO);
    let mut rate = Lanes::ZERO;
    let mut last_step = Lanes::ZERO;
    for _ in 0..ITERATIONS {
        rate = black_box((-log_tau).exp());
        let mut sums = Sums::NONE;
        for nodes in &mut *nodes {
            // Keeps the compiler from adding lane by lane.
            let sums = black_box(&mut sums);
            for k in 0..POINTS {
                sums.add::<FUSED>(&mut nodes[k], rate);
            }
        }
        let Solution { step, linear: [rise, rest] } = newton(black_box(&sums), count, pressure);
        let size = step.abs();
        let there = open * each_lane!(i => if size.0[i] < CONVERGED { 1.0 } else { 0.0 });
        found[0] = there.where_positive(reference + rest, found[0]);
        found[1] = there.where_positive(rise, found[1]);
        found[2] = there.where_positive(log_tau + step, found[2]);
        last_step = there.where_positive(step, last_step);
        longest = (-(last * step)).where_positive(last.abs() * 0.5, longest);
        last = step.max(-longest).min(longest);
        // A lane that is there keeps its τ, whatever others need: its nodes keep their e^(−t/τ).
        open -= there;
        log_tau = open.where_positive(log_tau + last, log_tau);
        // A step that is no number ends the search.
        let away = (log_tau - begin).abs() + size * 0.0;
        open = open * each_lane!(i => if away.0[i] < FARTHEST { 1.0 } else { 0.0 });
        if !black_box(open).any_positive() {
            break;
        }
    }
    let [pressure, rise, log_tau] = found;
    let rest = pressure - reference;
    // The last step s is so small that e^(−t/τ) goes on by a factor e^d = 1 + d + d²/2 with d = (t/τ) (s − s²/2).
    let further = black_box(rate * (last_step - last_step * last_step * 0.5));
    let (mut farthest, mut span) = (Lanes::ZERO, [Lanes::ZERO; 2]);
    for node in nodes.as_flattened() {
        let d = node.time * further;
        let bend = multiply_add::<FUSED>(d * 0.5, d, d);
        let decay = multiply_add::<FUSED>(node.decay, bend, node.decay);
        let misfit = node.pressure - rest - rise * decay;
        // Nodes without weight are none of the record's.
        let there = (node.weight - NO_WEIGHT).where_positive(Lanes::ONE, Lanes::ZERO);
        farthest = farthest.max(misfit.abs() * there);
        let pressure = there * node.pressure;
        span = [span[0].min(pressure), span[1].max(pressure)];
    }
    let own = black_box(farthest) / (span[1] - span[0]);
    Regressions([pressure, rise, black_box(log_tau).exp(), own])
}

#[cfg(test)]
pub mod tests {
    use super::*;
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

    /// Where a function between two places is least, by golden section.
    pub fn least(of: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        for _ in 0..60 {
            let (c, d) = (b - golden * (b - a), a + golden * (b - a));
            if of(c) < of(d) { b = d } else { a = c }
        }
        0.5 * (a + b)
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
            prop_assert!((found.time_constant / expected - 1.0).abs() < 2e-5, "{found:?} {expected}");
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
        let Regression { final_pressure: pf, rise, time_constant: found, .. } =
            records.fit(Arch::new(), Guess::TimeConstant(Lanes::from(tau * off))).lane(4).unwrap();
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
            let Regression { final_pressure, rise, time_constant, misfit } = found.lane(lane).unwrap();
            let exponential = |k: usize| final_pressure + rise * (-(k as f64) / SAMPLE_RATE_HZ / time_constant).exp();
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
        let tau = found.lane(3).unwrap().time_constant;
        assert!((tau - 0.01 / 2f64.ln()).abs() < 1e-9, "{tau}");
    }
}
