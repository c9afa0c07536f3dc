//! What `pneutherm identify` and `pneutherm diagnose` do before they print, for other callers: Python.

use anyhow::{Context, bail};
use identify::{Diagnosed, Identification, Method, diagnosis};
use records::{Model, Provenance, Rig, Rmse};
use std::path::Path;

use crate::output;

/// The method of that name.
///
/// # Errors
/// There is none.
pub fn method(name: &str) -> anyhow::Result<Method> {
    match Method::ALL.into_iter().find(|method| method.name() == name) {
        Some(method) => Ok(method),
        None => bail!("method: `{name}` is not known; known here: {}", Method::ALL.map(Method::name).join(", ")),
    }
}

/// Identifies what was measured on the rig and writes the model, if asked for.
///
/// # Errors
/// A file that is refused, a rig that cannot be identified, a file that cannot be written.
pub fn identify(rig: &Path, method: Method, model: Option<&Path>) -> anyhow::Result<Identification> {
    let rig = Rig::read(rig)?;
    let found = identify::identify(&rig, method).with_context(|| rig.path.display().to_string())?;
    if let Some(path) = model {
        output::write(path, identified_model(&rig, &found).to_toml()?.as_bytes())?;
    }
    Ok(found)
}

/// Diagnoses what was measured on the rig and writes model and report, if asked for. `progress` hears what is being done
/// and which share of it.
///
/// # Errors
/// As [`identify()`].
pub fn diagnose(
    rig: &Path,
    model: Option<&Path>,
    report: Option<&Path>,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> anyhow::Result<Diagnosed> {
    let rig = Rig::read(rig)?;
    let found = identify::diagnose(&rig, progress).with_context(|| rig.path.display().to_string())?;
    if let Some(path) = model {
        output::write(path, diagnosed_model(&rig, &found).to_toml()?.as_bytes())?;
    }
    if let Some(path) = report {
        output::write(path, identify::report::html(&rig, &found).as_bytes())?;
    }
    Ok(found)
}

fn identified_model(rig: &Rig, found: &Identification) -> Model {
    let rmse = Some(rmse(&found.rmse_pa));
    Model {
        gas_name: rig.gas.name.clone(),
        chamber: found.chamber,
        rod_m: rig.cylinder.rod_through_m,
        ambient_temperature_k: found.ambient_temperature_k,
        ambient_pressure_pa: rig.ambient.pressure_pa,
        uncertainty: None,
        provenance: Provenance { rmse_before_pa: rmse, rmse_after_pa: rmse, ..Provenance::of_rig(rig) },
    }
}

/// Writes the model of the known effects that come closest to a residual that they do not explain; the diagnosed one where
/// there are none.
///
/// # Errors
/// A file that cannot be read again or written.
pub fn write_closest(rig: &Path, found: &Diagnosed, model: &Path) -> anyhow::Result<()> {
    let mut out = diagnosed_model(&Rig::read(rig)?, found);
    if let Some((chamber, closest)) = found.closest_chamber().zip(found.diagnosis.closest.as_ref()) {
        out.chamber = chamber;
        out.provenance.rmse_after_pa = Some(rmse(&closest.rmse_pa));
    }
    output::write(model, out.to_toml()?.as_bytes())
}

fn rmse(of: &diagnosis::Rmse) -> Rmse {
    Rmse { fit: of.fit, held_out: of.held_out }
}

fn diagnosed_model(rig: &Rig, found: &Diagnosed) -> Model {
    Model {
        gas_name: rig.gas.name.clone(),
        chamber: found.chamber(),
        rod_m: rig.cylinder.rod_through_m,
        ambient_temperature_k: found.data.ambient_temperature_k,
        ambient_pressure_pa: rig.ambient.pressure_pa,
        uncertainty: None,
        provenance: Provenance {
            rmse_before_pa: Some(rmse(&found.diagnosis.before.rmse_pa)),
            rmse_after_pa: Some(rmse(&found.diagnosis.after.rmse_pa)),
            ..Provenance::of_rig(rig)
        },
    }
}
