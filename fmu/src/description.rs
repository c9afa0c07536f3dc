//! The parts of `modelDescription.xml` common to both FMI versions, rendered from the one table of variables. A [`Dialect`]
//! provides what differs. The guid, in FMI 3.0 the instantiation token, is a hash of everything else.

use crate::identity::Identity;
use crate::plant::motion_source::EXPERIMENT_S;
use crate::plant::simulation::DEFAULT_TOLERANCE;
use crate::plant::values::Starts;
use crate::protocol::message::Category;
use crate::table::choices::ENUMERATIONS;
use crate::table::index_of_state;
use crate::table::structure::{self, Unknown};
use crate::table::units::{QUANTITIES, Quantity, UNITS};
use crate::table::variable::{Enumeration, Role, Variability, Variable};
use crate::table::{STEP_S, settable, table};
use crate::xml::{line, number};
use sha2::{Digest, Sha256};

/// Attributes of a tag, in order.
pub type Attributes = Vec<(&'static str, String)>;

/// A description and its guid.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The complete `modelDescription.xml`.
    pub xml: String,
    /// Hash of the rest, in braces: the guid, or the instantiation token of FMI 3.0.
    pub guid: String,
}

/// What differs between FMI versions.
pub trait Dialect {
    /// `fmiVersion`.
    const VERSION: &'static str;
    /// Name of the guid attribute.
    const GUID: &'static str;

    /// Further attributes of the root element.
    fn more() -> Attributes {
        Vec::new()
    }
    /// Capabilities for Model Exchange and co-simulation.
    fn capabilities(xml: &mut String, identifier: &str);
    /// The type of a quantity.
    fn quantity(xml: &mut String, quantity: &Quantity);
    /// The type of a choice.
    fn enumeration(xml: &mut String, enumeration: &Enumeration);
    /// A variable of the table; `attributes` are those common to all types.
    fn variable(xml: &mut String, variable: &Variable, attributes: Attributes, starts: &Starts);
    /// Variables after those of the table.
    fn further_variables(_xml: &mut String) {}
    /// Dependencies of outputs, of rates, and of the variables calculated in initialization.
    fn structure(xml: &mut String, unknowns: [Vec<Unknown>; 3]);
}

/// Renders the description of a chamber with these start values. `generated` is a UTC time such as 2026-01-31T12:00:00Z.
pub fn render<D: Dialect>(identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
    let hash = Sha256::digest(document::<D>(identity, starts, generated, "").as_bytes());
    let hex: String = hash[..16].iter().map(|byte| format!("{byte:02x}")).collect();
    let guid = format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]);
    Description { xml: document::<D>(identity, starts, generated, &guid), guid }
}

fn document<D: Dialect>(identity: &Identity, starts: &Starts, generated: Option<&str>, guid: &str) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    line(&mut xml, 0, "fmiModelDescription", &about::<D>(identity, generated, guid), false);
    D::capabilities(&mut xml, &identity.identifier);
    units(&mut xml);
    xml += "  <TypeDefinitions>\n";
    QUANTITIES.iter().for_each(|quantity| D::quantity(&mut xml, quantity));
    ENUMERATIONS.iter().for_each(|enumeration| D::enumeration(&mut xml, enumeration));
    xml += "  </TypeDefinitions>\n";
    xml += "  <LogCategories>\n    <Category name=\"logAll\" description=\"All of the following\"/>\n";
    for (_, name, description) in Category::ALL {
        line(&mut xml, 4, "Category", &[("name", name.into()), ("description", description.into())], true);
    }
    xml += "  </LogCategories>\n";
    let experiment =
        [("startTime", 0.0), ("stopTime", EXPERIMENT_S), ("tolerance", DEFAULT_TOLERANCE), ("stepSize", STEP_S)];
    line(&mut xml, 2, "DefaultExperiment", &experiment.map(|(name, value)| (name, number(value))), true);
    xml += "  <ModelVariables>\n";
    for (reference, variable) in table().iter().enumerate() {
        D::variable(&mut xml, variable, common(reference, variable), starts);
    }
    D::further_variables(&mut xml);
    xml += "  </ModelVariables>\n  <ModelStructure>\n";
    let outputs = structure::between_steps(|role| matches!(role, Role::Output(_)));
    let rates = structure::between_steps(|role| matches!(role, Role::Rate(_)));
    D::structure(&mut xml, [outputs, rates, structure::in_initialization()]);
    xml + "  </ModelStructure>\n</fmiModelDescription>\n"
}

fn about<D: Dialect>(identity: &Identity, generated: Option<&str>, guid: &str) -> Attributes {
    let description = "Gas in a pneumatic cylinder chamber behind a moving piston, with heat transfer to the wall";
    let mut attributes = vec![
        ("fmiVersion", D::VERSION.into()),
        ("modelName", identity.name.clone()),
        (D::GUID, guid.into()),
        ("description", description.into()),
        ("author", "pneutherm".into()),
        ("version", env!("CARGO_PKG_VERSION").into()),
        ("copyright", "The pneutherm authors".into()),
        ("license", "MIT OR Apache-2.0, see documentation/licenses".into()),
        ("generationTool", concat!("pneutherm ", env!("CARGO_PKG_VERSION")).into()),
    ];
    attributes.extend(generated.map(|generated| ("generationDateAndTime", generated.into())));
    attributes.push(("variableNamingConvention", "structured".into()));
    attributes.extend(D::more());
    attributes
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

/// Attributes common to variables of all types.
fn common(reference: usize, variable: &Variable) -> Attributes {
    let (causality, initial) = match variable.role {
        Role::Input(_) => ("input", None),
        Role::Output(_) => ("output", Some("calculated")),
        Role::Parameter(_) | Role::Choice(_) => ("parameter", Some("exact")),
        Role::State(_) | Role::Rate(_) => ("local", Some("calculated")),
    };
    let variability = match variable.variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Continuous => "continuous",
    };
    let mut attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial.into())));
    attributes
}

/// Attributes of a quantity in its type definition.
pub fn of_quantity(quantity: &Quantity) -> Attributes {
    let mut attributes = unit(quantity);
    attributes.extend(quantity.min.map(|min| ("min", number(min))));
    attributes.push(("nominal", number(quantity.nominal)));
    attributes
}

fn unit(quantity: &Quantity) -> Attributes {
    let display = quantity.display.map(|display| ("displayUnit", display.into()));
    quantity.unit_attribute().into_iter().chain(display).collect()
}

/// Attributes of a real variable. A rate names its state by index, counted from `first`.
pub fn of_real(variable: &Variable, starts: &Starts, first: usize) -> Attributes {
    let mut attributes = vec![("declaredType", variable.quantity.name.into())];
    attributes.extend(unit(variable.quantity));
    attributes.extend(variable.min.map(|min| ("min", number(min))));
    attributes.extend(variable.max.map(|max| ("max", number(max))));
    attributes.push(("nominal", number(variable.nominal)));
    attributes.extend(settable(starts, variable.role).map(|start| ("start", number(start))));
    if let Role::Rate(state) = variable.role {
        attributes.extend(index_of_state(state).map(|index| ("derivative", (first + index).to_string())));
    }
    attributes
}

/// Attributes of a choice's type.
pub fn of_enumeration(enumeration: &Enumeration) -> Attributes {
    vec![("name", enumeration.name.into()), ("description", enumeration.description.into())]
}

/// The items of a choice.
pub fn items(xml: &mut String, indent: usize, enumeration: &Enumeration) {
    for (value, (name, description)) in enumeration.items.iter().enumerate() {
        let value = (value + 1).to_string();
        let item = [("name", (*name).into()), ("value", value), ("description", (*description).into())];
        line(xml, indent, "Item", &item, true);
    }
}

/// The dependencies of an unknown, with variables counted from `first`.
pub fn dependencies(unknown: &Unknown, first: usize) -> String {
    let indices: Vec<String> = unknown.dependencies.iter().map(|index| (first + index).to_string()).collect();
    indices.join(" ")
}
