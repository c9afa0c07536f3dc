//! A model's chamber along a motion: what `pneutherm simulate` and its like in Python compute.

use crate::predictive::{self, Band, Wanted};
use anyhow::{Context, bail};
use chamber::signals::{Knot, Signals};
use chamber::simulate::{RELATIVE_TOLERANCE, Sample, Start, simulate};
use records::limits::PRESSURE_PA;
use records::{Document, Layout, Model, Need, Reading, RigFile, Trace, Window};
use std::path::{Path, PathBuf};

/// Steps of the search for the start; each leaves a small share of the error, a leak's share of the rest's pressure.
const MEAN_ITERATIONS: usize = 8;

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Request {
    /// The model file's content.
    pub model: Document,
    /// The motion, a trace file with or without pressure.
    pub motion: PathBuf,
    /// The content of a rig file whose columns and format are the motion's.
    pub rig: Option<Document>,
    /// Gas pressure at the start, Pa; otherwise from the motion's pressure before the first movement.
    pub initial_pressure_pa: Option<f64>,
    /// A predictive band from the model's uncertainty, where one is wanted.
    pub band: Option<Wanted>,
}

/// A column of the result.
pub struct Column {
    /// Its name, with the unit.
    pub name: &'static str,
    /// Unit of its values.
    pub unit: &'static str,
    /// One line for people.
    pub doc: &'static str,
    /// Its value of a sample.
    pub of: fn(&Sample) -> f64,
}

/// The result's columns, in order.
pub const COLUMNS: [Column; 7] = [
    Column { name: "time_s", unit: "s", doc: "Time, as in the motion", of: |s| s.time },
    Column {
        name: "pressure_pa",
        unit: "Pa",
        doc: "Pressure that the sensor would show, sensor effects included",
        of: |s| s.measured_pressure,
    },
    Column { name: "gas_pressure_pa", unit: "Pa", doc: "Pressure of the gas", of: |s| s.gas_pressure },
    Column { name: "temperature_k", unit: "K", doc: "Mean temperature of the gas", of: |s| s.temperature },
    Column { name: "mass_kg", unit: "kg", doc: "Mass of the gas", of: |s| s.mass },
    Column { name: "volume_m3", unit: "m3", doc: "Volume of the gas", of: |s| s.volume },
    Column { name: "heat_flow_w", unit: "W", doc: "Heat flow into the gas", of: |s| s.heat_flow },
];

/// A simulated motion.
pub struct Simulated {
    /// One for each row of the motion.
    pub samples: Vec<Sample>,
    /// The band around each column but time.
    pub band: Option<Band>,
    /// What was done to the motion's rows to read them, and what the band holds, in sentences.
    pub notes: Vec<String>,
}

/// A column with its values.
pub struct Values {
    /// Its name, with the unit.
    pub name: String,
    /// Unit of its values.
    pub unit: &'static str,
    /// One line for people.
    pub doc: String,
    /// One for each row.
    pub values: Vec<f64>,
}

impl Simulated {
    /// The whole result, column by column.
    pub fn columns(&self) -> Vec<Values> {
        let own = COLUMNS.iter().map(|column| Values {
            name: column.name.to_owned(),
            unit: column.unit,
            doc: column.doc.to_owned(),
            values: self.samples.iter().map(column.of).collect(),
        });
        own.chain(self.band.iter().flat_map(Band::columns)).collect()
    }
}

/// What is simulated along: a motion that was read, and where its first rows are at rest.
pub struct Course<'a> {
    request: &'a Request,
    motion: &'a Trace,
}

/// Simulates: one sample for each row of the motion.
///
/// # Errors
/// A file that is refused, a motion that leaves no gas, no pressure to begin from; a band that the model cannot give.
pub fn simulated(request: &Request) -> anyhow::Result<Simulated> {
    let model = Model::from_document(&request.model)?;
    let motion = read_motion(&request.motion, request.rig.as_ref())?;
    let course = Course { request, motion: &motion };
    let samples = course.samples(&model, 0.0)?;
    let mut notes = motion.notes();
    let band = match &request.band {
        None => None,
        Some(wanted) => {
            let band = predictive::band(&model, &course, *wanted)
                .with_context(|| format!("{}: no band can be drawn", request.model.path().display()))?;
            notes.push(band.note.clone());
            Some(band)
        }
    };
    Ok(Simulated { samples, band, notes })
}

/// A model along a record: what is imposed on the chamber, the state it begins from, one sample for each row.
///
/// # Errors
/// A motion that leaves no gas or cannot be followed, no pressure to begin from.
pub fn along_record(model: &Model, record: &Trace) -> anyhow::Result<(Signals, Start, Vec<Sample>)> {
    from(None, 0.0, model, record)
}

/// The same from a pressure asked for, Pa, or the measured one plus `shift`.
fn from(
    initial_pressure_pa: Option<f64>,
    shift: f64,
    model: &Model,
    motion: &Trace,
) -> anyhow::Result<(Signals, Start, Vec<Sample>)> {
    let signals = signals(model, motion);
    check_volume(model, motion, &signals)?;
    let start = start(initial_pressure_pa, model, motion, &signals, shift)?;
    let samples = along(model, start, &signals, motion, motion.len())?;
    Ok((signals, start, samples))
}

impl Course<'_> {
    /// A model along the motion, its mean pressure at rest that of the motion plus `shift`, Pa.
    ///
    /// # Errors
    /// A motion that leaves no gas or cannot be followed, no pressure to begin from.
    pub fn samples(&self, model: &Model, shift: f64) -> anyhow::Result<Vec<Sample>> {
        let (_, _, samples) = from(self.request.initial_pressure_pa, shift, model, self.motion)?;
        Ok(samples)
    }

    /// How many rows the pressure at the start is the mean of; none where it was asked for.
    pub fn rows_at_rest(&self) -> Option<usize> {
        self.request.initial_pressure_pa.is_none().then(|| rows_at_rest(self.motion))
    }
}

fn read_motion(path: &Path, rig: Option<&Document>) -> anyhow::Result<Trace> {
    let (layout, stroke_m) = rig.map_or_else(|| Ok((Layout::default(), None)), RigFile::layout)?;
    let reading = Reading { layout: &layout, stroke_m, window: Window::ALL, need: Need::Motion };
    Ok(Trace::read(path, &reading)?)
}

fn signals(model: &Model, motion: &Trace) -> Signals {
    let knot = |row: usize| Knot {
        time: motion.time_s[row],
        position: motion.position_m[row],
        mass_flow: motion.mass_flow_kg_per_s.as_ref().map_or(0.0, |flow| flow[row]),
        ambient_temperature: motion.ambient_temperature_k.as_ref().map_or(model.ambient_temperature_k, |t| t[row]),
    };
    let recorded =
        Signals { knots: (0..motion.len()).map(knot).collect(), ambient_pressure: model.ambient_pressure_pa };
    recorded.with_true_stroke(model.active(), &model.chamber.effects)
}

/// The first rows of the motion, simulated.
fn along(model: &Model, start: Start, signals: &Signals, motion: &Trace, rows: usize) -> anyhow::Result<Vec<Sample>> {
    simulate(&model.chamber, model.active(), start, signals, &motion.time_s[..rows], RELATIVE_TOLERANCE)
        .with_context(|| {
            let path = motion.path.display();
            format!("{path}: the model cannot be integrated along this motion; possible causes are a flow that empties the chamber, a jump of the position, or an unrealistic value in the model")
        })
}

/// The state that the simulation begins from: the wall's temperature at rest, and the pressure asked for, or the measured
/// one plus `shift`.
fn start(
    initial_pressure_pa: Option<f64>,
    model: &Model,
    motion: &Trace,
    signals: &Signals,
    shift: f64,
) -> anyhow::Result<Start> {
    let rest = rows_at_rest(motion);
    let ambient = motion.ambient_temperature_k.as_ref().map(|ambient| mean(ambient[..rest].iter().copied()));
    let ambient = ambient.unwrap_or(model.ambient_temperature_k);
    let at = |pressure: f64| Start::at_rest(&model.chamber, pressure, ambient);
    if let Some(pressure) = initial_pressure_pa {
        if !PRESSURE_PA.allow(pressure) {
            bail!("the initial pressure is {pressure}; expected {}", PRESSURE_PA.words());
        }
        return Ok(at(pressure));
    }
    let Some(measured) = &motion.pressure_pa else {
        bail!(
            "{}: no pressure column to take the initial pressure from; give it with --initial-pressure",
            motion.path.display()
        );
    };
    let measured = mean(measured[..rest].iter().copied()) + shift;
    // At rest the sensor shows the mean, but a leak or a drift moves it meanwhile: begin so that the means agree.
    let mut pressure = measured;
    for _ in 0..MEAN_ITERATIONS {
        let samples = along(model, at(pressure), signals, motion, rest)?;
        let next = pressure + measured - mean(samples.iter().map(|sample| sample.measured_pressure));
        let settled = (next - pressure).abs() < 1e-9 * measured;
        // A model that empties or fills the chamber before the piston moves has no such start.
        if !(0.5 * measured..2.0 * measured).contains(&next) {
            return Ok(at(measured));
        }
        pressure = next;
        if settled {
            break;
        }
    }
    Ok(at(pressure))
}

/// Rows before the piston moves or gas flows.
fn rows_at_rest(motion: &Trace) -> usize {
    let flow = motion.mass_flow_kg_per_s.as_deref().unwrap_or_default();
    let closed = flow.iter().position(|flow| *flow != 0.0).unwrap_or(motion.len());
    motion.rows_at_rest().min(closed.max(1))
}

/// Refuses a motion that runs into the chamber's end.
fn check_volume(model: &Model, motion: &Trace, signals: &Signals) -> anyhow::Result<()> {
    let geometry = &model.chamber.geometry;
    for Knot { time, position, .. } in &signals.knots {
        if geometry.volume(*position) <= 0.0 {
            bail!(
                "{}: at {time} s the position {position} m leaves no gas volume (the dead volume is {} m3)",
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
