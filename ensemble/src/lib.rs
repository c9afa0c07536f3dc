//! The batch kernel behind parameter studies: solves many push-and-hold tests at once, in SIMD lanes.
//!
//! A [`Kernel`] runs on one thread. Each result is a pure function of its scenario: its bits depend neither on the other scenarios
//! nor on their order. The caller distributes chunks over threads.
//!
//! | row | solved by | in |
//! |---|---|---|
//! | sealed, no effects | the closed form | `closed::rows` |
//! | effects that keep the closed form | the closed form with other constants, or with a modified integrand | `closed::with_effects` |
//! | either of these, read by a sensor with effects | the same, filtered | `closed::readings` |
//! | sealed, integrator requested | one equation | `systems::sealed` |
//! | wall heating only | two equations; their Taylor series in the hold | `systems::wall_heating` |
//! | decaying turbulence only | two equations | `systems::decaying_turbulence` |
//! | empirical heat flow as a function of pressure only | one equation | `systems::empirical_heat_flow` |
//! | one leak, or constant flows with at most one leak | two equations | `systems::flows` |
//! | natural convection only, gas on one side of the wall's temperature | two equations; a series in the hold | `systems::natural_convection` |
//! | wall conduction only | gas and wall modes; collocation in the hold | `systems::wall_conduction` |
//! | any other | mass, energy and the effects' states, by code compiled for its set of effects if there is any | `general` |
//! | of these: tight, effects without states | integral over temperature in the hold | `general::relaxation` |
//! | of these: tight, wall conduction beside effects that keep the closed form | collocation in the hold | `general::wall_conduction` |
//!
//! `Kernel::add` chooses the path. Without wide instructions (`instructions`) `general` integrates every row without a closed form
//! throughout.
//!
//! Rows of `general` leave a trace: pressure, temperature and their slopes at the end of each step (`general::history`). The sensor
//! is applied to the trace as a filter (`filter`) and finally as a curve of the reading (`reader::bends`); it costs no steps. Peaks,
//! settling times and samples are read from the result (`reader`).

// Indexing several arrays of lanes by one index reads like the equations.
#![allow(clippy::needless_range_loop)]
// Unit tests never integrate batches, see `compiled_sets`.
#![cfg_attr(test, allow(dead_code, unused_imports, unused_variables))]

mod batch;
mod chambers;
mod closed;
mod conduction;
mod ending;
mod filter;
mod general;
mod instructions;
mod integrator;
pub mod lanes;
mod numerics;
mod outcome;
mod plan;
mod query;
mod reader;
mod regression;
mod scenario;
mod sensor;
mod sets;
mod systems;

pub use batch::CHUNK;
pub use general::compiled::has_code_of_its_own;
pub use instructions::InstructionSet;
pub use outcome::{Failure, Fit, Outcome};
pub use scenario::{Options, Scenario, Solver};

use batch::{Batch, Features};
use chamber::effects::EffectSet;
use closed::ClosedRows;
use general::GeneralRows;
use systems::Systems;

/// Writes the outcome of each scenario to the same index: [`Kernel::run`] with temporary working memory.
///
/// # Panics
/// If the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    Kernel::default().run(set, scenarios, options, out);
}

/// Solves batches one after the other and keeps its working memory: one field per path.
#[derive(Default)]
pub struct Kernel {
    instructions: InstructionSet,
    closed: ClosedRows,
    systems: Systems,
    general: GeneralRows,
}

impl Kernel {
    /// A kernel that uses a given instruction set.
    pub fn new(instructions: InstructionSet) -> Self {
        Self { instructions, ..Self::default() }
    }

    /// Writes the outcome of each scenario to the same index. `set` must contain every effect that is active in any scenario; a
    /// smaller set is faster.
    ///
    /// # Panics
    /// If the two slices differ in length.
    pub fn run(&mut self, set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
        assert_eq!(scenarios.len(), out.len(), "one outcome for each scenario");
        let InstructionSet(arch) = self.instructions;
        for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            self.solve(set, Batch { arch, scenarios, options }, out);
        }
    }

    /// Solves one chunk. Rows that their specialised equations cannot solve are integrated by the general ones.
    fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        let Batch { scenarios, .. } = batch;
        for (row, (scenario, out)) in scenarios.iter().zip(&mut *out).enumerate() {
            if let Err(reason) = self.add(row as u32, set, &Features::of(scenario, batch)) {
                *out = Outcome::failed(reason);
            }
        }
        for list in self.systems.lists() {
            for row in list.solve(batch, out) {
                if let Err(reason) = self.general.add(row, set, &Features::of(&scenarios[row as usize], batch)) {
                    out[row as usize] = Outcome::failed(reason);
                }
            }
        }
        self.closed.solve(set, batch, out);
        self.general.solve(set, batch, out);
    }

    /// Assigns a row to its path.
    #[inline]
    fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        let rows = if let Some(rows) = self.closed.rows_like(features) {
            rows
        } else if features.is_exact {
            return Err(Failure::NoExactSolution);
        } else if let Some(rows) = self.systems.rows_like(features) {
            rows
        } else {
            return self.general.add(row, set, features);
        };
        plan::check(set, features.active, features.scenario)?;
        rows.push(row);
        Ok(())
    }
}

/// The effects that rule out the closed form, as constant flows do.
pub const WITHOUT_CLOSED_FORM: EffectSet = sets::on_the_gas(EffectSet::ALL).without(closed::with_effects::EFFECTS);
