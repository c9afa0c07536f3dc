//! `[vary]` of a study file: the varied quantities, and their values or distributions.

use super::constraints;
use super::names;
use super::section::{Entry, Section};
use crate::error::Error;
use crate::quantity::axis::{Axis, Scale};
use crate::quantity::copula::Copula;
use crate::quantity::distribution::{Distribution, Limits};
use crate::quantity::uncertain::{self, Parameter, Uncertain};
use crate::quantity::{self, Base};
use crate::result::outputs;
use crate::study::Varied;
use records::Field;
use report::number::shortest;

/// Names of the distributions in study files.
const DISTRIBUTIONS: [(&str, Kind); 6] = [
    ("normal", Kind::Normal),
    ("log-normal", Kind::LogNormal),
    ("lognormal", Kind::LogNormal),
    ("uniform", Kind::Uniform),
    ("triangular", Kind::Triangular),
    ("empirical", Kind::Empirical),
];

#[derive(Clone, Copy)]
enum Kind {
    Normal,
    LogNormal,
    Uniform,
    Triangular,
    Empirical,
}

impl Kind {
    /// Its allowed keys.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Kind::Normal => &["distribution", "mean", "sd", "from", "to"],
            Kind::LogNormal => &["distribution", "median", "sd_log", "mean", "sd", "from", "to"],
            Kind::Uniform => &["distribution", "from", "to"],
            Kind::Triangular => &["distribution", "from", "mode", "to"],
            Kind::Empirical => &["distribution", "values"],
        }
    }
}

/// A varied quantity, and its entry in the study.
pub struct VariedAxis<'a> {
    /// The entry of `[vary]`, for error messages.
    pub entry: Field<'a>,
    /// The quantity and its column.
    pub varied: Varied,
    /// A list or a range of its levels.
    pub axis: Axis,
    /// Whether it is drawn from the model's uncertainty.
    of_model: bool,
}

/// All axes of [vary], in the order of the file, and the correlations of those drawn from the model.
pub fn axes<'a>(
    vary: &Section<'a>,
    model: &Result<Uncertain, String>,
) -> Result<(Vec<VariedAxis<'a>>, Option<Copula>), Error> {
    let mut found: Vec<VariedAxis<'a>> = Vec::new();
    let mut add = |new: VariedAxis<'a>| {
        let quantity = new.varied.quantity;
        if let Some(other) = found.iter().find(|other| other.varied.quantity == quantity) {
            let (line, name) = (other.entry.line(), &quantity::all()[quantity].name);
            return Err(new.entry.because(format!("repeats {name}, which line {line} varies already")));
        }
        found.push(new);
        Ok(())
    };
    for (entry, name) in leaves(vary, "")?.into_iter().filter(|(_, name)| name != constraints::KEY) {
        if name == "from" {
            for Parameter { quantity, distribution, .. } in &all_of_model(entry, model)?.parameters {
                let column = quantity::all()[*quantity].name.clone();
                let varied = Varied { column, quantity: *quantity };
                add(VariedAxis { entry, varied, axis: Axis::Drawn(distribution.clone()), of_model: true })?;
            }
            continue;
        }
        let quantity = names::find(&name).map_err(|reason| entry.because(reason.message(&name)))?;
        let (axis, of_model) = axis(entry, quantity, model)?;
        add(VariedAxis { entry, varied: varied(&name, quantity), axis, of_model })?;
    }
    refuse_contradictions(&found)?;
    let copula = copula(&found, model)?;
    Ok((found, copula))
}

/// The parameters included by `from = "model"` of [vary].
fn all_of_model(entry: Field<'_>, model: &Result<Uncertain, String>) -> Result<Uncertain, Error> {
    entry.choice(&[("model", ())])?;
    let known = known(entry, model)?.marginal(|parameter| !quantity::is_of_recorded_stroke(parameter.quantity));
    if known.parameters.is_empty() {
        return Err(entry.because("draws nothing: no parameter in the model's [uncertainty] has a variance"));
    }
    Ok(known)
}

fn known<'m>(entry: Field<'_>, model: &'m Result<Uncertain, String>) -> Result<&'m Uncertain, Error> {
    model.as_ref().map_err(|why| entry.because(format!("cannot be drawn from the model, which {why}")))
}

/// The correlations of the axes drawn from the model.
fn copula(found: &[VariedAxis<'_>], model: &Result<Uncertain, String>) -> Result<Option<Copula>, Error> {
    let columns: Vec<usize> = (0..found.len()).filter(|i| found[*i].of_model).collect();
    let (Some(first), Ok(model)) = (columns.first(), model) else { return Ok(None) };
    let entry = found[*first].entry;
    // In column order.
    let index = |column: &usize| model.parameters.iter().position(|p| p.quantity == found[*column].varied.quantity);
    let indices: Vec<usize> = columns.iter().filter_map(index).collect();
    let correlation = model.correlation.select_rows(&indices).select_columns(&indices);
    uncertain::copula(columns, &correlation)
        .map(Some)
        .map_err(|why| entry.because(format!("cannot be drawn from the model, which {why}")))
}

/// Refuses quantities that set the same thing twice.
fn refuse_contradictions(found: &[VariedAxis<'_>]) -> Result<(), Error> {
    let conflict = |a: Base, b: Base| {
        let at = |base: Base| found.iter().find(|f| f.varied.quantity == base as usize).map(|f| f.entry);
        Some((at(a)?, at(b)?))
    };
    if let Some((entry, _)) = conflict(Base::VolumeToArea, Base::Bore) {
        return Err(entry.because("is what the bore is solved from; vary one of the two"));
    }
    if let Some((entry, _)) = conflict(Base::VolumeToAreaByLength, Base::VolumeToArea) {
        return Err(entry.because("volume_to_area_by_length_m and volume_to_area_m are one quantity, solved for in two ways; vary one of the two"));
    }
    for stroke in [Base::InitialStroke, Base::FinalStroke] {
        if let Some((entry, _)) = conflict(Base::VolumeToAreaByLength, stroke) {
            return Err(entry.because("is what both strokes are solved from: give them in [test]"));
        }
    }
    if let Some((entry, _)) = conflict(Base::HoldTimeConstants, Base::Duration) {
        return Err(
            entry.because("hold_time_constants and duration_s both set the length of the test; vary one of the two")
        );
    }
    Ok(())
}

/// The quantity with its column name: as in the study, unless another column has that name.
pub fn varied(name: &str, quantity: usize) -> Varied {
    let full = &quantity::all()[quantity].name;
    let taken = quantity != Base::VolumeToArea as usize && outputs::is_output(name);
    Varied { column: if taken { full.clone() } else { name.to_owned() }, quantity }
}

/// The entries that describe an axis, with their dotted names: `a.b_m = {…}` without quotes is a nested table.
fn leaves<'a>(section: &Section<'a>, prefix: &str) -> Result<Vec<(Field<'a>, String)>, Error> {
    let mut found = Vec::new();
    for entry in section.entries() {
        let name = if prefix.is_empty() { entry.key().to_owned() } else { format!("{prefix}.{}", entry.key()) };
        let nested = entry
            .table()
            .is_ok_and(|table| table.fields().next().is_some() && table.fields().all(|field| field.table().is_ok()));
        if nested {
            found.extend(leaves(&entry.section()?, &name)?);
        } else {
            found.push((entry, name));
        }
    }
    Ok(found)
}

/// The values of an entry, and whether they are drawn from the model's uncertainty.
fn axis(entry: Field<'_>, quantity: usize, model: &Result<Uncertain, String>) -> Result<(Axis, bool), Error> {
    const FORMS: &str = "{ values = [...] }, { from = ..., to = ..., count = ..., scale = \"linear\" }, \
        { distribution = \"normal\", mean = ..., sd = ... } or { from = \"model\" }";
    let section = Section::new(entry.table().map_err(|_| entry.not(FORMS))?);
    // Examined without requesting the key: a list of values has no `from`.
    if let Some(from) = section.entries().find(|entry| entry.key() == "from" && entry.is_text()) {
        section.get("from");
        from.choice(&[("model", ())])?;
        section.finish()?;
        return of_model(entry, quantity, model).map(|axis| (axis, true));
    }
    let allowed = &quantity::all()[quantity].allowed;
    let axis = match section.get("distribution") {
        Some(name) => drawn(entry, name.choice(&DISTRIBUTIONS)?, &section)?,
        None => listed(entry, &section, FORMS)?,
    };
    section.finish()?;
    let bounds = axis.bounds();
    let drawn = matches!(axis, Axis::Drawn(_));
    match [*bounds.start(), *bounds.end()].into_iter().find(|value| !allowed.contains(*value)) {
        None => Ok((axis, false)),
        Some(value) if drawn => Err(entry
            .because(format!("reaches {value:.6e}, but has to be {allowed}: `from` and `to` truncate a distribution"))),
        Some(value) => Err(entry.because(format!("takes {}, but has to be {allowed}", shortest(value)))),
    }
}

/// The model's distribution of a quantity.
fn of_model(entry: Field<'_>, quantity: usize, model: &Result<Uncertain, String>) -> Result<Axis, Error> {
    let known = known(entry, model)?;
    let parameter = known.parameters.iter().find(|parameter| parameter.quantity == quantity).ok_or_else(|| {
        let names: Vec<_> = known.parameters.iter().map(|p| quantity::all()[p.quantity].name.as_str()).collect();
        let names = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        entry.because(format!("has no variance in the model's [uncertainty], which knows that of {names}"))
    })?;
    Ok(Axis::Drawn(parameter.distribution.clone()))
}

/// A list of values or a range.
fn listed(entry: Field<'_>, section: &Section<'_>, forms: &str) -> Result<Axis, Error> {
    if let Some(values) = section.get("values") {
        return Ok(Axis::Values { values: values.some_numbers()? });
    }
    let (Some(from), Some(to)) = (section.get("from"), section.get("to")) else {
        section.get("count");
        section.get("scale");
        section.finish()?;
        return Err(entry.because(format!("is incomplete; expected {forms}")));
    };
    let (from, to) = (from.finite()?, to.finite()?);
    let scale =
        section.get("scale").map(|e| e.choice(&[("linear", Scale::Linear), ("log", Scale::Log)])).transpose()?;
    let scale = scale.unwrap_or(Scale::Linear);
    let count = section.get("count").map(|e| e.whole(2)).transpose()?;
    section.finish()?;
    range(entry, from, to, count, scale)
}

fn range(entry: Field<'_>, from: f64, to: f64, count: Option<u64>, scale: Scale) -> Result<Axis, Error> {
    if from >= to {
        return Err(entry.because(format!("runs from {from} to {to}: `from` has to be below `to`")));
    }
    if scale == Scale::Log && from <= 0.0 {
        return Err(entry.because(format!("runs from {from}: a logarithmic scale needs a value above 0")));
    }
    Ok(Axis::Range { from, to, count, scale })
}

/// A distribution by its name and its parameters.
fn drawn(entry: Field<'_>, kind: Kind, section: &Section<'_>) -> Result<Axis, Error> {
    // Reports a misspelt key rather than a missing one.
    section.allow(kind.keys())?;
    let optional = |key: &str| section.get(key).map(|entry| entry.finite()).transpose();
    let number = |key: &str, expected: &str| section.require(key, expected)?.finite();
    let limits = || Ok::<_, Error>(Limits { from: optional("from")?, to: optional("to")? });
    let distribution = match kind {
        Kind::Uniform => {
            let (from, to) = (number("from", "the least value")?, number("to", "the greatest value")?);
            return range(entry, from, to, None, Scale::Linear);
        }
        Kind::Normal => {
            let mean = number("mean", "the mean")?;
            let sd = number("sd", "the standard deviation")?;
            Distribution::Normal { mean, sd, limits: limits()? }
        }
        Kind::LogNormal => {
            let (median, sd_log) = log_normal(entry, section)?;
            Distribution::LogNormal { median, sd_log, limits: limits()? }
        }
        Kind::Triangular => Distribution::Triangular {
            from: number("from", "the least value")?,
            mode: number("mode", "the most probable value")?,
            to: number("to", "the greatest value")?,
        },
        Kind::Empirical => {
            let mut values = section.require("values", "the measured values")?.some_numbers()?;
            values.sort_by(f64::total_cmp);
            Distribution::Empirical { values }
        }
    };
    match distribution.problem() {
        Some(problem) => Err(entry.because(problem)),
        None => Ok(Axis::Drawn(distribution)),
    }
}

/// Median and logarithmic standard deviation, given directly or through the quantity's mean and standard deviation.
fn log_normal(entry: Field<'_>, section: &Section<'_>) -> Result<(f64, f64), Error> {
    let optional = |key: &str| section.get(key).map(|entry| entry.finite()).transpose();
    match (optional("median")?, optional("sd_log")?, optional("mean")?, optional("sd")?) {
        (Some(median), Some(sd_log), None, None) => Ok((median, sd_log)),
        (None, None, Some(mean), Some(sd)) if mean > 0.0 && sd > 0.0 => {
            let variance_log = (sd / mean).powi(2).ln_1p();
            Ok((mean * (-0.5 * variance_log).exp(), variance_log.sqrt()))
        }
        (None, None, Some(mean), Some(sd)) => {
            Err(entry.because(format!("has a mean of {mean} and an `sd` of {sd}: both have to be above 0")))
        }
        _ => Err(entry.because("takes either `median` and `sd_log` or `mean` and `sd`")),
    }
}
