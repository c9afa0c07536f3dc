//! Reads a trace: detects the text format from the file's first lines, then reads row by row.

use super::content::Content;
use super::dialect::Dialect;
use super::excel;
use super::header::Header;
use super::lines::{Lines, Stop};
use super::reading::Reading;
use super::record::Trace;
use super::rows::{ReadRows, Rows};
use crate::error::Error;
use crate::error::trace::TraceProblem;
use crate::format::Format;
use crate::layout::{Layout, Quantity};
use std::path::Path;

/// Minimum number of rows of a record.
const MIN_ROWS: usize = 3;

impl Trace {
    /// Reads a trace file.
    ///
    /// # Errors
    /// [`Error`] names the file, the line, the column and the value.
    pub fn read(path: &Path, reading: &Reading<'_>) -> Result<Self, Error> {
        Self::read_content(path, &Content::File, reading)
    }

    /// Reads a trace from a file or a copy.
    pub(crate) fn read_content(path: &Path, content: &Content, reading: &Reading<'_>) -> Result<Self, Error> {
        with_lines(path, content, reading.layout, |lines| {
            let dialect = dialect(lines, reading.layout)?;
            let header = match Header::read(&dialect, reading) {
                Ok(header) => header,
                Err(problem) => return Err(with_cause(problem, &dialect, lines, reading.layout)?.into()),
            };
            let table = read_rows(lines, &dialect, &header, reading)?;
            no_excel_days(&header, &table.columns[0])?;
            let mut columns = table.columns.into_iter();
            let mut next = |quantity| header.index_of(quantity).map(|_| columns.next().unwrap_or_default());
            Ok(Trace {
                path: path.to_owned(),
                sha256: lines.sha256(),
                time_s: next(Quantity::Time).unwrap_or_default(),
                pressure_pa: next(Quantity::Pressure),
                position_m: next(Quantity::Position).unwrap_or_default(),
                ambient_temperature_k: next(Quantity::AmbientTemperature),
                gas_temperature_k: next(Quantity::GasTemperature),
                mass_flow_kg_per_s: next(Quantity::MassFlow),
                lines: table.lines,
                dropped_rows: table.dropped_rows,
                sorted: table.sorted,
            })
        })
    }
}

/// Opens the file and processes its lines; errors name the file.
pub(super) fn with_lines<T>(
    path: &Path,
    content: &Content,
    layout: &Layout,
    work: impl FnOnce(&mut Lines<'_>) -> Result<T, Stop>,
) -> Result<T, Error> {
    let source = content.open(path)?;
    let done = Lines::new(source, layout.format.encoding).and_then(|mut lines| {
        lines.skip(layout.format.skip_lines.unwrap_or(0))?;
        work(&mut lines)
    });
    done.map_err(|stop| match stop {
        Stop::Io(source) => Error::Read { path: path.to_owned(), source },
        Stop::Problem(problem) => Error::trace(path, problem),
    })
}

/// Text format of the file, from its first lines.
pub(super) fn dialect(lines: &mut Lines<'_>, layout: &Layout) -> Result<Dialect, Stop> {
    let wanted: Vec<&str> = layout.columns.iter().map(|column| column.name.as_str()).collect();
    if lines.head()?.is_empty() {
        let lines = lines.number();
        return Err(match layout.format.skip_lines {
            Some(skipped) if lines > 0 && skipped > 0 => TraceProblem::AllSkipped { skipped, lines }.into(),
            _ => TraceProblem::Empty.into(),
        });
    }
    Ok(Dialect::find(lines.head()?, &layout.format, &wanted))
}

/// The problem or, if a column is missing because the rig file states a wrong decimal sign, that cause.
fn with_cause(
    problem: TraceProblem,
    dialect: &Dialect,
    lines: &mut Lines<'_>,
    layout: &Layout,
) -> Result<TraceProblem, Stop> {
    let TraceProblem::MissingColumn { column, .. } = &problem else { return Ok(problem) };
    let format = Format { decimal: None, ..layout.format.clone() };
    let free = Dialect::find(lines.head()?, &format, &[column]);
    let is_cause =
        layout.format.decimal.is_some() && free.decimal != dialect.decimal && free.find_column(column).0.is_some();
    Ok(if is_cause { TraceProblem::OtherDecimal { line: free.first_row, found: free.decimal.name() } } else { problem })
}

fn read_rows(
    lines: &mut Lines<'_>,
    dialect: &Dialect,
    header: &Header<'_>,
    reading: &Reading<'_>,
) -> Result<ReadRows, Stop> {
    let mut rows = Rows::new(dialect, header, reading);
    while let Some((line, text)) = lines.next_filled()? {
        if line >= dialect.first_row && !dialect.is_comment(text) {
            rows.take(line, text)?;
        }
    }
    let (seen, extent_s) = (rows.seen(), rows.extent_s());
    let table = rows.finish()?;
    enough(seen, table.columns[0].len(), header.line, extent_s)?;
    Ok(table)
}

/// Refuses Excel's days where seconds are expected: as seconds the record would be too short and too fast for any chamber.
fn no_excel_days(header: &Header<'_>, time_s: &[f64]) -> Result<(), TraceProblem> {
    let column = header.found[0].2;
    let is_seconds = column.unit == Quantity::Time.si_unit() && column.factor == 1.0 && column.offset == 0.0;
    match (time_s.first(), time_s.last()) {
        (Some(&from), Some(&to)) if is_seconds && excel::are_days(from, to, time_s.len()) => {
            Err(TraceProblem::ExcelDays { column: column.name.clone(), from, to })
        }
        _ => Ok(()),
    }
}

fn enough(rows: usize, used: usize, line: usize, [from, to]: [f64; 2]) -> Result<(), TraceProblem> {
    match (rows, used) {
        (0, _) => Err(TraceProblem::NoRows { line }),
        (_, used) if used >= MIN_ROWS => Ok(()),
        (rows, used) if rows == used => Err(TraceProblem::FewRows { rows, part: String::new() }),
        (_, used) => {
            let part = format!("between from_s and to_s, of a record from {from:?} s to {to:?} s, ");
            Err(TraceProblem::FewRows { rows: used, part })
        }
    }
}
