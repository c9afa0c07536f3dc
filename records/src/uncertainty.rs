//! Uncertainty of a model's parameters: the `[uncertainty]` table of a model file.
//!
//! `parameters` names them: `lambda0_w_per_m2_k`, `dead_volume_m3`, an effect's `leakage.conductance_m3_per_s_pa`. `ci95` holds a
//! 95 % interval for each, `covariance` their covariance matrix, all in SI units.

use crate::error::Error;
use crate::key::{Bounds, KeyProblem};
use crate::names::{nearest, repeated};
use crate::table::Table;
use crate::toml_text::quoted;
use chamber::effects;
use std::fmt::Write;

/// Rounding tolerance of a covariance matrix, as a correlation.
const ROUNDING: f64 = 1e-6;

/// Parameters that a fit may free besides those of the effects.
const OF_RIG: [&str; 7] = [
    "lambda0_w_per_m2_k", "dead_volume_m3", "bore_m", "ambient_temperature_k", "position_scale", "position_offset_m",
    "rest_temperature_k",
];

/// Intervals and covariance of a model's parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Names of the parameters, as in results.
    pub parameters: Vec<String>,
    /// The 95 % interval of each, SI units.
    pub ci95: Vec<[f64; 2]>,
    /// Covariance of their values, SI units, row by row.
    pub covariance: Vec<Vec<f64>>,
}

impl Uncertainty {
    pub(crate) fn read(root: &Table<'_>) -> Result<Option<Self>, Error> {
        let Some(table) = root.table("uncertainty")? else { return Ok(None) };
        table.allow(&["parameters", "ci95", "covariance"])?;
        let parameters = table.texts("parameters")?;
        let parameters = parameters.ok_or_else(|| table.missing("parameters", "a list of the parameters' names"))?;
        let count = parameters.len();
        let rows = |key, what: &str| {
            let rows = table.rows_of_numbers(key, &Bounds::Finite)?.ok_or_else(|| table.missing(key, what))?;
            if rows.len() == count {
                return Ok(rows);
            }
            let problem = format!("{} rows for {count} parameters, expected {what}", rows.len());
            Err(table.contradiction(key, problem))
        };
        if let Some(twice) = repeated(&parameters) {
            return Err(table.contradiction("parameters", format!("`{twice}` is named twice")));
        }
        if let Some(problem) = parameters.iter().find_map(|name| unknown(name)) {
            return Err(table.refuse("parameters", problem));
        }
        let ci95 = rows("ci95", "an interval [low, high] for each parameter")?;
        let covariance = rows("covariance", "a square matrix, a row for each parameter")?;
        let interval = |(row, name): (&Vec<f64>, &&str)| match row[..] {
            [low, high] if low <= high => Ok([low, high]),
            _ => Err(table.contradiction("ci95", format!("{row:?} is no interval [low, high] for `{name}`"))),
        };
        let ci95 = ci95.iter().zip(&parameters).map(interval).collect::<Result<_, _>>()?;
        check_covariance(&covariance, &parameters).map_err(|problem| table.contradiction("covariance", problem))?;
        Ok(Some(Self { parameters: parameters.into_iter().map(str::to_owned).collect(), ci95, covariance }))
    }

    pub(crate) fn write(&self, out: &mut String) -> std::fmt::Result {
        let parameters: Vec<String> = self.parameters.iter().map(|name| quoted(name)).collect();
        writeln!(out, "[uncertainty]  # 95 % intervals and covariance, SI units")?;
        writeln!(out, "parameters = [{}]", parameters.join(", "))?;
        writeln!(out, "ci95 = [")?;
        self.ci95.iter().try_for_each(|row| writeln!(out, "    {row:?},"))?;
        writeln!(out, "]\ncovariance = [")?;
        self.covariance.iter().try_for_each(|row| writeln!(out, "    {row:?},"))?;
        writeln!(out, "]")
    }
}

/// The problem of a parameter name that no fit frees; `None` for a known name.
fn unknown(name: &str) -> Option<KeyProblem> {
    let of_card =
        |card: &'static chamber::card::Card| card.parameters.iter().map(|p| format!("{}.{}", card.name, p.key()));
    let of_effects: Vec<String> = effects::all().flat_map(|(_, card)| of_card(card)).collect();
    let all = || OF_RIG.into_iter().chain(of_effects.iter().map(String::as_str));
    if all().any(|known| known == name) {
        return None;
    }
    let an_effect = "<effect>.<parameter> such as leakage.conductance_m3_per_s_pa";
    Some(KeyProblem::UnknownName {
        value: name.to_owned(),
        near: nearest(name, all()).map(str::to_owned),
        known: OF_RIG.into_iter().chain([an_effect]).map(str::to_owned).collect(),
    })
}

/// Refuses an invalid covariance matrix: wrong shape, negative variance, asymmetry, or a correlation beyond one.
fn check_covariance(rows: &[Vec<f64>], parameters: &[&str]) -> Result<(), String> {
    for (row, name) in rows.iter().zip(parameters) {
        if row.len() != parameters.len() {
            let count = parameters.len();
            return Err(format!("the row of `{name}` has {} numbers where {count} parameters are named", row.len()));
        }
    }
    for (i, row) in rows.iter().enumerate() {
        if row[i] < 0.0 {
            return Err(format!("the variance of `{}`, {:?}, is negative", parameters[i], row[i]));
        }
        for (j, value) in row.iter().enumerate().take(i) {
            let limit = row[i].sqrt() * rows[j][j].sqrt();
            let pair = format!("`{}` and `{}`", parameters[j], parameters[i]);
            if (value - rows[j][i]).abs() > ROUNDING * limit {
                return Err(format!("the covariance of {pair} is given twice with different values"));
            }
            if value.abs() > (1.0 + ROUNDING) * limit {
                return Err(format!("the covariance of {pair}, {value:?}, is beyond what their variances allow"));
            }
        }
    }
    Ok(())
}
