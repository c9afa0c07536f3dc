//! Whitening of block residuals: independent innovations of unit variance from a Kalman filter over a record.
//!
//! A block's residual is the sum of white noise, of the recording's coloured noise and hum ([`Noise`]), and of errors that blocks
//! have in common: those of a hold's mean position, of its slope and of the position before, of the time at which the move before
//! ended, and the rounding of readings that stick to one step (which changes as the pressure moves through the step). Each of
//! these is a linear state, so the filter's cost is linear in the number of blocks, and the same operator applies to residuals
//! and to every column of sensitivities.
//!
//! An Ornstein–Uhlenbeck process x of variance σ² and time constant τ averaged over a block of length T = u τ, given x at
//! its start: mean g x, variance σ² (f − g²), covariance with x at the end σ² g (1 − e^(−u)), where
//! g = (1 − e^(−u))/u and f = 2 (u − 1 + e^(−u))/u². Source: R. E. Kalman, J. Basic Eng. 82 (1960) 35; innovations as
//! residuals of a grey-box model: N. R. Kristensen, H. Madsen and S. B. Jørgensen, Automatica 40 (2004) 225.

// Indexed vectors and matrices read like their formulas.
#![allow(clippy::needless_range_loop)]

use crate::record::noise::{FLICKER_COLOURS, Noise};
use nalgebra::{DMatrix, SVector};
use std::f64::consts::TAU;
use std::ops::{Add, Mul, Sub};

/// Number of errors that a segment's means have in common: see `common_sd_pa` of [`crate::record::blocks::Block`].
pub const IN_COMMON: usize = 4;
/// Index of the one due to gas that is too warm or too cold at first.
pub const RELAXING: usize = 3;

/// Most states of the filter: the coloured processes of flicker noise, two of the hum, those that a segment has in common, one of
/// rounding.
const MOST: usize = FLICKER_COLOURS + IN_COMMON + 3;

/// One mean of readings as the filter observes it: its time and the errors in it. Times in s, standard deviations in Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Start of the mean.
    pub begin_s: f64,
    /// Its end; equal to the start for a single reading.
    pub end_s: f64,
    /// Variance of its white part, Pa².
    pub variance: f64,
    /// Standard deviations that the means of one segment have in common.
    pub common_sd_pa: [f64; IN_COMMON],
    /// Index of the rest, move or hold that the block belongs to.
    pub segment: usize,
    /// Standard deviation of rounding, where the readings stick.
    pub rounding_sd_pa: f64,
    /// Correlation of its rounding with that of the mean before: zero where that stuck to another step.
    pub rounding_keeps: f64,
}

type Vector = [f64; MOST];

/// Columns that are whitened together.
const ABREAST: usize = 4;

/// Which states take part, and their indices.
#[derive(Clone, Copy, Debug, Default)]
struct Layout {
    colours: usize,
    hum: Option<usize>,
    held: Option<usize>,
    dwell: Option<usize>,
    count: usize,
}

impl Layout {
    fn of(noise: &Noise, observations: &[Observation]) -> Self {
        let colours = noise.colours.len().min(FLICKER_COLOURS);
        let mut count = colours;
        let mut next = |wanted: bool, states: usize| {
            count += if wanted { states } else { 0 };
            wanted.then(|| count - states)
        };
        let hum = next(noise.hum.is_some(), 2);
        let held = next(observations.iter().any(|p| p.common_sd_pa != [0.0; IN_COMMON]), IN_COMMON);
        let dwell = next(observations.iter().any(|p| p.rounding_sd_pa > 0.0), 1);
        Self { colours, hum, held, dwell, count }
    }

    /// States that restart at this mean, given the one before.
    fn renewed(&self, observation: &Observation, before: Option<&Observation>) -> impl Iterator<Item = usize> + use<> {
        let segment = before.is_none_or(|b| b.segment != observation.segment);
        self.held.filter(|_| segment).map(|at| at..at + IN_COMMON).into_iter().flatten()
    }
}

/// What the filter does at one mean.
#[derive(Clone, Copy, Debug)]
struct Step {
    observe: Vector,
    keep: Vector,
    /// Cosine and sine of the hum's phase step to the next mean, with damping.
    turn: [f64; 2],
    gain: Vector,
    per_sd: f64,
}

/// The operator that makes a record's residuals white.
#[derive(Clone, Debug, Default)]
pub struct Whitener {
    layout: Layout,
    steps: Vec<Step>,
}

impl Whitener {
    /// For these means, with this noise.
    pub fn new(noise: &Noise, observations: &[Observation]) -> Self {
        let layout = Layout::of(noise, observations);
        let mut covariance = [[0.0; MOST]; MOST];
        for (k, colour) in noise.colours.iter().take(layout.colours).enumerate() {
            covariance[k][k] = colour.sd_pa * colour.sd_pa;
        }
        if let (Some(at), Some(hum)) = (layout.hum, noise.hum) {
            covariance[at][at] = hum.sd_pa * hum.sd_pa;
            covariance[at + 1][at + 1] = hum.sd_pa * hum.sd_pa;
        }
        if let Some(at) = layout.dwell {
            covariance[at][at] = 1.0;
        }
        let mut steps: Vec<Step> = Vec::with_capacity(observations.len());
        for (i, observation) in observations.iter().enumerate() {
            for state in layout.renewed(observation, i.checked_sub(1).map(|b| &observations[b])) {
                renew(&mut covariance, state);
                // A state that restarts forgets its past.
                if let Some(before) = steps.last_mut() {
                    (before.keep[state], before.gain[state]) = (0.0, 0.0);
                }
            }
            steps.push(step(&layout, noise, observation, observations.get(i + 1), &mut covariance));
        }
        Self { layout, steps }
    }

    /// Σ ln of the variances of the first `count` innovations: what a likelihood needs beside the squares.
    pub fn log_determinant_of(&self, count: usize) -> f64 {
        self.steps.iter().take(count).map(|step| -2.0 * step.per_sd.ln()).sum()
    }

    /// Whitens a column in place; it may be shorter than the record.
    pub fn apply(&self, column: &mut [f64]) {
        self.apply_abreast(&mut [column]);
    }

    /// Whitens every column.
    pub fn apply_to(&self, matrix: &mut DMatrix<f64>) {
        let rows = matrix.nrows().max(1);
        let mut columns: Vec<&mut [f64]> = matrix.as_mut_slice().chunks_exact_mut(rows).collect();
        let (groups, rest) = columns.as_chunks_mut::<ABREAST>();
        groups.iter_mut().for_each(|group| self.apply_abreast(group));
        rest.iter_mut().for_each(|column| self.apply(column));
    }

    /// Whitens columns of the same length, row by row: each depends on its own previous rows only.
    fn apply_abreast<const N: usize>(&self, columns: &mut [&mut [f64]; N]) {
        let count = self.layout.count;
        let mut state = [SVector::<f64, N>::zeros(); MOST];
        for (row, step) in self.steps.iter().enumerate().take(columns[0].len()) {
            let mut innovation = SVector::from_fn(|k, _| columns[k][row]);
            for k in 0..count {
                innovation -= state[k] * step.observe[k];
            }
            let white = innovation * step.per_sd;
            columns.iter_mut().zip(&white).for_each(|(column, white)| column[row] = *white);
            carry(&self.layout, step, &mut state);
            for k in 0..count {
                state[k] += innovation * step.gain[k];
            }
        }
    }
}

/// Carries a state, or those of several columns, to the next mean.
#[inline]
fn carry<T>(layout: &Layout, step: &Step, state: &mut [T; MOST])
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let turned = layout.hum.map(|at| {
        let ([c, s], [cos, sin]) = ([state[at], state[at + 1]], step.turn);
        (at, [c * cos + s * sin, s * cos - c * sin])
    });
    for k in 0..layout.count {
        state[k] = state[k] * step.keep[k];
    }
    if let Some((at, turned)) = turned {
        state[at..at + 2].copy_from_slice(&turned);
    }
}

/// Resets a state to its prior variance of one, independent of the others.
fn renew(covariance: &mut [Vector; MOST], state: usize) {
    covariance[state] = [0.0; MOST];
    covariance.iter_mut().for_each(|row| row[state] = 0.0);
    covariance[state][state] = 1.0;
}

/// The filter's step at one mean; carries the covariance to the next one.
fn step(
    layout: &Layout,
    noise: &Noise,
    observation: &Observation,
    next: Option<&Observation>,
    covariance: &mut [Vector; MOST],
) -> Step {
    let count = layout.count;
    let length = observation.end_s - observation.begin_s;
    let gap = next.map_or(0.0, |n| (n.begin_s - observation.end_s).max(0.0));
    let mut out = Step { observe: [0.0; MOST], keep: [1.0; MOST], turn: [0.0; 2], gain: [0.0; MOST], per_sd: 0.0 };
    let (mut cross, mut added) = ([0.0; MOST], [0.0; MOST]);
    let mut own = observation.variance;
    for (k, colour) in noise.colours.iter().take(layout.colours).enumerate() {
        let (variance, u) = (colour.sd_pa * colour.sd_pa, length / colour.time_s);
        let [g, f] = averages(u);
        let (decay, wait) = ((-u).exp(), (-gap / colour.time_s).exp());
        (out.observe[k], out.keep[k]) = (g, decay * wait);
        own += variance * (f - g * g).max(0.0);
        cross[k] = variance * g * (1.0 - decay) * wait;
        added[k] = variance * (1.0 - (decay * wait).powi(2));
    }
    if let (Some(at), Some(hum)) = (layout.hum, noise.hum) {
        let angle = 0.5 * TAU * hum.frequency_hz * length;
        out.observe[at] = if angle > 1e-6 { angle.sin() / angle } else { 1.0 };
        let middle = |p: &Observation| 0.5 * (p.begin_s + p.end_s);
        let ahead = next.map_or(0.0, |n| middle(n) - middle(observation));
        let damping = (-ahead / hum.coherence_s).exp();
        let (sin, cos) = (TAU * hum.frequency_hz * ahead).sin_cos();
        out.turn = [cos * damping, sin * damping];
        added[at] = hum.sd_pa * hum.sd_pa * (1.0 - damping * damping);
        added[at + 1] = added[at];
    }
    if let Some(at) = layout.held {
        out.observe[at..at + IN_COMMON].copy_from_slice(&observation.common_sd_pa);
    }
    if let Some(at) = layout.dwell {
        out.observe[at] = observation.rounding_sd_pa;
        out.keep[at] = next.map_or(0.0, |n| n.rounding_keeps);
        added[at] = 1.0 - out.keep[at] * out.keep[at];
    }

    // P Hᵀ and S = H P Hᵀ + R; P Hᵀ and P itself are then carried to the next mean.
    let mut along = [0.0; MOST];
    for i in 0..count {
        along[i] = (0..count).map(|j| covariance[i][j] * out.observe[j]).sum();
    }
    let variance = own + (0..count).map(|i| out.observe[i] * along[i]).sum::<f64>();
    carry(layout, &out, &mut along);
    for k in 0..count {
        out.gain[k] = (along[k] + cross[k]) / variance;
    }
    for _ in 0..2 {
        for row in covariance.iter_mut().take(count) {
            carry(layout, &out, row);
        }
        for i in 0..count {
            for j in 0..i {
                let swapped = covariance[i][j];
                covariance[i][j] = covariance[j][i];
                covariance[j][i] = swapped;
            }
        }
    }
    for i in 0..count {
        for j in 0..count {
            covariance[i][j] -= out.gain[i] * out.gain[j] * variance;
        }
        covariance[i][i] += added[i];
    }
    out.per_sd = 1.0 / variance.sqrt();
    out
}

/// g and f of a mean over u time constants.
fn averages(u: f64) -> [f64; 2] {
    if u < 1e-3 {
        return [1.0 - u / 2.0 + u * u / 6.0, 1.0 - u / 3.0 + u * u / 12.0];
    }
    let decay = (-u).exp();
    [(1.0 - decay) / u, 2.0 * (u - 1.0 + decay) / (u * u)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::noise::{Colour, Hum};

    /// The covariance of the means, written out.
    fn covariance(noise: &Noise, observations: &[Observation]) -> DMatrix<f64> {
        DMatrix::from_fn(observations.len(), observations.len(), |i, j| {
            let (a, b) =
                if i <= j { (&observations[i], &observations[j]) } else { (&observations[j], &observations[i]) };
            let mut sum = if i == j { a.variance } else { 0.0 };
            for colour in &noise.colours {
                let u = |p: &Observation| (p.end_s - p.begin_s) / colour.time_s;
                let share = match i == j {
                    true => averages(u(a))[1],
                    false => averages(u(a))[0] * averages(u(b))[0] * (-(b.begin_s - a.end_s) / colour.time_s).exp(),
                };
                sum += colour.sd_pa * colour.sd_pa * share;
            }
            if let Some(hum) = noise.hum {
                let weight = |p: &Observation| {
                    let angle = 0.5 * TAU * hum.frequency_hz * (p.end_s - p.begin_s);
                    if angle > 0.0 { angle.sin() / angle } else { 1.0 }
                };
                let ahead = 0.5 * (b.begin_s + b.end_s - a.begin_s - a.end_s);
                sum += hum.sd_pa.powi(2)
                    * weight(a)
                    * weight(b)
                    * (TAU * hum.frequency_hz * ahead).cos()
                    * (-ahead / hum.coherence_s).exp();
            }
            if a.segment == b.segment {
                sum += (0..IN_COMMON).map(|k| a.common_sd_pa[k] * b.common_sd_pa[k]).sum::<f64>();
            }
            let (first, last) = (i.min(j), i.max(j));
            let kept: f64 = observations[first + 1..=last].iter().map(|p| p.rounding_keeps).product();
            sum + kept * a.rounding_sd_pa * b.rounding_sd_pa
        })
    }

    #[test]
    fn the_filter_is_a_root_of_the_inverse_covariance() {
        let noise = Noise {
            colours: vec![Colour { sd_pa: 3.0, time_s: 0.4 }, Colour { sd_pa: 1.5, time_s: 5.0 }],
            hum: Some(Hum { sd_pa: 2.0, frequency_hz: 0.7, coherence_s: 3.0 }),
            ..Noise::white(1.0)
        };
        let observation = |k: usize| Observation {
            begin_s: 0.1 * k as f64,
            end_s: 0.1 * k as f64 + if k.is_multiple_of(3) { 0.0 } else { 0.08 },
            variance: 1.0 + 0.1 * k as f64,
            common_sd_pa: [0.5, 0.1 * k as f64, -0.2, 0.3 / (1.0 + k as f64)],
            segment: k / 5,
            rounding_sd_pa: if k > 4 { 1.2 } else { 0.0 },
            rounding_keeps: if k.is_multiple_of(4) { 0.0 } else { 0.7 },
        };
        let observations: Vec<Observation> = (0..14).map(observation).collect();
        let whitener = Whitener::new(&noise, &observations);
        let mut root = DMatrix::identity(14, 14);
        whitener.apply_to(&mut root);
        let product = root.transpose() * root * covariance(&noise, &observations);
        assert!((product - DMatrix::<f64>::identity(14, 14)).norm() < 1e-9);
        let determinant = covariance(&noise, &observations).determinant().ln();
        assert!((whitener.log_determinant_of(14) - determinant).abs() < 1e-9);
    }
}
