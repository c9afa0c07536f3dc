//! The work of `pneutherm identify`, `diagnose` and `validate` without printing, for other callers such as Python.

use crate::pages::diagnosis;
use crate::{measured, output};
use anyhow::{Context, bail};
use chamber::Chamber;
use identify::outcome::estimates;
use identify::{Diagnosed, Identification, Method, Predictor, Validated};
use records::{Model, Provenance, Rig, Rmse, Uncertainty};
use std::path::Path;

/// The method of that name.
///
/// # Errors
/// If there is none.
pub fn method(name: &str) -> anyhow::Result<Method> {
    match Method::ALL.into_iter().find(|method| method.name() == name) {
        Some(method) => Ok(method),
        None => bail!("method: unknown value `{name}`; expected one of: {}", Method::ALL.map(Method::name).join(", ")),
    }
}

/// Identifies the model of a rig's records and writes it, if requested.
///
/// # Errors
/// For a rig that cannot be identified, or a file that cannot be written.
pub fn identify(rig: &Rig, method: Method, model: Option<&Path>) -> anyhow::Result<Identification> {
    let mut found = identify::identify(rig, method).with_context(|| rig.path.display().to_string())?;
    found.assumptions.extend(rig.notes());
    if let Some(path) = model {
        output::write(path, identified_model(rig, &found).to_toml()?.as_bytes())?;
    }
    Ok(found)
}

/// Diagnoses a rig's records and writes a report, if requested. `progress` receives the current activity and the fraction done.
///
/// # Errors
/// As [`identify()`].
pub fn diagnose(rig: &Rig, report: Option<&Path>, progress: &(dyn Fn(&str, f64) + Sync)) -> anyhow::Result<Diagnosed> {
    let mut found = identify::diagnose(rig, progress).with_context(|| rig.path.display().to_string())?;
    found.diagnosis.assumptions.extend(rig.notes());
    if let Some(path) = report {
        output::write(path, diagnosis::html(rig, &found)?.as_bytes())?;
    }
    Ok(found)
}

/// Validates a model on the records of a rig.
///
/// # Errors
/// For records that the model cannot be integrated along.
pub fn validate(model: &Model, rig: &Rig, whole_record: bool) -> anyhow::Result<Validated> {
    // Its error on held-out data, else on the data of the fit; a model without either is assumed exact.
    let error_pa = model.provenance.rmse_after_pa.map_or(0.0, |rmse| rmse.held_out.unwrap_or(rmse.fit));
    let predictor = Predictor { chamber: model.chamber, error_pa, of_each_record: model.provenance.of_each_record };
    let mut found =
        identify::validate(&predictor, rig, whole_record).with_context(|| rig.path.display().to_string())?;
    found.validation.notes.extend(measured::notes(model, rig));
    Ok(found)
}

fn identified_model(rig: &Rig, found: &Identification) -> Model {
    let rmse = Some(rmse(&found.rmse_pa));
    let provenance = Provenance { rmse_before_pa: rmse, rmse_after_pa: rmse, ..Provenance::of_rig(rig) };
    model(rig, found.chamber, found.ambient_temperature_k, found.uncertainty.clone(), provenance)
}

fn model(
    rig: &Rig,
    chamber: Chamber,
    ambient_temperature_k: f64,
    uncertainty: Option<Uncertainty>,
    provenance: Provenance,
) -> Model {
    Model {
        gas_name: rig.gas.name.clone(),
        chamber,
        ambient_temperature_k,
        ambient_pressure_pa: rig.ambient.pressure_pa,
        uncertainty,
        provenance,
    }
}

fn rmse(of: &estimates::Rmse) -> Rmse {
    Rmse { fit: of.fit, held_out: of.held_out }
}

/// Writes the final model of a diagnosis.
///
/// # Errors
/// If the file cannot be written.
pub fn write_diagnosed(rig: &Rig, found: &Diagnosed, path: &Path) -> anyhow::Result<()> {
    output::write(path, diagnosed_model(rig, found).to_toml()?.as_bytes())
}

fn diagnosed_model(rig: &Rig, found: &Diagnosed) -> Model {
    let provenance = Provenance {
        verdict: Some(found.found.verdict),
        rmse_before_pa: Some(rmse(&found.diagnosis.before.rmse_pa)),
        rmse_after_pa: Some(rmse(&found.diagnosis.after.rmse_pa)),
        of_each_record: found.of_each_record(),
        ..Provenance::of_rig(rig)
    };
    model(rig, found.chamber(), found.data.ambient_temperature_k, Some(found.uncertainty()), provenance)
}
