//! A batch of scenarios, and the features of a row that decide how it is solved.

use crate::instructions;
use crate::scenario::{Options, Scenario, Solver};
use crate::sensor::Sensor;
use crate::sets;
use chamber::AreaLaw;
use chamber::effects::{self, EffectSet};
use pulp::Arch;

/// Number of scenarios solved together: their working memory fits a core's cache.
pub const CHUNK: usize = 512;

/// Scenarios solved together, with the options and the instruction set.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    pub arch: Arch,
    pub scenarios: &'a [Scenario],
    pub options: &'a Options,
}

/// The features of a row that decide how it is solved.
pub struct Features<'a> {
    pub scenario: &'a Scenario,
    /// Active effects, and those of them that act on the gas.
    pub active: EffectSet,
    pub of_gas: EffectSet,
    /// The sensor, if any of its effects is active.
    pub sensor: Option<Sensor>,
    /// Whether there are no constant flows.
    pub is_sealed: bool,
    pub is_swept: bool,
    /// Whether only the integrator, or only the exact solution, is allowed.
    pub integrates: bool,
    pub is_exact: bool,
    /// Whether the instruction set is a wide one.
    pub is_wide: bool,
}

impl<'a> Features<'a> {
    /// The features of a scenario of a batch.
    #[inline]
    pub fn of(scenario: &'a Scenario, Batch { arch, options, .. }: Batch) -> Self {
        let active = scenario.chamber.active();
        let shown = active.intersection(effects::of_sensor());
        Self {
            scenario,
            active,
            of_gas: sets::on_the_gas(active),
            sensor: (!shown.is_empty()).then(|| Sensor::new(shown, &scenario.chamber.effects)),
            is_sealed: scenario.is_sealed(),
            is_swept: scenario.chamber.geometry.area_law == AreaLaw::Swept,
            integrates: options.solver == Solver::Adaptive,
            is_exact: options.solver == Solver::Exact,
            is_wide: instructions::is_wide(arch),
        }
    }
}
