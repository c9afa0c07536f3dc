//! `[statistics]` of a study file.

use super::section::{Entry, Section};
use crate::error::Error;
use crate::study::Study;
use crate::study::plan::{Bins, Goals, Plan, no_result};
use records::Field;

/// Maximum number of bins of a histogram: each part stores them all.
const MOST_BINS: u64 = 100_000;

/// The statistics requested by `[statistics]`.
pub fn read(study: &Study, section: &Section<'_>) -> Result<Plan, Error> {
    let mut plan = Plan::all(study.outputs());
    let every = plan.columns.clone();
    let known = |entry: &Field<'_>, name: &str| {
        if every.iter().any(|column| column == name) {
            return Ok(());
        }
        Err(entry.because(format!("names `{name}`, which {}", no_result(name, &every))))
    };
    if let Some(entry) = section.get("columns") {
        let wanted = entry.texts()?;
        wanted.iter().try_for_each(|name| known(&entry, name))?;
        plan.columns.retain(|column| wanted.contains(&column.as_str()));
        if plan.columns.is_empty() {
            return Err(entry.because("is empty; at least one column is needed"));
        }
    }
    if let Some(entry) = section.get("quantiles") {
        plan.quantiles = entry.some_numbers()?;
        if let Some(wrong) = plan.quantiles.iter().find(|p| !(0.0..=1.0).contains(*p)) {
            return Err(entry.because(format!("takes {wrong}; probabilities from 0 to 1 are expected")));
        }
    }
    for entry in section.section("histograms")?.entries() {
        known(&entry, entry.key())?;
        if !plan.columns.iter().any(|column| column == entry.key()) {
            return Err(entry.because("is none of the `columns` of [statistics]"));
        }
        plan.histograms.push((entry.key().to_owned(), bins(entry)?));
    }
    if let Some(entry) = section.get("pareto") {
        plan.pareto = Some(goals(entry, known, &plan.columns)?);
    }
    section.finish()?;
    Ok(plan)
}

/// The bins of a histogram.
fn bins(entry: Field<'_>) -> Result<Bins, Error> {
    let section = entry.section()?;
    let from = section.require("from", "the lower edge")?.finite()?;
    let to = section.require("to", "the upper edge")?.finite()?;
    let bins = section.require("bins", "the number of bins")?;
    let number = bins.whole(1)?;
    section.finish()?;
    if from >= to {
        return Err(entry.because(format!("runs from {from} to {to}: `from` has to be below `to`")));
    }
    if number > MOST_BINS {
        return Err(bins.because(format!("is {number}; at most {MOST_BINS} are allowed")));
    }
    Ok(Bins { from, to, bins: number })
}

/// The goals of a Pareto front: 2 to 4 of `columns`. `known` refuses a name that is no result.
fn goals(
    entry: Field<'_>,
    known: impl Fn(&Field<'_>, &str) -> Result<(), Error>,
    columns: &[String],
) -> Result<Goals, Error> {
    let section = entry.section()?;
    let list = |key: &str| {
        section.get(key).map_or(Ok(Vec::new()), |entry| {
            let names = entry.texts()?;
            names.iter().try_for_each(|name| known(&entry, name))?;
            Ok::<_, Error>(names.into_iter().map(str::to_owned).collect())
        })
    };
    let goals = Goals { minimise: list("minimise")?, maximise: list("maximise")? };
    section.finish()?;
    let names: Vec<&str> = goals.columns().map(|(name, _)| name).collect();
    if !(2..=4).contains(&names.len()) {
        let count = names.len();
        return Err(entry.because(format!("names {count} columns in `minimise` and `maximise`: 2 to 4 are expected")));
    }
    if let Some(twice) = records::repeated(&names) {
        return Err(entry.because(format!("names `{twice}` twice")));
    }
    if let Some(absent) = names.iter().find(|name| !columns.iter().any(|column| column == *name)) {
        return Err(entry.because(format!("names `{absent}`, which is none of the `columns` of [statistics]")));
    }
    Ok(goals)
}
