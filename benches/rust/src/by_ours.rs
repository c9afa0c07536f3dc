//! pneutherm's batch kernel, called as by `sweep`: each thread solves one piece of the rows after the other.

use crate::Solve;
use crate::options;
use crate::scenario::{AMBIENT_TEMPERATURE_K, Answer, Case, EFFECTS};
use chamber::effects::{self, EffectSet, EffectValues};
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use ensemble::{Failure, Options, Outcome, Scenario, Solver};
use rayon::prelude::*;

/// Rows per thread and piece, as in `sweep`.
const PIECE: usize = 1 << 13;

/// The kernel for these scenarios, which are converted to its own type before the clock starts, as for the others.
pub fn solver(cases: &[Case], asked: &options::Options) -> Solve {
    let scenarios: Vec<Scenario> = cases.iter().map(scenario).collect();
    let solver = if asked.is("auto") { Solver::Auto } else { Solver::Adaptive };
    let options = Options { solver, relative_tolerance: asked.tolerance(), fit: asked.is("fit") };
    let set = scenarios.first().map_or(EffectSet::NONE, |s| s.chamber.effects.active());
    Box::new(move |cases, answers| {
        let pieces = scenarios[..cases.len()].par_chunks(PIECE).zip(answers.par_chunks_mut(PIECE));
        pieces.for_each_init(
            || vec![Outcome::failed(Failure::TooManySteps); PIECE],
            |outcomes, (scenarios, answers)| {
                let outcomes = &mut outcomes[..scenarios.len()];
                ensemble::run(set, scenarios, &options, outcomes);
                for (answer, outcome) in answers.iter_mut().zip(outcomes) {
                    *answer = Answer { peak_pa: outcome.pressure_peak_pa, final_pa: outcome.pressure_final_pa };
                }
            },
        );
    })
}

fn scenario(case: &Case) -> Scenario {
    let geometry = Geometry::new(case.bore_m, 0.0, case.dead_volume_m3, AreaLaw::Total);
    let mut chamber = Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(case.coefficient));
    let mut values = EffectValues::NEUTRAL;
    for ((name, parameter), value) in EFFECTS.iter().zip(case.effects).filter(|(_, value)| *value != 0.0) {
        let (effect, _) = effects::find(name).expect("an effect");
        values.of_mut(effect)[*parameter] = value;
    }
    chamber.effects = values;
    let positions = [case.initial_stroke_m, case.final_stroke_m];
    let (pressure, push, duration) = (case.initial_pressure_pa, case.push_time_s, case.duration_s);
    let mut scenario = Scenario::push(chamber, pressure, positions, push, duration);
    scenario.initial_temperature_k = AMBIENT_TEMPERATURE_K;
    scenario.ambient_temperature_k = AMBIENT_TEMPERATURE_K;
    scenario.temperature_in_k = AMBIENT_TEMPERATURE_K;
    scenario.mass_flow_in_kg_per_s = case.inflow_kg_per_s;
    scenario
}
