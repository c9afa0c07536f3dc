//! A model's chamber along a motion: the computation of `pneutherm simulate` and its Python equivalent.

pub mod band;
pub mod columns;
pub mod motion_run;
pub mod stroke;

use anyhow::{Context, bail};
use band::{Band, Wanted};
use chamber::simulate::Sample;
use chamber::words::listed;
use columns::{COLUMNS, Values};
use identify::record::plausibility::checks;
use identify::record::unit::Declared;
use motion_run::MotionRun;
use records::layout::Quantity;
use records::{Document, Layout, Model, Need, Reading, RigFile, Trace, Window};
use std::path::{Path, PathBuf};
use stroke::Stroke;

/// Request for a simulation.
#[derive(Clone, Debug)]
pub struct Request {
    /// The model file's content.
    pub model: Document,
    /// The motion, a trace file with or without pressure.
    pub motion: PathBuf,
    /// The content of a rig file with the motion's columns and format.
    pub rig: Option<Document>,
    /// Initial gas pressure, Pa; if `None`, taken from the motion's pressure before the first movement.
    pub initial_pressure_pa: Option<f64>,
    /// Whether positions are used as they are, linear between rows, even if they scatter at rest.
    pub raw_positions: bool,
    /// A prediction band from the model's uncertainty, if requested.
    pub band: Option<Wanted>,
}

/// A simulated motion.
pub struct Simulated {
    /// One sample per row of the motion.
    pub samples: Vec<Sample>,
    /// The band for each column except time.
    pub band: Option<Band>,
    /// Notes on the reading of the motion's rows and on the band, in sentences.
    pub notes: Vec<String>,
}

impl Simulated {
    /// The complete result, column by column.
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

/// Simulates the motion, with one sample per row.
///
/// # Errors
/// For a refused file, a motion that leaves no gas, a missing initial pressure, or a band that the model cannot give.
pub fn simulated(request: &Request) -> anyhow::Result<Simulated> {
    let model = Model::from_document(&request.model)?;
    let (motion, declared) = read_motion(&request.motion, request.rig.as_ref())?;
    match &motion.pressure_pa {
        _ if request.initial_pressure_pa.is_some() => (),
        Some(pressure_pa) => checks::level(&motion.path, pressure_pa, declared)?,
        None => bail!(
            "{}: no pressure column to take the initial pressure from{}; give it with --initial-pressure",
            motion.path.display(),
            near_pressure_column(request)
        ),
    }
    let stroke_of = if request.raw_positions { Stroke::through } else { Stroke::reconstructed };
    let stroke = stroke_of(&motion.time_s, &motion.position_m);
    let mut notes = motion.notes();
    if !stroke.faults.is_empty() {
        notes.push(format!(
            "{}: the piston is held where it rests and moves along smooth curves, since its positions {}",
            motion.path.display(),
            listed(&stroke.faults)
        ));
    }
    let run = MotionRun::new(&motion, stroke, request.initial_pressure_pa);
    notes.extend(run.outlier_note());
    let samples = run.samples(&model, 0.0)?;
    let band = match &request.band {
        None => None,
        Some(wanted) => {
            let band = band::band(&model, &run, *wanted)
                .with_context(|| format!("{}: no band can be drawn", request.model.path().display()))?;
            notes.push(band.note.clone());
            Some(band)
        }
    };
    Ok(Simulated { samples, band, notes })
}

/// A suggestion for the pressure column, in words; empty if no name is similar.
fn near_pressure_column(request: &Request) -> String {
    let near = || {
        let (layout, _) = request.rig.as_ref().map(RigFile::layout).transpose().ok()?.unwrap_or_default();
        records::near_column(&request.motion, &layout, Quantity::Pressure)
    };
    near().map_or(String::new(), |(near, wanted)| format!(" (it has `{near}`: did you mean `{wanted}`?)"))
}

/// The motion, and the declaration of its pressures.
fn read_motion(path: &Path, rig: Option<&Document>) -> anyhow::Result<(Trace, Declared)> {
    let (layout, stroke_m) = rig.map_or_else(|| Ok((Layout::default(), None)), RigFile::layout)?;
    let reading = Reading { layout: &layout, stroke_m, window: Window::ALL, need: Need::Motion };
    Ok((Trace::read(path, &reading)?, Declared::of_layout(&layout)))
}
