//! `pneutherm simulate`: the chamber along a measured or planned stroke.

use crate::output;
use crate::simulation::band::{LEVEL, SAMPLES, Wanted};
use crate::simulation::{self, Request, Simulated};
use records::document::Kind;
use records::limits::PRESSURE_PA;
use records::{Document, RigFile};
use std::path::PathBuf;

/// Simulate a model's chamber along a measured or planned stroke
#[derive(clap::Args)]
#[command(after_help = "\
The output has one row per row of the motion: time_s, pressure_pa (what the sensor would show), gas_pressure_pa, \
temperature_k, mass_kg, volume_m3, heat_flow_w (into the gas). With --samples each column but time_s has two more, the ends of \
its band: pressure_low_pa, pressure_high_pa and so on. The gas starts at the temperature of the wall at rest, which is ambient \
unless the model has a warm_wall. Positions are linear between rows; where they scatter at rest, the piston is held there and \
moves along smooth curves through the rows, as in `identify`, unless --raw-positions is given. The initial pressure is chosen so that the simulated mean before the first movement equals that of the motion's pressure column.

Example:
  pneutherm simulate model.toml --motion validation.csv -o simulated.csv
  pneutherm simulate model.toml --motion plan.csv --initial-pressure 6e5 | head
  pneutherm simulate model.toml --motion validation.csv --samples 256 -o band.csv")]
pub struct Args {
    /// The model file, as `identify` and `diagnose` write it
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    /// The motion: columns time_s and position_m, optionally pressure_pa, ambient_temperature_k, mass_flow_kg_per_s
    #[arg(long, value_name = "TRACE.csv")]
    motion: PathBuf,
    /// A rig file whose [columns] and [format] describe the motion file
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Initial gas pressure, Pa absolute; by default from the motion's pressure before the first movement
    #[arg(long, value_name = "PA", value_parser = pressure, allow_negative_numbers = true)]
    initial_pressure: Option<f64>,
    /// Take noisy positions as they are, linear between rows
    #[arg(long)]
    raw_positions: bool,
    /// Also write a prediction band from this many draws, 16 to 100000, of the parameters in the model's [uncertainty]. The
    /// band of pressure_pa includes the noise of the records
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(i64::from(*SAMPLES.start())..=i64::from(*SAMPLES.end())))]
    samples: Option<u32>,
    /// Coverage probability of the band, between 0 and 1
    #[arg(long, value_name = "P", value_parser = level, allow_negative_numbers = true, default_value_t = LEVEL, requires = "samples")]
    level: f64,
    /// Seed of the random draws
    #[arg(long, value_name = "SEED", default_value_t = 0, requires = "samples")]
    seed: u64,
    /// Write the table to this file, `-` for standard output
    #[arg(short, long, value_name = "OUT.csv", default_value = "-")]
    output: PathBuf,
}

fn pressure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if PRESSURE_PA.allow(value) => Ok(value),
        _ => Err(format!("expected {}", PRESSURE_PA.description())),
    }
}

fn level(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("expected a probability between 0 and 1, such as 0.95".to_owned()),
    }
}

/// Simulates and writes the table.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let inputs = [Some(&args.model), Some(&args.motion), args.rig.as_ref()];
    output::check([&args.output], inputs.into_iter().flatten().map(PathBuf::as_path))?;
    let simulated = simulation::simulated(&Request {
        model: Document::read_as(Kind::Model, &args.model)?,
        motion: args.motion.clone(),
        rig: args.rig.as_deref().map(RigFile::document).transpose()?,
        initial_pressure_pa: args.initial_pressure,
        raw_positions: args.raw_positions,
        band: args.samples.map(|samples| Wanted { samples, seed: args.seed, level: args.level }),
    })?;
    simulated.notes.iter().for_each(|note| output::note(note));
    output::write(&args.output, table(&simulated).as_bytes())
}

fn table(simulated: &Simulated) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let columns = simulated.columns();
    let header = line(columns.iter().map(|column| column.name.clone()).collect());
    let row = |row: usize| line(columns.iter().map(|column| cell(column.values[row])).collect());
    std::iter::once(header).chain((0..simulated.samples.len()).map(row)).collect()
}

/// The shortest notation that reads back unchanged, with an exponent where there would be leading zeros.
fn cell(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-3 { format!("{value:e}") } else { value.to_string() }
}
