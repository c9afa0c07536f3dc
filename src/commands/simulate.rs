//! `pneutherm simulate`: the chamber along a measured or planned stroke.

use crate::output;
use anyhow::{Context, bail};
use chamber::signals::{Knot, Signals};
use chamber::simulate::{RELATIVE_TOLERANCE, Sample, Start, simulate};
use records::{Layout, Model, Need, Reading, RigFile, Trace, Window};
use std::fmt::Write;
use std::path::PathBuf;

/// Steps of the search for the start; each leaves a small share of the error, a leak's share of the rest's pressure.
const MEAN_ITERATIONS: usize = 8;

/// Simulate a model's chamber along a measured or planned stroke
#[derive(clap::Args)]
#[command(after_help = "\
One row for each row of the motion: time_s, pressure_pa (what the sensor would show), gas_pressure_pa, temperature_k,
mass_kg, volume_m3, heat_flow_w (into the gas). The gas begins at ambient temperature, and at the pressure with which
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
    let model = Model::read(&args.model)?;
    let motion = read_motion(args)?;
    let signals = signals(&model, &motion);
    check_volume(&model, &motion)?;
    let start = start(args, &model, &motion, &signals)?;
    let samples = along(&model, start, &signals, &motion, motion.len())?;
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

/// The first rows of the motion, simulated.
fn along(model: &Model, start: Start, signals: &Signals, motion: &Trace, rows: usize) -> anyhow::Result<Vec<Sample>> {
    simulate(&model.chamber, model.active(), start, signals, &motion.time_s[..rows], RELATIVE_TOLERANCE)
        .with_context(|| format!("{}: cannot be simulated along", motion.path.display()))
}

/// The state that the simulation begins from: ambient temperature, and the pressure asked for or measured.
fn start(args: &Args, model: &Model, motion: &Trace, signals: &Signals) -> anyhow::Result<Start> {
    let rest = rows_at_rest(motion);
    let ambient = motion.ambient_temperature_k.as_ref().map(|ambient| mean(ambient[..rest].iter().copied()));
    let temperature = ambient.unwrap_or(model.ambient_temperature_k);
    if let Some(pressure) = args.initial_pressure {
        return Ok(Start { pressure, temperature });
    }
    let Some(measured) = &motion.pressure_pa else {
        bail!(
            "{}: has no pressure column to begin from; say the gas pressure at the start by --initial-pressure",
            motion.path.display()
        );
    };
    let measured = mean(measured[..rest].iter().copied());
    // At rest the sensor shows the mean, but a leak or a drift moves it meanwhile: begin so that the means agree.
    let mut pressure = measured;
    for _ in 0..MEAN_ITERATIONS {
        let samples = along(model, Start { pressure, temperature }, signals, motion, rest)?;
        let next = pressure + measured - mean(samples.iter().map(|sample| sample.measured_pressure));
        let settled = (next - pressure).abs() < 1e-9 * measured;
        // A model that empties or fills the chamber before the piston moves has no such start.
        if !(0.5 * measured..2.0 * measured).contains(&next) {
            return Ok(Start { pressure: measured, temperature });
        }
        pressure = next;
        if settled {
            break;
        }
    }
    Ok(Start { pressure, temperature })
}

/// Rows before the piston moves or gas flows.
fn rows_at_rest(motion: &Trace) -> usize {
    let flow = motion.mass_flow_kg_per_s.as_deref().unwrap_or_default();
    let closed = flow.iter().position(|flow| *flow != 0.0).unwrap_or(motion.len());
    motion.rows_at_rest().min(closed.max(1))
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

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn table(samples: &[Sample]) -> Result<String, std::fmt::Error> {
    let mut out = "time_s,pressure_pa,gas_pressure_pa,temperature_k,mass_kg,volume_m3,heat_flow_w\n".to_owned();
    for Sample { time, measured_pressure, gas_pressure, temperature, mass, volume, heat_flow } in samples {
        writeln!(out, "{time},{measured_pressure},{gas_pressure},{temperature},{mass},{volume},{heat_flow}")?;
    }
    Ok(out)
}
