//! The FMU's documentation: a page with equations, variables and a worked example, a picture, the licences.

use crate::description::number;
use crate::variables::{Role, Starts, Variable, table};
use chamber::effects;
use std::fmt::Write;

/// The FMU's icon.
pub const ICON: &[u8] = include_bytes!("../../modelDescription/model.png");
const TEMPLATE: &str = include_str!("../../modelDescription/documentation/template.html");
const PICTURE: &str = include_str!("../../modelDescription/documentation/chamber.svg");
const LICENSES: [(&str, &str); 2] = [
    ("licenses/LICENSE-MIT.txt", include_str!("../../LICENSE-MIT")),
    ("licenses/LICENSE-APACHE.txt", include_str!("../../LICENSE-APACHE")),
];

/// Files of the documentation, by name within its folder.
pub fn files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files = vec![("index.html", page().into_bytes()), ("chamber.svg", PICTURE.into())];
    files.extend(LICENSES.map(|(name, text)| (name, text.into())));
    files
}

/// `index.html`: the reviewed template with the tables filled in.
pub fn page() -> String {
    let start = Starts::default();
    let of = |role: fn(&Role) -> bool| -> String {
        table().iter().filter(|v| role(&v.role)).map(|v| row(v, &start)).collect()
    };
    TEMPLATE
        .replace("{{inputs}}", &of(|role| matches!(role, Role::Input(_))))
        .replace("{{outputs}}", &of(|role| matches!(role, Role::Output(_))))
        .replace("{{parameters}}", &of(|role| matches!(role, Role::Parameter(_) | Role::AreaLaw)))
        .replace("{{effects}}", &effects_table())
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
}

fn row(variable: &Variable, start: &Starts) -> String {
    let start = match variable.role {
        Role::Input(i) => number(start.inputs[i]),
        Role::Parameter(i) => number(start.parameters.real[i]),
        Role::AreaLaw => "1 = total, 2 = swept".into(),
        _ => String::new(),
    };
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
    for (_, card) in effects::all() {
        let name = crate::variables::camel(card.name);
        let equation = card.equation.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            rows,
            "<tr><td><code>{name}</code></td><td>{}</td><td>{}</td><td><code>{equation}</code></td><td>{}</td></tr>",
            card.balance, card.doc, card.source
        );
    }
    rows
}
