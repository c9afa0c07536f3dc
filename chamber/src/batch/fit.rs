//! The paper's steps 1 to 7 on a computed relaxation.
//!
//! Step 1, P = Pf + ΔP e^(−t/τ), is linear in Pf and ΔP: one nonlinear parameter is left (variable projection with
//! Kaufman's simplification, BIT 15 (1975) 49). The sums over the samples of a record at 100 Hz are taken as integrals
//! with Gregory's corrections at both ends: the same sums to about 1e-6, at a fraction of the pressures.

use super::outcome::Fit;
use super::scenario::Scenario;
use crate::AreaLaw;
use crate::Geometry;
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Rate of the record that the regression is meant for, Hz.
pub const SAMPLE_RATE_HZ: f64 = 100.0;
const ITERATIONS: usize = 60;
/// Change of ln τ after which the next one would be some fifty times smaller still.
const CONVERGED: f64 = 1e-5;
/// As many samples from the peak on are summed one by one where a sensor may lag: it moves fast there.
pub const LAGGING: usize = 16;
/// A record of at most as many samples is summed one by one.
const FEW: usize = 40;

/// Nodes and weights of 4-point Gauss–Legendre quadrature on [−1, 1].
pub const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Σ over the samples 0 to `last` of a record as single samples and, for a long one, the integral in between.
pub struct Samples {
    single: [(f64, f64); FEW],
    count: usize,
    integral: Option<f64>,
}

impl Samples {
    /// For samples numbered 0 to `last`, the first `one_by_one` of them (at most [`LAGGING`]) summed singly in any case.
    pub fn new(last: f64, one_by_one: usize) -> Self {
        let first = one_by_one.min(LAGGING);
        let mut single = [(0.0, 1.0); FEW];
        if last < FEW as f64 {
            let count = last as usize + 1;
            for (k, s) in single.iter_mut().enumerate() {
                s.0 = k as f64;
            }
            return Self { single, count, integral: None };
        }
        for (k, s) in single.iter_mut().enumerate().take(first) {
            s.0 = k as f64;
        }
        // Gregory: Σ f = ∫ f + (f0 + fN)/2 − (Δf0 − ∇fN)/12 + (Δ²f0 + ∇²fN)/24 − …
        let weights = [0.5 + 1.0 / 12.0 + 1.0 / 24.0, -1.0 / 12.0 - 2.0 / 24.0, 1.0 / 24.0];
        for (k, w) in weights.into_iter().enumerate() {
            single[first + k] = ((first + k) as f64, w);
            single[first + 3 + k] = (last - k as f64, w);
        }
        Self { single, count: first + 6, integral: Some(first as f64) }
    }

    /// Numbers and weights of single samples.
    pub fn single(&self) -> &[(f64, f64)] {
        &self.single[..self.count]
    }

    /// The sample from which to the last the integral over the sample number belongs to the sum.
    pub fn integral(&self) -> Option<f64> {
        self.integral
    }
}

/// Pressures, Pa, at times after the first sample, s, each with the number of samples it stands for.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    lanes: Vec<[Lanes; 3]>,
    count: usize,
    reference: f64,
}

impl Nodes {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.lanes.clear();
        self.count = 0;
    }

    /// Adds a lane's width of them, to a number of nodes that is a multiple of that width.
    #[inline(always)]
    pub fn push_lanes(&mut self, time: Lanes, pressure: Lanes, weight: Lanes) {
        debug_assert_eq!(self.count % WIDTH, 0);
        if self.count == 0 {
            self.reference = pressure[0];
        }
        self.lanes.push([time, pressure - self.reference, weight]);
        self.count += WIDTH;
    }

    /// Adds one.
    #[inline(always)]
    pub fn push(&mut self, time: f64, pressure: f64, weight: f64) {
        let lane = self.count % WIDTH;
        if lane == 0 {
            self.lanes.push([Lanes::ZERO; 3]);
        }
        if self.count == 0 {
            self.reference = pressure;
        }
        if let Some([t, p, w]) = self.lanes.last_mut() {
            (t[lane], p[lane], w[lane]) = (time, pressure - self.reference, weight);
        }
        self.count += 1;
    }

    /// Replaces all pressures, Pa, by those at the nodes' times, s.
    #[inline(always)]
    pub fn set_pressures(&mut self, pressure: impl Fn(Lanes) -> Lanes) {
        for (index, [t, p, _]) in self.lanes.iter_mut().enumerate() {
            let value = black_box(pressure(*black_box(&*t)));
            if index == 0 {
                self.reference = value[0];
            }
            *p = value - self.reference;
        }
    }
}

/// τ, s, of the exponential that falls in one 1/k as a sealed relaxation does, whose ε = 1 − Pf/P decays with the
/// rate k, 1/s, from `excess` on: near to what least squares find.
pub fn time_constant(rate: f64, excess: f64) -> f64 {
    let later = excess * (-1f64).exp();
    1.0 / (rate * (1.0 + ((1.0 - later) / (1.0 - excess)).ln()))
}

/// Least squares of P = Pf + ΔP e^(−t/τ), to be dispatched: Pf, ΔP in Pa and τ in s; none where the record determines
/// none.
pub struct Exponential<'a> {
    /// The record.
    pub nodes: &'a Nodes,
    /// τ to start from, s.
    pub guess: f64,
}

impl WithSimd for Exponential<'_> {
    type Output = Option<[f64; 3]>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { nodes, guess } = self;
        let mut log_tau = guess.ln();
        let begin = log_tau;
        for _ in 0..ITERATIONS {
            let per_tau = (-log_tau).exp();
            let mut sums = [Lanes::ZERO; 9];
            for [t, p, w] in &nodes.lanes {
                // Keeps the compiler from adding lane by lane.
                let sums = black_box(&mut sums);
                let x = *t * per_tau;
                let e = (-x).exp();
                let g = x * e;
                let (we, wg) = (*w * e, *w * g);
                sums[0] += *w;
                sums[1] += we;
                sums[2] += wg;
                sums[3] += we * e;
                sums[4] += we * g;
                sums[5] += wg * g;
                sums[6] += *w * *p;
                sums[7] += we * *p;
                sums[8] += wg * *p;
            }
            let mut total = [0.0; 9];
            for (total, sum) in total.iter_mut().zip(&sums) {
                *total = sum.total();
            }
            let [n, e, g, ee, eg, gg, p, pe, pg] = total;
            // Centred on the constant, then on e.
            let (see, seg, sgg) = (ee - e * e / n, eg - e * g / n, gg - g * g / n);
            let (spe, spg) = (pe - p * e / n, pg - p * g / n);
            let rise = spe / see;
            let step = (spg - spe * seg / see) / (rise * (sgg - seg * seg / see));
            if !step.is_finite() {
                return None;
            }
            if step.abs() < CONVERGED {
                return Some([nodes.reference + (p - rise * e) / n, rise, 1.0 / per_tau]);
            }
            log_tau += step.clamp(-1.0, 1.0);
            if (log_tau - begin).abs() > 12.0 {
                return None;
            }
        }
        None
    }
}

/// Steps 2 to 7 on the result of step 1, as published: Aq by (27) with all the gas's volume. None where pressures and
/// strokes contradict each other.
pub fn steps(scenario: &Scenario, positions: [f64; 2], initial_pressure: f64, regression: [f64; 3]) -> Option<Fit> {
    let [pf, rise, tau] = regression;
    let c = &scenario.chamber;
    let swept = positions.map(|x| c.geometry.piston_area * x);
    let rt = c.gas.gas_constant * scenario.ambient_temperature_k;
    let mass = (swept[0] - swept[1]) / rt * (initial_pressure * pf / (pf - initial_pressure));
    let dead_volume = mass * rt / initial_pressure - swept[0];
    let volume = dead_volume + swept[1];
    let as_published = Geometry { dead_volume, area_law: AreaLaw::Total, ..c.geometry };
    let area = as_published.heat_transfer_area(volume);
    let lambda_av = mass * c.gas.cv() / tau / area;
    let settling_in_tau = 100f64.ln();
    let pressure_av = pf + rise * 0.99 / settling_in_tau;
    let temperature_av = volume * pressure_av / (mass * c.gas.gas_constant);
    let h = &c.heat_transfer;
    let lambda0 = lambda_av * (h.reference_pressure * h.reference_temperature / (pressure_av * temperature_av)).sqrt();
    (mass > 0.0 && volume > 0.0 && lambda0.is_finite()).then_some(Fit {
        final_pressure_pa: pf,
        pressure_rise_pa: rise,
        time_constant_s: tau,
        lambda_av_w_per_m2_k: lambda_av,
        lambda0_w_per_m2_k: lambda0,
    })
}
