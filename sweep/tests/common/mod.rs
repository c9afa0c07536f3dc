//! Shared by the tests of whole studies: a model, studies based on it, tables read back.
#![allow(dead_code)]

use arrow::array::AsArray;
use arrow::datatypes::{Float64Type, Int32Type};
use arrow::record_batch::RecordBatch;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use records::{Document, Model, Provenance};
use std::collections::BTreeMap;
use std::path::Path;
use sweep::{Local, Study};
use tempfile::TempDir;

/// The cylinder of the paper's section 3.1.
pub fn model() -> Model {
    let geometry = Geometry::new(0.02, 0.0, 1.57e-6, AreaLaw::Total);
    Model {
        gas_name: Some("air".into()),
        chamber: Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5)),
        ambient_temperature_k: 293.0,
        ambient_pressure_pa: 1.013e5,
        uncertainty: None,
        provenance: Provenance::default(),
    }
}

/// The test of section 3.1.
pub const TEST: &str = "
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.1
final_stroke_m = 0.05
push_time_s = 0.04
duration_s = 5.0
";

/// Axes of a factorial design of 2400 rows, half of which leak.
pub const BORES: &str = "bore_m = { from = 0.016, to = 0.063, count = 40, scale = \"log\" }
initial_pressure_pa = { from = 1e5, to = 7e5, count = 30 }
\"effect.leakage.conductance_m3_per_s_pa\" = { values = [0.0, 1e-12] }";

/// A study of [`model`] from its lines of [study] and [vary].
pub fn study(head: &str, vary: &str) -> Study {
    Study::about(&model(), &text(head, vary)).unwrap()
}

/// The text of that study.
pub fn text(head: &str, vary: &str) -> String {
    format!("[study]\n{head}\n{TEST}\n[vary]\n{vary}\n")
}

/// A study from its text; paths in it are relative to the folder of `path`.
pub fn study_at(text: &str, path: &Path) -> Result<Study, sweep::Error> {
    Study::from_document(&Document::parse(path, text.to_owned())?)
}

/// The folder of a study.
pub fn at(folder: &TempDir) -> Local {
    Local::new(folder.path())
}

/// The contents of a Parquet file as one batch, without the file's metadata (which contain the shard).
pub fn read(path: &Path) -> RecordBatch {
    let builder = ParquetRecordBatchReaderBuilder::try_new(std::fs::File::open(path).unwrap()).unwrap();
    let schema = builder.schema().as_ref().clone().with_metadata(std::collections::HashMap::new());
    let schema = std::sync::Arc::new(schema);
    let plain = |batch: RecordBatch| batch.with_schema(schema.clone()).unwrap();
    let batches: Vec<_> = builder.build().unwrap().map(|batch| plain(batch.unwrap())).collect();
    arrow::compute::concat_batches(&schema, &batches).unwrap()
}

/// The tables of all parts of a study's folder, by name; empty if it has no rows.
pub fn parts(folder: &Path) -> BTreeMap<String, RecordBatch> {
    let folder = folder.join("rows");
    if !folder.exists() {
        return BTreeMap::new();
    }
    let names = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    names.map(|name| (name.clone(), read(&folder.join(&name)))).collect()
}

/// Ignores progress.
pub fn quiet(_: u64) {}

/// A column's values, NaN for a null.
pub fn values(batch: &RecordBatch, name: &str) -> Vec<f64> {
    let column = batch.column_by_name(name).unwrap_or_else(|| panic!("no column {name}")).as_primitive::<Float64Type>();
    column.iter().map(|value| value.unwrap_or(f64::NAN)).collect()
}

/// The statuses as text.
pub fn statuses(batch: &RecordBatch) -> Vec<String> {
    let dictionary = batch.column_by_name("status").unwrap().as_dictionary::<Int32Type>();
    let names = dictionary.values().as_string::<i32>();
    dictionary.keys().iter().map(|key| names.value(key.unwrap() as usize).to_owned()).collect()
}
