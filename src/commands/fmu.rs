//! `pneutherm fmu`: a model as an FMI 2.0 co-simulation unit.

use crate::output;
use anyhow::Context;
use fmu::package::{Contents, Library};
use fmu::variables::{BASE, INPUTS, Parameters, REALS, Starts, input, parameter};
use records::Model;
use std::path::PathBuf;

/// The FMU's libraries, built by `build.rs`.
const LIBRARIES: &[Library<'static>] = include!(concat!(env!("OUT_DIR"), "/libraries.rs"));
/// Where the piston stands in an FMU until its host says otherwise, m.
const START_POSITION_M: f64 = 0.1;

/// Write an FMI 2.0 co-simulation FMU whose start values are a model's
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm fmu model.toml -o Chamber.fmu

Every start value can be changed by the importing tool. The date in the FMU is that of SOURCE_DATE_EPOCH, else the \
model's own: the same model gives the same bytes.")]
pub struct Args {
    /// The model file, as `identify` and `diagnose` write it
    model: PathBuf,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu", default_value = "Chamber.fmu")]
    output: PathBuf,
}

/// Reads the model, writes the FMU.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let model = Model::read(&args.model)?;
    let bytes = package(&model, &std::fs::read(&args.model)?)
        .with_context(|| format!("{}: no FMU can be made of this model", args.model.display()))?;
    output::write(&args.output, &bytes)?;
    if !output::is_stdout(&args.output) {
        let platforms: Vec<_> = LIBRARIES.iter().map(|library| library.platform).collect();
        let told = format!("{}: FMI 2.0 co-simulation for {}\n", args.output.display(), platforms.join(", "));
        output::print(told.as_bytes())?;
    }
    Ok(())
}

/// The FMU of a model, as bytes; it keeps the model's file in its resources.
pub fn package(model: &Model, model_file: &[u8]) -> anyhow::Result<Vec<u8>> {
    let starts = starts(model);
    let generated = generated(std::env::var("SOURCE_DATE_EPOCH").ok().as_deref(), model)?;
    let contents = Contents {
        starts: &starts,
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
    real[parameter::ROD_DIAMETER] = model.rod_m;
    real[parameter::DEAD_VOLUME] = chamber.geometry.dead_volume;
    real[parameter::INITIAL_PRESSURE] = model.ambient_pressure_pa;
    real[parameter::INITIAL_TEMPERATURE] = model.ambient_temperature_k;
    real[parameter::LAMBDA0] = chamber.heat_transfer.coefficient;
    real[parameter::REFERENCE_PRESSURE] = chamber.heat_transfer.reference_pressure;
    real[parameter::REFERENCE_TEMPERATURE] = chamber.heat_transfer.reference_temperature;
    real[parameter::GAS_CONSTANT] = chamber.gas.gas_constant;
    real[parameter::HEAT_CAPACITY_RATIO] = chamber.gas.heat_capacity_ratio;
    real[BASE..].copy_from_slice(&chamber.effects.0);
    let mut inputs = [0.0; INPUTS];
    inputs[input::POSITION] = START_POSITION_M;
    inputs[input::TEMPERATURE_IN] = model.ambient_temperature_k;
    inputs[input::AMBIENT_TEMPERATURE] = model.ambient_temperature_k;
    inputs[input::AMBIENT_PRESSURE] = model.ambient_pressure_pa;
    Starts { parameters: Parameters { real, area_law: chamber.geometry.area_law }, inputs }
}

/// UTC time of generation: that of SOURCE_DATE_EPOCH, else the model's.
fn generated(epoch: Option<&str>, model: &Model) -> anyhow::Result<Option<String>> {
    let Some(epoch) = epoch else { return Ok(model.provenance.date.clone()) };
    let seconds: u64 =
        epoch.parse().with_context(|| format!("SOURCE_DATE_EPOCH = {epoch}: whole seconds since 1970 are expected"))?;
    Ok(Some(records::utc(seconds)))
}
