//! The points of a study: from the axes in `[vary]`, or from the rows of a table.

use super::check::{self, Bounds};
use super::constraints;
use super::names::{self, NotFound};
use super::section::{Entry, Section};
use super::size;
use super::vary::{self, VariedAxis, varied};
use crate::design::table::Table;
use crate::design::{Axes, Design, NAMES, sobol};
use crate::error::Error;
use crate::hash;
use crate::quantity::axis::Axis;
use crate::quantity::copula::Copula;
use crate::quantity::point::Point;
use crate::quantity::uncertain::Uncertain;
use crate::quantity::{self, Base};
use crate::study::Varied;
use ensemble::Solver;
use records::{Field, Model};
use std::path::Path;

/// The points, and the quantities that vary.
pub struct Points<'a> {
    /// The design that generates the points.
    pub design: Design,
    /// Number of points.
    pub rows: u64,
    /// The varied quantities, in column order.
    pub varied: Vec<Varied>,
    /// Entries of `[vary]`, for error messages; empty for a table.
    entries: Vec<Field<'a>>,
    /// SHA-256 of a table's file.
    pub table_sha256: Option<String>,
}

impl Points<'_> {
    /// Refuses values that no row could use, and invalid rows of a table; `base` holds the fixed values.
    pub fn check(
        &mut self,
        model: &Model,
        base: &Point,
        solver: Solver,
        test: &Section<'_>,
        path: &Path,
    ) -> Result<(), Error> {
        let Self { design, varied, entries, .. } = self;
        let is_beyond = |v: &Varied| quantity::is_beyond_table(v.quantity, &model.chamber.effects);
        if let Some(index) = varied.iter().position(is_beyond) {
            let message = "is beyond the entries of the model's table: add an entry to the model to vary it";
            return Err(match entries.get(index) {
                Some(entry) => entry.because(message),
                None => Error::Option(format!("{}: column `{}` {message}", path.display(), varied[index].column)),
            });
        }
        if let Design::Table(table) = design {
            let mut point = *base;
            return table.check(
                varied.iter().map(|v| quantity::all()[v.quantity].allowed.clone()).collect(),
                |values| {
                    for (varied, value) in varied.iter().zip(values) {
                        point.0[varied.quantity] = *value;
                    }
                    check::check(&Bounds::of_point(&point), model, solver)
                        .map_err(|refused| format!("{} {}", quantity::all()[refused.quantity].name, refused.message))
                },
            );
        }
        let mut bounds = Bounds::of_point(base);
        for (varied, axis) in varied.iter().zip(design.axes()) {
            bounds.set(varied.quantity, axis.bounds());
        }
        check::check(&bounds, model, solver).map_err(|refused| {
            let name = &quantity::all()[refused.quantity].name;
            let varies = varied.iter().zip(entries).find(|(v, _)| v.quantity == refused.quantity).map(|(_, e)| *e);
            let given = || name.strip_prefix("test.").and_then(|key| test.get(key));
            match varies.or_else(given) {
                Some(entry) => entry.because(refused.message),
                None => Error::Option(format!("{}: {name} {}", path.display(), refused.message)),
            }
        })
    }
}

/// The points: from `[vary]` or, for a table, from its columns.
pub fn read<'a>(
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
    refuse_axes(vary, entry, name, &found, copula.as_ref())?;
    let samples = || {
        let entry = study.require("samples", &format!("the number of samples of a \"{name}\" design"))?;
        size::checked_rows(entry, Some(entry.whole(1)?))
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
    let asks = study.get("samples").filter(|_| name != "factorial").unwrap_or(entry);
    let rows = size::checked_rows(asks, design.rows())?;
    Ok(Points { design, rows, varied, entries, table_sha256: None })
}

/// Refuses axes that a design cannot have: none, too many dimensions, or unsupported levels or correlations.
fn refuse_axes(
    vary: &Section<'_>,
    entry: Field<'_>,
    name: &str,
    found: &[VariedAxis<'_>],
    copula: Option<&Copula>,
) -> Result<(), Error> {
    if found.is_empty() {
        return Err(vary.because("names no quantity; at least one quantity to vary is needed"));
    }
    if name == "factorial"
        && let Some(VariedAxis { entry, axis, .. }) = found.iter().find(|found| found.axis.levels().is_none())
    {
        return Err(entry.because(match axis {
            Axis::Drawn(_) => {
                "is a distribution, which has no levels: design = \"sobol\", \"latin-hypercube\" or \"saltelli\" draws from it"
            }
            _ => "needs a `count` of levels in a factorial design",
        }));
    }
    if name == "saltelli" && copula.is_some_and(Copula::is_correlated) {
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
    Ok(())
}

/// A design read from a file: each of its columns is a quantity; `columns` selects some of them.
fn table<'a>(study: &Section<'a>, vary: &Section<'a>, path: &Path) -> Result<Points<'a>, Error> {
    if let Some(entry) = vary.entries().find(|entry| entry.key() != constraints::KEY) {
        return Err(entry.because("is varied beside a table; make it a column of the table"));
    }
    let entry = study.require("table", "a Parquet or CSV file with a column for each quantity")?;
    let file = entry.path_beside(path)?;
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
        let quantity = names::find(name).map_err(|reason| {
            let picks = match reason {
                NotFound::Unknown(None) => "; `columns = [...]` in the study picks columns",
                _ => "",
            };
            Error::table(&file, format!("column `{name}` {}{picks}", reason.message(name)))
        })?;
        if list.iter().any(|v| v.quantity == quantity) {
            let message = format!("column `{name}` is a quantity that another column holds already");
            return Err(Error::table(&file, message));
        }
        list.push(varied(name, quantity));
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
            return Err(Error::table(&file, message));
        }
    }
    let table_sha256 = Some(hash::of_file(&file).map_err(Error::reading(&file))?);
    let rows = size::checked_rows(entry, Some(table.rows()))?;
    Ok(Points { design: Design::Table(table), rows, varied: list, entries: Vec::new(), table_sha256 })
}
