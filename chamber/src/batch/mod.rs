//! Many scenarios at once: the kernel behind parameter studies.
//!
//! [`run`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.

mod fit;
mod outcome;
mod plain;
mod plan;
mod scenario;
#[cfg(test)]
mod tests;

pub use fit::SAMPLE_RATE_HZ;
pub use outcome::{Failure, Fit, Outcome};
pub use scenario::{Hold, Options, Scenario, Solver};

use crate::effects::EffectSet;

/// Solves each scenario into the outcome of the same index. `set` must contain every effect that is active in any of
/// them; a smaller set is faster.
///
/// # Panics
/// Where the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
    for (scenario, outcome) in scenarios.iter().zip(out) {
        *outcome = plain::run(set, scenario, options);
    }
}
