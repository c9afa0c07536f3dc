//! Reads the rows of a part back from its file.

use crate::error::Error;
use crate::row::chunk::CHUNK;
use arrow::array::{Array, Float64Array};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use std::fs::File;
use std::path::Path;

/// The rows of a part's file after the first `skipped`, with the named columns or all.
pub fn read(path: &Path, names: Option<&[&str]>, skipped: u64) -> Result<ParquetRecordBatchReader, Error> {
    let file = File::open(path).map_err(Error::reading(path))?;
    let parquet = Error::parquet(path);
    let mut builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(&parquet)?.with_offset(skipped as usize);
    if let Some(names) = names {
        let fields = builder.schema().fields().iter().enumerate();
        let wanted = fields.filter(|(_, field)| names.contains(&field.name().as_str())).map(|(index, _)| index);
        let mask = ProjectionMask::roots(builder.parquet_schema(), wanted);
        builder = builder.with_projection(mask);
    }
    builder.with_batch_size(CHUNK as usize).build().map_err(parquet)
}

/// A column's numbers, with NaN for nulls.
pub fn numbers(column: &Float64Array) -> Vec<f64> {
    match column.null_count() {
        0 => column.values().to_vec(),
        _ => column.iter().map(|value| value.unwrap_or(f64::NAN)).collect(),
    }
}
