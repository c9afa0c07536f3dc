//! `pneutherm simulate`: the chamber along a measured or planned stroke.

use crate::output;
use crate::simulation::{self, COLUMNS, Request};
use chamber::simulate::Sample;
use std::path::PathBuf;

/// Simulate a model's chamber along a measured or planned stroke
#[derive(clap::Args)]
#[command(after_help = "\
One row for each row of the motion: time_s, pressure_pa (what the sensor would show), gas_pressure_pa, temperature_k, \
mass_kg, volume_m3, heat_flow_w (into the gas). The gas begins at ambient temperature, and at the pressure with which \
the simulated mean before the first movement is that of the motion's pressure column.

Example:
  pneutherm simulate model.toml --motion validation.csv -o simulated.csv
  pneutherm simulate model.toml --motion plan.csv --initial-pressure 6e5 | head")]
pub struct Args {
    /// The model, as `identify` and `diagnose` write it
    #[arg(value_name = "MODEL.toml")]
    model: PathBuf,
    /// The motion: columns time_s and position_m; pressure_pa, ambient_temperature_k, mass_flow_kg_per_s where known
    #[arg(long, value_name = "TRACE.csv")]
    motion: PathBuf,
    /// A rig whose [columns] and [format] say how the motion's file is laid out
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Gas pressure at the start, Pa, absolute; otherwise from the motion's pressure before the first movement
    #[arg(long, value_name = "PA", value_parser = pressure)]
    initial_pressure: Option<f64>,
    /// The file to write
    #[arg(short, long, value_name = "OUT.csv", default_value = "-")]
    output: PathBuf,
}

fn pressure(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("a pressure in Pa, absolute and above zero, is expected".to_owned()),
    }
}

/// Simulates and writes the table.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let simulated = simulation::simulated(&Request {
        model: args.model.clone(),
        motion: args.motion.clone(),
        rig: args.rig.clone(),
        initial_pressure_pa: args.initial_pressure,
    })?;
    simulated.notes.iter().for_each(|note| output::note(note));
    output::write(&args.output, table(&simulated.samples).as_bytes())
}

fn table(samples: &[Sample]) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let header = line(COLUMNS.iter().map(|column| column.name.to_owned()).collect());
    let rows = samples.iter().map(|sample| line(COLUMNS.iter().map(|c| (c.of)(sample).to_string()).collect()));
    std::iter::once(header).chain(rows).collect()
}
