//! A state with a linear decay term, integrated exactly within the stages of [`crate::tableau`].
//!
//! dx/dt = d(t) − μ x with constant μ gives x(c h) = e^(−μ c h) x(0) + ∫ e^(−μ (c h − s)) d(s) ds, s from 0 to c h. The pair
//! approximates ∫ d ds = h Σ a_j d_j, where the moments Σ a_j c_j^k match those of powers of s. Here the decay reduces each
//! moment:
//!
//! Σ a_j(μ) c_j^k = φ_k(μ c h) Σ a_j c_j^k,  φ_k(z) = (k + 1) ∫ e^(−z (1 − s)) s^k ds, s from 0 to 1
//!
//! With μ = 0 the weights are the pair's own. For slowly varying d the state is right however large μ h is: d and the other
//! states alone limit the step, where an explicit method needs μ h < 3.3. Source of such methods: M. Hochbruck and A. Ostermann,
//! Acta Numerica 19 (2010) 209. Times in s, μ in 1/s.

use crate::tableau::{A, C, STAGES};

/// Maximum number of moments, k = 0 to 4, that fix the weights of a stage.
const MOMENTS: usize = 5;

/// Coefficients of the φ_k in the weight of each slope in each stage: by stage, slope, k.
const BY_MOMENT: [[[f64; MOMENTS]; STAGES - 1]; STAGES] = {
    let mut out = [[[0.0; MOMENTS]; STAGES - 1]; STAGES];
    let mut stage = 1;
    while stage < STAGES {
        let mut j = 0;
        while j < stage {
            if A[stage][j] != 0.0 {
                let of_power = lagrange(stage, j);
                let mut k = 0;
                while k < MOMENTS {
                    out[stage][j][k] = of_power[k] * moment(stage, k);
                    k += 1;
                }
            }
            j += 1;
        }
        stage += 1;
    }
    out
};

/// Σ a_j c_j^k of a stage.
const fn moment(stage: usize, k: usize) -> f64 {
    let mut sum = 0.0;
    let mut j = 0;
    while j < stage {
        let mut term = A[stage][j];
        let mut power = 0;
        while power < k {
            term *= C[j];
            power += 1;
        }
        sum += term;
        j += 1;
    }
    sum
}

/// Coefficients of the polynomial that is one at the j-th of the slopes that a stage uses and zero at the others.
const fn lagrange(stage: usize, j: usize) -> [f64; MOMENTS] {
    let mut out = [0.0; MOMENTS];
    out[0] = 1.0;
    let mut i = 0;
    while i < stage {
        if i != j && A[stage][i] != 0.0 {
            let scale = 1.0 / (C[j] - C[i]);
            let mut k = MOMENTS - 1;
            while k > 0 {
                out[k] = (out[k - 1] - C[i] * out[k]) * scale;
                k -= 1;
            }
            out[0] *= -C[i] * scale;
        }
        i += 1;
    }
    out
}

/// φ_k(z), and e^(−z).
fn phi(z: f64) -> ([f64; MOMENTS], f64) {
    /// From this z on, the forward recursion, which divides by z, is stable.
    const LARGE: f64 = 1.5;
    let kept = (-z).exp();
    // Without the factor k + 1 so far: ∫ e^(−z (1 − s)) s^k ds = (1 − k × the one before)/z.
    let mut out = [0.0; MOMENTS];
    if z >= LARGE {
        out[0] = (1.0 - kept) / z;
        for k in 1..MOMENTS {
            out[k] = (1.0 - k as f64 * out[k - 1]) / z;
        }
    } else {
        let mut term = 1.0 / MOMENTS as f64;
        let mut m = MOMENTS as f64;
        while term.abs() > f64::EPSILON * 1e-2 {
            out[MOMENTS - 1] += term;
            m += 1.0;
            term *= -z / m;
        }
        for k in (1..MOMENTS).rev() {
            out[k - 1] = (1.0 - z * out[k]) / k as f64;
        }
    }
    (0..MOMENTS).for_each(|k| out[k] *= (k + 1) as f64);
    (out, kept)
}

/// A decaying state and the weights of the stages of a step.
#[derive(Clone, Copy, Debug)]
pub struct Decay {
    /// Its index among the states.
    pub state: usize,
    /// μ, 1/s.
    pub rate: f64,
    /// Fraction of the initial value left at each stage.
    pub kept: [f64; STAGES],
    /// Weights of the driving term at the earlier stages.
    pub weights: [[f64; STAGES - 1]; STAGES],
    /// Fraction of a change of the driving term that remains after a whole step.
    pub left: f64,
}

impl Decay {
    /// For the state at this index, with the weights of a step of zero length.
    pub fn new(state: usize, rate: f64) -> Self {
        Self { state, rate, kept: [1.0; STAGES], weights: A, left: 1.0 }
    }

    /// Computes the weights for a step length, s.
    pub fn prepare(&mut self, length: f64) {
        let mut of_stage = ([1.0; MOMENTS], 1.0);
        for stage in 1..STAGES {
            // The last two stages are both at the end of the step.
            if C[stage] != C[stage - 1] {
                of_stage = phi(self.rate * C[stage] * length);
            }
            let (phi, kept) = of_stage;
            self.kept[stage] = kept;
            for (weight, by_moment) in self.weights[stage].iter_mut().zip(&BY_MOMENT[stage]) {
                *weight = by_moment.iter().zip(phi).map(|(by, phi)| by * phi).sum();
            }
        }
        self.left = of_stage.0[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_decay_the_weights_are_those_of_the_pair() {
        let mut decay = Decay::new(0, 0.0);
        decay.prepare(0.3);
        let off = |stage: usize, j: usize| (decay.weights[stage][j] - A[stage][j]).abs();
        let worst = (0..STAGES).flat_map(|s| (0..STAGES - 1).map(move |j| off(s, j))).fold(0.0, f64::max);
        assert!(worst < 1e-13 && decay.kept == [1.0; STAGES] && decay.left == 1.0, "{worst:e}");
    }

    #[test]
    fn what_drives_the_state_as_a_polynomial_of_fourth_degree_is_followed_exactly_however_fast_it_decays() {
        for rate in [1e-4, 0.7, 1.49, 1.51, 40.0, 1e4] {
            let mut decay = Decay::new(0, rate);
            decay.prepare(1.0);
            // x = 1 + 2 t − t⁴/2 + 3 e^(−μ t) is driven by dx/dt + μ x.
            let x = |t: f64| 1.0 + 2.0 * t - 0.5 * t.powi(4) + 3.0 * (-rate * t).exp();
            let drive = |t: f64| 2.0 - 2.0 * t.powi(3) + rate * (1.0 + 2.0 * t - 0.5 * t.powi(4));
            let last = STAGES - 1;
            let driven: f64 = (0..last).map(|j| decay.weights[last][j] * drive(C[j])).sum();
            let off = decay.kept[last] * x(0.0) + driven - x(1.0);
            assert!(off.abs() < 1e-12, "{rate}: {off:e}");
        }
    }
}
