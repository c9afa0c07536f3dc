//! Columns for Python in the Arrow PyCapsule interface: pyarrow, polars, pandas and DuckDB read them where they lie.
//!
//! Interface: <https://arrow.apache.org/docs/format/CDataInterface/PyCapsuleInterface.html>.

use arrow::array::{ArrayRef, Float64Array, RecordBatch, RecordBatchIterator};
use arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use arrow::error::ArrowError;
use arrow::ffi_stream::FFI_ArrowArrayStream;
use pneutherm::simulation::Simulated;
use pyo3::prelude::*;
use pyo3::types::{PyAny, PyCapsule};
use std::collections::HashMap;
use std::sync::Arc;

/// A result with rows and columns. `pyarrow.table(it)` makes a table of it without a copy.
#[pyclass(frozen, module = "pneutherm._native")]
pub struct Table {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
}

impl Table {
    /// Of batches with the same columns; `None` where there is no batch.
    pub fn new(batches: Vec<RecordBatch>) -> Option<Self> {
        let schema = batches.first()?.schema();
        Some(Self { schema, batches })
    }

    /// Of a simulation: a row a sample.
    pub fn of_simulation(simulated: &Simulated) -> anyhow::Result<Self> {
        let (fields, columns): (Vec<_>, Vec<_>) = simulated
            .columns()
            .into_iter()
            .map(|column| {
                let metadata = [("unit", column.unit.to_owned()), ("description", column.doc)];
                let metadata: HashMap<_, _> = metadata.map(|(key, value)| (key.to_owned(), value)).into();
                let field = Field::new(column.name, DataType::Float64, false).with_metadata(metadata);
                (field, Arc::new(Float64Array::from(column.values)) as ArrayRef)
            })
            .unzip();
        let schema = Arc::new(Schema::new(fields));
        let batch = RecordBatch::try_new(schema.clone(), columns)?;
        Ok(Self { schema, batches: vec![batch] })
    }
}

/// Rows as an Arrow C stream. Whoever wants another schema casts: the interface leaves it to us whether we can.
fn stream<'py>(
    py: Python<'py>,
    rows: impl Iterator<Item = Result<RecordBatch, ArrowError>> + Send + 'static,
    schema: SchemaRef,
) -> PyResult<Bound<'py, PyCapsule>> {
    let rows = RecordBatchIterator::new(rows, schema);
    PyCapsule::new_with_value(py, FFI_ArrowArrayStream::new(Box::new(rows)), c"arrow_array_stream")
}

#[pymethods]
impl Table {
    /// The rows as an Arrow C stream, anew at each call.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        stream(py, self.batches.clone().into_iter().map(Ok), self.schema.clone())
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.batches.iter().map(RecordBatch::num_rows).sum()
    }
}

/// The rows of a study in the Arrow C stream interface, computed as they are read.
#[pyclass(frozen, module = "pneutherm._native")]
pub struct Batches(pub Arc<sweep::Study>);

#[pymethods]
impl Batches {
    /// The rows as an Arrow C stream, anew at each call.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        let rows = sweep::run::whole::batches(self.0.clone());
        let rows = rows.map(|batch| batch.map_err(|error| ArrowError::ExternalError(Box::new(error))));
        stream(py, rows, sweep::part::columns::schema(&self.0))
    }
}
