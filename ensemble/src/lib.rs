//! Many push-and-hold tests at once: the kernel behind parameter studies.
//!
//! A [`Kernel`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.
//!
//! | a row | is solved by |
//! |---|---|
//! | sealed, without effects | the closed form (`exact_rows`), or where the integrator is asked for its one equation (`sealed`) |
//! | with effects that keep the closed form | the closed form with a changed integrand (`kept`) |
//! | any other | mass, energy and the effects' states, in code for its set of effects where there is some (`general`, `advance`) |
//!
//! Rows of the last kind leave a trace: pressure and temperature with their slopes at the end of each step (`history`).
//! What the sensor does to it is a filter of that trace (`filter`) and costs no steps; peaks, settling and samples are read
//! from it (`reader`).

// Several arrays of lanes side by side, by one index, read as the equations do.
#![allow(clippy::needless_range_loop)]

mod adaptive;
mod advance;
mod clock;
mod corner;
mod course;
mod exact_rows;
mod filter;
mod finish;
mod fit;
mod general;
mod hermite;
mod history;
mod instructions;
mod interpolant;
mod kept;
pub mod lanes;
mod math;
mod outcome;
#[cfg(test)]
mod plain;
mod plan;
mod reader;
mod regression;
mod root;
mod samples;
mod scenario;
mod sealed;
mod step;
mod tableau;
#[cfg(test)]
mod tests;

pub use instructions::InstructionSet;
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
    instructions: InstructionSet,
    adaptive: adaptive::Memory,
    course: course::Memory,
    records: regression::Records,
    sorted: Sorted,
}

impl Kernel {
    /// With instructions of one's choice.
    pub fn new(instructions: InstructionSet) -> Self {
        Self { instructions, ..Self::default() }
    }

    /// Solves each scenario into the outcome of the same index. `set` must contain every effect that is active in any
    /// of them; a smaller set is faster.
    ///
    /// # Panics
    /// Where the two slices differ in length.
    pub fn run(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
        let Self { instructions: InstructionSet(arch), adaptive: memory, course: course_memory, records, sorted } =
            self;
        let arch = *arch;
        for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            sorted.fill(set, scenarios, options, out);
            if options.solver == Solver::Adaptive {
                adaptive::run(arch, memory, &sorted.sealed, scenarios, options, out);
            } else {
                exact_rows::run(arch, records, EffectSet::NONE, &sorted.sealed, scenarios, options, out);
                for rows in sorted.kept.iter().filter(|rows| !rows.is_empty()) {
                    exact_rows::run(arch, records, set.intersection(*kept::EFFECTS), rows, scenarios, options, out);
                }
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
    /// Tests with effects that keep the closed form, and their durations, s, by area law.
    kept: [Vec<(u32, f64)>; 2],
    /// Others, by area law and whether they have a profile: what lanes must have in common.
    others: [Vec<(u32, Plan)>; 4],
}

impl Sorted {
    /// Sorts a chunk; rows that cannot be solved are answered at once.
    fn fill(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        self.sealed.clear();
        self.kept.iter_mut().for_each(Vec::clear);
        self.others.iter_mut().for_each(Vec::clear);
        for (row, (s, out)) in scenarios.iter().zip(out).enumerate() {
            let row = row as u32;
            let swept = usize::from(s.chamber.geometry.area_law == AreaLaw::Swept);
            let closed = s.mass_flow_in_kg_per_s == 0.0 && s.mass_flow_out_kg_per_s == 0.0 && s.profile.is_none();
            let active = if set.is_empty() { set } else { s.chamber.active() };
            let sealed = closed && active.is_empty();
            let kept = closed && options.solver != Solver::Adaptive && kept::EFFECTS.contains(active);
            if options.solver == Solver::Exact && !kept {
                *out = Outcome::failed(Failure::NoExactSolution);
                continue;
            }
            if kept || sealed && set.is_empty() {
                let list = if sealed { &mut self.sealed } else { &mut self.kept[swept] };
                match plan::check(set, s).and_then(|()| plan::times(s)) {
                    Ok((_, duration)) => list.push((row, duration)),
                    Err(reason) => *out = Outcome::failed(reason),
                }
                continue;
            }
            let kind = swept + 2 * usize::from(s.profile.is_some());
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

/// The effects of a set that act on the gas: neither on its reading nor on a record of the stroke.
fn on_the_gas(set: EffectSet) -> EffectSet {
    set.without(effects::of_sensor()).without(effects::of_recorded_stroke())
}

macro_rules! sets_with_code_of_their_own {
    ($([$($name:literal)*])*) => {
        /// Sets of effects that rows are integrated with by code compiled for them, the smallest first.
        const COMPILED: &[u32] = &[0 $(, $(bit($name))|*)*];

        fn course(
            arch: pulp::Arch,
            memory: &mut course::Memory,
            set: EffectSet,
            rows: &[(u32, Plan)],
            scenarios: &[Scenario],
            options: &Options,
            out: &mut [Outcome],
        ) {
            // What the sensor does to a known pressure is no matter of the integration.
            let set = on_the_gas(set);
            match compiled_for(set) {
                _ if matches!(arch, pulp::Arch::Scalar) => {
                    course::run::<STATES, { general::AT_RUN_TIME }>(arch, memory, set, rows, scenarios, options, out)
                }
                Some(0) => course::run::<2, 0>(arch, memory, set, rows, scenarios, options, out),
                $(Some(bits) if bits == const { $(bit($name))|* } => {
                    const BITS: u32 = $(bit($name))|*;
                    course::run::<{ general::states(BITS) }, BITS>(arch, memory, set, rows, scenarios, options, out)
                })*
                _ => course::run::<STATES, { general::AT_RUN_TIME }>(arch, memory, set, rows, scenarios, options, out),
            }
        }
    };
}

/// The bits of the first compiled set that has all effects of a set. Where there is none, rows are asked at run time for
/// what they have, which takes several times as long.
fn compiled_for(set: EffectSet) -> Option<u32> {
    COMPILED.iter().copied().find(|bits| EffectSet::from_bits(*bits).contains(set))
}

sets_with_code_of_their_own![
    ["leakage"]
    ["wall_heating"]
    ["pressure_exponent" "natural_convection" "forced_convection" "gas_column_length" "dead_volume_surface" "warm_wall"]
];
