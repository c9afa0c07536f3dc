//! `modelDescription.xml`, rendered from the one table of variables. The guid is a hash of everything else in it.

use crate::instance::area_law_number;
use crate::refusal::Category;
use crate::snapshot::DEFAULT_TOLERANCE;
use crate::structure::{self, Unknown};
use crate::units::{QUANTITIES, UNITS};
use crate::variables::{Role, Starts, Variability, Variable, output, place, place_of_state, table};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// Name of the library and of the functions' home in the FMU.
pub const MODEL_IDENTIFIER: &str = "Chamber";
/// Communication step that the description proposes, s.
const STEP_S: f64 = 1e-3;
/// Duration that the description proposes, s.
const STOP_S: f64 = 10.0;

/// A description and its guid.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The file.
    pub xml: String,
    /// Its guid, in braces.
    pub guid: String,
}

/// Renders the description of a chamber with these start values. `generated` is a UTC time as in 2026-01-31T12:00:00Z.
pub fn render(starts: &Starts, generated: Option<&str>) -> Description {
    let draft = document(starts, generated, "");
    let hash = Sha256::digest(draft.as_bytes());
    let hex: String = hash[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    let guid = format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]);
    Description { xml: document(starts, generated, &guid), guid }
}

fn document(starts: &Starts, generated: Option<&str>, guid: &str) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    head(&mut xml, generated, guid);
    units(&mut xml);
    types(&mut xml);
    xml += "  <LogCategories>\n    <Category name=\"logAll\" description=\"All of the following\"/>\n";
    for (_, name, description) in Category::ALL {
        line(&mut xml, 4, "Category", &[("name", name.into()), ("description", description.into())], true);
    }
    xml += "  </LogCategories>\n";
    let experiment = [("startTime", 0.0), ("stopTime", STOP_S), ("tolerance", DEFAULT_TOLERANCE), ("stepSize", STEP_S)];
    line(&mut xml, 2, "DefaultExperiment", &experiment.map(|(name, value)| (name, number(value))), true);
    xml += "  <ModelVariables>\n";
    for (i, variable) in table().iter().enumerate() {
        scalar_variable(&mut xml, i, variable, starts);
    }
    xml += "  </ModelVariables>\n";
    model_structure(&mut xml);
    xml += "</fmiModelDescription>\n";
    xml
}

fn head(xml: &mut String, generated: Option<&str>, guid: &str) {
    let mut attributes = vec![
        ("fmiVersion", "2.0".into()),
        ("modelName", MODEL_IDENTIFIER.into()),
        ("guid", guid.into()),
        (
            "description",
            "Gas in a pneumatic cylinder chamber behind a moving piston, with heat transfer to the wall".into(),
        ),
        ("author", "pneutherm".into()),
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("copyright", "The pneutherm authors".into()),
        ("license", "MIT OR Apache-2.0, see documentation/licenses".into()),
        ("generationTool", concat!("pneutherm ", env!("CARGO_PKG_VERSION")).into()),
    ];
    if let Some(generated) = generated {
        attributes.push(("generationDateAndTime", generated.into()));
    }
    attributes.push(("variableNamingConvention", "structured".into()));
    line(xml, 0, "fmiModelDescription", &attributes, false);
    let yes = || "true".to_owned();
    let capabilities = [
        ("modelIdentifier", MODEL_IDENTIFIER.into()),
        ("needsExecutionTool", "false".into()),
        ("canHandleVariableCommunicationStepSize", yes()),
        ("canInterpolateInputs", yes()),
        ("maxOutputDerivativeOrder", "1".into()),
        ("canRunAsynchronuously", "false".into()),
        ("canBeInstantiatedOnlyOncePerProcess", "false".into()),
        ("canNotUseMemoryManagementFunctions", yes()),
        ("canGetAndSetFMUstate", yes()),
        ("canSerializeFMUstate", yes()),
        ("providesDirectionalDerivative", yes()),
    ];
    line(xml, 2, "CoSimulation", &capabilities, true);
}

fn units(xml: &mut String) {
    *xml += "  <UnitDefinitions>\n";
    for unit in UNITS {
        let is_leaf = unit.base.is_none() && unit.displays.is_empty();
        line(xml, 4, "Unit", &[("name", unit.name.into())], is_leaf);
        if let Some(base) = unit.base {
            let exponents: Vec<_> = base.iter().map(|(name, exponent)| (*name, exponent.to_string())).collect();
            line(xml, 6, "BaseUnit", &exponents, true);
        }
        for display in unit.displays {
            let mut attributes = vec![("name", display.name.into()), ("factor", number(display.factor))];
            if display.offset != 0.0 {
                attributes.push(("offset", number(display.offset)));
            }
            line(xml, 6, "DisplayUnit", &attributes, true);
        }
        if !is_leaf {
            *xml += "    </Unit>\n";
        }
    }
    *xml += "  </UnitDefinitions>\n";
}

fn types(xml: &mut String) {
    *xml += "  <TypeDefinitions>\n";
    for quantity in QUANTITIES {
        line(xml, 4, "SimpleType", &[("name", quantity.name.into())], false);
        let mut attributes = vec![("quantity", quantity.name.into()), ("unit", quantity.unit.into())];
        attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
        attributes.extend(quantity.min.map(|min| ("min", number(min))));
        attributes.push(("nominal", number(quantity.nominal)));
        line(xml, 6, "Real", &attributes, true);
        *xml += "    </SimpleType>\n";
    }
    let laws = "Lateral area that exchanges heat, beside both end faces";
    line(xml, 4, "SimpleType", &[("name", "AreaLaw".into()), ("description", laws.into())], false);
    *xml += "      <Enumeration>\n";
    for (name, value, description) in
        [("total", "1", "Of all the gas's volume, dead volume included"), ("swept", "2", "Of the swept length only")]
    {
        let item = [("name", name.into()), ("value", value.into()), ("description", description.into())];
        line(xml, 8, "Item", &item, true);
    }
    *xml += "      </Enumeration>\n    </SimpleType>\n  </TypeDefinitions>\n";
}

fn scalar_variable(xml: &mut String, index: usize, variable: &Variable, starts: &Starts) {
    let causality = match variable.role {
        Role::Input(_) => "input",
        Role::Output(_) => "output",
        Role::Parameter(_) | Role::AreaLaw => "parameter",
        Role::State(_) | Role::Rate(_) => "local",
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Continuous => "continuous",
    };
    let mut attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", index.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    match causality {
        "parameter" => attributes.push(("initial", "exact".into())),
        "output" | "local" => attributes.push(("initial", "calculated".into())),
        _ => {}
    }
    line(xml, 4, "ScalarVariable", &attributes, false);
    if variable.role == Role::AreaLaw {
        let start = area_law_number(starts.parameters.area_law).to_string();
        line(xml, 6, "Enumeration", &[("declaredType", "AreaLaw".into()), ("start", start)], true);
    } else {
        line(xml, 6, "Real", &real_attributes(variable, starts), true);
    }
    *xml += "    </ScalarVariable>\n";
}

fn real_attributes(variable: &Variable, starts: &Starts) -> Vec<(&'static str, String)> {
    let quantity = variable.quantity;
    let mut attributes = vec![("declaredType", quantity.name.into()), ("unit", quantity.unit.into())];
    attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
    attributes.extend(variable.min.map(|min| ("min", number(min))));
    attributes.extend(variable.max.map(|max| ("max", number(max))));
    attributes.push(("nominal", number(variable.nominal)));
    match variable.role {
        Role::Input(i) => attributes.push(("start", number(starts.inputs[i]))),
        Role::Parameter(i) => attributes.push(("start", number(starts.parameters.real[i]))),
        Role::Rate(state) => attributes.extend(place_of_state(state).map(|i| ("derivative", (i + 1).to_string()))),
        _ => {}
    }
    attributes
}

fn model_structure(xml: &mut String) {
    let outputs = structure::between_steps(|role| matches!(role, Role::Output(_)));
    let rates = structure::between_steps(|role| matches!(role, Role::Rate(_)));
    *xml += "  <ModelStructure>\n";
    for (name, unknowns) in
        [("Outputs", outputs), ("Derivatives", rates), ("InitialUnknowns", structure::in_initialization())]
    {
        let _ = writeln!(xml, "    <{name}>");
        for Unknown { variable, dependencies } in unknowns {
            let dependencies: Vec<String> = dependencies.iter().map(|i| (i + 1).to_string()).collect();
            let attributes = [("index", (variable + 1).to_string()), ("dependencies", dependencies.join(" "))];
            line(xml, 6, "Unknown", &attributes, true);
        }
        let _ = writeln!(xml, "    </{name}>");
    }
    *xml += "  </ModelStructure>\n";
    debug_assert!(place(Role::Output(output::MASS)).is_some());
}

/// One opening (or, for a leaf, whole) tag on a line of its own.
fn line(xml: &mut String, indent: usize, tag: &str, attributes: &[(&str, String)], leaf: bool) {
    let _ = write!(xml, "{:indent$}<{tag}", "");
    for (name, value) in attributes {
        let _ = write!(xml, " {name}=\"{}\"", escaped(value));
    }
    *xml += if leaf { "/>\n" } else { ">\n" };
}

/// Text as an attribute's value.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The shortest decimal that reads back to the same number.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e7).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}
