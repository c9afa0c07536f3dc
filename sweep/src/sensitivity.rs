//! Global sensitivity of a Saltelli study's results: which share of an output's variance each quantity brings.
//!
//! First order: S_i = mean(B (AB_i − A))/V (Saltelli et al. 2010, table 2, b). Total order: T_i = ½ mean((A − AB_i)²)/V
//! (Jansen 1999). Second order: S_ij = mean(BA_i AB_j − A B)/V − S_i − S_j, i < j (Saltelli 2002). V is the variance of A and B;
//! values count from the mean of all of them, as in SALib. Blocks with a missing value take no part.
//!
//! Intervals: 1.96 standard deviations of the indices over resamples of the blocks. Each block enters each resample as often as
//! a Poisson number of mean 1 says, which is the bootstrap of many blocks and needs one pass (Hanley and MacGibbon 2006).
//! It takes blocks for independent; those of a Sobol' sequence are spread more evenly, so the intervals are wide rather than
//! narrow.

use crate::columns;
use crate::design::Design;
use crate::design::random::{Stream, mix, unit};
use crate::error::Error;
use crate::store::LocalFile;
use crate::study::Study;
use arrow::array::{Array, AsArray};
use arrow::datatypes::{DataType, Float64Type};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::fs::File;

/// Name of the file with the indices, beside the parts.
pub const FILE: &str = "sensitivity.json";
/// Half-width of a 95 % interval over the standard error.
const QUANTILE_95: f64 = 1.959963984540054;
/// Resamples behind an interval: its half-width is known within 5 %.
const RESAMPLES: u64 = 200;
/// Of the streams that resample.
const KEY: u64 = 0x0b00_7574;

/// Indices of one output, in the order of the axes, each with the half-width of its 95 % interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Indices {
    /// First order.
    pub first: Vec<[f64; 2]>,
    /// Total order.
    pub total: Vec<[f64; 2]>,
    /// Second order of the pairs (0, 1), (0, 2) … (1, 2) …, where the study has it.
    pub second: Vec<[f64; 2]>,
    /// Blocks without a missing value.
    pub blocks: u64,
}

/// What a block of rows consists of.
#[derive(Clone, Copy, Debug)]
struct Layout {
    axes: usize,
    second: bool,
}

impl Layout {
    /// Rows of a block: A, A with one column of B each, with second order B with one column of A each, B.
    fn length(self) -> usize {
        self.axes * if self.second { 2 } else { 1 } + 2
    }

    /// The pairs of quantities that have an index.
    fn pairs(self) -> impl Iterator<Item = (usize, usize)> {
        let n = if self.second { self.axes } else { 0 };
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// What the indices are means of, from a block of standardised values: count, sum and squares of A and B for the
    /// variance, then first order, total order, second order.
    fn terms(self, block: &[f64], terms: &mut Vec<f64>) {
        let (a, b) = (block[0], block[block.len() - 1]);
        let (ab, ba) = block[1..].split_at(self.axes);
        terms.clear();
        terms.extend([1.0, a + b, a * a + b * b]);
        terms.extend(ab.iter().map(|ab| b * (ab - a)));
        terms.extend(ab.iter().map(|ab| 0.5 * (a - ab) * (a - ab)));
        terms.extend(self.pairs().map(|(i, j)| ba[i] * ab[j] - a * b));
    }

    /// The indices from sums of the terms over blocks.
    fn indices(self, sums: &[f64]) -> Vec<f64> {
        let n = sums[0];
        let mean = sums[1] / (2.0 * n);
        let variance = sums[2] / (2.0 * n) - mean * mean;
        let mut indices: Vec<f64> = sums[3..].iter().map(|sum| sum / n / variance).collect();
        for (place, (i, j)) in self.pairs().enumerate() {
            indices[2 * self.axes + place] -= indices[i] + indices[j];
        }
        indices
    }
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

    fn deviation(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Of the first pass: what values are standardised by.
#[derive(Default)]
struct Centre {
    /// Of every value.
    all: Moments,
    /// Of A and B.
    ends: Moments,
}

impl Centre {
    fn add(&mut self, block: &[f64]) {
        block.iter().for_each(|value| self.all.add(*value));
        self.ends.add(block[0]);
        self.ends.add(block[block.len() - 1]);
    }
}

/// Of the second pass: sums of the terms over the blocks, and over those of each resample.
struct Sums {
    layout: Layout,
    centre: Centre,
    blocks: u64,
    whole: Vec<f64>,
    resamples: Vec<(Stream, Vec<f64>)>,
    standardised: Vec<f64>,
    terms: Vec<f64>,
}

impl Sums {
    fn new(layout: Layout, centre: Centre) -> Self {
        let zeros = vec![0.0; 3 + 2 * layout.axes + layout.pairs().count()];
        let resample = |k| (Stream::new(mix(KEY, k)), zeros.clone());
        let resamples = (0..RESAMPLES).map(resample).collect();
        Self { layout, centre, blocks: 0, whole: zeros, resamples, standardised: Vec::new(), terms: Vec::new() }
    }

    fn add(&mut self, block: &[f64]) {
        let (mean, deviation) = (self.centre.all.mean, self.centre.ends.deviation());
        self.standardised.clear();
        self.standardised.extend(block.iter().map(|value| (value - mean) / deviation));
        self.layout.terms(&self.standardised, &mut self.terms);
        self.whole.iter_mut().zip(&self.terms).for_each(|(sum, term)| *sum += term);
        for (stream, sums) in &mut self.resamples {
            let times = poisson(unit(stream.at(self.blocks)));
            if times > 0.0 {
                sums.iter_mut().zip(&self.terms).for_each(|(sum, term)| *sum += times * term);
            }
        }
        self.blocks += 1;
    }

    fn indices(&self) -> Indices {
        let values = self.layout.indices(&self.whole);
        let resampled: Vec<Vec<f64>> = self.resamples.iter().map(|(_, sums)| self.layout.indices(sums)).collect();
        let each = |i: usize| {
            let mut moments = Moments::default();
            resampled.iter().for_each(|indices| moments.add(indices[i]));
            [values[i], QUANTILE_95 * moments.deviation()]
        };
        let n = self.layout.axes;
        Indices {
            first: (0..n).map(each).collect(),
            total: (n..2 * n).map(each).collect(),
            second: (2 * n..values.len()).map(each).collect(),
            blocks: self.blocks,
        }
    }
}

/// A Poisson number of mean 1 from a share of its probability.
fn poisson(share: f64) -> f64 {
    let (mut number, mut probability) = (0.0, (-1.0f64).exp());
    let mut below = probability;
    while share >= below && number < 16.0 {
        number += 1.0;
        probability /= number;
        below += probability;
    }
    number
}

/// Indices of one output from its values by row, a missing one being NaN; with second order where the study has it.
pub fn of_values(axes: usize, second: bool, values: &[f64]) -> Indices {
    let layout = Layout { axes, second };
    let whole = |block: &&[f64]| block.iter().all(|value| value.is_finite());
    let blocks = || values.chunks_exact(layout.length()).filter(whole);
    let mut centre = Centre::default();
    blocks().for_each(|block| centre.add(block));
    let mut sums = Sums::new(layout, centre);
    blocks().for_each(|block| sums.add(block));
    sums.indices()
}

/// Indices of every output of a Saltelli study from its parts, in bounded memory; `None` for other designs. `local` gives a
/// part as a file on the disk; it is asked once for each part.
///
/// # Errors
/// A part cannot be read.
pub fn of_study(study: &Study, local: impl Fn(u64) -> Result<LocalFile, Error>) -> Result<Option<Value>, Error> {
    let Design::Saltelli { axes, samples, second_order, .. } = &study.design else { return Ok(None) };
    let parts: Vec<LocalFile> = (0..study.parts).map(local).collect::<Result<_, _>>()?;
    let layout = Layout { axes: axes.len(), second: *second_order };
    let schema = columns::schema(study);
    let is_result = |i: &usize| *i > study.varied.len() && *schema.field(*i).data_type() == DataType::Float64;
    let results: Vec<usize> = (0..schema.fields().len()).filter(is_result).collect();
    let of_column = |column: &usize| {
        let mut centre = Centre::default();
        blocks(&parts, *column, layout.length(), |block| centre.add(block))?;
        let mut sums = Sums::new(layout, centre);
        blocks(&parts, *column, layout.length(), |block| sums.add(block))?;
        Ok((schema.field(*column).name().clone(), described(study, layout, &sums.indices())))
    };
    let outputs: Map<String, Value> =
        results.par_iter().map(of_column).collect::<Result<Vec<_>, Error>>()?.into_iter().collect();
    Ok(Some(json!({
        "study": study.name,
        "samples": samples,
        "method": "first order: Saltelli et al. 2010; total order: Jansen 1999; second order: Saltelli 2002",
        "ci95": format!("half-width, from {RESAMPLES} bootstrap resamples of the blocks"),
        "outputs": outputs,
    })))
}

fn described(study: &Study, layout: Layout, indices: &Indices) -> Value {
    let entry = |[value, half]: &[f64; 2]| json!({ "value": value, "ci95": half });
    let list = |values: &[[f64; 2]]| {
        let named = study.varied.iter().zip(values);
        Value::Object(named.map(|(v, value)| (v.column.clone(), entry(value))).collect())
    };
    let mut described =
        json!({ "blocks": indices.blocks, "first_order": list(&indices.first), "total_order": list(&indices.total) });
    if layout.second {
        let pair = |((i, j), value): ((usize, usize), &[f64; 2])| {
            json!({
                "quantities": [study.varied[i].column, study.varied[j].column],
                "value": value[0],
                "ci95": value[1],
            })
        };
        described["second_order"] = layout.pairs().zip(&indices.second).map(pair).collect();
    }
    described
}

/// Hands every block of one column's values that misses none to `take`, in order; blocks may reach across parts.
fn blocks(parts: &[LocalFile], column: usize, length: usize, mut take: impl FnMut(&[f64])) -> Result<(), Error> {
    let mut block = Vec::with_capacity(length);
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
        let design = Design::saltelli(vec![axis; 3], n, 3, true);
        let mut x = vec![Vec::new(); 3];
        design.fill(0..n * 8, &mut x).unwrap();
        let y = |i: usize| x[0][i].sin() + a * x[1][i].sin().powi(2) + b * x[2][i].powi(4) * x[0][i].sin();
        let indices = of_values(3, true, &(0..x[0].len()).map(y).collect::<Vec<_>>());
        let v1 = 0.5 * (1.0 + b * PI.powi(4) / 5.0).powi(2);
        let v2 = a * a / 8.0;
        let v13 = b * b * PI.powi(8) * (1.0 / 18.0 - 1.0 / 50.0);
        let v = v1 + v2 + v13;
        for (found, exact) in indices.first.iter().zip([v1 / v, v2 / v, 0.0]) {
            assert!((found[0] - exact).abs() < 0.01, "{found:?} {exact}");
        }
        for (found, exact) in indices.second.iter().zip([0.0, v13 / v, 0.0]) {
            assert!((found[0] - exact).abs() < 0.02, "{found:?} {exact}");
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
        assert_eq!(of_values(2, false, &values), of_values(2, false, &broken));
    }

    /// Ishigami's function, a = 7, b = 0.1, and its indices of first and total order.
    fn ishigami(x: [f64; 3]) -> f64 {
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }
    const FIRST: [f64; 3] = [0.313_905, 0.442_411, 0.0];
    const TOTAL: [f64; 3] = [0.557_589, 0.442_411, 0.243_684];

    /// Share of the intervals that hold the true index.
    fn coverage(studies: impl Iterator<Item = Vec<f64>>) -> f64 {
        let (mut covered, mut asked) = (0, 0);
        for values in studies {
            let indices = of_values(3, false, &values);
            for (found, exact) in indices.first.iter().zip(FIRST).chain(indices.total.iter().zip(TOTAL)) {
                covered += usize::from((found[0] - exact).abs() <= found[1]);
                asked += 1;
            }
        }
        covered as f64 / asked as f64
    }

    /// Blocks of independent uniform points through Ishigami's function.
    fn ishigami_at_random(blocks: u64, seed: u64) -> Vec<f64> {
        let y = ishigami;
        let stream = Stream::new(seed);
        let angle = |i: u64| std::f64::consts::PI * (2.0 * unit(stream.at(i)) - 1.0);
        let block = |k: u64| {
            let (a, b): ([f64; 3], [f64; 3]) = (
                std::array::from_fn(|d| angle(6 * k + d as u64)),
                std::array::from_fn(|d| angle(6 * k + 3 + d as u64)),
            );
            let mixed = |i: usize| std::array::from_fn(|d| if d == i { b[d] } else { a[d] });
            [y(a), y(mixed(0)), y(mixed(1)), y(mixed(2)), y(b)]
        };
        (0..blocks).flat_map(block).collect()
    }

    #[test]
    fn intervals_of_independent_blocks_cover_the_true_indices_at_their_level() {
        let share = coverage((0..400).map(|seed| ishigami_at_random(400, seed)));
        assert!((0.93..=0.97).contains(&share), "{share}");
    }

    /// Points of a Sobol' sequence are spread more evenly than independent ones, which the resampling does not know.
    #[test]
    fn intervals_of_a_saltelli_design_cover_the_true_indices_at_least_at_their_level() {
        let axis =
            Axis::Range { from: -std::f64::consts::PI, to: std::f64::consts::PI, count: None, scale: Scale::Linear };
        let study = |seed| {
            let design = Design::saltelli(vec![axis.clone(); 3], 256, seed, false);
            let mut x = vec![Vec::new(); 3];
            design.fill(0..256 * 5, &mut x).unwrap();
            (0..x[0].len()).map(|i| ishigami([x[0][i], x[1][i], x[2][i]])).collect()
        };
        let share = coverage((0..200).map(study));
        assert!(share > 0.95, "{share}");
    }

    #[test]
    fn a_poisson_number_has_mean_and_variance_one() {
        let n = 100_000;
        let numbers: Vec<f64> = (0..n).map(|i| poisson((f64::from(i) + 0.5) / f64::from(n))).collect();
        let mean = numbers.iter().sum::<f64>() / f64::from(n);
        let variance = numbers.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 1e-3 && (variance - 1.0).abs() < 1e-3, "{mean} {variance}");
    }
}
