//! Global sensitivity of a Saltelli study's results: which share of an output's variance each quantity brings.
//!
//! Blocks with a missing value take no part. [`indices`] explains the estimates and their intervals.

pub mod indices;

use crate::columns;
use crate::design::Design;
use crate::design::saltelli::{REPLICATES, Scheme};
use crate::error::Error;
use crate::store::LocalFile;
use crate::study::Study;
use arrow::array::{Array, AsArray};
use arrow::datatypes::{DataType, Float64Type};
use indices::{Centre, Indices, Sums};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::fs::File;

/// Name of the file with the indices, beside the parts.
pub const FILE: &str = "sensitivity.json";

/// Indices of every output of a Saltelli study from its parts, in bounded memory; `None` for other designs. `local` gives a
/// part as a file on the disk; it is asked once for each part.
///
/// # Errors
/// A part cannot be read.
pub fn of_study(study: &Study, local: impl Fn(u64) -> Result<LocalFile, Error>) -> Result<Option<Value>, Error> {
    let Design::Saltelli(design) = &study.design else { return Ok(None) };
    let scheme = design.scheme();
    let parts: Vec<LocalFile> = (0..study.parts).map(local).collect::<Result<_, _>>()?;
    let schema = columns::schema(study);
    let is_result = |i: &usize| *i > study.varied.len() && *schema.field(*i).data_type() == DataType::Float64;
    let results: Vec<usize> = (0..schema.fields().len()).filter(is_result).collect();
    let of_column = |column: &usize| {
        let mut centre = Centre::default();
        blocks(&parts, *column, scheme.rows() as usize, |_, block| centre.add(block))?;
        let mut sums = Sums::new(scheme, centre);
        blocks(&parts, *column, scheme.rows() as usize, |number, block| sums.add(number, block))?;
        Ok((schema.field(*column).name().clone(), described(study, scheme, &sums.indices())))
    };
    let outputs: Map<String, Value> =
        results.par_iter().map(of_column).collect::<Result<Vec<_>, Error>>()?.into_iter().collect();
    Ok(Some(json!({
        "study": study.name,
        "samples": design.samples(),
        "method": "first order: Saltelli et al. 2010; total order: Jansen 1999; second order: Saltelli 2002",
        "ci95": format!("half-width: Student's t and the jackknife over {REPLICATES} independently scrambled replicates"),
        "outputs": outputs,
    })))
}

fn described(study: &Study, scheme: Scheme, indices: &Indices) -> Value {
    let entry = |[value, half]: &[f64; 2]| json!({ "value": value, "ci95": half });
    let list = |values: &[[f64; 2]]| {
        let named = study.varied.iter().zip(values);
        Value::Object(named.map(|(v, value)| (v.column.clone(), entry(value))).collect())
    };
    let mut described =
        json!({ "blocks": indices.blocks, "first_order": list(&indices.first), "total_order": list(&indices.total) });
    if scheme.second {
        let pair = |((i, j), value): ((usize, usize), &[f64; 2])| {
            json!({
                "quantities": [study.varied[i].column, study.varied[j].column],
                "value": value[0],
                "ci95": value[1],
            })
        };
        described["second_order"] = scheme.pairs().zip(&indices.second).map(pair).collect();
    }
    described
}

/// Hands every block of one column's values that misses none to `take` with its number, in order; blocks may reach across
/// parts.
fn blocks(parts: &[LocalFile], column: usize, length: usize, mut take: impl FnMut(u64, &[f64])) -> Result<(), Error> {
    let mut block = Vec::with_capacity(length);
    let mut number = 0;
    for path in parts.iter().map(LocalFile::path) {
        let file = File::open(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
        let parquet = |source| Error::Parquet { path: path.to_owned(), source };
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(parquet)?;
        let mask = ProjectionMask::roots(builder.parquet_schema(), [column]);
        for batch in builder.with_projection(mask).build().map_err(parquet)? {
            let batch = batch.map_err(|error| Error::arrow(path, error))?;
            let values = batch.column(0).as_primitive::<Float64Type>();
            for i in 0..values.len() {
                block.push(if values.is_null(i) { f64::NAN } else { values.value(i) });
                if block.len() == length {
                    if block.iter().all(|value| value.is_finite()) {
                        take(number, &block);
                    }
                    block.clear();
                    number += 1;
                }
            }
        }
    }
    Ok(())
}
