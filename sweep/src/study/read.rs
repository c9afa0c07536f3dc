//! Study files. Unknown keys and values out of range are refused with file, line and key.

use super::check::{self, Bounds};
use super::section::{Entry, Section};
use super::vary::{self, CONSTRAINTS, Found, not_found, varied};
use super::{MOST_PARTS, MOST_ROWS, SOLVERS, Study, TOLERANCES, Varied};
use crate::axis::Axis;
use crate::constraint::Constraint;
use crate::design::table::Table;
use crate::design::{Axes, Design, NAMES, sobol};
use crate::error::Error;
use crate::hash;
use crate::quantity::{self, Base, NotFound, Point};
use crate::solve;
use crate::statistics::{Bins, Goals, Plan, no_result};
use crate::uncertain::Uncertain;
use ensemble::{Options, Solver};
use records::{Document, Field, Model};
use report::number::shortest;
use std::path::{Path, PathBuf};

/// The points, what varies in them, where the study says so, and the hash of a table's file.
struct Points<'a> {
    design: Design,
    varied: Vec<Varied>,
    entries: Vec<Field<'a>>,
    table_sha256: Option<String>,
}

impl Study {
    /// Reads a study file and the model it names, whose path is relative to the study's.
    ///
    /// # Errors
    /// Whatever is wrong with either file, with its line and key.
    pub fn read(path: &Path) -> Result<Study, Error> {
        Study::from_document(&Document::read(path)?)
    }

    /// A study from the content of a file; paths in it are relative to the document's folder.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn from_document(document: &Document) -> Result<Study, Error> {
        Study::parse(document, None)
    }

    /// A study from its text; paths in it are relative to the folder of `path`, which also names it in errors.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn from_toml(text: &str, path: &Path) -> Result<Study, Error> {
        Study::from_document(&Document::parse(path, text.to_owned())?)
    }

    /// A study from its text about a model at hand: the text names no model.
    ///
    /// # Errors
    /// As [`Study::read`].
    pub fn about(model: &Model, text: &str) -> Result<Study, Error> {
        Study::parse(&Document::parse(Path::new("study"), text.to_owned())?, Some(model))
    }

    fn parse(document: &Document, model: Option<&Model>) -> Result<Study, Error> {
        let path = document.path();
        let top = Section::new(document.root());
        let (study, test, vary) = (top.section("study")?, top.section("test")?, top.section("vary")?);
        let statistics = top.get("statistics").map(|entry| entry.section()).transpose()?;
        top.finish()?;

        let mut model = match model {
            Some(model) => model.clone(),
            None => {
                let entry = study.require("model", "the model file to begin from")?;
                Model::read(&beside(path, entry.text()?))?
            }
        };
        let uncertain = Uncertain::of(&model);
        let left_out = model.leave_out_recorded_stroke();
        let name = study.get("name").map(|e| e.text()).transpose()?.map_or_else(|| stem(path), str::to_owned);
        let seed = study.get("seed").map(|e| e.whole(0)).transpose()?.unwrap_or(0);
        let fit = study.get("fit").map(|e| e.flag()).transpose()?.unwrap_or(true);
        let solver = study.get("solver").map(|e| e.choice(&SOLVERS)).transpose()?.unwrap_or(Solver::Auto);
        let tolerance = study.get("tolerance").map(tolerance).transpose()?.unwrap_or(Options::RELATIVE_TOLERANCE);
        let samples = study.get("samples").map(|e| e.whole(1)).transpose()?;
        let parts = study.get("parts").map(|e| Ok::<_, Error>((e, e.whole(1)?))).transpose()?;

        let Points { mut design, varied, entries, table_sha256 } = design(&study, &vary, &uncertain, path, seed)?;
        study.finish()?;
        let base = base(&model, &test, &varied)?;
        possible(&model, &base, &mut design, &varied, &entries, &test, path)?;
        let rows = design.rows().filter(|&rows| rows <= MOST_ROWS).ok_or_else(|| {
            let path = path.display();
            Error::Option(format!("{path}: the design has more rows than a study may have ({MOST_ROWS}); coarsen it"))
        })?;
        let parts = match parts {
            Some((entry, parts)) if parts > MOST_PARTS => {
                return Err(entry.because(format!("is {parts}; at most {MOST_PARTS} files are allowed")));
            }
            Some((entry, parts)) if parts > rows => {
                return Err(entry.because(format!("is {parts}, but the design has only {rows} rows")));
            }
            Some((_, parts)) => parts,
            None => Study::default_parts(rows),
        };
        let constraints = constraints(&vary, &design, &base, &varied)?;
        let samples = samples.filter(|_| !matches!(design, Design::Factorial(_) | Design::Table(_)));
        let path = path.to_owned();
        #[rustfmt::skip]
        let study = Study {
            name, path, model, left_out, base, varied, design, constraints, seed, rows, fit, solver, tolerance, parts, statistics: None,
            samples, table_sha256,
        };
        if let Some(entry) = vary.get(CONSTRAINTS)
            && study.rows <= ROWS_LOOKED_AT
            && solve::nothing_is_left(&study)?
        {
            return Err(entry.because("leave no row to solve"));
        }
        let plan = statistics.map(|section| plan(&study, &section)).transpose()?;
        Ok(Study { statistics: plan, ..study })
    }
}

/// A path as written in the study, relative to the study's folder.
fn beside(study: &Path, written: &str) -> PathBuf {
    study.parent().unwrap_or(Path::new("")).join(written)
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

/// The points: from [vary] or, for a table, from its columns.
fn design<'a>(
    study: &Section<'a>,
    vary: &Section<'a>,
    model: &Result<Uncertain, String>,
    path: &Path,
    seed: u64,
) -> Result<Points<'a>, Error> {
    let names = NAMES.map(|name| (name, name));
    let list = NAMES.map(|name| format!("\"{name}\"")).join(", ");
    let entry = study.require("design", &format!("one of {list}"))?;
    let name = entry.choice(&names)?;
    if name == "table" {
        return table(study, vary, path);
    }
    if let Some(unused) = study.get("table") {
        return Err(unused.because(format!("belongs to design = \"table\"; this study's is \"{name}\"")));
    }
    let (found, copula) = vary::axes(vary, model)?;
    if found.is_empty() {
        return Err(vary.because("names no quantity; at least one quantity to vary is needed"));
    }
    if name == "factorial"
        && let Some(Found { entry, axis, .. }) = found.iter().find(|found| found.axis.levels().is_none())
    {
        return Err(entry.because(match axis {
            Axis::Drawn(_) => {
                "is a distribution, which has no levels: design = \"sobol\", \"latin-hypercube\" or \"saltelli\" draws from it"
            }
            _ => "needs a `count` of levels in a factorial design",
        }));
    }
    if name == "saltelli" && copula.as_ref().is_some_and(|copula| copula.is_correlated()) {
        return Err(entry.because(
            "is \"saltelli\", whose indices are of independent quantities; those that the model draws are correlated: take \"sobol\" or \"latin-hypercube\"",
        ));
    }
    let limit = if name == "saltelli" { sobol::DIMENSIONS / 2 } else { sobol::DIMENSIONS };
    if found.len() > limit {
        return Err(entry.because(format!(
            "is \"{name}\", which varies at most {limit} quantities; this study varies {}",
            found.len()
        )));
    }
    let samples = || {
        let entry = study.require("samples", &format!("the number of samples of a \"{name}\" design"))?;
        let samples = entry.whole(1)?;
        if samples > 1 << 52 {
            Err(entry.because(format!("is {samples}; at most 2^52 are allowed")))
        } else {
            Ok(samples)
        }
    };
    let second_order = match study.get("second_order") {
        Some(entry) if name != "saltelli" => {
            return Err(entry.because(format!("belongs to design = \"saltelli\"; this study's is \"{name}\"")));
        }
        Some(entry) => entry.flag()?,
        None => false,
    };
    let varied = found.iter().map(|found| found.varied.clone()).collect();
    let entries = found.iter().map(|found| found.entry).collect();
    let axes = Axes::new(found.into_iter().map(|found| found.axis).collect(), copula);
    let design = match name {
        "factorial" => Design::Factorial(axes),
        "latin-hypercube" => Design::latin_hypercube(axes, samples()?, seed),
        "sobol" => Design::sobol(axes, samples()?, seed),
        _ => Design::saltelli(axes, samples()?, seed, second_order),
    };
    Ok(Points { design, varied, entries, table_sha256: None })
}

/// Rows that are all looked at before the first is solved, whether the constraints leave any.
const ROWS_LOOKED_AT: u64 = 1 << 14;

/// The constraints of [vary].
fn constraints(vary: &Section<'_>, design: &Design, base: &Point, varied: &[Varied]) -> Result<Vec<Constraint>, Error> {
    let Some(entry) = vary.get(CONSTRAINTS) else { return Ok(Vec::new()) };
    if let Design::Saltelli(_) = design {
        return Err(entry.because(
            "make quantities depend on each other, but the indices of a \"saltelli\" design are of independent ones: take \"sobol\" or \"latin-hypercube\"",
        ));
    }
    let varies = |place: &usize| varied.iter().any(|v| v.quantity == *place);
    // Quantities that each row has, though they are neither given nor varied, and what they follow from.
    let follows =
        |place: &usize| FOLLOWING.iter().find(|(base, _)| *base as usize == *place).map_or(&[][..], |(_, from)| *from);
    let parsed = |text: &&str| {
        let refuse = |why: String| entry.because(format!("has \"{text}\", which {why}"));
        let constraint = Constraint::parse(text).map_err(refuse)?;
        let quantities = constraint.quantities();
        if !quantities.iter().any(|place| varies(place) || follows(place).iter().any(|base| varies(&(*base as usize))))
        {
            return Err(refuse("depends on nothing that varies".into()));
        }
        let given = |place: &usize| !base.0[*place].is_nan() || varies(place) || !follows(place).is_empty();
        match quantities.iter().find(|place| !given(place)) {
            Some(place) => Err(refuse(format!("names {}; this study does not set it", quantity::all()[*place].name))),
            None => Ok(constraint),
        }
    };
    let texts = entry.texts()?;
    if texts.len() > MOST_CONSTRAINTS {
        return Err(entry.because(format!("are {}; at most {MOST_CONSTRAINTS} are allowed", texts.len())));
    }
    texts.iter().map(parsed).collect()
}

/// Quantities that a row can have without being given them, and what each then follows from.
const FOLLOWING: [(Base, &[Base]); 8] = [
    (Base::Bore, &[Base::VolumeToArea]),
    (Base::InitialStroke, &[Base::VolumeToAreaByLength]),
    (Base::FinalStroke, &[Base::VolumeToAreaByLength]),
    (Base::VolumeToArea, &[Base::VolumeToAreaByLength, Base::Bore, Base::FinalStroke, Base::DeadVolume, Base::Rod]),
    (Base::VolumeToAreaByLength, &[Base::VolumeToArea, Base::Bore, Base::FinalStroke, Base::DeadVolume, Base::Rod]),
    (Base::Duration, &[Base::HoldTimeConstants]),
    (Base::InitialTemperature, &[Base::AmbientTemperature]),
    (Base::TemperatureIn, &[Base::AmbientTemperature]),
];

/// Constraints at most.
const MOST_CONSTRAINTS: usize = 100;

/// Refuses values that no row could use, and rows of a table that cannot be.
fn possible(
    model: &Model,
    base: &Point,
    design: &mut Design,
    varied: &[Varied],
    entries: &[Field<'_>],
    test: &Section<'_>,
    path: &Path,
) -> Result<(), Error> {
    if let Some(place) = varied.iter().position(|v| quantity::is_beyond_table(v.quantity, &model.chamber.effects)) {
        let message = "is beyond the entries of the model's table: add an entry to the model to vary it";
        return Err(match entries.get(place) {
            Some(entry) => entry.because(message),
            None => Error::Option(format!("{}: column `{}` {message}", path.display(), varied[place].column)),
        });
    }
    if let Design::Table(table) = design {
        let mut point = *base;
        return table.check(varied.iter().map(|v| quantity::all()[v.quantity].allowed.clone()).collect(), |values| {
            for (varied, value) in varied.iter().zip(values) {
                point.0[varied.quantity] = *value;
            }
            check::check(&Bounds::of_point(&point), model)
                .map_err(|refused| format!("{} {}", quantity::all()[refused.quantity].name, refused.message))
        });
    }
    let mut bounds = Bounds::of_point(base);
    for (varied, axis) in varied.iter().zip(design.axes()) {
        bounds.set(varied.quantity, axis.bounds());
    }
    check::check(&bounds, model).map_err(|refused| {
        let name = &quantity::all()[refused.quantity].name;
        let varies = varied.iter().zip(entries).find(|(v, _)| v.quantity == refused.quantity).map(|(_, entry)| *entry);
        let given = || name.strip_prefix("test.").and_then(|key| test.get(key));
        match varies.or_else(given) {
            Some(entry) => entry.because(refused.message),
            None => Error::Option(format!("{}: {name} {}", path.display(), refused.message)),
        }
    })
}

/// A design that is read from a file: each of its columns is a quantity; `columns` picks some of them.
fn table<'a>(study: &Section<'a>, vary: &Section<'a>, path: &Path) -> Result<Points<'a>, Error> {
    if let Some(entry) = vary.entries().find(|entry| entry.key() != CONSTRAINTS) {
        return Err(entry.because("is varied beside a table; make it a column of the table"));
    }
    let entry = study.require("table", "a Parquet or CSV file with a column for each quantity")?;
    let file = beside(path, entry.text()?);
    let mut table = Table::open(&file)?;
    if let Some(entry) = study.get("columns") {
        let wanted = entry.texts()?;
        if let Some(absent) = wanted.iter().find(|name| !table.names().contains(name)) {
            return Err(entry.because(format!("names `{absent}`, which {} does not have", file.display())));
        }
        table.retain(|name| wanted.contains(&name));
    } else {
        table.retain(|name| name != "row");
    }
    let mut list: Vec<Varied> = Vec::new();
    for name in table.names() {
        let place = quantity::find(name).map_err(|reason| {
            let picks = match reason {
                NotFound::Unknown(None) => "; `columns = [...]` in the study picks columns",
                _ => "",
            };
            Error::Table { path: file.clone(), message: format!("column `{name}` {}{picks}", not_found(name, &reason)) }
        })?;
        if list.iter().any(|v| v.quantity == place) {
            let message = format!("column `{name}` is a quantity that another column holds already");
            return Err(Error::Table { path: file.clone(), message });
        }
        list.push(varied(name, place));
    }
    let both = |a: Base, b: Base| [a, b].iter().all(|base| list.iter().any(|v| v.quantity == *base as usize));
    for (a, b) in [
        (Base::VolumeToArea, Base::Bore),
        (Base::VolumeToArea, Base::VolumeToAreaByLength),
        (Base::VolumeToAreaByLength, Base::InitialStroke),
        (Base::VolumeToAreaByLength, Base::FinalStroke),
        (Base::HoldTimeConstants, Base::Duration),
    ] {
        if both(a, b) {
            let [a, b] = [a, b].map(|base| &quantity::all()[base as usize].name);
            let message = format!("columns {a} and {b} set the same thing twice: keep one of the two");
            return Err(Error::Table { path: file.clone(), message });
        }
    }
    let table_sha256 = Some(hash::of_file(&file).map_err(|source| Error::Read { path: file.clone(), source })?);
    Ok(Points { design: Design::Table(table), varied: list, entries: Vec::new(), table_sha256 })
}

/// What [statistics] asks for.
fn plan(study: &Study, section: &Section<'_>) -> Result<Plan, Error> {
    let mut plan = Plan::all(study);
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
        let bins = entry.section()?;
        let from = bins.require("from", "the lower edge")?.finite()?;
        let to = bins.require("to", "the upper edge")?.finite()?;
        let count = bins.require("bins", "the number of bins")?;
        let number = count.whole(1)?;
        bins.finish()?;
        if from >= to {
            return Err(entry.because(format!("runs from {from} to {to}: `from` has to be below `to`")));
        }
        if number > MOST_BINS {
            return Err(count.because(format!("is {number}; at most {MOST_BINS} are allowed")));
        }
        plan.histograms.push((entry.key().to_owned(), Bins { from, to, bins: number }));
    }
    if let Some(entry) = section.get("pareto") {
        let goals = entry.section()?;
        let list = |key: &str| {
            goals.get(key).map_or(Ok(Vec::new()), |entry| {
                let names = entry.texts()?;
                names.iter().try_for_each(|name| known(&entry, name))?;
                Ok::<_, Error>(names.into_iter().map(str::to_owned).collect())
            })
        };
        let found = Goals { minimise: list("minimise")?, maximise: list("maximise")? };
        goals.finish()?;
        let names: Vec<&str> = found.columns().map(|(name, _)| name).collect();
        if !(2..=4).contains(&names.len()) {
            let count = names.len();
            return Err(
                entry.because(format!("names {count} columns in `minimise` and `maximise`: 2 to 4 are expected"))
            );
        }
        if let Some(twice) = records::repeated(&names) {
            return Err(entry.because(format!("names `{twice}` twice")));
        }
        if let Some(absent) = names.iter().find(|name| !plan.columns.iter().any(|column| column == *name)) {
            return Err(entry.because(format!("names `{absent}`, which is none of the `columns` of [statistics]")));
        }
        plan.pareto = Some(found);
    }
    section.finish()?;
    Ok(plan)
}

/// Bins of a histogram at most: each part keeps them all.
const MOST_BINS: u64 = 100_000;

/// Every number that does not vary: the model's, then the test's.
fn base(model: &Model, test: &Section<'_>, varied: &[Varied]) -> Result<Point, Error> {
    let mut base = Point::of_model(model);

    // A misspelt key is said to be one before the key it was meant for is missed.
    for key in quantity::all().iter().filter_map(|q| q.name.strip_prefix("test.")) {
        test.get(key);
    }
    test.finish()?;

    let varies = |base: Base| varied.iter().any(|v| v.quantity == base as usize);
    let take = |base: &mut Point, quantity: Base| -> Result<bool, Error> {
        let q = &quantity::all()[quantity as usize];
        let key = q.name.trim_start_matches("test.");
        let Some(entry) = test.get(key) else { return Ok(varies(quantity)) };
        let value = entry.finite()?;
        if !q.allowed.contains(value) {
            return Err(entry.because(format!("is {}, but has to be {}", shortest(value), q.allowed)));
        }
        base.set(quantity, value);
        Ok(true)
    };
    for quantity in [Base::InitialPressure, Base::InitialStroke, Base::FinalStroke, Base::PushTime] {
        if !take(&mut base, quantity)? {
            let q = &quantity::all()[quantity as usize];
            let key = q.name.trim_start_matches("test.");
            return Err(test.missing(key, &format!("{} in {}, here or in [vary]", q.doc, q.unit)));
        }
    }
    for flow in [Base::MassFlowIn, Base::MassFlowOut] {
        base.set(flow, 0.0);
        take(&mut base, flow)?;
    }
    for temperature in [Base::InitialTemperature, Base::TemperatureIn] {
        take(&mut base, temperature)?;
    }
    match (take(&mut base, Base::Duration)?, take(&mut base, Base::HoldTimeConstants)?) {
        (true, true) => {
            let entry = test.get("hold_time_constants").or_else(|| test.get("duration_s"));
            let message = "duration_s and hold_time_constants both set the length of the test: keep one of the two";
            return Err(entry.map_or_else(|| test.missing("duration_s", message), |entry| entry.because(message)));
        }
        (false, false) => {
            return Err(test.missing("duration_s", "duration_s or hold_time_constants, here or in [vary]"));
        }
        _ => {}
    }
    Ok(base)
}
