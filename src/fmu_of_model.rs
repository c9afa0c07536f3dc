//! A model as an FMU: its numbers as start values, and their origin.

use anyhow::Context;
use fmu::identity::Identity;
use fmu::package::documentation::About;
use fmu::package::validation::Validation;
use fmu::package::{Contents, Library, Version};
use fmu::plant::values::{
    BASE, CRITICAL_RATIO, Choices, Parameters, REALS, Starts, StrokeInput, parameter, start_inputs,
};
use fmu::table::effects::parameter_name;
use records::{Model, Verdict};

/// The FMU's libraries, built by `build.rs`.
pub const LIBRARIES: &[Library<'static>] = include!(concat!(env!("OUT_DIR"), "/libraries.rs"));
/// Start value of the piston's position in an FMU, m.
const START_POSITION_M: f64 = 0.1;

/// The FMU of a model, as bytes, with the model file in its resources.
pub fn package(
    version: Version,
    identity: &Identity,
    model: &Model,
    model_file: &[u8],
    validations: &[Validation],
) -> anyhow::Result<Vec<u8>> {
    let (starts, about) = (starts(model), about(model));
    let generated = generated(std::env::var("SOURCE_DATE_EPOCH").ok().as_deref(), model)?;
    let contents = Contents {
        version,
        identity,
        about: &about,
        starts: &starts,
        validations,
        generated: generated.as_deref(),
        model_file: Some(model_file),
        libraries: LIBRARIES,
    };
    Ok(fmu::package::package(&contents)?)
}

/// A caution about the model, if its diagnosis found no cause.
pub fn doubt(model: &Model) -> Option<&'static str> {
    match model.provenance.verdict? {
        Verdict::Adequate | Verdict::Explained => None,
        Verdict::Improved => Some(
            "The verdict of the model is `improved`: its effects describe the records and need not be the cause, in most cases because the residual is more than noise.",
        ),
        Verdict::Unexplained => Some(
            "The verdict of the model is `unexplained`: the residual of the paper's model is more than noise, and no known effect predicts left-out data decisively better.",
        ),
    }
}

/// Origin of the model's numbers, for the FMU's documentation.
fn about(model: &Model) -> About {
    let provenance = &model.provenance;
    let verdict = provenance.verdict.map(|verdict| match verdict {
        Verdict::Adequate => {
            "adequate: the residual of the paper's model is noise, or below the accuracy asked for.".to_owned()
        }
        Verdict::Explained => {
            "explained: with the effects that are on, the residual is noise, or small compared with what it was."
                .to_owned()
        }
        Verdict::Improved | Verdict::Unexplained => doubt(model).unwrap_or_default().to_owned(),
    });
    let error = |rmse: Option<records::Rmse>| rmse.map(|rmse| rmse.held_out.unwrap_or(rmse.fit));
    let error_pa = error(provenance.rmse_before_pa).zip(error(provenance.rmse_after_pa)).map(|(a, b)| [a, b]);
    let intervals = model.uncertainty.iter().flat_map(|known| known.parameters.iter().zip(&known.ci95));
    About {
        verdict,
        error_pa,
        intervals: intervals.filter_map(|(key, interval)| Some((variable_of(key)?, *interval))).collect(),
        records: provenance.traces.iter().map(|trace| trace.path.clone()).collect(),
    }
}

/// The FMU's name of a parameter, from its key in a model file.
fn variable_of(key: &str) -> Option<String> {
    match key {
        "lambda0_w_per_m2_k" => return Some("lambda0".into()),
        "dead_volume_m3" => return Some("deadVolume".into()),
        "bore_m" => return Some("bore".into()),
        _ => {}
    }
    let (effect, key) = key.split_once('.')?;
    let (_, card) = chamber::effects::find(effect)?;
    let parameter = card.parameters.iter().find(|p| p.key() == key)?;
    Some(parameter_name(card, parameter))
}

/// The model's numbers as the FMU's start values.
fn starts(model: &Model) -> Starts {
    let chamber = &model.chamber;
    let mut real = [0.0; REALS];
    real[parameter::BORE] = chamber.geometry.bore;
    real[parameter::ROD_DIAMETER] = model.chamber.geometry.rod_diameter;
    real[parameter::DEAD_VOLUME] = chamber.geometry.dead_volume;
    real[parameter::INITIAL_PRESSURE] = model.ambient_pressure_pa;
    real[parameter::INITIAL_TEMPERATURE] = chamber.effects.rest_temperature(model.ambient_temperature_k);
    real[parameter::LAMBDA0] = chamber.heat_transfer.coefficient;
    real[parameter::REFERENCE_PRESSURE] = chamber.heat_transfer.reference_pressure;
    real[parameter::REFERENCE_TEMPERATURE] = chamber.heat_transfer.reference_temperature;
    real[parameter::GAS_CONSTANT] = chamber.gas.gas_constant;
    real[parameter::HEAT_CAPACITY_RATIO] = chamber.gas.heat_capacity_ratio;
    real[BASE..].copy_from_slice(&chamber.effects.0);
    real[parameter::SUPPLY_CRITICAL_RATIO] = CRITICAL_RATIO;
    real[parameter::EXHAUST_CRITICAL_RATIO] = CRITICAL_RATIO;
    let choices = Choices {
        area_law: chamber.geometry.area_law,
        stroke_input: StrokeInput::PositionAndVelocity,
        external_wall: false,
    };
    let inputs = start_inputs(START_POSITION_M, model.ambient_temperature_k, model.ambient_pressure_pa);
    Starts { parameters: Parameters { real, choices }, inputs }
}

/// UTC time of generation: SOURCE_DATE_EPOCH, else the model's date.
fn generated(epoch: Option<&str>, model: &Model) -> anyhow::Result<Option<String>> {
    let Some(epoch) = epoch else {
        let as_moment = |date: &String| {
            records::as_utc(date).with_context(|| {
                format!("provenance.date = \"{date}\" is no date; expected one like \"2026-11-21T12:00:00Z\"")
            })
        };
        return model.provenance.date.as_ref().map(as_moment).transpose();
    };
    let seconds = epoch.trim().parse().ok().filter(|seconds| *seconds <= records::LAST_SECOND);
    let seconds = seconds.with_context(|| {
        format!("SOURCE_DATE_EPOCH = {epoch}: expected whole seconds since 1970, before the year 10000")
    })?;
    Ok(Some(records::utc(seconds)))
}
