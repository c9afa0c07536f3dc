//! The columns of a study's table: names with their unit, types, what each holds, and how they are encoded.

use crate::error::Error;
use crate::part;
use crate::quantity::{self, Base};
use crate::row::{Outputs, Status};
use crate::solve::Rows;
use crate::study::Study;
use arrow::array::{ArrayRef, DictionaryArray, Float64Array, Int32Array, Int64Array, StringArray};
use arrow::buffer::{BooleanBuffer, NullBuffer};
use arrow::datatypes::{DataType, Field, Int32Type, Schema, SchemaRef};
use arrow::record_batch::RecordBatch;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterVersion};
use parquet::schema::types::ColumnPath;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Rows of a row group: what a reader has to take at once, and what a writer keeps in memory.
const ROW_GROUP: usize = 1 << 17;
/// Rows of a page: with as many, zstd tells the bytes of sign and exponent, of which something is to be saved, from the
/// others' noise. On rows of a Latin hypercube: 2 % smaller than with 20 000 rows, in two thirds of the time.
const PAGE: usize = 1 << 16;
/// Fastest of zstd's levels: on 100 000 rows of a fitted study 1, 3 and 6 differ by 1 %.
const ZSTD_LEVEL: i32 = 1;

use When::{Always, Fit, Solved};

/// A column that is computed.
pub struct Output {
    /// Its name, with the unit's suffix.
    pub name: &'static str,
    /// The unit as people write it.
    pub unit: &'static str,
    /// One line for people.
    pub doc: &'static str,
    /// Studies in which the column is.
    pub when: When,
    /// Adds the values of some rows to a column; NaN where there is none.
    pub append: fn(&[Outputs], &mut Vec<f64>),
}

/// Which studies have a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Every study.
    Always,
    /// Those with the paper's regression: not with `fit = false`.
    Fit,
    /// Those that solve for it because this is varied.
    Solved(Base),
}

/// A column's values, by what each is in a row.
macro_rules! each {
    ($row:ident => $value:expr) => {
        |rows, column| column.extend(rows.iter().map(|$row| $value))
    };
}

/// Every computed column but the row's number and its status, in order.
#[rustfmt::skip]
pub const OUTPUTS: [Output; 15] = [
    Output { name: "bore_m", unit: "m", when: Solved(Base::VolumeToArea), doc: "Bore, solved for", append: each!(o => o.bore) },
    Output { name: "initial_stroke_m", unit: "m", when: Solved(Base::VolumeToAreaByLength), doc: "Piston position before the push, solved for", append: each!(o => o.strokes[0]) },
    Output { name: "final_stroke_m", unit: "m", when: Solved(Base::VolumeToAreaByLength), doc: "Piston position after the push, solved for", append: each!(o => o.strokes[1]) },
    Output { name: "volume_m3", unit: "m3", when: Always, doc: "Gas volume at the final stroke", append: each!(o => o.volume) },
    Output { name: "area_m2", unit: "m2", when: Always, doc: "Heat transfer area at the final stroke", append: each!(o => o.area) },
    Output { name: "volume_to_area_m", unit: "m", when: Always, doc: "Gas volume over heat transfer area at the final stroke", append: each!(o => o.volume / o.area) },
    Output { name: "pressure_peak_pa", unit: "Pa", when: Always, doc: "Largest pressure from the end of the push on; for an expansion the smallest", append: each!(o => o.pressure_peak) },
    Output { name: "pressure_final_pa", unit: "Pa", when: Always, doc: "Pressure at the end of the test", append: each!(o => o.pressure_final) },
    Output { name: "temperature_final_k", unit: "K", when: Always, doc: "Gas temperature at the end of the test", append: each!(o => o.temperature_final) },
    Output { name: "temperature_peak_k", unit: "K", when: Always, doc: "Largest gas temperature from the end of the push on; for an expansion the smallest", append: each!(o => o.temperature_peak) },
    Output { name: "time_constant_s", unit: "s", when: Fit, doc: "Time constant of P = Pf + dP exp(-t/tau) fitted from the end of the push on", append: each!(o => o.time_constant) },
    Output { name: "lambda_av_w_per_m2_k", unit: "W/(m2.K)", when: Fit, doc: "Average heat transfer coefficient by the paper's steps", append: each!(o => o.lambda_av) },
    Output { name: "lambda0_w_per_m2_k", unit: "W/(m2.K)", when: Fit, doc: "Heat transfer coefficient at the reference state by the paper's steps", append: each!(o => o.lambda0) },
    Output { name: "settling_time_s", unit: "s", when: Always, doc: "From the end of the push until pressure stays within 1 % of its peak-to-final distance", append: each!(o => o.settling_time) },
    Output { name: "energy_error", unit: "1", when: Always, doc: "Closure of the energy balance over the work of the push: change of internal energy less the integrals of heat, enthalpy and work, which the step control does not know; 0 where the solution is exact", append: each!(o => o.energy_error) },
];

/// Whether a column of that name is computed, so that no varied quantity can have it.
pub fn is_output(name: &str) -> bool {
    let solved = |output: &Output| matches!(output.when, Solved(_));
    name == "row" || name == "status" || OUTPUTS.iter().any(|output| output.name == name && !solved(output))
}

/// The computed columns of a study.
pub fn outputs(study: &Study) -> impl Iterator<Item = &'static Output> + '_ {
    let has = |when: When| match when {
        Always => true,
        Fit => study.fit,
        Solved(base) => study.varied.iter().any(|v| v.quantity == base as usize),
    };
    OUTPUTS.iter().filter(move |o| has(o.when) && !study.varied.iter().any(|v| v.column == o.name))
}

/// A field with its `unit` and `description`.
pub fn field(name: &str, kind: DataType, nullable: bool, unit: &str, doc: &str) -> Field {
    let metadata = [("unit", unit), ("description", doc)].map(|(key, value)| (key.to_owned(), value.to_owned()));
    Field::new(name, kind, nullable).with_metadata(HashMap::from(metadata))
}

/// The first column of every table: which row of the study it is.
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
    fields.extend(outputs(study).map(|o| field(o.name, DataType::Float64, true, o.unit, o.doc)));
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

/// Numbers, those that are none as nulls.
fn finite_or_null(values: Vec<f64>) -> Float64Array {
    let all = values.iter().fold(true, |all, value| all & value.is_finite());
    let valid = (!all).then(|| NullBuffer::from(BooleanBuffer::collect_bool(values.len(), |i| values[i].is_finite())));
    Float64Array::new(values.into(), valid)
}

/// Each status that came up, in order, with the number of its rows.
pub struct Statuses<'a> {
    study: &'a Study,
    met: Vec<(Status, u64)>,
}

impl<'a> Statuses<'a> {
    /// Begins without statuses.
    pub fn new(study: &'a Study) -> Self {
        Self { study, met: Vec::new() }
    }

    /// Counts rows that ended alike, and tells the place of their status.
    fn count(&mut self, row: Status, rows: usize) -> usize {
        let met = &mut self.met;
        let place = met.iter().position(|(status, _)| *status == row).unwrap_or_else(|| {
            met.push((row, 0));
            met.len() - 1
        });
        met[place].1 += rows as u64;
        place
    }

    /// Counts some rows: neighbours mostly end alike.
    pub fn count_all(&mut self, rows: &[Status]) {
        rows.chunk_by(|a, b| a == b).for_each(|run| {
            self.count(run[0], run.len());
        });
    }

    /// Counts some rows, and makes their status column.
    pub fn column(&mut self, rows: &[Status]) -> DictionaryArray<Int32Type> {
        let keys = Int32Array::from(rows.iter().map(|row| self.count(*row, 1) as i32).collect::<Vec<i32>>());
        let texts = StringArray::from_iter_values(self.met.iter().map(|(status, _)| status.text(self.study)));
        DictionaryArray::new(keys, Arc::new(texts))
    }

    /// How many rows ended with each status.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.met.iter().map(|(status, count)| (status.text(self.study).into_owned(), *count)).collect()
    }
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
        .set_writer_version(WriterVersion::PARQUET_2_0)
        .set_max_row_group_row_count(Some(ROW_GROUP))
        .set_data_page_row_count_limit(PAGE)
        .set_write_batch_size(part::CHUNK as usize)
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
