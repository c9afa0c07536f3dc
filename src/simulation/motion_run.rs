//! A model along a motion: the chamber's inputs, its initial state, and one sample per row.

use super::stroke::Stroke;
use anyhow::{Context, bail};
use chamber::signals::{Knot, Signals};
use chamber::simulate::{RELATIVE_TOLERANCE, Sample, Start, simulate};
use identify::record::far_off;
use identify::record::plausibility::outliers;
use records::limits::PRESSURE_PA;
use records::{Model, Trace};

/// Iterations for the initial pressure; each leaves a small fraction of the error, the fraction of the pressure lost to a leak
/// during the rest.
const MEAN_ITERATIONS: usize = 8;

/// Inputs of a simulation: a motion from a file, and the initial pressure.
pub struct MotionRun<'a> {
    /// The file's rows: times, ambient temperatures, flows, and the pressure from which the initial one is taken.
    pub motion: &'a Trace,
    /// Motion of the piston, which may differ from the recorded positions.
    pub stroke: Stroke,
    /// Initial gas pressure, Pa; if `None`, taken from the motion's pressure before the first movement.
    pub initial_pressure_pa: Option<f64>,
    /// Number of rows before the piston moves or gas flows.
    rest: usize,
    /// Outliers of the pressure among those rows.
    far_off: Vec<usize>,
}

impl<'a> MotionRun<'a> {
    /// A motion with its stroke, and the initial pressure if given.
    pub fn new(motion: &'a Trace, stroke: Stroke, initial_pressure_pa: Option<f64>) -> Self {
        let rest = rows_at_rest(motion);
        let measured = motion.pressure_pa.as_deref().filter(|_| initial_pressure_pa.is_none());
        let far_off = measured.map_or_else(Vec::new, |pressure_pa| outliers::of_rest(pressure_pa, rest));
        Self { motion, stroke, initial_pressure_pa, rest, far_off }
    }

    /// A note on the outliers left out before the first movement, if any.
    pub fn outlier_note(&self) -> Option<String> {
        let Trace { path, lines, time_s, .. } = self.motion;
        far_off::sentence(path, &self.far_off, lines, time_s)
    }

    /// Mean over the rows at rest, without outliers.
    fn mean_at_rest(&self, of: impl Fn(usize) -> f64) -> f64 {
        let rows = || (0..self.rest).filter(|row| self.far_off.binary_search(row).is_err());
        rows().map(of).sum::<f64>() / rows().count() as f64
    }

    /// A model along the motion, with its mean pressure at rest equal to that of the motion plus `shift`, Pa.
    ///
    /// # Errors
    /// For a motion that leaves no gas or cannot be integrated, or without an initial pressure.
    pub fn samples(&self, model: &Model, shift: f64) -> anyhow::Result<Vec<Sample>> {
        let (_, _, samples) = self.followed(model, shift)?;
        Ok(samples)
    }

    /// Number of rows averaged for the initial pressure; `None` if it was given.
    pub fn rows_at_rest(&self) -> Option<usize> {
        self.initial_pressure_pa.is_none().then(|| self.rest - self.far_off.len())
    }

    /// As [`MotionRun::samples`], with the chamber's inputs and initial state.
    fn followed(&self, model: &Model, shift: f64) -> anyhow::Result<(Signals, Start, Vec<Sample>)> {
        let signals = self.signals(model);
        check_volume(model, self.motion, &signals)?;
        let start = self.start(model, &signals, shift)?;
        let samples = along(model, start, &signals, self.motion, self.motion.len())?;
        Ok((signals, start, samples))
    }

    fn signals(&self, model: &Model) -> Signals {
        let motion = self.motion;
        let knot = |row: usize| Knot {
            time: motion.time_s[row],
            position: motion.position_m[row],
            mass_flow: motion.mass_flow_kg_per_s.as_ref().map_or(0.0, |flow| flow[row]),
            ambient_temperature: motion.ambient_temperature_k.as_ref().map_or(model.ambient_temperature_k, |t| t[row]),
        };
        let rows =
            Signals { knots: (0..motion.len()).map(knot).collect(), ambient_pressure: model.ambient_pressure_pa };
        let knots = self.stroke.knots.iter().map(|&(time, position)| Knot { position, ..rows.knot(time) });
        let recorded = Signals { knots: knots.collect(), ambient_pressure: rows.ambient_pressure };
        recorded.with_true_stroke(model.active(), &model.chamber.effects)
    }

    /// The initial state: the wall's temperature at rest, and the given pressure or the measured one plus `shift`.
    fn start(&self, model: &Model, signals: &Signals, shift: f64) -> anyhow::Result<Start> {
        let motion = self.motion;
        let ambient = motion.ambient_temperature_k.as_ref().map(|ambient| self.mean_at_rest(|row| ambient[row]));
        let ambient = ambient.unwrap_or(model.ambient_temperature_k);
        let at = |pressure: f64| Start::at_rest(&model.chamber, pressure, ambient);
        if let Some(pressure) = self.initial_pressure_pa {
            if !PRESSURE_PA.allow(pressure) {
                bail!("the initial pressure is {pressure}; expected {}", PRESSURE_PA.description());
            }
            return Ok(at(pressure));
        }
        let Some(measured) = &motion.pressure_pa else {
            bail!(
                "{}: no pressure column to take the initial pressure from; give it with --initial-pressure",
                motion.path.display()
            );
        };
        let measured = self.mean_at_rest(|row| measured[row]) + shift;
        Ok(at(self.pressure_of_mean(model, signals, at, measured)?))
    }

    /// The initial pressure for which the sensor's mean reading over the rest is `measured`, despite a leak or drift; `measured`
    /// itself for a model that empties or fills the chamber before the piston moves.
    fn pressure_of_mean(
        &self,
        model: &Model,
        signals: &Signals,
        at: impl Fn(f64) -> Start,
        measured: f64,
    ) -> anyhow::Result<f64> {
        let mut pressure = measured;
        for _ in 0..MEAN_ITERATIONS {
            let samples = along(model, at(pressure), signals, self.motion, self.rest)?;
            let next = pressure + measured - self.mean_at_rest(|row| samples[row].measured_pressure);
            if !(0.5 * measured..2.0 * measured).contains(&next) {
                return Ok(measured);
            }
            let settled = (next - pressure).abs() < 1e-9 * measured;
            pressure = next;
            if settled {
                break;
            }
        }
        Ok(pressure)
    }
}

/// A model along a record with a stroke linear between rows: the chamber's inputs, its initial state, and one sample per row.
///
/// # Errors
/// For a motion that leaves no gas or cannot be integrated, or without an initial pressure.
pub fn along_record(model: &Model, record: &Trace) -> anyhow::Result<(Signals, Start, Vec<Sample>)> {
    let stroke = Stroke::reconstructed(&record.time_s, &record.position_m).at_rows(&record.time_s);
    MotionRun::new(record, stroke, None).followed(model, 0.0)
}

/// Simulates the first rows of the motion.
fn along(model: &Model, start: Start, signals: &Signals, motion: &Trace, rows: usize) -> anyhow::Result<Vec<Sample>> {
    simulate(&model.chamber, model.active(), start, signals, &motion.time_s[..rows], RELATIVE_TOLERANCE)
        .with_context(|| {
            let path = motion.path.display();
            format!("{path}: the model cannot be integrated along this motion; possible causes are a flow that empties the chamber, a jump of the position, or an unrealistic value in the model")
        })
}

/// Number of rows before the piston moves or gas flows.
fn rows_at_rest(motion: &Trace) -> usize {
    let flow = motion.mass_flow_kg_per_s.as_deref().unwrap_or_default();
    let closed = flow.iter().position(|flow| *flow != 0.0).unwrap_or(motion.len());
    motion.rows_at_rest().min(closed.max(1))
}

/// Refuses a motion beyond the chamber's end.
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
