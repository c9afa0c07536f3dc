//! Contents of a trace file, found without a rig file: `pneutherm look`.
//!
//! | module | finds |
//! |---|---|
//! | [`columns`], [`described`] | which column is time, pressure, position, in which unit, from names and units lines |
//! | [`readings`] | rate, gaps, resolution, actual readout rate of the sensor |
//! | [`motion`] | rests and moves; windows with one push-and-hold test each |
//! | [`proposal`] | a rig file with these findings |

pub mod columns;
pub mod described;
pub mod motion;
pub mod proposal;
pub mod readings;

use crate::error::Error;
use crate::error::trace::TraceProblem;
use crate::format::{Decimal, Encoding, Format};
use crate::layout::Layout;
use crate::names::nearest;
use crate::trace::{self, Content, Need, Reading, Trace, Window};
use columns::{Guess, Names};
use motion::Phase;
use readings::Readings;
use std::path::Path;

pub use crate::trace::Dialect;

/// Refuses a missing column that the user named.
fn check(path: &Path, dialect: &Dialect, names: &Names) -> Result<(), Error> {
    for name in [&names.time, &names.pressure, &names.position].into_iter().flatten() {
        if dialect.find_column(name).0.is_none() {
            let mut problem = trace::missing_column(name, dialect, false);
            if let TraceProblem::MissingColumn { hint, .. } = &mut problem {
                let near = nearest(name, dialect.names.iter().map(String::as_str));
                *hint = match (dialect.header, near) {
                    (None, _) => ", as there is no header line: give the column's number, \"column 1\"".to_owned(),
                    (_, Some(near)) => format!(", did you mean `{near}`?"),
                    (_, None) => String::new(),
                };
            }
            return Err(Error::trace(path, problem));
        }
    }
    Ok(())
}

/// Rewords an error that refers to a rig file, as there is none yet.
fn without_rig(error: Error) -> Error {
    match error {
        Error::Trace { path, problem } if problem.is_of_a_rig_file() => {
            Error::trace(&path, TraceProblem::WithoutRig { problem })
        }
        other => other,
    }
}

/// Whether decimal commas make rows of numbers readable.
fn has_decimal_commas(path: &Path, content: &Content) -> bool {
    let format = Format { decimal: Some(Decimal::Comma), ..Format::default() };
    let layout = Layout { format, ..Layout::default() };
    trace::sample(path, content, &layout).is_ok_and(|(_, _, sample)| !sample.is_empty())
}

/// Contents found in a trace file.
#[derive(Clone, Debug)]
pub struct Look {
    /// Its text format.
    pub dialect: Dialect,
    /// Its character encoding.
    pub encoding: Encoding,
    /// The part of the format that must be stated because it would not be detected.
    pub format: Format,
    /// Assignment of columns to quantities.
    pub guess: Guess,
    /// The record, if time, pressure and position were found.
    pub found: Option<Found>,
}

/// Contents of a record.
#[derive(Clone, Debug)]
pub struct Found {
    /// The record itself.
    pub trace: Trace,
    /// Its sampling and resolution.
    pub readings: Readings,
    /// Rests and moves, in order.
    pub phases: Vec<Phase>,
}

impl Look {
    /// Examines a trace file. `names` are columns named by the user.
    ///
    /// # Errors
    /// An unreadable file or one without a table, a missing column, more bad rows than one in fifty.
    pub fn at(path: &Path, names: &Names) -> Result<Self, Error> {
        let content = Content::lasting(path)?;
        let (mut dialect, mut encoding, mut sample) = trace::sample(path, &content, &Layout::default())?;
        let mut format = Format::default();
        if sample.is_empty() && has_decimal_commas(path, &content) {
            format.decimal = Some(Decimal::Comma);
            let layout = Layout { format: format.clone(), ..Layout::default() };
            (dialect, encoding, sample) = trace::sample(path, &content, &layout)?;
        }
        check(path, &dialect, names)?;
        if dialect.names.len() < 2 {
            return Err(Error::trace(path, TraceProblem::OneColumn));
        }
        if sample.is_empty() {
            return Err(Error::trace(path, TraceProblem::NoRows { line: dialect.header.unwrap_or(1) }));
        }
        let mut guess = Guess::from_names(&dialect, &sample, names);
        if !guess.missing().is_empty() {
            return Ok(Self { dialect, encoding, format, guess, found: None });
        }
        let read = |guess: &Guess| {
            let layout = Layout { format: format.clone(), ..guess.layout() };
            let reading = Reading { layout: &layout, stroke_m: None, window: Window::ALL, need: Need::Measurement };
            Trace::read_content(path, &content, &reading)
        };
        // Gauge pressures can be too low for absolute ones; positions may have any zero and direction.
        let trace = loop {
            match read(&guess) {
                Ok(trace) => break trace,
                Err(error) if guess.learns_from(&error) => {}
                Err(error) => return Err(without_rig(error)),
            }
        };
        let trace = if guess.learns_from_record(&trace) { read(&guess).map_err(without_rig)? } else { trace };
        let pressure = trace.pressure_pa.as_deref().unwrap_or_default();
        let readings = Readings::of(&trace.time_s, pressure);
        let phases = motion::phases(&trace.time_s, &trace.position_m);
        Ok(Self { dialect, encoding, format, guess, found: Some(Found { trace, readings, phases }) })
    }
}
