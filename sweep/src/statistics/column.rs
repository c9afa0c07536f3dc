//! Statistics of one column: moments, extremes with their rows, a sketch of its distribution, a histogram.

use super::moments::Moments;
use super::points::point_of;
use super::sketch::{Quantile, Sketch};
use crate::error::Error;
use crate::study::Study;
use crate::study::plan::{Bins, Plan};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Moments, extremes, quantile sketch and histogram of one column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Column {
    count: u64,
    nulls: u64,
    mean: f64,
    /// Sum of squared deviations from the mean.
    squares: f64,
    minimum: Option<Extreme>,
    maximum: Option<Extreme>,
    sketch: Sketch,
    /// Counts of a histogram, with those below and above its range at the ends.
    bins: Vec<u64>,
}

/// A value and the first row that has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Extreme {
    value: f64,
    row: u64,
}

impl Column {
    /// Without rows yet; `bins` requests a histogram.
    pub fn new(bins: Option<Bins>) -> Self {
        Self { bins: bins.map_or(Vec::new(), |bins| vec![0; bins.bins as usize + 2]), ..Self::default() }
    }

    /// Adds rows from `first_row` on, with NaN for missing values.
    pub fn add(&mut self, bins: Option<Bins>, first_row: u64, values: &[f64]) {
        if let Some(moments) = Moments::of(values).filter(Moments::is_finite) {
            self.add_finite(bins, values, moments, |index| first_row + index as u64);
            return;
        }
        let numbered = (first_row..).zip(values.iter().copied());
        let (rows, finite): (Vec<u64>, Vec<f64>) = numbered.filter(|(_, value)| value.is_finite()).unzip();
        self.nulls += (values.len() - finite.len()) as u64;
        if let Some(moments) = Moments::of(&finite) {
            self.add_finite(bins, &finite, moments, |index| rows[index]);
        }
    }

    fn add_finite(&mut self, bins: Option<Bins>, values: &[f64], moments: Moments, row: impl Fn(usize) -> u64) {
        let Moments { count, mean, squares, least, most } = moments;
        let first = |wanted: f64| {
            let index = values.iter().position(|value| *value == wanted).unwrap_or(0);
            Extreme { value: wanted, row: row(index) }
        };
        if self.minimum.is_none_or(|so_far| least < so_far.value) {
            self.minimum = Some(first(least));
        }
        if self.maximum.is_none_or(|so_far| most > so_far.value) {
            self.maximum = Some(first(most));
        }
        self.sketch.add(values, least, most);
        if let Some(Bins { from, to, bins }) = bins {
            for &value in values {
                let bin = if value < from {
                    0
                } else if value > to {
                    bins + 1
                } else {
                    1 + (((value - from) / (to - from) * bins as f64) as u64).min(bins - 1)
                };
                self.bins[bin as usize] += 1;
            }
        }
        self.merge_moments(count, mean, squares);
    }

    /// Update formulas of T. Chan, G. Golub and R. LeVeque, "Algorithms for computing the sample variance" (1983).
    fn merge_moments(&mut self, count: u64, mean: f64, squares: f64) {
        if count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, count as f64);
        let difference = mean - self.mean;
        self.mean += difference * (b / (a + b));
        self.squares += squares + difference * difference * (a * b / (a + b));
        self.count += count;
    }

    /// Merges the statistics of later rows.
    pub fn merge(&mut self, later: &Self) {
        self.nulls += later.nulls;
        if let Some(minimum) = later.minimum.filter(|l| self.minimum.is_none_or(|s| l.value < s.value)) {
            self.minimum = Some(minimum);
        }
        if let Some(maximum) = later.maximum.filter(|l| self.maximum.is_none_or(|s| l.value > s.value)) {
            self.maximum = Some(maximum);
        }
        self.sketch.merge(&later.sketch);
        for (count, later) in self.bins.iter_mut().zip(&later.bins) {
            *count += later;
        }
        self.merge_moments(later.count, later.mean, later.squares);
    }

    /// The statistics in the form of the file.
    ///
    /// # Errors
    /// A table of points cannot be read.
    pub fn summary(
        &self,
        study: &Study,
        plan: &Plan,
        bins: Option<Bins>,
        unit: Option<&String>,
    ) -> Result<Value, Error> {
        let some = |value: f64| (self.count > 0 && value.is_finite()).then_some(value);
        let variance = self.squares / (self.count as f64 - 1.0);
        let quantile = |(probability, found): (&f64, Option<Quantile>)| {
            let (least, most) =
                (self.minimum.map_or(f64::NAN, |e| e.value), self.maximum.map_or(f64::NAN, |e| e.value));
            let value = found.map(|found| found.value.max(least).min(most));
            json!({ "probability": probability, "value": value, "error_bound": found.map(|found| found.error) })
        };
        let quantiles = plan.quantiles.iter().zip(self.sketch.quantiles(&plan.quantiles)).map(quantile);
        let mut summary = json!({
            "unit": unit,
            "count": self.count,
            "nulls": self.nulls,
            "mean": some(self.mean),
            "variance": some(variance),
            "standard_deviation": some(variance.sqrt()),
            "minimum": described(study, self.minimum)?,
            "maximum": described(study, self.maximum)?,
            "quantiles": quantiles.collect::<Vec<_>>(),
        });
        if let (Some(Bins { from, to, bins }), [below, counts @ .., above]) = (bins, &self.bins[..]) {
            let edges: Vec<f64> = (0..=bins).map(|i| from + (to - from) * i as f64 / bins as f64).collect();
            summary["histogram"] = json!({ "edges": edges, "counts": counts, "below": below, "above": above });
        }
        Ok(summary)
    }
}

/// An extreme with its row and that row's point of the design.
fn described(study: &Study, extreme: Option<Extreme>) -> Result<Value, Error> {
    let Some(Extreme { value, row }) = extreme else { return Ok(Value::Null) };
    Ok(json!({ "value": value, "row": row, "at": point_of(study, row)? }))
}
