//! The columns of a study's table: names with their unit, types, what each holds, and how they are encoded.

use crate::error::Error;
use crate::quantity;
use crate::row::{Outputs, Status};
use crate::study::Study;
use arrow::array::{ArrayRef, DictionaryArray, Float64Array, Int32Array, Int64Array, StringArray};
use arrow::buffer::NullBuffer;
use arrow::datatypes::{DataType, Field, Int32Type, Schema, SchemaRef};
use arrow::record_batch::RecordBatch;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::schema::types::ColumnPath;
use serde_json::{Map, Value, json};
use std::collections::HashMap;
use std::sync::Arc;

/// Rows of a row group: what a reader has to take at once, and what a writer keeps in memory.
const ROW_GROUP: usize = 1 << 17;
/// Fastest of zstd's levels: on 100 000 rows of a fitted study 1, 3 and 6 differ by 1 %.
const ZSTD_LEVEL: i32 = 1;

/// A column that is computed.
pub struct Output {
    /// Its name, with the unit's suffix.
    pub name: &'static str,
    /// The unit as people write it.
    pub unit: &'static str,
    /// One line for people.
    pub doc: &'static str,
    /// Whether it comes from the paper's regression and is left out with `fit = false`.
    pub of_fit: bool,
    /// The value; NaN where there is none.
    pub value: fn(&Outputs) -> f64,
}

/// Every computed column but the row's number and its status, in order.
#[rustfmt::skip]
pub const OUTPUTS: [Output; 12] = [
    Output { name: "volume_m3", unit: "m3", of_fit: false, doc: "Gas volume at the final stroke", value: |o| o.volume },
    Output { name: "area_m2", unit: "m2", of_fit: false, doc: "Heat transfer area at the final stroke", value: |o| o.area },
    Output { name: "volume_to_area_m", unit: "m", of_fit: false, doc: "Gas volume over heat transfer area at the final stroke", value: |o| o.volume / o.area },
    Output { name: "pressure_peak_pa", unit: "Pa", of_fit: false, doc: "Largest pressure from the end of the push on; for an expansion the smallest", value: |o| o.pressure_peak },
    Output { name: "pressure_final_pa", unit: "Pa", of_fit: false, doc: "Pressure at the end of the test", value: |o| o.pressure_final },
    Output { name: "temperature_final_k", unit: "K", of_fit: false, doc: "Gas temperature at the end of the test", value: |o| o.temperature_final },
    Output { name: "temperature_peak_k", unit: "K", of_fit: false, doc: "Largest gas temperature from the end of the push on; for an expansion the smallest", value: |o| o.temperature_peak },
    Output { name: "time_constant_s", unit: "s", of_fit: true, doc: "Time constant of P = Pf + dP exp(-t/tau) fitted from the end of the push on", value: |o| o.time_constant },
    Output { name: "lambda_av_w_per_m2_k", unit: "W/(m2.K)", of_fit: true, doc: "Average heat transfer coefficient by the paper's steps", value: |o| o.lambda_av },
    Output { name: "lambda0_w_per_m2_k", unit: "W/(m2.K)", of_fit: true, doc: "Heat transfer coefficient at the reference state by the paper's steps", value: |o| o.lambda0 },
    Output { name: "settling_time_s", unit: "s", of_fit: false, doc: "From the end of the push until pressure stays within 1 % of its peak-to-final distance", value: |o| o.settling_time },
    Output { name: "energy_error", unit: "1", of_fit: false, doc: "Relative closure of the energy balance", value: |o| o.energy_error },
];

/// Whether a column of that name is computed, so that no varied quantity can have it.
pub fn is_output(name: &str) -> bool {
    name == "row" || name == "status" || OUTPUTS.iter().any(|output| output.name == name)
}

/// The computed columns of a study.
fn outputs(study: &Study) -> impl Iterator<Item = &'static Output> {
    let varied: Vec<String> = study.varied.iter().map(|v| v.column.clone()).collect();
    let fit = study.fit;
    OUTPUTS.iter().filter(move |o| (fit || !o.of_fit) && !varied.iter().any(|name| name == o.name))
}

/// The schema of a study's table, each field with its `unit` and `description`.
pub fn schema(study: &Study) -> SchemaRef {
    let field = |name: &str, kind: DataType, nullable: bool, unit: &str, doc: &str| {
        let metadata = [("unit", unit), ("description", doc)].map(|(key, value)| (key.to_owned(), value.to_owned()));
        Field::new(name, kind, nullable).with_metadata(HashMap::from(metadata))
    };
    let mut fields = vec![field("row", DataType::Int64, false, "1", "Number of the row in the design, from zero")];
    for varied in &study.varied {
        let q = &quantity::all()[varied.quantity];
        fields.push(field(&varied.column, DataType::Float64, false, q.unit, q.doc));
    }
    fields.extend(outputs(study).map(|o| field(o.name, DataType::Float64, true, o.unit, o.doc)));
    let dictionary = DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8));
    fields.push(field("status", dictionary, false, "1", "ok, not_settled (the test ends before), or failed: reason"));
    Arc::new(Schema::new(fields))
}

/// Rows as Arrow: numbered from `first`, `points` being the varied quantities by column.
pub fn batch(
    study: &Study,
    schema: &SchemaRef,
    first: u64,
    points: Vec<Vec<f64>>,
    rows: &[Outputs],
) -> Result<RecordBatch, Error> {
    let numbers = Int64Array::from_iter_values((0..rows.len() as u64).map(|i| (first + i) as i64));
    let mut columns: Vec<ArrayRef> = vec![Arc::new(numbers)];
    columns.extend(points.into_iter().map(|column| Arc::new(Float64Array::from(column)) as ArrayRef));
    for output in outputs(study) {
        let values: Vec<f64> = rows.iter().map(output.value).collect();
        columns.push(Arc::new(finite_or_null(values)));
    }
    columns.push(Arc::new(statuses(rows)));
    RecordBatch::try_new(schema.clone(), columns).map_err(|error| Error::arrow(&study.path, error))
}

/// Numbers, those that are none as nulls.
fn finite_or_null(values: Vec<f64>) -> Float64Array {
    let all = values.iter().all(|value| value.is_finite());
    let valid = (!all).then(|| values.iter().map(|value| value.is_finite()).collect::<NullBuffer>());
    Float64Array::new(values.into(), valid)
}

/// The status column: each status once, in the order in which they come up.
fn statuses(rows: &[Outputs]) -> DictionaryArray<Int32Type> {
    let mut met: Vec<Status> = Vec::new();
    let key = |row: &Outputs| {
        let place = met.iter().position(|status| *status == row.status).unwrap_or_else(|| {
            met.push(row.status);
            met.len() - 1
        });
        place as i32
    };
    let keys = Int32Array::from_iter_values(rows.iter().map(key));
    let texts = StringArray::from_iter_values(met.iter().map(|status| status.text()));
    DictionaryArray::new(keys, Arc::new(texts))
}

/// How a part is encoded, with the study in its key-value metadata.
pub fn properties(study: &Study, schema: &SchemaRef, extra: &[(&str, String)]) -> WriterProperties {
    let units: Map<String, Value> =
        schema.fields().iter().map(|f| (f.name().clone(), json!(f.metadata()["unit"]))).collect();
    let mut metadata = vec![
        ("study", study.json().to_string()),
        ("study_sha256", study.identity()),
        ("units", Value::Object(units).to_string()),
        ("program_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("seed", study.seed.to_string()),
    ];
    metadata.extend(extra.iter().cloned());
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(ZSTD_LEVEL).unwrap_or_default()))
        .set_created_by(format!("pneutherm {}", env!("CARGO_PKG_VERSION")))
        .set_max_row_group_row_count(Some(ROW_GROUP))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_dictionary_enabled(false)
        .set_key_value_metadata(Some(metadata.into_iter().map(|(k, v)| KeyValue::new(k.to_owned(), v)).collect()));
    for field in schema.fields() {
        let path = ColumnPath::from(field.name().as_str());
        properties = match field.data_type() {
            DataType::Int64 => properties.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED),
            DataType::Float64 if !is_discrete(study, field.name()) => {
                properties.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT)
            }
            _ => properties.set_column_dictionary_enabled(path, true),
        };
    }
    properties.build()
}

/// Whether a column has few values, so that a dictionary serves it.
fn is_discrete(study: &Study, name: &str) -> bool {
    let axes = study.design.axes().iter().zip(&study.varied);
    let factorial = study.design.name() == "factorial";
    axes.into_iter().any(|(axis, varied)| varied.column == name && (factorial || axis.is_discrete()))
}
