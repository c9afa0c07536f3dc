//! Statistics of a study's results, without its rows: mean, variance, extremes, quantiles and histograms of each column.
//!
//! Each part has its [`State`]; those of all parts, merged in order, are the study's, so that shards and threads do not change a
//! bit of it. Memory does not grow with the rows.

mod column;
mod front;
mod moments;
mod points;
mod sketch;

pub use front::Front;
pub use sketch::{ERROR, MOST, Sketch};

use crate::error::Error;
use crate::part::columns;
use crate::part::reader;
use crate::part::status_column::StatusCounts;
use crate::row::chunk::CHUNK;
use crate::study::Study;
use crate::study::plan::{Goals, Plan};
use arrow::array::AsArray;
use arrow::datatypes::Float64Type;
use column::Column;
use points::points_of;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Statistics of the rows so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Identity of the plan of these statistics ([`Plan::identity`]).
    pub plan: String,
    columns: Vec<Column>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    front: Option<Front>,
}

impl State {
    /// Without rows yet.
    pub fn new(plan: &Plan) -> Self {
        let column = |name: &String| Column::new(plan.bins(name));
        let front = plan.pareto.as_ref().map(|_| Front::default());
        Self { plan: plan.identity(), columns: plan.columns.iter().map(column).collect(), front }
    }

    /// Adds rows from `first_row` on: the plan's columns, with NaN for missing values.
    pub fn add<'v>(&mut self, plan: &Plan, first_row: u64, values: impl Iterator<Item = &'v [f64]>) {
        let values: Vec<&[f64]> = values.collect();
        for ((name, column), values) in plan.columns.iter().zip(&mut self.columns).zip(&values) {
            column.add(plan.bins(name), first_row, values);
        }
        let (Some(goals), Some(front)) = (&plan.pareto, &mut self.front) else { return };
        let index = |name: &str| plan.columns.iter().position(|column| column == name);
        let wanted: Vec<(&[f64], f64)> =
            goals.columns().filter_map(|(name, sign)| Some((*values.get(index(name)?)?, sign))).collect();
        let mut point = Vec::with_capacity(wanted.len());
        for (i, row) in (first_row..).take(values.first().map_or(0, |column| column.len())).enumerate() {
            point.clear();
            point.extend(wanted.iter().map(|(column, sign)| sign * column[i]));
            if point.iter().all(|value| value.is_finite()) {
                front.add(row, &point);
            }
        }
    }

    /// Merges the state of later rows.
    pub fn merge(&mut self, later: &Self) {
        for (column, later) in self.columns.iter_mut().zip(&later.columns) {
            column.merge(later);
        }
        if let (Some(front), Some(later)) = (&mut self.front, &later.front) {
            front.merge(later);
        }
    }

    /// The statistics in the form of the file.
    ///
    /// # Errors
    /// A table of points cannot be read.
    pub fn summary(&self, study: &Study, plan: &Plan, statuses: &StatusCounts) -> Result<Value, Error> {
        let schema = columns::schema(study);
        let mut list = Map::new();
        for (name, column) in plan.columns.iter().zip(&self.columns) {
            let unit = schema.field_with_name(name).ok().and_then(|field| field.metadata().get("unit"));
            list.insert(name.clone(), column.summary(study, plan, plan.bins(name), unit)?);
        }
        let mut summary = json!({
            "study": study.name,
            "study_sha256": study.identity(),
            "rows": study.rows,
            "statuses": statuses,
            "method": {
                "variance": "unbiased (n - 1)",
                "quantiles": format!(
                    "exact while a column has at most {MOST} different values, then counted in about as many buckets: within error_bound, half a bucket, at most {ERROR:.2e} of the value"
                ),
                "nulls": "rows without the value take no part and are counted",
            },
            "columns": list,
        });
        if let (Some(goals), Some(front)) = (&plan.pareto, &self.front) {
            summary["pareto"] = described_front(study, goals, front)?;
        }
        Ok(summary)
    }
}

/// A Pareto front, each point with its row and its point of the design.
fn described_front(study: &Study, goals: &Goals, front: &Front) -> Result<Value, Error> {
    let sorted = front.sorted();
    let at = points_of(study, sorted.iter().map(|(row, _)| *row).collect())?;
    let point = |(row, values): &(u64, Vec<f64>)| {
        let values: Map<String, Value> =
            goals.columns().zip(values).map(|((name, sign), value)| (name.to_owned(), json!(sign * value))).collect();
        json!({ "row": row, "values": values, "at": at[row] })
    };
    let points: Vec<Value> = sorted.into_iter().map(point).collect();
    Ok(json!({
        "minimise": goals.minimise,
        "maximise": goals.maximise,
        "complete": front.is_complete(),
        "points": points,
    }))
}

/// The state of a part from its stored rows.
///
/// # Errors
/// The file cannot be read, or lacks a column of the plan.
pub fn of_file(plan: &Plan, path: &Path, first_row: u64) -> Result<State, Error> {
    let names: Vec<&str> = plan.columns.iter().map(String::as_str).collect();
    let mut state = State::new(plan);
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); plan.columns.len()];
    // Chunks as when the rows are solved, so that the sums agree bit for bit.
    let mut begin = first_row;
    for batch in reader::read(path, Some(&names), 0)? {
        let batch = batch.map_err(|error| Error::arrow(path, error))?;
        for (name, values) in plan.columns.iter().zip(&mut columns) {
            let column = batch.column_by_name(name).and_then(|column| column.as_primitive_opt::<Float64Type>());
            let column = column
                .ok_or_else(|| Error::table(path, format!("has no column `{name}` of numbers for the statistics")))?;
            values.extend(reader::numbers(column));
        }
        loop {
            let length = (CHUNK - begin % CHUNK) as usize;
            if columns.iter().any(|values| values.len() < length) || columns.is_empty() {
                break;
            }
            state.add(plan, begin, columns.iter().map(|values| &values[..length]));
            columns.iter_mut().for_each(|values| drop(values.drain(..length)));
            begin += length as u64;
        }
    }
    if columns.iter().all(|values| !values.is_empty()) {
        state.add(plan, begin, columns.iter().map(Vec::as_slice));
    }
    Ok(state)
}
