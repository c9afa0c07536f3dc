//! A whole study file: reads its own keys here, and its tables in other modules.

use super::constraints;
use super::points::{self, Points};
use super::section::{Entry, Section};
use super::size;
use super::statistics;
use super::test;
use super::{Overrides, SOLVERS, TOLERANCES};
use crate::design::Design;
use crate::error::Error;
use crate::quantity::uncertain::Uncertain;
use crate::row;
use crate::study::Study;
use ensemble::{Options, Solver};
use records::{Document, Field, Model};
use std::path::Path;

/// Keys of `[study]`. Those that do not suit the design are reported after all are read.
#[rustfmt::skip]
const KEYS: [&str; 12] = [
    "model", "name", "design", "samples", "second_order", "table", "columns", "seed", "fit", "solver", "tolerance", "parts",
];

/// Number of rows up to which all are checked, before the first is solved, for any that the constraints leave.
const ROWS_LOOKED_AT: u64 = 1 << 14;

impl Study {
    /// Reads a study file and the model it names, whose path is relative to the study's.
    ///
    /// # Errors
    /// Any error in either file, with its line and key.
    pub fn read(path: &Path) -> Result<Study, Error> {
        Study::read_with(path, Overrides::default())
    }

    /// The same with some settings replaced.
    ///
    /// # Errors
    /// As [`Study::read`], and for invalid replacements.
    pub fn read_with(path: &Path, overrides: Overrides) -> Result<Study, Error> {
        Study::parse(&Document::read(path)?, None, overrides)
    }

    /// A study from the content of a file; paths in it are relative to the document's folder.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn from_document(document: &Document) -> Result<Study, Error> {
        Study::parse(document, None, Overrides::default())
    }

    /// A study from its text and a given model: the text names no model.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn about(model: &Model, text: &str) -> Result<Study, Error> {
        Study::parse(&Document::parse(Path::new("study"), text.to_owned())?, Some(model), Overrides::default())
    }

    fn parse(document: &Document, model: Option<&Model>, overrides: Overrides) -> Result<Study, Error> {
        let path = document.path();
        let top = Section::new(document.root());
        let (study, test, vary) = (top.section("study")?, top.section("test")?, top.section("vary")?);
        let asked = top.get("statistics").map(|entry| entry.section()).transpose()?;
        top.finish()?;
        study.allow(&KEYS)?;

        let mut model = match model {
            Some(model) => model.clone(),
            None => {
                let entry = study.require("model", "the model file to begin from")?;
                Model::read(&entry.path_beside(path)?)?
            }
        };
        let uncertain = Uncertain::of(&model);
        let excluded = model.exclude_recorded_stroke_effects();
        let name = study.get("name").map(|e| e.text()).transpose()?.map_or_else(|| stem(path), str::to_owned);
        let seed = study.get("seed").map(|e| e.whole(0)).transpose()?.unwrap_or(0);
        let fit = study.get("fit").map(|e| e.flag()).transpose()?.unwrap_or(true);
        let solver = study.get("solver").map(|e| e.choice(&SOLVERS)).transpose()?;
        let solver = overrides.solver.or(solver).unwrap_or(Solver::Auto);
        let tolerance = study.get("tolerance").map(tolerance).transpose()?;
        let tolerance = overrides.tolerance()?.or(tolerance).unwrap_or(Options::RELATIVE_TOLERANCE);
        let samples = study.get("samples").map(|e| e.whole(1)).transpose()?;
        let parts = study.get("parts").map(|e| Ok::<_, Error>((e, e.whole(1)?))).transpose()?;

        let mut points = points::read(&study, &vary, &uncertain, path, seed)?;
        study.finish()?;
        let base = test::read(&model, &test, &points.varied)?;
        points.check(&model, &base, solver, &test, path)?;
        let Points { design, rows, varied, table_sha256, .. } = points;
        let parts = match parts {
            Some((entry, parts)) => size::checked_parts(entry, parts, rows)?,
            None => size::default_parts(rows),
        };
        let constraints = constraints::read(&vary, &design, &base, &varied)?;
        let notes = without_effect(&study, &vary, &design);
        let samples = samples.filter(|_| is_sampled(&design));
        let path = path.to_owned();
        #[rustfmt::skip]
        let study = Study {
            name, path, model, excluded, base, varied, design, constraints, seed, rows, fit, solver, tolerance, parts, statistics: None,
            samples, table_sha256, notes,
        };
        if let Some(entry) = vary.get(constraints::KEY)
            && study.rows <= ROWS_LOOKED_AT
            && nothing_is_left(&study)?
        {
            return Err(entry.because("leave no row to solve"));
        }
        let plan = asked.map(|section| statistics::read(&study, &section)).transpose()?;
        Ok(Study { statistics: plan, ..study })
    }
}

fn is_sampled(design: &Design) -> bool {
    !matches!(design, Design::Factorial(_) | Design::Table(_))
}

/// Keys without effect in a study of that design, in sentences.
fn without_effect(study: &Section<'_>, vary: &Section<'_>, design: &Design) -> Vec<String> {
    let name = design.name();
    let samples = study.get("samples").filter(|_| !is_sampled(design));
    let samples = samples.map(|_| format!("study.samples has no effect: a \"{name}\" design has the rows that it has"));
    let has_count = |entry: &Field<'_>| entry.table().is_ok_and(|table| table.has("count"));
    let counts = vary.entries().filter(|entry| is_sampled(design) && has_count(entry));
    let counts = counts.map(|entry| {
        format!("vary.{}: count has no effect: a \"{name}\" design draws study.samples values", entry.key())
    });
    samples.into_iter().chain(counts).collect()
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "study".into(), |stem| stem.to_string_lossy().into_owned())
}

fn tolerance(entry: Field<'_>) -> Result<f64, Error> {
    let value = entry.finite()?;
    if TOLERANCES.contains(&value) {
        Ok(value)
    } else {
        Err(entry.because(format!("is {value}; expected a number from 1e-13 to 1e-2")))
    }
}

/// Whether no row can be solved: each violates a constraint or is impossible.
fn nothing_is_left(study: &Study) -> Result<bool, Error> {
    let mut points: Vec<Vec<f64>> = study.varied.iter().map(|_| Vec::new()).collect();
    study.design.fill(0..study.rows, &mut points)?;
    let mut point = study.base;
    Ok((0..study.rows as usize).all(|i| {
        study.vary(&mut point, &points, i);
        row::scenario(study, &point).is_err()
    }))
}
