//! What a trace file holds, understood without a rig file: `pneutherm look`.
//!
//! | module | finds |
//! |---|---|
//! | [`columns`], [`described`] | which column is time, pressure, position, in which unit, by names and units lines |
//! | [`readings`] | rate, gaps, resolution, how often the sensor is really read out |
//! | [`motion`] | rests and moves; windows of one push-and-hold test each |
//! | [`proposal`] | a rig file that says all this |

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

/// Refuses a column named by the user that is not there.
fn check(path: &Path, dialect: &Dialect, names: &Names) -> Result<(), Error> {
    for name in [&names.time, &names.pressure, &names.position].into_iter().flatten() {
        if dialect.place(name).0.is_none() {
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

/// A refusal of what no rig file says yet.
fn without_rig(error: Error) -> Error {
    match error {
        Error::Trace { path, problem } if problem.is_of_a_rig_file() => {
            Error::trace(&path, TraceProblem::WithoutRig { problem })
        }
        other => other,
    }
}

/// Whether there are rows of numbers where these have decimal commas.
fn has_decimal_commas(path: &Path, content: &Content) -> bool {
    let format = Format { decimal: Some(Decimal::Comma), ..Format::default() };
    let layout = Layout { format, ..Layout::default() };
    trace::sample(path, content, &layout).is_ok_and(|(_, _, sample)| !sample.is_empty())
}

/// What was found in a trace file.
#[derive(Clone, Debug)]
pub struct Look {
    /// How its text is written.
    pub dialect: Dialect,
    /// How characters are written.
    pub encoding: Encoding,
    /// What has to be stated of that, as it would not be found.
    pub format: Format,
    /// Which column holds what.
    pub guess: Guess,
    /// The record, where time, pressure and position were found.
    pub found: Option<Found>,
}

/// What a record shows.
#[derive(Clone, Debug)]
pub struct Found {
    /// The record itself.
    pub trace: Trace,
    /// How it was read.
    pub readings: Readings,
    /// Rests and moves, in order.
    pub phases: Vec<Phase>,
}

impl Look {
    /// Looks at a trace file. `names` are columns that the user has named.
    ///
    /// # Errors
    /// A file that cannot be read or is no table, a column that is not there, more bad rows than one in fifty.
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
        // Gauge pressures fall below what absolute ones can be, positions may count from anywhere, either way.
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
