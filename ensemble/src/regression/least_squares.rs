//! The least-squares fit of P = Pf + ΔP e^(−t/τ), one record per lane. Pf and ΔP enter linearly and are eliminated (variable projection:
//! G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413); what is left is Newton's method in ln τ, which takes one step
//! from a good guess.

use super::samples::{POINTS, SAMPLE_RATE_HZ};
use super::time_constant;
use crate::lanes::math::decay;
use crate::lanes::{Lanes, each_lane, multiply_add};
use chamber::real::Real;
use chamber::seven_steps;
use core::hint::black_box;

const ITERATIONS: usize = 60;
/// Change of ln τ below which the next one would be at most its square.
const CONVERGED: f64 = 2e-3;
/// Newton's curvature is used if it is at least this fraction of the Gauss–Newton curvature.
const CONVEX: f64 = 0.3;
/// Largest distance from the guess, in ln τ.
const FARTHEST: f64 = 12.0;
/// Nodes of smaller weight do not count.
const NO_WEIGHT: f64 = 1e-6;
/// Fewest samples that determine the parameters.
const FEWEST: f64 = 5.0;

/// A node of all records: time after the first sample, pressure relative to the first one, number of samples it represents, and
/// e^(−t/τ) for the last τ.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    pub time: Lanes,
    pub pressure: Lanes,
    pub weight: Lanes,
    pub decay: Lanes,
}

impl Node {
    pub const NONE: Self = Self { time: Lanes::ZERO, pressure: Lanes::ZERO, weight: Lanes::ZERO, decay: Lanes::ONE };
}

/// The initial guess of τ.
// Made once per group of lanes and not stored.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
pub enum Guess {
    /// τ, s.
    TimeConstant(Lanes),
    /// The τ of a sealed relaxation, whose ε = 1 − Pf/P decays exponentially.
    Relaxation {
        /// k, 1/s.
        rate: Lanes,
        /// ε at the time `from`.
        excess: Lanes,
        /// In s from the start of the test.
        from: Lanes,
    },
}

/// The fit to one record.
#[derive(Clone, Copy, Debug)]
pub struct Regression {
    /// Pf, ΔP and τ.
    pub exponential: seven_steps::Regression,
    /// Largest residual, relative to the record's own range.
    pub misfit: f64,
}

/// Pf and ΔP, Pa, and τ, s, by lane, NaN if the record does not determine them; and the largest residual, relative to the record's
/// own range.
#[derive(Clone, Copy, Debug)]
pub struct Regressions([Lanes; 4]);

impl Regressions {
    /// The fit of one lane; `None` if its record does not determine it.
    pub fn lane(&self, lane: usize) -> Option<Regression> {
        let [final_pressure_pa, pressure_rise_pa, time_constant_s, misfit] = self.0.map(|found| found[lane]);
        let found = [final_pressure_pa, pressure_rise_pa, time_constant_s].iter().all(|v| v.is_finite());
        let exponential = seven_steps::Regression { final_pressure_pa, pressure_rise_pa, time_constant_s };
        found.then_some(Regression { exponential, misfit })
    }
}

/// Sums over a record's samples with e = e^(−t/τ), g = (t/τ) e and h = (t/τ) g, of which the derivatives by ln τ consist.
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
    const NONE: Self = {
        let o = Lanes::ZERO;
        Self { e: o, g: o, h: o, ee: o, eg: o, gg: o, pe: o, pg: o, ph: o }
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

/// The result of the sums at one τ.
struct Solution {
    /// Newton's step of ln τ.
    step: Lanes,
    /// ΔP, and Pf relative to the reference, after the step.
    linear: [Lanes; 2],
}

/// Newton's step, also given the sums of the weights and of the pressures.
#[inline(always)]
fn newton(s: &Sums, count: Lanes, pressure: Lanes) -> Solution {
    let share = count.recip();
    // With the constant eliminated; Σ h e is Σ g².
    let (mean_e, mean_g, mean_h) = (s.e * share, s.g * share, s.h * share);
    let (ee, eg, gg, he) = (s.ee - mean_e * s.e, s.eg - mean_e * s.g, s.gg - mean_g * s.g, s.gg - mean_h * s.e);
    let (pe, pg, ph) = (s.pe - mean_e * pressure, s.pg - mean_g * pressure, s.ph - mean_h * pressure);
    let rise = pe / ee;
    let per_rise = rise.recip();
    // Products of the residuals, relative to ΔP, with g and with dg/d ln τ = h − g.
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

/// The least-squares fit; each lane as if it were alone.
#[inline(always)]
pub fn least_squares<const FUSED: bool>(
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
            // The sum over the samples approximates the integral from half an interval before the first to half one after the last.
            let since = (first - 0.5) * (1.0 / SAMPLE_RATE_HZ) - from;
            time_constant::logarithm_of_guess(rate, excess * (-(rate * since)).exp(), count * (1.0 / SAMPLE_RATE_HZ))
        }
    });
    let mut log_tau = begin;
    let mut found = [Lanes::from(f64::NAN); 3];
    // The previous step, and the limit of the next: half the step at each reversal.
    let (mut last, mut longest) = (Lanes::ZERO, Lanes::ONE);
    // Positive while a lane is not done.
    let mut open = black_box(count - (FEWEST - 0.5)).where_positive(Lanes::ONE, Lanes::ZERO);
    let mut rate = Lanes::ZERO;
    let mut last_step = Lanes::ZERO;
    for _ in 0..ITERATIONS {
        rate = black_box((-log_tau).exp());
        let mut sums = Sums::NONE;
        for nodes in &mut *nodes {
            // Prevents the compiler from adding lane by lane.
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
        // A converged lane keeps its τ, and its nodes their e^(−t/τ), while others continue.
        open -= there;
        log_tau = open.where_positive(log_tau + last, log_tau);
        // A NaN step ends the search.
        let away = (log_tau - begin).abs() + size * 0.0;
        open = open * each_lane!(i => if away.0[i] < FARTHEST { 1.0 } else { 0.0 });
        if !black_box(open).any_positive() {
            break;
        }
    }
    let [pressure, rise, log_tau] = found;
    let rest = pressure - reference;
    // The last step s is so small that e^(−t/τ) changes by a factor e^d = 1 + d + d²/2 with d = (t/τ) (s − s²/2).
    let further = black_box(rate * (last_step - last_step * last_step * 0.5));
    let (mut farthest, mut span) = (Lanes::ZERO, [Lanes::ZERO; 2]);
    for node in nodes.as_flattened() {
        let d = node.time * further;
        let bend = multiply_add::<FUSED>(d * 0.5, d, d);
        let decay = multiply_add::<FUSED>(node.decay, bend, node.decay);
        let misfit = node.pressure - rest - rise * decay;
        // Nodes without weight do not belong to the record.
        let there = (node.weight - NO_WEIGHT).where_positive(Lanes::ONE, Lanes::ZERO);
        farthest = farthest.max(misfit.abs() * there);
        let pressure = there * node.pressure;
        span = [span[0].min(pressure), span[1].max(pressure)];
    }
    let own = black_box(farthest) / (span[1] - span[0]);
    Regressions([pressure, rise, black_box(log_tau).exp(), own])
}
