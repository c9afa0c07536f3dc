//! Measured records as reference experiments of an FMU: the model along each record as `pneutherm simulate` has it,
//! but for the stroke, which is linear from row to row.

use crate::other_rig;
use crate::simulation::course::along_record;
use anyhow::Context;
use chamber::signals::Signals;
use fmu::package::validation::Validation;
use identify::record::checks;
use identify::record::unit::Declared;
use records::{Model, Rig, Trace};

/// Each record of the rig, with the error of the model on it.
///
/// # Errors
/// A record without pressure, or one that the model cannot follow.
pub fn validations(model: &Model, rig: &Rig) -> anyhow::Result<Vec<Validation>> {
    rig.traces().map(|record| validation(model, rig, record)).collect()
}

/// What to know beside the errors: rows left out, and what makes a model's error another than that of a prediction.
pub fn notes(model: &Model, rig: &Rig) -> Vec<String> {
    rig.notes().into_iter().chain(other_rig::notes(model, rig)).collect()
}

fn validation(model: &Model, rig: &Rig, record: &Trace) -> anyhow::Result<Validation> {
    let pressure_pa =
        record.pressure_pa.clone().with_context(|| format!("{}: no pressure column", record.path.display()))?;
    checks::level(&record.path, &pressure_pa, Declared::of(rig))?;
    let (signals, start, samples) = along_record(model, record)?;
    let squares: f64 =
        samples.iter().zip(&pressure_pa).map(|(sample, measured)| (measured - sample.measured_pressure).powi(2)).sum();
    let begin = record.time_s[0];
    let name = record.path.file_name().unwrap_or(record.path.as_os_str());
    Ok(Validation {
        record: name.to_string_lossy().into_owned(),
        took_part: model.provenance.is_of(record),
        error_pa: (squares / samples.len() as f64).sqrt(),
        start: vec![("initialPressure", start.pressure), ("initialTemperature", start.temperature)],
        input_time_s: signals.knots.iter().map(|knot| knot.time - begin).collect(),
        inputs: inputs(&signals),
        time_s: record.time_s.iter().map(|time| time - begin).collect(),
        pressure_pa,
    })
}

/// The inputs at the knots; flows only where some were recorded. The velocity is that of the stretch from a knot to the next.
fn inputs(signals: &Signals) -> Vec<(&'static str, Vec<f64>)> {
    let knots = &signals.knots;
    let velocity = knots.windows(2).map(|k| (k[1].position - k[0].position) / (k[1].time - k[0].time)).chain([0.0]);
    let ambient: Vec<f64> = knots.iter().map(|knot| knot.ambient_temperature).collect();
    let mut inputs = vec![
        ("position", knots.iter().map(|knot| knot.position).collect()),
        ("velocity", velocity.collect()),
        ("ambientTemperature", ambient.clone()),
    ];
    if knots.iter().any(|knot| knot.mass_flow != 0.0) {
        inputs.push(("massFlowIn", knots.iter().map(|knot| knot.mass_flow.max(0.0)).collect()));
        inputs.push(("temperatureIn", ambient));
        inputs.push(("massFlowOut", knots.iter().map(|knot| (-knot.mass_flow).max(0.0)).collect()));
    }
    inputs
}
