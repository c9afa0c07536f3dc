//! Many push-and-hold tests at once: the kernel behind parameter studies.
//!
//! A [`Kernel`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.

// Several arrays of lanes side by side, by one index, read as the equations do.
#![allow(clippy::needless_range_loop)]

mod adaptive;
mod advance;
mod clock;
mod corner;
mod course;
mod exact_rows;
mod finish;
mod fit;
mod general;
mod hermite;
pub mod lanes;
mod log;
mod look;
mod math;
mod outcome;
#[cfg(test)]
mod plain;
mod plan;
mod reading;
mod regression;
mod root;
mod samples;
mod scenario;
mod sealed;
mod step;
mod tableau;
#[cfg(test)]
mod tests;

pub use outcome::{Failure, Fit, Outcome};
pub use samples::SAMPLE_RATE_HZ;
pub use scenario::{Hold, Options, Scenario, Solver};

use chamber::AreaLaw;
use chamber::balance::STATES;
use chamber::effects::{self, EffectSet};
use plan::Plan;

/// Scenarios that are solved together: as many as keep their working memory in a core's cache.
pub const CHUNK: usize = 512;

/// Solves each scenario into the outcome of the same index: [`Kernel::run`], with memory for this once.
///
/// # Panics
/// Where the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    Kernel::default().run(set, scenarios, options, out);
}

/// Solves batches one after the other in memory that it keeps.
#[derive(Default)]
pub struct Kernel {
    adaptive: adaptive::Memory,
    course: course::Memory,
    records: regression::Records,
    sorted: Sorted,
}

impl Kernel {
    /// Solves each scenario into the outcome of the same index. `set` must contain every effect that is active in any
    /// of them; a smaller set is faster.
    ///
    /// # Panics
    /// Where the two slices differ in length.
    pub fn run(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
        let arch = pulp::Arch::new();
        let Self { adaptive: memory, course: course_memory, records, sorted } = self;
        for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            sorted.fill(set, scenarios, options, out);
            if options.solver == Solver::Adaptive {
                adaptive::run(arch, memory, &sorted.sealed, scenarios, options, out);
            } else {
                exact_rows::run(arch, records, &sorted.sealed, scenarios, options, out);
            }
            for rows in sorted.others.iter().filter(|rows| !rows.is_empty()) {
                course(arch, course_memory, set, rows, scenarios, options, out);
            }
        }
    }
}

/// A chunk's rows by the way they are solved.
#[derive(Default)]
struct Sorted {
    /// Sealed tests and their durations, s.
    sealed: Vec<(u32, f64)>,
    /// Others, by area law and whether they have a profile: what lanes must have in common.
    others: [Vec<(u32, Plan)>; 4],
}

impl Sorted {
    /// Sorts a chunk; rows that cannot be solved are answered at once.
    fn fill(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        self.sealed.clear();
        self.others.iter_mut().for_each(Vec::clear);
        for (row, (s, out)) in scenarios.iter().zip(out).enumerate() {
            let row = row as u32;
            let flows = s.mass_flow_in_kg_per_s != 0.0 || s.mass_flow_out_kg_per_s != 0.0;
            let sealed = !flows && s.profile.is_none() && (set.is_empty() || s.chamber.active().is_empty());
            if options.solver == Solver::Exact && !sealed {
                *out = Outcome::failed(Failure::NoExactSolution);
                continue;
            }
            if sealed && (set.is_empty() || options.solver != Solver::Adaptive) {
                match plan::check(set, s).and_then(|()| plan::times(s)) {
                    Ok((_, duration)) => self.sealed.push((row, duration)),
                    Err(reason) => *out = Outcome::failed(reason),
                }
                continue;
            }
            let kind =
                usize::from(s.chamber.geometry.area_law == AreaLaw::Swept) + 2 * usize::from(s.profile.is_some());
            match Plan::new(set, s) {
                Ok(plan) => self.others[kind].push((row, plan)),
                Err(reason) => *out = Outcome::failed(reason),
            }
        }
    }
}

/// The bit of the effect of that name in [`EffectSet::bits`].
const fn bit(name: &str) -> u32 {
    let mut index = 0;
    while index < effects::COUNT {
        let (a, b) = (effects::CARDS[index].name.as_bytes(), name.as_bytes());
        let mut same = a.len() == b.len();
        let mut i = 0;
        while same && i < a.len() {
            same = a[i] == b[i];
            i += 1;
        }
        if same {
            return 1 << index;
        }
        index += 1;
    }
    panic!("no effect of that name")
}

/// Rows of any kind, in code of its own for some sets; any other is asked at run time for what it has.
fn course(
    arch: pulp::Arch,
    memory: &mut course::Memory,
    set: EffectSet,
    rows: &[(u32, Plan)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    macro_rules! compiled {
        ($($name:literal)*) => {
            match set.bits() {
                0 => course::run::<2, 0>(arch, memory, set, rows, scenarios, options, out),
                $(bits if bits == const { bit($name) } => {
                    course::run::<{ general::states(bit($name)) }, { bit($name) }>(arch, memory, set, rows, scenarios, options, out)
                })*
                _ => course::run::<STATES, { general::AT_RUN_TIME }>(arch, memory, set, rows, scenarios, options, out),
            }
        };
    }
    compiled!("leakage");
}
