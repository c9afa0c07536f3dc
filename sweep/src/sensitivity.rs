//! Global sensitivity of a Saltelli study's results: which share of an output's variance each quantity brings.
//!
//! First order: S_i = mean(B (AB_i − A))/V (Saltelli et al. 2010, table 2, b). Total order: T_i = ½ mean((A − AB_i)²)/V
//! (Jansen 1999). V is the variance of A and B; values count from the mean of all of them, as in SALib.
//! Blocks with a missing value take no part.

use crate::columns;
use crate::design::Design;
use crate::error::Error;
use crate::study::Study;
use arrow::array::{Array, AsArray};
use arrow::datatypes::{DataType, Float64Type};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::{Map, Value, json};
use std::fs::File;
use std::path::PathBuf;

/// Name of the file with the indices, beside the parts.
pub const FILE: &str = "sensitivity.json";
/// Half-width of a 95 % interval over the standard error.
const QUANTILE_95: f64 = 1.959963984540054;

/// Indices of one output, in the order of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Indices {
    /// First order and the half-width of its 95 % interval.
    pub first: Vec<[f64; 2]>,
    /// Total order and the half-width of its 95 % interval.
    pub total: Vec<[f64; 2]>,
    /// Blocks without a missing value.
    pub blocks: u64,
}

/// Sums over blocks; the first pass needs the means and the variance of A and B, the second the indices.
#[derive(Clone)]
struct Sums {
    blocks: u64,
    /// Of every value.
    all: Moments,
    /// Of A and B.
    ends: Moments,
    first: Vec<[f64; 2]>,
    total: Vec<[f64; 2]>,
}

/// Mean and sum of squared deviations, by Welford's update.
#[derive(Clone, Default)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, value: f64) {
        self.count += 1.0;
        let difference = value - self.mean;
        self.mean += difference / self.count;
        self.squares += difference * (value - self.mean);
    }

    fn variance(&self) -> f64 {
        self.squares / self.count
    }
}

impl Sums {
    fn new(axes: usize) -> Self {
        let zeros = vec![[0.0; 2]; axes];
        Self { blocks: 0, all: Moments::default(), ends: Moments::default(), first: zeros.clone(), total: zeros }
    }

    fn add_to_moments(&mut self, block: &[f64]) {
        self.blocks += 1;
        block.iter().for_each(|value| self.all.add(*value));
        self.ends.add(block[0]);
        self.ends.add(block[block.len() - 1]);
    }

    fn add_to_indices(&mut self, block: &[f64]) {
        let deviation = self.ends.variance().sqrt();
        let standard = |value: f64| (value - self.all.mean) / deviation;
        let (a, b) = (standard(block[0]), standard(block[block.len() - 1]));
        for axis in 0..self.first.len() {
            let ab = standard(block[axis + 1]);
            for (sums, term) in
                [(&mut self.first[axis], b * (ab - a)), (&mut self.total[axis], 0.5 * (a - ab) * (a - ab))]
            {
                sums[0] += term;
                sums[1] += term * term;
            }
        }
    }

    fn indices(&self) -> Indices {
        let n = self.blocks as f64;
        let mean = |[sum, squares]: &[f64; 2]| {
            let mean = sum / n;
            let error = ((squares / n - mean * mean).max(0.0) / n).sqrt();
            [mean, QUANTILE_95 * error]
        };
        Indices {
            first: self.first.iter().map(mean).collect(),
            total: self.total.iter().map(mean).collect(),
            blocks: self.blocks,
        }
    }
}

/// Indices of one output from its values by row, a missing one being NaN.
pub fn of_values(axes: usize, values: &[f64]) -> Indices {
    let mut sums = Sums::new(axes);
    let whole = |block: &&[f64]| block.iter().all(|value| value.is_finite());
    values.chunks_exact(axes + 2).filter(whole).for_each(|block| sums.add_to_moments(block));
    values.chunks_exact(axes + 2).filter(whole).for_each(|block| sums.add_to_indices(block));
    sums.indices()
}

/// Indices of every output of a Saltelli study from its parts, in bounded memory; `None` for other designs.
///
/// # Errors
/// A part cannot be read.
pub fn of_study(study: &Study, path_of: impl Fn(u64) -> PathBuf) -> Result<Option<Value>, Error> {
    let Design::Saltelli(axes, samples, _) = &study.design else { return Ok(None) };
    let schema = columns::schema(study);
    let is_result = |i: &usize| *i > study.varied.len() && *schema.field(*i).data_type() == DataType::Float64;
    let mut outputs = Map::new();
    for column in (0..schema.fields().len()).filter(is_result) {
        let mut sums = Sums::new(axes.len());
        blocks(study, column, axes.len() + 2, &path_of, |block| sums.add_to_moments(block))?;
        blocks(study, column, axes.len() + 2, &path_of, |block| sums.add_to_indices(block))?;
        outputs.insert(schema.field(column).name().clone(), described(study, &sums.indices()));
    }
    Ok(Some(json!({
        "study": study.name,
        "samples": samples,
        "method": "first order: Saltelli et al. 2010; total order: Jansen 1999; ci95: half-width",
        "outputs": outputs,
    })))
}

fn described(study: &Study, indices: &Indices) -> Value {
    let list = |values: &[[f64; 2]]| {
        let named = study.varied.iter().zip(values);
        Value::Object(named.map(|(v, [s, ci])| (v.column.clone(), json!({ "value": s, "ci95": ci }))).collect())
    };
    json!({ "blocks": indices.blocks, "first_order": list(&indices.first), "total_order": list(&indices.total) })
}

/// Hands every block of one column's values that misses none to `take`, in order; blocks may reach across parts.
fn blocks(
    study: &Study,
    column: usize,
    length: usize,
    path_of: &impl Fn(u64) -> PathBuf,
    mut take: impl FnMut(&[f64]),
) -> Result<(), Error> {
    let mut block = Vec::with_capacity(length);
    for part in 0..study.parts {
        let path = path_of(part);
        let file = File::open(&path).map_err(|source| Error::Read { path: path.clone(), source })?;
        let parquet = |source| Error::Parquet { path: path.clone(), source };
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(parquet)?;
        let mask = ProjectionMask::roots(builder.parquet_schema(), [column]);
        for batch in builder.with_projection(mask).build().map_err(parquet)? {
            let batch = batch.map_err(|error| Error::arrow(&path, error))?;
            let values = batch.column(0).as_primitive::<Float64Type>();
            for i in 0..values.len() {
                block.push(if values.is_null(i) { f64::NAN } else { values.value(i) });
                if block.len() == length {
                    if block.iter().all(|value| value.is_finite()) {
                        take(&block);
                    }
                    block.clear();
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Axis, Scale};

    #[test]
    fn indices_of_the_ishigami_function_are_its_exact_ones() {
        // Ishigami and Homma 1990, a = 7, b = 0.1: variance and its parts in closed form.
        use std::f64::consts::PI;
        let (a, b) = (7.0, 0.1);
        let axis = Axis::Range { from: -PI, to: PI, count: None, scale: Scale::Linear };
        let n = 1 << 14;
        let design = Design::saltelli(vec![axis; 3], n, 3);
        let mut x = vec![Vec::new(); 3];
        design.fill(0..n * 5, &mut x).unwrap();
        let y = |i: usize| x[0][i].sin() + a * x[1][i].sin().powi(2) + b * x[2][i].powi(4) * x[0][i].sin();
        let indices = of_values(3, &(0..x[0].len()).map(y).collect::<Vec<_>>());
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let v2 = a * a / 8.0;
        let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        for (found, exact) in indices.first.iter().zip([v1 / v, v2 / v, 0.0]) {
            assert!((found[0] - exact).abs() < 0.01, "{found:?} {exact}");
        }
        for (found, exact) in indices.total.iter().zip([(v1 + v13) / v, v2 / v, v13 / v]) {
            assert!((found[0] - exact).abs() < 0.01, "{found:?} {exact}");
        }
    }

    #[test]
    fn a_block_with_a_missing_value_takes_no_part() {
        let values: Vec<f64> = (0..40).map(|i| f64::from(i * i % 17)).collect();
        let mut broken = values.clone();
        broken.extend([1.0, f64::NAN, 2.0, 3.0]);
        assert_eq!(of_values(2, &values), of_values(2, &broken));
    }
}
