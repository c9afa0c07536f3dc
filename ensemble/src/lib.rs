//! Many push-and-hold tests at once: the kernel behind parameter studies.
//!
//! A [`Kernel`] solves push-and-hold tests on one thread, each result a pure function of its scenario: the same bits
//! whatever the others are and in whichever order they come. The caller spreads chunks over threads.
//!
//! | a row | is solved by | in |
//! |---|---|---|
//! | sealed, without effects | the closed form | `closed::rows` |
//! | with effects that keep the closed form | the closed form with other constants, or with a changed integrand | `closed::kept` |
//! | of either kind behind a sensor | the same, filtered | `closed::readings` |
//! | sealed, where the integrator is asked for | its one equation | `own::sealed` |
//! | with a wall that warms only | its two equations, in the hold by their series | `own::walled` |
//! | with turbulence that decays only | its two equations | `own::stirred` |
//! | with a missing term that is a heat flow over the pressure | its one equation | `own::heated` |
//! | with one leak only, or with constant flows and at most one leak | its two equations | `own::flows` |
//! | with natural convection only, on one side of the wall's temperature | two equations, in the hold a series | `own::convective` |
//! | with a wall that remembers only | its own equations, in the hold by collocation | `own::remembering` |
//! | any other | mass, energy and the effects' states, in code for its set of effects where there is some | `general` |
//! | of these tight, with effects without states | in the hold an integral over the temperature | `general::relaxation` |
//! | of these tight, with a wall that remembers and what keeps the closed form | in the hold collocation | `general::remembering` |
//!
//! Which way a row takes is decided in `Kernel::add`. Without wide instructions (`instructions`) rows without a closed form are all of the
//! last kinds.
//!
//! Rows of `general` leave a trace: pressure and temperature with their slopes at the end of each step (`general::history`).
//! What the sensor does to it is a filter of that trace (`filter`) and at last a curve of the reading (`reader::bends`), and
//! costs no steps; peaks, settling and samples are read from it (`reader`).

// Several arrays of lanes side by side, by one index, read as the equations do.
#![allow(clippy::needless_range_loop)]
// In unit tests nothing calls the integration of batches, see `sets_with_code_of_their_own`.
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
mod look;
mod numerics;
mod outcome;
mod own;
mod plan;
mod reader;
mod regression;
mod scenario;
mod sets;

pub use batch::CHUNK;
pub use general::compiled::has_code_of_its_own;
pub use instructions::InstructionSet;
pub use outcome::{Failure, Fit, Outcome};
pub use regression::samples::SAMPLE_RATE_HZ;
pub use scenario::{Options, Scenario, Solver};

use batch::{Batch, Features};
use chamber::effects::EffectSet;
use closed::ClosedRows;
use general::GeneralRows;
use own::Own;

/// Solves each scenario into the outcome of the same index: [`Kernel::run`], with memory for this once.
///
/// # Panics
/// Where the two slices differ in length.
pub fn run(set: EffectSet, scenarios: &[Scenario], options: &Options, out: &mut [Outcome]) {
    Kernel::default().run(set, scenarios, options, out);
}

/// Solves batches one after the other in memory that it keeps: a chunk's rows by the way they are solved.
#[derive(Default)]
pub struct Kernel {
    instructions: InstructionSet,
    closed: ClosedRows,
    own: Own,
    general: GeneralRows,
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
        let InstructionSet(arch) = self.instructions;
        for (scenarios, out) in scenarios.chunks(CHUNK).zip(out.chunks_mut(CHUNK)) {
            self.solve(set, Batch { arch, scenarios, options }, out);
        }
    }

    /// Solves a chunk of scenarios into the outcomes of the same index.
    fn solve(&mut self, set: EffectSet, batch: Batch, out: &mut [Outcome]) {
        let Batch { scenarios, .. } = batch;
        for (row, (scenario, out)) in scenarios.iter().zip(&mut *out).enumerate() {
            if let Err(reason) = self.add(row as u32, set, &Features::of(scenario, batch)) {
                *out = Outcome::failed(reason);
            }
        }
        for list in self.own.lists() {
            for row in list.solve(batch, out) {
                if let Err(reason) = self.general.add(row, set, &Features::of(&scenarios[row as usize], batch)) {
                    out[row as usize] = Outcome::failed(reason);
                }
            }
        }
        self.closed.solve(set, batch, out);
        self.general.solve(set, batch, out);
    }

    /// Adds a row to those that are solved in its way.
    #[inline]
    fn add(&mut self, row: u32, set: EffectSet, features: &Features) -> Result<(), Failure> {
        let rows = if let Some(rows) = self.closed.rows_like(features) {
            rows
        } else if features.is_exact {
            return Err(Failure::NoExactSolution);
        } else if let Some(rows) = self.own.rows_like(features) {
            rows
        } else {
            return self.general.add(row, set, features);
        };
        plan::check(set, features.active, features.scenario)?;
        rows.push(row);
        Ok(())
    }
}

/// The effects with which a test has no closed form, beside flows.
pub const WITHOUT_CLOSED_FORM: EffectSet = sets::on_the_gas(EffectSet::ALL).without(closed::kept::EFFECTS);
