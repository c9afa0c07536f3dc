//! User-defined points: a Parquet or CSV file with a column for each varied quantity, read in pieces.

use crate::error::Error;
use crate::quantity::Allowed;
use arrow::array::{Array, AsArray, Float64Array};
use arrow::compute::cast;
use arrow::datatypes::{DataType, Float64Type};
use arrow::record_batch::RecordBatch;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder};
use records::layout::Separator;
use report::number::shortest;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Separator of a CSV file. A row is a line, so that errors name its line exactly: the `csv` crate counts blank lines and the
/// second half of a CR LF towards the next record.
const COMMA: Separator = Separator::Byte(b',');
/// Length limit of a line in a CSV file, bytes: a file without line ends is not loaded into memory as one line.
const MAX_LINE: u64 = 1 << 20;
/// Rows between stored positions in a CSV file.
const STRIDE: u64 = 16_384;

/// A file of points.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    rows: u64,
    names: Vec<String>,
    columns: Vec<usize>,
    /// Allowed values of each of these columns, once known.
    allowed: Vec<Allowed>,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    Parquet(ArrowReaderMetadata),
    /// Byte and line of every [`STRIDE`]-th row.
    Csv(Vec<(u64, u64)>),
}

impl Table {
    /// Opens a file ending in `.parquet` or `.csv`; the first line of a CSV file has the column names.
    ///
    /// # Errors
    /// The file cannot be read, or has another ending or no rows.
    pub fn open(path: &Path) -> Result<Self, Error> {
        if !std::fs::metadata(path).map_err(Error::reading(path))?.is_file() {
            return Err(Error::table(
                path,
                "it is no file; expected a Parquet or CSV file, whose rows are read more than once",
            ));
        }
        let (names, rows, kind) = match path.extension().and_then(|e| e.to_str()) {
            Some("parquet") => {
                let file = File::open(path).map_err(Error::reading(path))?;
                let metadata = unbroken(path, || {
                    ArrowReaderMetadata::load(&file, ArrowReaderOptions::new()).map_err(Error::parquet(path))
                })?;
                let names = metadata.schema().fields().iter().map(|f| f.name().clone()).collect();
                let rows = metadata.metadata().file_metadata().num_rows() as u64;
                (names, rows, Kind::Parquet(metadata))
            }
            Some("csv") => index_csv(path)?,
            _ => return Err(Error::table(path, "expected a Parquet or CSV file, whose name ends in .parquet or .csv")),
        };
        if rows == 0 {
            return Err(Error::table(path, "the table has no rows; expected one for each point"));
        }
        let columns = (0..names.len()).collect();
        Ok(Self { path: path.to_owned(), rows, columns, allowed: Vec::new(), names, kind })
    }

    /// Names of the columns in use.
    pub fn names(&self) -> Vec<&str> {
        self.columns.iter().map(|&c| self.names[c].as_str()).collect()
    }

    /// Uses only the columns for which `keep` is true.
    pub fn retain(&mut self, keep: impl Fn(&str) -> bool) {
        self.columns.retain(|&c| keep(&self.names[c]));
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads every row once and checks each value against its column's allowed ones, and each row with `row`, which returns the
    /// reason for a refusal.
    ///
    /// # Errors
    /// As [`Table::fill`], or the first value or row refused.
    pub fn check(
        &mut self,
        allowed: Vec<Allowed>,
        mut row: impl FnMut(&[f64]) -> Result<(), String>,
    ) -> Result<(), Error> {
        self.allowed = allowed;
        let mut columns = vec![Vec::new(); self.columns.len()];
        for start in (0..self.rows).step_by(STRIDE as usize) {
            let end = self.rows.min(start + STRIDE);
            columns.iter_mut().for_each(Vec::clear);
            self.fill(start..end, &mut columns)?;
            for (i, number) in (start..end).enumerate() {
                let values: Vec<f64> = columns.iter().map(|column| column[i]).collect();
                row(&values).map_err(|why| Error::table(&self.path, format!("row {number}: {why}")))?;
            }
        }
        Ok(())
    }

    /// Appends the values of some rows to one column for each of [`Table::names`].
    ///
    /// # Errors
    /// The file cannot be read or contains a value that is no number, such as an empty or missing one.
    pub fn fill(&self, rows: Range<u64>, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        match &self.kind {
            Kind::Parquet(metadata) => unbroken(&self.path, || self.fill_from_parquet(metadata, rows, columns)),
            Kind::Csv(positions) => self.fill_from_csv(positions, rows, columns),
        }
    }

    fn fill_from_parquet(
        &self,
        metadata: &ArrowReaderMetadata,
        rows: Range<u64>,
        columns: &mut [Vec<f64>],
    ) -> Result<(), Error> {
        let file = File::open(&self.path).map_err(Error::reading(&self.path))?;
        let mask = ProjectionMask::roots(metadata.parquet_schema(), self.columns.iter().copied());
        let reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata.clone())
            .with_projection(mask)
            .with_offset(rows.start as usize)
            .with_limit((rows.end - rows.start) as usize)
            .build()
            .map_err(Error::parquet(&self.path))?;
        let mut at = rows.start;
        for batch in reader {
            let batch = batch.map_err(|error| Error::arrow(&self.path, error))?;
            self.append(&batch, at, columns)?;
            at += batch.num_rows() as u64;
        }
        if at == rows.end {
            Ok(())
        } else {
            Err(Error::table(&self.path, "the file holds fewer rows than its header says; write it again"))
        }
    }

    fn append(&self, batch: &RecordBatch, first_row: u64, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        for (c, (&index, column)) in self.columns.iter().zip(columns).enumerate() {
            let name = &self.names[index];
            let array = batch
                .column_by_name(name)
                .ok_or_else(|| Error::table(&self.path, format!("column `{name}` is missing in some row groups")))?;
            let numeric = array.data_type().is_numeric();
            let numbers = if numeric { cast(array, &DataType::Float64).ok() } else { None };
            let numbers = numbers.ok_or_else(|| {
                Error::table(&self.path, format!("column `{name}` holds {}; expected numbers", array.data_type()))
            })?;
            let numbers: &Float64Array = numbers.as_primitive::<Float64Type>();
            for i in 0..numbers.len() {
                if numbers.is_null(i) || !numbers.value(i).is_finite() {
                    let row = first_row + i as u64;
                    return Err(Error::table(
                        &self.path,
                        format!("column `{name}`, row {row}: expected a finite number"),
                    ));
                }
                let value = numbers.value(i);
                self.check_allowed(c, value, || format!("column `{name}`, row {}", first_row + i as u64))?;
                column.push(value);
            }
        }
        Ok(())
    }

    /// Refuses a value not allowed in the column at this index among those in use; `location` describes where it is.
    fn check_allowed(&self, column: usize, value: f64, location: impl FnOnce() -> String) -> Result<(), Error> {
        match self.allowed.get(column).filter(|allowed| !allowed.contains(value)) {
            None => Ok(()),
            Some(allowed) => {
                let message = format!("{}: is {}, but has to be {allowed}", location(), shortest(value));
                Err(Error::table(&self.path, message))
            }
        }
    }

    fn fill_from_csv(&self, positions: &[(u64, u64)], rows: Range<u64>, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        let read = Error::reading(&self.path);
        let (byte, mut line) = positions[(rows.start / STRIDE) as usize];
        let mut reader = BufReader::new(File::open(&self.path).map_err(&read)?);
        reader.seek(SeekFrom::Start(byte)).map_err(&read)?;
        let mut row = rows.start / STRIDE * STRIDE;
        let mut text = String::new();
        while row < rows.end {
            text.clear();
            if reader.by_ref().take(MAX_LINE).read_line(&mut text).map_err(&read)? == 0 {
                return Err(Error::table(&self.path, "the table became shorter while it was read"));
            }
            line += 1;
            if text.trim().is_empty() {
                continue;
            }
            if row >= rows.start {
                self.append_line(&text, line, columns)?;
            }
            row += 1;
        }
        Ok(())
    }

    fn append_line(&self, text: &str, line: u64, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        let fields = records::fields_of_line(text, COMMA);
        if fields.len() != self.names.len() {
            let (found, expected) = (fields.len(), self.names.len());
            return Err(Error::table(
                &self.path,
                format!("line {line}: {found} values; expected {expected}, one for each column of the header"),
            ));
        }
        for (c, (&index, column)) in self.columns.iter().zip(columns).enumerate() {
            let number = fields[index].parse::<f64>().ok().filter(|n| n.is_finite()).ok_or_else(|| {
                let what = match fields[index] {
                    "" => "the field is empty; expected a number".to_owned(),
                    text => format!("`{text}` is not a finite number (decimal point, no unit)"),
                };
                Error::table(&self.path, format!("line {line}, column `{}`: {what}", self.names[index]))
            })?;
            self.check_allowed(c, number, || format!("line {line}, column `{}`", self.names[index]))?;
            column.push(number);
        }
        Ok(())
    }
}

/// The Parquet library panics on some damaged files; these are refused like any others.
fn unbroken<T>(path: &Path, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err(Error::table(path, "the Parquet file is damaged")))
}

/// Refuses a line read only in part.
fn check_length(path: &Path, line: u64, begin: &[u8]) -> Result<(), Error> {
    if begin.len() as u64 == MAX_LINE && !begin.ends_with(b"\n") {
        let message = format!("line {line} is longer than {MAX_LINE} bytes; expected a row of a few numbers");
        return Err(Error::table(path, message));
    }
    Ok(())
}

/// Reads a CSV file once: its header, its number of rows and the position of every [`STRIDE`]-th row.
fn index_csv(path: &Path) -> Result<(Vec<String>, u64, Kind), Error> {
    let read = Error::reading(path);
    let mut reader = BufReader::new(File::open(path).map_err(&read)?);
    let mut text = String::new();
    let mut byte = reader.by_ref().take(MAX_LINE).read_line(&mut text).map_err(&read)? as u64;
    check_length(path, 1, text.as_bytes())?;
    let header = text.trim_start_matches('\u{feff}').trim();
    let names: Vec<String> = records::fields_of_line(header, COMMA).into_iter().map(str::to_owned).collect();
    if let ([_], Some(separator)) = (&names[..], header.chars().find(|c| matches!(c, ';' | '\t'))) {
        let message =
            format!("line 1: its columns are separated by {separator:?}; expected commas, and decimal points");
        return Err(Error::table(path, message));
    }
    if let Some(twice) = records::repeated(&names) {
        return Err(Error::table(path, format!("line 1: two columns are named `{twice}`; expected different names")));
    }
    let (mut rows, mut line, mut positions) = (0, 1, Vec::new());
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut bytes).map_err(&read)?;
        if length == 0 {
            return Ok((names, rows, Kind::Csv(positions)));
        }
        check_length(path, line + 1, &bytes)?;
        if !bytes.iter().all(u8::is_ascii_whitespace) {
            if rows % STRIDE == 0 {
                positions.push((byte, line));
            }
            rows += 1;
        }
        byte += length as u64;
        line += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_piece_of_a_csv_file_is_what_stands_there_also_beside_words_with_commas() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let lines: String =
            (0..40_000).map(|i| format!("\"a, {i}\", {}.5\r\n{}", 2 * i, if i % 7 == 0 { "\n" } else { "" })).collect();
        std::fs::write(&path, format!("\"id, free\",\"bore_m\"\n{lines}")).unwrap();
        let mut table = Table::open(&path).unwrap();
        table.retain(|name| name == "bore_m");
        assert_eq!((table.rows(), table.names()), (40_000, vec!["bore_m"]));
        for rows in [0..3, 16_383..16_386, 39_990..40_000] {
            let mut columns = vec![Vec::new()];
            table.fill(rows.clone(), &mut columns).unwrap();
            assert_eq!(columns[0], rows.map(|i| 2.0 * i as f64 + 0.5).collect::<Vec<_>>());
        }
    }

    #[test]
    fn text_in_a_number_is_refused_with_its_line_and_column() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, "bore_m,rod_m\n0.02,0\n0.02,1 cm\n").unwrap();
        let table = Table::open(&path).unwrap();
        let message = table.fill(0..2, &mut [vec![], vec![]]).unwrap_err().to_string();
        assert!(message.contains("line 3, column `rod_m`: `1 cm` is not a finite number"), "{message}");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_without_line_ends_is_refused_and_not_taken_into_memory_as_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let refused = |begin: &str| {
            std::fs::write(&path, begin).unwrap();
            // A sparse file, larger than the available memory.
            File::options().write(true).open(&path).unwrap().set_len(1 << 40).unwrap();
            Table::open(&path).err().unwrap().to_string()
        };
        for (begin, line) in [("bore_m", 1), ("bore_m\n0.02\n0.03", 3)] {
            let message = refused(begin);
            assert!(message.contains(&format!("line {line} is longer than 1048576 bytes")), "{message}");
        }
    }

    #[test]
    fn a_table_of_another_office_program_is_refused_for_its_separators() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        std::fs::write(&path, "bore_m;rod_m\r\n0,02;0\r\n").unwrap();
        let message = Table::open(&path).err().unwrap().to_string();
        assert!(message.contains("line 1: its columns are separated by ';'; expected commas"), "{message}");
    }
}
