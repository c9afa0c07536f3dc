//! The response of the wall's modes, x' = c d − μ x, over a step on which d is a polynomial: the exact solution, however large μ h is.

use super::lengths::{LENGTHS, length};
use super::rule::{NODES, PLACES, RULE};
use crate::filter;
use crate::instructions::Wide;
use crate::lanes::Lanes;
use chamber::effects::wall_conduction::{KERNEL, MODES, Mode};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};
use std::sync::OnceLock;

/// The response of the modes to d over a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response<R> {
    /// Length of the step, s.
    pub length: R,
    /// Fraction of each mode that is left at each node.
    pub decay: [[R; MODES]; NODES],
    /// Warming of the surface up to each node by the values of d, s^½.
    pub warming: [[R; NODES]; NODES],
    /// Contribution of the values of d to each mode at the end, s^½.
    pub fed: [[R; NODES]; MODES],
}

impl<R: Real> Response<R> {
    /// Computes the response over a length, s.
    #[inline(always)]
    fn work_out(&mut self, length: R) {
        let rule = &*RULE;
        (self.length, self.warming) = (length, [[R::ZERO; NODES]; NODES]);
        for mode in 0..black_box(MODES) {
            let Mode { rate, weight } = KERNEL[mode];
            for node in 0..black_box(NODES) {
                let place = PLACES[node];
                let w = length * (rate * place);
                let faded = filter::decay_factor(w);
                self.decay[node][mode] = faded;
                // A sensor with a lag of 1/μ shows the fraction g of a power of the place: μ times the integral.
                let shares = filter::shares(w, faded);
                for from in 0..black_box(NODES) {
                    let (mut shown, mut power) = (R::ZERO, weight / rate);
                    for k in 0..NODES {
                        shown += shares[k] * (rule.powers[from][k] * power);
                        power *= place;
                    }
                    self.warming[node][from] += shown;
                    // The last node is the end.
                    self.fed[mode][from] = shown;
                }
            }
        }
    }
}

impl Response<f64> {
    /// The response over the step of an index: see [`length`].
    pub fn of(number: usize) -> &'static Self {
        static ALL: [OnceLock<Response<f64>>; LENGTHS] = [const { OnceLock::new() }; LENGTHS];
        ALL[number].get_or_init(|| {
            let mut response = Self::default();
            response.work_out(length(number));
            response
        })
    }
}

impl Response<Lanes> {
    /// Computes the responses over a length, s, in each lane, unless they are those of the last call.
    pub fn reach(&mut self, length: Lanes, arch: Arch) {
        if self.length != length {
            arch.dispatch(Wide(WorkOutResponses { response: self, length }));
        }
    }
}

struct WorkOutResponses<'a> {
    response: &'a mut Response<Lanes>,
    length: Lanes,
}

impl WithSimd for WorkOutResponses<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        self.response.work_out(black_box(self.length));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::gauss;

    /// x' = c d − μ x over a step of d = 1 − 2 (t/h) + 3 (t/h)^4, by a Gauss rule over short parts.
    #[test]
    fn modes_respond_as_their_equations_say_from_slow_to_stiff() {
        let drive = |x: f64| 1.0 - 2.0 * x + 3.0 * x.powi(4);
        for length in [1e-3, 0.03, 0.5, 20.0] {
            let mut response = Response::default();
            response.work_out(length);
            let values = PLACES.map(drive);
            let mut surface = [0.0; NODES];
            for (mode, of) in KERNEL.iter().enumerate() {
                let up_to = |place: f64| {
                    let parts = (of.rate * length).ceil().max(4.0) as usize;
                    let part = |k: usize| {
                        (0..gauss::NODES).map(gauss::node).map(move |(x, w)| {
                            let at = place * (k as f64 + x) / parts as f64;
                            let decay = (-of.rate * length * (place - at)).exp();
                            w * place * length / parts as f64 * decay * drive(at)
                        })
                    };
                    of.weight * (0..parts).flat_map(part).sum::<f64>()
                };
                let fed: f64 = values.iter().zip(response.fed[mode]).map(|(d, fed)| d * fed).sum();
                assert!((fed / up_to(1.0) - 1.0).abs() < 1e-11, "{length} {mode}: {fed} {}", up_to(1.0));
                for (node, place) in PLACES.into_iter().enumerate() {
                    surface[node] += up_to(place);
                }
            }
            for node in 0..NODES {
                let warming: f64 = values.iter().zip(response.warming[node]).map(|(d, by)| d * by).sum();
                assert!((warming / surface[node] - 1.0).abs() < 1e-11, "{length} {node}: {warming} {}", surface[node]);
            }
        }
    }
}
