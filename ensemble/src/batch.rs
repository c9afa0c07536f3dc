//! Scenarios that are solved together, and what decides how each is solved.

use crate::filter::Behind;
use crate::instructions;
use crate::scenario::{Options, Scenario, Solver};
use crate::sets;
use chamber::AreaLaw;
use chamber::effects::{self, EffectSet};
use pulp::Arch;

/// Scenarios that are solved together: as many as keep their working memory in a core's cache.
pub const CHUNK: usize = 512;

/// Scenarios that are solved together, how, and with which instructions.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    pub arch: Arch,
    pub scenarios: &'a [Scenario],
    pub options: &'a Options,
}

/// What decides how a row is solved.
pub struct Features<'a> {
    pub scenario: &'a Scenario,
    /// Its active effects, and those on the gas.
    pub active: EffectSet,
    pub of_gas: EffectSet,
    /// The sensor, where the record does not show the gas as it is.
    pub behind: Option<Behind>,
    /// Whether no gas enters or leaves but by effects.
    pub is_sealed: bool,
    pub is_swept: bool,
    /// Whether the integrator is asked for, or closed forms only.
    pub integrates: bool,
    pub is_exact: bool,
    /// Whether there are wide instructions.
    pub is_wide: bool,
}

impl<'a> Features<'a> {
    /// Of a scenario of a batch.
    #[inline]
    pub fn of(scenario: &'a Scenario, Batch { arch, options, .. }: Batch) -> Self {
        let active = scenario.chamber.active();
        let shown = active.intersection(effects::of_sensor());
        Self {
            scenario,
            active,
            of_gas: sets::on_the_gas(active),
            behind: (!shown.is_empty()).then(|| Behind::new(shown, &scenario.chamber.effects)),
            is_sealed: scenario.is_sealed(),
            is_swept: scenario.chamber.geometry.area_law == AreaLaw::Swept,
            integrates: options.solver == Solver::Adaptive,
            is_exact: options.solver == Solver::Exact,
            is_wide: instructions::is_wide(arch),
        }
    }
}
