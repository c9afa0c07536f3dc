//! Many scenarios at once: the kernel behind parameter studies.
//!
//! [`run`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.

mod adaptive;
mod advance;
mod finish;
mod fit;
mod outcome;
mod plain;
mod plan;
mod scenario;
mod sealed;
mod step;
mod tableau;
#[cfg(test)]
mod tests;

pub use fit::SAMPLE_RATE_HZ;
pub use outcome::{Failure, Fit, Outcome};
pub use scenario::{Hold, Options, Scenario, Solver};

use crate::effects::EffectSet;

/// Scenarios that are solved together: as many as keep their working memory in a core's cache.
const CHUNK: usize = 256;

/// Solves each scenario into the outcome of the same index. `set` must contain every effect that is active in any of
/// them; a smaller set is faster.
///
/// # Panics
/// Where the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
    let mut memory = adaptive::Memory::default();
    let mut rows = Vec::new();
    for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
        rows.clear();
        for (row, (s, out)) in scenarios.iter().zip(out.iter_mut()).enumerate() {
            let flows = s.mass_flow_in_kg_per_s != 0.0 || s.mass_flow_out_kg_per_s != 0.0;
            if options.fit || flows || s.profile.is_some() || !set.is_empty() {
                *out = plain::run(set, s, options);
                continue;
            }
            match plan::check(set, s).and_then(|()| plan::times(s)) {
                Ok((_, duration)) => rows.push((row as u32, duration)),
                Err(reason) => *out = Outcome::failed(reason),
            }
        }
        let chunk = Chunk { memory: &mut memory, rows: &rows, scenarios, options, out };
        pulp::Arch::new().dispatch(chunk);
    }
}

/// A chunk's work, compiled for each instruction set.
struct Chunk<'a> {
    memory: &'a mut adaptive::Memory,
    rows: &'a [(u32, f64)],
    scenarios: &'a [Scenario],
    options: &'a Options,
    out: &'a mut [Outcome],
}

impl pulp::WithSimd for Chunk<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        // Every instruction set beyond plain SSE2 that pulp knows of fuses multiplication and addition.
        if S::IS_SCALAR {
            adaptive::run::<false>(self.memory, self.rows, self.scenarios, self.options, self.out);
        } else {
            adaptive::run::<true>(self.memory, self.rows, self.scenarios, self.options, self.out);
        }
    }
}
