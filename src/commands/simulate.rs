//! `pneutherm simulate`: the chamber along a measured or planned stroke.

use crate::output;
use anyhow::{Context, bail};
use chamber::signals::{Knot, Signals};
use chamber::simulate::{RELATIVE_TOLERANCE, Sample, Start, simulate};
use records::{Layout, Model, Need, Reading, RigFile, Trace, Window};
use std::fmt::Write;
use std::path::PathBuf;

/// Simulate a model's chamber along a measured or planned stroke
#[derive(clap::Args)]
#[command(after_help = "\
One row for each row of the motion: time_s, pressure_pa (what the sensor would show), gas_pressure_pa, temperature_k,
mass_kg, volume_m3, heat_flow_w (into the gas). Before the first movement the gas is at ambient temperature.

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
    /// Gas pressure at the start, Pa, absolute; otherwise the mean of the motion's pressure before the first movement
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
    let model = Model::read(&args.model)?;
    let motion = read_motion(args)?;
    let signals = signals(&model, &motion);
    check_volume(&model, &motion)?;
    let rest = motion.rows_at_rest();
    let initial_pressure = match (args.initial_pressure, &motion.pressure_pa) {
        (Some(pressure), _) => pressure,
        (None, Some(pressure)) => mean(&pressure[..rest]),
        (None, None) => bail!(
            "{}: has no pressure column to begin from; say the gas pressure at the start by --initial-pressure",
            motion.path.display()
        ),
    };
    let initial_temperature = match &motion.ambient_temperature_k {
        Some(ambient) => mean(&ambient[..rest]),
        None => model.ambient_temperature_k,
    };
    let start = Start { pressure: initial_pressure, temperature: initial_temperature };
    let samples = simulate(&model.chamber, model.active(), start, &signals, &motion.time_s, RELATIVE_TOLERANCE)
        .with_context(|| format!("{}: cannot be simulated along", motion.path.display()))?;
    output::write(&args.output, table(&samples)?.as_bytes())
}

fn read_motion(args: &Args) -> anyhow::Result<Trace> {
    let (layout, stroke_m) = match &args.rig {
        None => (Layout::default(), None),
        Some(path) => {
            let file = RigFile::read(path)?;
            (file.layout, file.rig.cylinder.stroke_m)
        }
    };
    let reading = Reading { layout: &layout, stroke_m, window: Window::ALL, need: Need::Motion };
    Ok(Trace::read(&args.motion, &reading)?)
}

fn signals(model: &Model, motion: &Trace) -> Signals {
    let knot = |row: usize| Knot {
        time: motion.time_s[row],
        position: motion.position_m[row],
        mass_flow: motion.mass_flow_kg_per_s.as_ref().map_or(0.0, |flow| flow[row]),
        ambient_temperature: motion.ambient_temperature_k.as_ref().map_or(model.ambient_temperature_k, |t| t[row]),
    };
    Signals { knots: (0..motion.len()).map(knot).collect(), ambient_pressure: model.ambient_pressure_pa }
}

/// Refuses a motion that runs into the chamber's end.
fn check_volume(model: &Model, motion: &Trace) -> anyhow::Result<()> {
    let geometry = &model.chamber.geometry;
    let rows = motion.time_s.iter().zip(&motion.position_m);
    for (time, position) in rows {
        if geometry.volume(*position) <= 0.0 {
            bail!(
                "{}: at {time} s the position {position} m leaves no gas: the dead volume is {} m3",
                motion.path.display(),
                geometry.dead_volume
            );
        }
    }
    Ok(())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn table(samples: &[Sample]) -> Result<String, std::fmt::Error> {
    let mut out = "time_s,pressure_pa,gas_pressure_pa,temperature_k,mass_kg,volume_m3,heat_flow_w\n".to_owned();
    for Sample { time, measured_pressure, gas_pressure, temperature, mass, volume, heat_flow } in samples {
        writeln!(out, "{time},{measured_pressure},{gas_pressure},{temperature},{mass},{volume},{heat_flow}")?;
    }
    Ok(out)
}
