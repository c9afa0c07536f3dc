//! From points to results: rows become scenarios, the batch kernel of `chamber` simulates them.

use crate::quantity;
use crate::row::{self, Outputs};
use crate::study::Study;
use chamber::batch::{self, Failure, Options, Outcome};
use chamber::effects::{self, EffectSet, EffectValues, PARAMETERS};

/// Simulates some rows, given by a column for each varied quantity.
pub fn rows(study: &Study, points: &[Vec<f64>]) -> Vec<Outputs> {
    let count = points.first().map_or(0, Vec::len);
    let mut point = study.base;
    let mut outputs = Vec::with_capacity(count);
    let mut scenarios = Vec::with_capacity(count);
    for row in 0..count {
        for (varied, column) in study.varied.iter().zip(points) {
            point.0[varied.quantity] = column[row];
        }
        match row::scenario(study, &point) {
            Ok(scenario) => {
                scenarios.push(scenario);
                outputs.push(None);
            }
            Err(failure) => outputs.push(Some(Outputs::failed(failure))),
        }
    }
    let options = Options { solver: study.solver, relative_tolerance: study.tolerance, fit: study.fit };
    let mut outcomes = vec![Outcome::failed(Failure::TooManySteps); scenarios.len()];
    batch::run(effects_of(study), &scenarios, &options, &mut outcomes);
    let mut simulated = scenarios.iter().zip(&outcomes).map(|(scenario, outcome)| Outputs::new(scenario, outcome));
    outputs.into_iter().map_while(|failed| failed.or_else(|| simulated.next())).collect()
}

/// Effects that are on in some row. The same for all rows, whatever the chunk, so that a row's bits are its own.
pub fn effects_of(study: &Study) -> EffectSet {
    let mut values = EffectValues::NEUTRAL;
    values.0.copy_from_slice(study.base.effects());
    let first = quantity::COUNT - PARAMETERS;
    let varied = study.varied.iter().filter_map(|v| v.quantity.checked_sub(first));
    varied.fold(values.active(), |set, parameter| {
        let index = effects::PARAMETER_OFFSETS.partition_point(|offset| *offset <= parameter) - 1;
        set.union(EffectSet::one(index))
    })
}
