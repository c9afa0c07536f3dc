//! The FMU's documentation: a page with equations, variables and a worked example, a picture, and the licences.

use super::validation::Validation;
use crate::identity::Identity;
use crate::plant::values::Starts;
use crate::table::effects::{camel, effects_here};
use crate::table::variable::{Role, Variable};
use crate::table::{settable, table};
use crate::xml::number;
use report::page::escaped;
use std::fmt::Write;

/// The FMU's icon.
pub const ICON: &[u8] = include_bytes!("../../../modelDescription/model.png");
/// A terminal's icon.
pub const TERMINAL: &[u8] = include_bytes!("../../../modelDescription/terminal.png");
const TEMPLATE: &str = include_str!("../../../modelDescription/documentation/template.html");
const PICTURE: &str = include_str!("../../../modelDescription/documentation/chamber.svg");
const LICENSES: [(&str, &str); 3] = [
    ("licenses/LICENSE-MIT.txt", include_str!("../../../LICENSE-MIT")),
    ("licenses/LICENSE-APACHE.txt", include_str!("../../../LICENSE-APACHE")),
    ("licenses/THIRD-PARTY.md", include_str!("../../../THIRD-PARTY.md")),
];

/// Origin of a model's numbers. SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// The diagnosis's verdict on the model, as a sentence.
    pub verdict: Option<String>,
    /// Error relative to the record, Pa rms, of the paper's model and of this one.
    pub error_pa: Option<[f64; 2]>,
    /// 95 % intervals, by parameter names of the FMU.
    pub intervals: Vec<(String, [f64; 2])>,
    /// Records used for the identification.
    pub records: Vec<String>,
}

/// Files of the documentation with that page, by name within their folder.
pub fn files(page: String) -> Vec<(&'static str, Vec<u8>)> {
    let mut files = vec![("index.html", page.into_bytes()), ("chamber.svg", PICTURE.into())];
    files.extend(LICENSES.map(|(name, text)| (name, text.into())));
    files
}

/// `index.html`: the reviewed template with the tables filled in.
pub fn page(identity: &Identity, start: &Starts, about: &About, validations: &[Validation]) -> String {
    let of = |role: fn(&Role) -> bool| -> String {
        table().iter().filter(|v| role(&v.role)).map(|v| row(v, start, about)).collect()
    };
    TEMPLATE
        .replace("{{inputs}}", &of(|role| matches!(role, Role::Input(_))))
        .replace("{{outputs}}", &of(|role| matches!(role, Role::Output(_))))
        .replace("{{parameters}}", &of(|role| matches!(role, Role::Parameter(_) | Role::Choice(_))))
        .replace("{{effects}}", &effects_table())
        .replace("{{about}}", &origin(about, validations))
        .replace("{{name}}", &escaped(&identity.name))
        .replace("{{identifier}}", &identity.identifier)
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
}

/// Origin of the numbers, in HTML.
fn origin(about: &About, validations: &[Validation]) -> String {
    let mut text = String::new();
    if *about == About::default() {
        text += "<p>The model file names no records: its author chose the numbers.</p>\n";
    }
    if let Some(verdict) = &about.verdict {
        let _ = writeln!(text, "<p>Diagnosis: {}</p>", escaped(verdict));
    }
    if let Some([before, after]) = about.error_pa {
        let _ = writeln!(
            text,
            "<p>Error on the records: {before:.0} Pa rms with the paper's model, {after:.0} Pa rms with this model.</p>"
        );
    }
    if !about.records.is_empty() {
        let records: Vec<String> = about.records.iter().map(|name| format!("<code>{}</code>", escaped(name))).collect();
        let _ = writeln!(text, "<p>Identified from the records {}.</p>", records.join(", "));
    }
    for validation in validations {
        let _ = writeln!(text, "<p>Compared with the record {}.</p>", escaped(&validation.summary()));
    }
    text
}

fn row(variable: &Variable, start: &Starts, about: &About) -> String {
    let mut start = settable(start, variable.role).map(number).unwrap_or_default();
    if let Some((_, [low, high])) = about.intervals.iter().find(|(name, _)| *name == variable.name) {
        let _ = write!(start, "<br>{low:.3e} to {high:.3e} (95&nbsp;%)");
    }
    let bound = |bound: Option<f64>| bound.map(number).unwrap_or_default();
    let unit = if variable.quantity.unit == "1" { "" } else { variable.quantity.unit };
    let when = format!("{:?}", variable.variability).to_lowercase();
    format!(
        "<tr><td><code>{}</code></td><td>{unit}</td><td>{start}</td><td>{}</td><td>{}</td><td>{when}</td><td>{}</td></tr>\n",
        variable.name,
        bound(variable.min),
        bound(variable.max),
        variable.description
    )
}

fn effects_table() -> String {
    let mut rows = String::new();
    for (_, card) in effects_here() {
        let name = camel(card.name);
        let equation = escaped(card.equation);
        let _ = writeln!(
            rows,
            "<tr><td><code>{name}</code></td><td>{}</td><td>{}</td><td><code>{equation}</code></td><td>{}</td></tr>",
            card.balance, card.doc, card.source
        );
    }
    rows
}
