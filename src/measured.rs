//! Measured records as reference experiments of an FMU: the model along each record as in `pneutherm simulate`, except that the
//! stroke is linear between rows. Outliers are left out as in `pneutherm validate`.

use crate::other_rig;
use crate::simulation::motion_run::along_record;
use anyhow::Context;
use chamber::signals::Signals;
use chamber::simulate::{Sample, Start};
use fmu::package::validation::Validation;
use identify::record::data::{Data, Prepared};
use identify::record::far_off;
use identify::record::plausibility::checks;
use identify::record::plausibility::outliers;
use identify::record::unit::Declared;
use records::{Model, Rig, Trace};
use std::collections::HashMap;

/// Each record of the rig with the model's error on it, and notes on the readings left out.
///
/// # Errors
/// For a record without pressure, or one that the model cannot be integrated along.
pub fn validations(model: &Model, rig: &Rig) -> anyhow::Result<(Vec<Validation>, Vec<String>)> {
    let followed = rig.traces().map(|record| Followed::of(model, rig, record)).collect::<anyhow::Result<Vec<_>>>()?;
    let (excluded, why_not_searched) = match outliers_by_record(rig, &followed) {
        Ok(rows) => (rows, None),
        Err(why) => (vec![Vec::new(); followed.len()], Some(format!("readings far off are not looked for: {why}"))),
    };
    let notes = followed.iter().zip(&excluded).filter_map(|(f, rows)| {
        let Trace { path, lines, time_s, .. } = f.record;
        far_off::sentence(path, rows, lines, time_s)
    });
    let notes = why_not_searched.into_iter().chain(notes).collect();
    Ok((followed.into_iter().zip(&excluded).map(|(f, rows)| f.validation(model, rows)).collect(), notes))
}

/// Notes on the errors: rows left out, and reasons why a model's error is not that of a prediction.
pub fn notes(model: &Model, rig: &Rig) -> Vec<String> {
    rig.notes().into_iter().chain(other_rig::notes(model, rig)).collect()
}

/// A record and the model along it.
struct Followed<'a> {
    record: &'a Trace,
    pressure_pa: &'a [f64],
    signals: Signals,
    start: Start,
    /// Measured minus simulated pressure, row by row, Pa.
    residuals: Vec<f64>,
}

impl<'a> Followed<'a> {
    fn of(model: &Model, rig: &Rig, record: &'a Trace) -> anyhow::Result<Self> {
        let pressure_pa =
            record.pressure_pa.as_deref().with_context(|| format!("{}: no pressure column", record.path.display()))?;
        checks::level(&record.path, pressure_pa, Declared::of(rig))?;
        let (signals, start, samples) = along_record(model, record)?;
        let residual = |(measured, sample): (&f64, &Sample)| measured - sample.measured_pressure;
        let residuals = pressure_pa.iter().zip(&samples).map(residual).collect();
        Ok(Self { record, pressure_pa, signals, start, residuals })
    }

    /// The record's data for the FMU, without the pressures of some rows.
    fn validation(self, model: &Model, excluded: &[usize]) -> Validation {
        let Self { record, pressure_pa, signals, start, residuals } = self;
        let rows: Vec<usize> = (0..record.len()).filter(|row| excluded.binary_search(row).is_err()).collect();
        let squares: f64 = rows.iter().map(|&row| residuals[row].powi(2)).sum();
        let begin = record.time_s[0];
        let name = record.path.file_name().unwrap_or(record.path.as_os_str());
        Validation {
            record: name.to_string_lossy().into_owned(),
            took_part: model.provenance.is_of(record),
            error_pa: (squares / rows.len() as f64).sqrt(),
            start: vec![("initialPressure", start.pressure), ("initialTemperature", start.temperature)],
            input_time_s: signals.knots.iter().map(|knot| knot.time - begin).collect(),
            inputs: inputs(&signals),
            time_s: rows.iter().map(|&row| record.time_s[row] - begin).collect(),
            pressure_pa: rows.iter().map(|&row| pressure_pa[row]).collect(),
        }
    }
}

/// Outliers of each record, by row, or the reason why they are not searched for: records that cannot be prepared for a
/// comparison, which `validate` refuses.
fn outliers_by_record(rig: &Rig, followed: &[Followed<'_>]) -> Result<Vec<Vec<usize>>, String> {
    let data = Data::prepare(rig).map_err(|error| error.to_string())?;
    let (prepared, all) = (data.traces.len(), followed.len());
    if prepared != all {
        return Err(format!("{} of {all} records cannot be compared with the others", all - prepared));
    }
    let rows: Vec<Vec<usize>> = data.traces.iter().zip(followed).map(|(t, f)| rows_of(t, f.record)).collect();
    let residuals: Vec<Vec<f64>> =
        rows.iter().zip(followed).map(|(rows, f)| rows.iter().map(|&row| f.residuals[row]).collect()).collect();
    let found = outliers::in_residuals(&data, &residuals);
    let data = data.without(&found);
    let of_record = |(t, rows): (&Prepared, &Vec<usize>)| {
        let mut found: Vec<usize> = t.readout.outliers.iter().map(|&row| rows[row]).collect();
        found.sort_unstable();
        found
    };
    Ok(data.traces.iter().zip(&rows).map(of_record).collect())
}

/// The record's row for each prepared row, matched by line number, as some rows are not prepared.
fn rows_of(prepared: &Prepared, record: &Trace) -> Vec<usize> {
    let count = prepared.time_s.len();
    if count == record.len() {
        return (0..count).collect();
    }
    let of_line: HashMap<usize, usize> =
        (0..record.len()).filter_map(|row| Some((record.lines.of(row)?, row))).collect();
    let last = record.len() - 1;
    (0..count)
        .map(|row| prepared.lines.of(row).and_then(|line| of_line.get(&line).copied()).unwrap_or(row.min(last)))
        .collect()
}

/// The inputs at the knots, with flows only if recorded. The velocity applies from each knot to the next.
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
