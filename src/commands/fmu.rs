//! `pneutherm fmu`: a model as an FMI 2.0 or 3.0 unit for Model Exchange and co-simulation.

use crate::{measured, output};
use anyhow::Context;
use fmu::identity::Identity;
use fmu::package::documentation::About;
use fmu::package::validation::Validation;
use fmu::package::{Contents, Library, Version};
use fmu::plant::values::{
    BASE, CRITICAL_RATIO, Choices, Parameters, REALS, Starts, StrokeInput, parameter, start_inputs,
};
use fmu::table::effects::parameter_name;
use records::document::{Document, Kind};
use records::{Model, Rig, Verdict};
use std::path::{Path, PathBuf};

/// The FMU's libraries, built by `build.rs`.
const LIBRARIES: &[Library<'static>] = include!(concat!(env!("OUT_DIR"), "/libraries.rs"));
/// Where the piston stands in an FMU until its host says otherwise, m.
const START_POSITION_M: f64 = 0.1;

/// Write an FMU (FMI 2.0 or 3.0) with the start values of a model
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm fmu model.toml -o Chamber.fmu
  pneutherm fmu model.toml -o Chamber.fmu --validation other-day/rig.toml

Every FMU contains a push and hold with the result of the model, as a reference experiment (FMI-LS-REF). With --validation it \
contains the records of that rig too: the recorded stroke, from which a position_delay or position_averaging of the model is \
taken, the start values, the measured pressure and the error of the model, all as `pneutherm simulate` computes them. \
Readings far off are left out and named, as `pneutherm validate` does.

The importing tool can change every start value. The generation date in the FMU is SOURCE_DATE_EPOCH, or else the date of the \
model, so that the same model gives the same bytes.")]
pub struct Args {
    /// The model file, as `identify` and `diagnose` write it
    model: PathBuf,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu", default_value = "Chamber.fmu")]
    output: PathBuf,
    /// Version of FMI, 2 or 3
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = version)]
    fmi: Version,
    /// Put the records of this rig into the FMU as measured reference experiments; the rig file or the folder that holds its
    /// rig.toml
    #[arg(long, value_name = "RIG.toml")]
    validation: Option<PathBuf>,
}

fn version(text: &str) -> Result<Version, String> {
    match text {
        "2" | "2.0" => Ok(Version::Two),
        "3" | "3.0" => Ok(Version::Three),
        _ => Err("expected 2 or 3".into()),
    }
}

/// Reads the model, writes the FMU.
pub fn run(args: &Args) -> anyhow::Result<()> {
    // Read once: what is no file, as a pipe, gives its text only once.
    let model_file = Document::read_as(Kind::Model, &args.model)?;
    let whole = Model::from_document(&model_file)?;
    let mut model = whole.clone();
    let left_out = model.leave_out_recorded_stroke();
    for place in 0..chamber::effects::COUNT {
        fmu::table::effects::exported(place, model.chamber.effects.of(place))
            .map_err(|reason| anyhow::anyhow!("{}: the FMU cannot be made: {reason}", args.model.display()))?;
    }
    let name = args.output.file_stem().filter(|_| !output::is_stdout(&args.output)).and_then(|stem| stem.to_str());
    let identity = Identity::of(name.unwrap_or("Chamber"));
    let rig = args.validation.as_deref().map(Rig::read).transpose()?;
    output::check([&args.output], rig.iter().flat_map(output::files).chain([args.model.as_path()]))?;
    if !is_named_as_fmu(&args.output) {
        output::note(&format!("{}: most tools open an FMU only if its name ends in .fmu", args.output.display()));
    }
    // With what the model says of how a stroke is recorded: the inputs inside are the piston's true stroke.
    let (validations, left_out_rows) =
        rig.as_ref().map_or_else(|| Ok(Default::default()), |rig| measured::validations(&whole, rig))?;
    rig.iter().flat_map(|rig| measured::notes(&whole, rig)).chain(left_out_rows).for_each(|note| output::note(&note));
    let bytes = package(args.fmi, &identity, &model, model_file.text().as_bytes(), &validations)
        .with_context(|| format!("{}: the FMU cannot be made", args.model.display()))?;
    output::write(&args.output, &bytes)?;
    if !output::is_stdout(&args.output) {
        let platforms: Vec<_> = LIBRARIES.iter().map(|library| library.platform).collect();
        let version = if args.fmi == Version::Two { "2.0" } else { "3.0" };
        let (path, platforms) = (args.output.display(), platforms.join(", "));
        let told = format!("{path}: FMI {version}, Model Exchange and co-simulation, for {platforms}\n");
        output::print(told.as_bytes())?;
        for validation in &validations {
            output::print(format!("reference experiment {}\n", validation.summary()).as_bytes())?;
        }
        if let Some(note) = output::left_out(left_out) {
            output::print(note.as_bytes())?;
        }
        if let Some(doubt) = doubt(&model) {
            output::print(format!("{doubt}\n").as_bytes())?;
        }
    }
    Ok(())
}

/// Whether the file's name ends in `.fmu`; what is no file, as standard output and devices, needs none.
fn is_named_as_fmu(path: &Path) -> bool {
    let is_file = !output::is_stdout(path) && (path.is_file() || !path.exists());
    !is_file || path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("fmu"))
}

/// What to know before the model is used, where its diagnosis found no cause.
fn doubt(model: &Model) -> Option<&'static str> {
    match model.provenance.verdict? {
        Verdict::Adequate | Verdict::Explained => None,
        Verdict::Improved => Some(
            "The verdict of the model is `improved`: its effects describe the records and need not be the cause, mostly because the residual is more than noise.",
        ),
        Verdict::Unexplained => Some(
            "The verdict of the model is `unexplained`: the residual of the paper's model is more than noise, and no known effect predicts left-out data decisively better.",
        ),
    }
}

/// Where the model's numbers come from, for the FMU's documentation.
fn about(model: &Model) -> About {
    let provenance = &model.provenance;
    let verdict = provenance.verdict.map(|verdict| match verdict {
        Verdict::Adequate => {
            "adequate: the residual of the paper's model is noise, or below the accuracy asked for.".to_owned()
        }
        Verdict::Explained => {
            "explained: with the effects that are on, the residual is noise, or little beside what it was.".to_owned()
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

/// The FMU's name of a parameter that a model file names by its key.
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

/// The FMU of a model, as bytes; it keeps the model's file in its resources.
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

/// UTC time of generation: that of SOURCE_DATE_EPOCH, else the model's.
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
