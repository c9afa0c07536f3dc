//! The statistics requested by a study.

use crate::error::Error;
use crate::hash;
use crate::result::outputs::Output;
use serde::Serialize;
use serde_json::json;

/// Default probabilities of the quantiles.
pub const QUANTILES: [f64; 7] = [0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99];

/// The statistics requested by a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The columns, in the order of the table.
    pub columns: Vec<String>,
    /// Probabilities of the quantiles.
    pub quantiles: Vec<f64>,
    /// Histograms by column.
    pub histograms: Vec<(String, Bins)>,
    /// The Pareto front, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pareto: Option<Goals>,
}

/// Equal bins of a histogram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bins {
    /// Lower edge of the first.
    pub from: f64,
    /// Upper edge of the last, inclusive.
    pub to: f64,
    /// Number of bins.
    pub bins: u64,
}

/// Columns that a Pareto front minimises and maximises.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Goals {
    /// Columns that should be small.
    pub minimise: Vec<String>,
    /// Columns that should be large.
    pub maximise: Vec<String>,
}

impl Goals {
    /// The columns, minimised ones first, each with the sign that makes small values good.
    pub fn columns(&self) -> impl Iterator<Item = (&str, f64)> {
        self.minimise
            .iter()
            .map(|name| (name.as_str(), 1.0))
            .chain(self.maximise.iter().map(|name| (name.as_str(), -1.0)))
    }
}

/// Why a name is no result of the study, in words that follow it.
pub fn no_result(name: &str, results: &[String]) -> String {
    let hint = records::nearest(name, results.iter().map(String::as_str));
    let hint = hint.map_or(String::new(), |nearest| format!("; did you mean `{nearest}`?"));
    format!("is no result of this study{hint}")
}

impl Plan {
    /// Every computed column of a study, with the default quantiles.
    pub fn all(outputs: impl Iterator<Item = &'static Output>) -> Self {
        let columns = outputs.map(|output| output.name.to_owned()).collect();
        Self { columns, quantiles: QUANTILES.to_vec(), histograms: Vec::new(), pareto: None }
    }

    /// Selected computed columns of a study, by default all, with the quantiles of the given probabilities.
    ///
    /// # Errors
    /// A column that the study does not compute, or a probability outside 0 to 1.
    pub fn picked(
        outputs: impl Iterator<Item = &'static Output>,
        columns: Option<&[String]>,
        quantiles: Option<&[f64]>,
    ) -> Result<Self, Error> {
        let mut plan = Self::all(outputs);
        if let Some(columns) = columns {
            if let Some(unknown) = columns.iter().find(|name| !plan.columns.contains(name)) {
                return Err(Error::Option(format!("`{unknown}` {}", no_result(unknown, &plan.columns))));
            }
            plan.columns.retain(|column| columns.contains(column));
        }
        if let Some(quantiles) = quantiles {
            if let Some(wrong) = quantiles.iter().find(|p| !(0.0..=1.0).contains(*p)) {
                return Err(Error::Option(format!(
                    "a quantile of {wrong} is asked for; expected probabilities from 0 to 1"
                )));
            }
            plan.quantiles = quantiles.to_vec();
        }
        Ok(plan)
    }

    /// Identity that two states must share to be merged.
    pub fn identity(&self) -> String {
        let mut asked = vec![json!(self.columns), json!(self.histograms)];
        asked.extend(self.pareto.iter().map(|goals| json!(goals)));
        hash::of_bytes(json!(asked).to_string().as_bytes())
    }

    /// The histogram of a column, if requested.
    pub fn bins(&self, column: &str) -> Option<Bins> {
        self.histograms.iter().find(|(name, _)| name == column).map(|(_, bins)| *bins)
    }
}
