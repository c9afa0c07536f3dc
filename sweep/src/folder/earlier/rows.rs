//! Rows of a study, taken from an earlier study's folder where they exist.

use super::Earlier;
use crate::error::Error;
use crate::part::reader;
use crate::part::status_column;
use crate::progress::Progress;
use crate::result::status::Status;
use crate::row::solve::{RowSolver, Rows};
use crate::study::Study;
use arrow::array::{Array, AsArray};
use arrow::datatypes::Int32Type;
use arrow::record_batch::RecordBatch;
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;
use std::ops::Range;

/// Rows of a study in ascending order, taken from the earlier folder where they exist.
pub struct EarlierReader<'a> {
    earlier: &'a Earlier,
    study: &'a Study,
    progress: &'a dyn Progress,
    /// Solves rows without results again, without reporting progress.
    again: RowSolver<'a>,
    open: Option<Open>,
}

/// The part being read.
struct Open {
    part: usize,
    next: u64,
    reader: ParquetRecordBatchReader,
    rest: Option<RecordBatch>,
}

impl<'a> EarlierReader<'a> {
    /// A reader that takes rows of `earlier` for the larger `study`.
    pub fn new(earlier: &'a Earlier, study: &'a Study, progress: &'a dyn Progress) -> Self {
        Self { earlier, study, progress, again: RowSolver::new(study), open: None }
    }

    /// Some rows of the study.
    ///
    /// # Errors
    /// The earlier part, or a table of points, cannot be read.
    pub fn rows(&mut self, rows: Range<u64>, solver: &mut RowSolver<'_>) -> Result<Rows, Error> {
        let mut all: Option<Rows> = None;
        for (part, piece) in self.earlier.pieces(rows) {
            let piece = match part {
                None => solver.rows(piece)?,
                Some(part) => self.taken(part, piece)?,
            };
            match &mut all {
                None => all = Some(piece),
                Some(all) => all.append(piece),
            }
        }
        Ok(all.unwrap_or_else(|| Rows::none(self.study)))
    }

    fn taken(&mut self, part: usize, rows: Range<u64>) -> Result<Rows, Error> {
        let earlier_part = &self.earlier.parts[part];
        let mut open = match self.open.take().filter(|open| (open.part, open.next) == (part, rows.start)) {
            Some(open) => open,
            None => {
                let reader = reader::read(earlier_part.file.path(), None, rows.start - earlier_part.rows.start)?;
                Open { part, next: rows.start, reader, rest: None }
            }
        };
        let mut taken = Rows::none(self.study);
        taken.first = rows.start;
        self.study.design.fill(rows.clone(), &mut taken.points)?;
        while open.next < rows.end {
            let batch = match open.rest.take() {
                Some(batch) => batch,
                None => match open.reader.next() {
                    Some(batch) => batch.map_err(|error| Error::arrow(earlier_part.file.path(), error))?,
                    None => {
                        let why = format!("{} ends before its record says", earlier_part.file.path().display());
                        return Err(Error::NotContinued { folder: self.earlier.folder.clone(), why });
                    }
                },
            };
            let length = batch.num_rows().min((rows.end - open.next) as usize);
            if length < batch.num_rows() {
                open.rest = Some(batch.slice(length, batch.num_rows() - length));
            }
            self.add(&batch.slice(0, length), open.next, &mut taken)?;
            self.progress.found(length as u64);
            open.next += length as u64;
        }
        self.open = Some(open);
        Ok(taken)
    }

    /// Adds the results of a batch. A row without results is solved again, because its reason is stored only as text.
    fn add(&mut self, batch: &RecordBatch, first: u64, taken: &mut Rows) -> Result<(), Error> {
        let begin = taken.statuses.len();
        // The columns of both studies are the same, in the same order.
        let results = &batch.columns()[1 + self.study.varied.len()..];
        for (column, array) in taken.outputs.iter_mut().zip(results) {
            column.extend(reader::numbers(array.as_primitive()));
        }
        let statuses = results[taken.outputs.len()].as_dictionary::<Int32Type>();
        let texts = statuses.values().as_string::<i32>();
        let known: Vec<Option<Status>> =
            (0..texts.len()).map(|i| status_column::of_text(self.study, texts.value(i))).collect();
        for (i, key) in statuses.keys().values().iter().enumerate() {
            let status = match known.get(*key as usize).copied().flatten() {
                Some(status) => status,
                None => {
                    let row = first + i as u64;
                    let again = self.again.rows(row..row + 1)?;
                    for (column, value) in taken.outputs.iter_mut().zip(&again.outputs) {
                        column[begin + i] = value[0];
                    }
                    again.statuses[0]
                }
            };
            taken.statuses.push(status);
        }
        Ok(())
    }
}
