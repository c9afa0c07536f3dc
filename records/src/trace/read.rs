//! Reading a trace: the file's first lines tell how it is written, then each row is read where it stands.

use super::Trace;
use super::dialect::Dialect;
use super::excel;
use super::header::Header;
use super::lines::{self, Lines, Stop};
use super::problem::TraceProblem;
use super::reading::Reading;
use super::rows::{ReadRows, Rows};
use crate::error::Error;
use crate::layout::{Layout, Quantity};
use std::fs::File;
use std::io;
use std::path::Path;

/// The least rows that are a record.
const MIN_ROWS: usize = 3;

pub(super) fn read(path: &Path, reading: &Reading<'_>) -> Result<Trace, Error> {
    with_lines(path, reading.layout, |lines| {
        let dialect = dialect(lines, reading.layout)?;
        let header = Header::read(&dialect, reading)?;
        let table = read_rows(lines, &dialect, &header, reading)?;
        no_excel_days(&header, &table.columns[0])?;
        let mut columns = table.columns.into_iter();
        let mut next = |quantity| header.place(quantity).map(|_| columns.next().unwrap_or_default());
        Ok(Trace {
            path: path.to_owned(),
            sha256: lines.sha256(),
            time_s: next(Quantity::Time).unwrap_or_default(),
            pressure_pa: next(Quantity::Pressure),
            position_m: next(Quantity::Position).unwrap_or_default(),
            ambient_temperature_k: next(Quantity::AmbientTemperature),
            gas_temperature_k: next(Quantity::GasTemperature),
            mass_flow_kg_per_s: next(Quantity::MassFlow),
            left_out: table.left_out,
            sorted: table.sorted,
        })
    })
}

/// Opens the file and works on its lines; whatever stops that names the file.
pub(super) fn with_lines<T>(
    path: &Path,
    layout: &Layout,
    work: impl FnOnce(&mut Lines<'_>) -> Result<T, Stop>,
) -> Result<T, Error> {
    let unreadable = |source| Error::Read { path: path.to_owned(), source };
    let facts = std::fs::metadata(path).map_err(unreadable)?;
    if facts.is_dir() {
        let reason = "it is a folder, a trace file is expected";
        return Err(unreadable(io::Error::new(io::ErrorKind::IsADirectory, reason)));
    }
    let refused = |problem| Error::Trace { path: path.to_owned(), problem: Box::new(problem) };
    if facts.len() > lines::MAX_BYTES {
        return Err(refused(lines::too_large(&format!("{} MB", facts.len() >> 20))));
    }
    let file = File::open(path).map_err(unreadable)?;
    let done = Lines::new(file, layout.format.encoding).and_then(|mut lines| {
        lines.skip(layout.format.skip_lines.unwrap_or(0))?;
        work(&mut lines)
    });
    done.map_err(|stop| match stop {
        Stop::Io(source) => unreadable(source),
        Stop::Problem(problem) => refused(problem),
    })
}

/// How the file is written, from its first lines.
pub(super) fn dialect(lines: &mut Lines<'_>, layout: &Layout) -> Result<Dialect, Stop> {
    let wanted: Vec<&str> = layout.columns.iter().map(|column| column.name.as_str()).collect();
    let head = lines.head()?;
    if head.is_empty() {
        return Err(TraceProblem::Empty.into());
    }
    Ok(Dialect::find(head, &layout.format, &wanted))
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

/// Refuses Excel's days where seconds are expected: as such the record would be too short and too fast for any chamber.
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
