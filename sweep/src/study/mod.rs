//! A study: a base model, the push-and-hold test, the varied quantities and the design.
//!
//! | module | holds |
//! |---|---|
//! | `constraint` | which points are solved |
//! | [`plan`] | requested statistics |

pub(crate) mod constraint;
pub mod plan;

use crate::design::Design;
use crate::design::saltelli::REPLICATES;
use crate::file_names;
use crate::hash;
use crate::quantity::point::Point;
use crate::quantity::{self, Base};
use crate::result::outputs::{OUTPUTS, Output, When};
use chamber::effects::{EffectSet, EffectValues};
use constraint::Constraint;
use ensemble::Solver;
use plan::Plan;
use records::Model;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// A varied quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Varied {
    /// Name of its column, as in the study.
    pub column: String,
    /// Its index in [`quantity::all`].
    pub quantity: usize,
}

/// A checked study.
#[derive(Debug)]
pub struct Study {
    /// Name of the study; that of its file unless stated.
    pub name: String,
    /// The file it was read from.
    pub path: PathBuf,
    /// The model, which supplies everything that does not vary.
    pub model: Model,
    /// The model's effects ignored here: those on the stroke record, as a study's stroke is the true one.
    pub excluded: EffectSet,
    /// Values of all quantities that do not vary.
    pub base: Point,
    /// The varied quantities, in column order.
    pub varied: Vec<Varied>,
    /// The points at which the test is simulated.
    pub design: Design,
    /// Conditions that a row must satisfy, else it is left out.
    pub constraints: Vec<Constraint>,
    /// Seed of the sampled designs.
    pub seed: u64,
    /// Number of rows.
    pub rows: u64,
    /// Whether the paper's regression is carried out for each row.
    pub fit: bool,
    /// The solver of the equations.
    pub solver: Solver,
    /// Relative tolerance of the adaptive integration.
    pub tolerance: f64,
    /// Number of files that the rows are divided into.
    pub parts: u64,
    /// Requested statistics of the results, if any. They do not affect the rows.
    pub statistics: Option<Plan>,
    /// Ineffective settings in the study file, in sentences.
    pub notes: Vec<String>,
    /// Number of base samples of a sampled design.
    pub(crate) samples: Option<u64>,
    /// SHA-256 of the table's file, for a study on a table.
    pub(crate) table_sha256: Option<String>,
}

impl Study {
    /// The rows of a part: parts differ by at most one row.
    pub fn rows_of(&self, part: u64) -> std::ops::Range<u64> {
        let start = |part: u64| (u128::from(self.rows) * u128::from(part) / u128::from(self.parts)) as u64;
        start(part)..start(part + 1)
    }

    /// Name of a part's file.
    pub fn part_name(&self, part: u64) -> String {
        file_names::part(part, self.parts)
    }

    /// The study with all its numbers as JSON, stored with its rows.
    pub fn json(&self) -> Value {
        let mut study = json!({ "name": self.name, "design": self.design.name() });
        if let Some(samples) = self.samples {
            study["samples"] = json!(samples);
        }
        if let Design::Saltelli(saltelli) = &self.design {
            study["replicates"] = json!(REPLICATES);
            if saltelli.scheme().second {
                study["second_order"] = json!(true);
            }
        }
        study["seed"] = json!(self.seed);
        study["rows"] = json!(self.rows);
        study["parts"] = json!(self.parts);
        study["fit"] = json!(self.fit);
        study["solver"] = json!(self.solver.name());
        study["tolerance"] = json!(self.tolerance);
        study["gas"] = json!(self.model.gas_name);
        study["area_law"] = json!(self.model.chamber.geometry.area_law.name());
        let by_duration = self.base.get(Base::Duration).is_finite();
        study["length_of_the_test"] = json!(if by_duration { "duration_s" } else { "hold_time_constants" });
        study["fixed"] = Value::Object(self.fixed());
        self.describe_points(&mut study);
        if !self.constraints.is_empty() {
            let texts: Vec<_> = self.constraints.iter().map(|constraint| &constraint.text).collect();
            study["constraints"] = json!(texts);
        }
        study
    }

    /// The fixed numbers, by name; only for active effects.
    fn fixed(&self) -> Map<String, Value> {
        let mut fixed = Map::new();
        let effects = self.effects();
        for (index, q) in quantity::all().iter().enumerate() {
            let value = self.base.0[index];
            let effect_is_off = quantity::effect_of(index).is_some_and(|(effect, _)| !effects.has(effect));
            if value.is_finite() && !effect_is_off && !self.varied.iter().any(|v| v.quantity == index) {
                fixed.insert(q.name.clone(), json!(value));
            }
        }
        fixed
    }

    /// Adds what varies: the table's file and its columns, or each axis with its correlations.
    fn describe_points(&self, study: &mut Value) {
        match &self.design {
            Design::Table(table) => {
                let name = table.path().file_name().map(|name| name.to_string_lossy().into_owned());
                study["table"] = json!({ "file": name, "sha256": self.table_sha256 });
                let columns: Vec<_> = self.varied.iter().map(|v| &v.column).collect();
                study["vary"] = json!(columns);
            }
            design => {
                let axes = self.varied.iter().zip(design.axes());
                let axes: Map<String, Value> = axes.map(|(v, axis)| (v.column.clone(), json!(axis))).collect();
                study["vary"] = Value::Object(axes);
                if let Some(copula) = design.copula() {
                    let columns: Vec<_> = copula.columns().iter().map(|i| &self.varied[*i].column).collect();
                    study["correlated"] = json!({ "quantities": columns, "correlation": copula.correlation() });
                }
            }
        }
    }

    /// The computed columns of the study.
    pub fn outputs(&self) -> impl Iterator<Item = &'static Output> + '_ {
        let has = |when: When| match when {
            When::Always => true,
            When::Fit => self.fit,
            When::Solved(base) => self.varied.iter().any(|v| v.quantity == base as usize),
        };
        OUTPUTS.iter().filter(move |o| has(o.when) && !self.varied.iter().any(|v| v.column == o.name))
    }

    /// Effects that are on in some row. The same for all rows and chunks, so that a row's bits depend on the row alone.
    pub fn effects(&self) -> EffectSet {
        let mut values = EffectValues::NEUTRAL;
        values.0.copy_from_slice(self.base.effects());
        let varied = self.varied.iter().filter_map(|v| quantity::effect_of(v.quantity));
        values.active().union(varied.map(|(effect, _)| effect).collect())
    }

    /// Sets the varied quantities of a point from one row of their columns.
    pub fn vary(&self, point: &mut Point, columns: &[Vec<f64>], row: usize) {
        for (varied, column) in self.varied.iter().zip(columns) {
            point.0[varied.quantity] = column[row];
        }
    }

    /// Sets the varied parameters of a point in the effects of the study's model.
    pub fn vary_effects(&self, point: &Point, effects: &mut EffectValues) {
        for varied in &self.varied {
            if let Some(parameter) = quantity::parameter(varied.quantity) {
                effects.0[parameter] = point.0[varied.quantity];
            }
        }
    }

    /// SHA-256 of the study and the program's version: rows belong together if it is the same.
    pub fn identity(&self) -> String {
        let text = format!("{} {}", env!("CARGO_PKG_VERSION"), self.json());
        hash::of_bytes(text.as_bytes())
    }
}
