//! A study's table: columns with types, units and descriptions, and rows as its Arrow batches.

use super::status_column::Statuses;
use crate::error::Error;
use crate::quantity;
use crate::row::solve::Rows;
use crate::study::Study;
use arrow::array::{ArrayRef, Float64Array, Int64Array};
use arrow::buffer::{BooleanBuffer, NullBuffer};
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use arrow::record_batch::RecordBatch;
use std::collections::HashMap;
use std::sync::Arc;

/// A field with its `unit` and `description`.
pub fn field(name: &str, kind: DataType, nullable: bool, unit: &str, doc: &str) -> Field {
    let metadata = [("unit", unit), ("description", doc)].map(|(key, value)| (key.to_owned(), value.to_owned()));
    Field::new(name, kind, nullable).with_metadata(HashMap::from(metadata))
}

/// The first column of every table: the row's index in the study.
pub fn row_number() -> Field {
    field("row", DataType::Int64, false, "1", "Number of the row in the design, from zero")
}

/// The schema of a study's table.
pub fn schema(study: &Study) -> SchemaRef {
    let mut fields = vec![row_number()];
    for varied in &study.varied {
        let q = &quantity::all()[varied.quantity];
        fields.push(field(&varied.column, DataType::Float64, false, q.unit, q.doc));
    }
    fields.extend(study.outputs().map(|o| field(o.name, DataType::Float64, true, o.unit, o.doc)));
    let dictionary = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
    let statuses = "ok, not_settled (the test ends before), no_time_constant (a leak, say: the relaxation is over 5 % \
                    of its rise, and more than a closed chamber's, from an exponential), left_out: the constraint of [vary] that the row breaks, or failed: reason";
    fields.push(field("status", dictionary, false, "1", statuses));
    Arc::new(Schema::new(fields))
}

/// Rows as an Arrow batch of the study's schema.
pub fn batch(study: &Study, schema: &SchemaRef, rows: Rows, statuses: &mut Statuses<'_>) -> Result<RecordBatch, Error> {
    let first = rows.first as i64;
    let numbers: Vec<i64> = (first..first + rows.statuses.len() as i64).collect();
    let mut columns: Vec<ArrayRef> = vec![Arc::new(Int64Array::from(numbers))];
    columns.extend(rows.points.into_iter().map(|column| Arc::new(Float64Array::from(column)) as ArrayRef));
    columns.extend(rows.outputs.into_iter().map(|column| Arc::new(finite_or_null(column)) as ArrayRef));
    columns.push(Arc::new(statuses.column(&rows.statuses)));
    RecordBatch::try_new(schema.clone(), columns).map_err(|error| Error::arrow(&study.path, error))
}

/// Numbers, with nulls for non-finite ones.
fn finite_or_null(values: Vec<f64>) -> Float64Array {
    let all = values.iter().fold(true, |all, value| all & value.is_finite());
    let valid = (!all).then(|| NullBuffer::from(BooleanBuffer::collect_bool(values.len(), |i| values[i].is_finite())));
    Float64Array::new(values.into(), valid)
}
