//! `modelDescription.xml`, rendered from the one table of variables. The guid is a hash of everything else in it.

use crate::package::experiment;
use crate::package::identity::Identity;
use crate::plant::corners::CORNERS;
use crate::plant::simulation::DEFAULT_TOLERANCE;
use crate::plant::values::Starts;
use crate::protocol::message::Category;
use crate::table::structure::{self, Unknown};
use crate::table::units::{QUANTITIES, UNITS};
use crate::table::{ENUMERATIONS, Role, STEP_S, Type, Variability, Variable, place_of_state, settable, table};
use crate::xml::{Description, described, line, number};
use std::fmt::Write;

/// Renders the description of a chamber with these start values. `generated` is a UTC time as in 2026-01-31T12:00:00Z.
pub fn render(identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
    described(|guid| document(identity, starts, generated, guid))
}

fn document(identity: &Identity, starts: &Starts, generated: Option<&str>, guid: &str) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    head(&mut xml, identity, generated, guid);
    units(&mut xml);
    types(&mut xml);
    xml += "  <LogCategories>\n    <Category name=\"logAll\" description=\"All of the following\"/>\n";
    for (_, name, description) in Category::ALL {
        line(&mut xml, 4, "Category", &[("name", name.into()), ("description", description.into())], true);
    }
    xml += "  </LogCategories>\n";
    let experiment = [
        ("startTime", 0.0),
        ("stopTime", experiment::DURATION_S),
        ("tolerance", DEFAULT_TOLERANCE),
        ("stepSize", STEP_S),
    ];
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

fn head(xml: &mut String, identity: &Identity, generated: Option<&str>, guid: &str) {
    let mut attributes = vec![
        ("fmiVersion", "2.0".into()),
        ("modelName", identity.name.clone()),
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
    attributes.push(("numberOfEventIndicators", CORNERS.to_string()));
    line(xml, 0, "fmiModelDescription", &attributes, false);
    let yes = || "true".to_owned();
    let exchange = [
        ("modelIdentifier", identity.identifier.clone()),
        ("needsExecutionTool", "false".into()),
        ("completedIntegratorStepNotNeeded", "false".into()),
        ("canBeInstantiatedOnlyOncePerProcess", "false".into()),
        ("canNotUseMemoryManagementFunctions", yes()),
        ("canGetAndSetFMUstate", yes()),
        ("canSerializeFMUstate", yes()),
        ("providesDirectionalDerivative", yes()),
    ];
    line(xml, 2, "ModelExchange", &exchange, true);
    let capabilities = [
        ("modelIdentifier", identity.identifier.clone()),
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
        let mut attributes = vec![("quantity", quantity.name.into())];
        attributes.extend(quantity.unit_attribute());
        attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
        attributes.extend(quantity.min.map(|min| ("min", number(min))));
        attributes.push(("nominal", number(quantity.nominal)));
        line(xml, 6, "Real", &attributes, true);
        *xml += "    </SimpleType>\n";
    }
    for enumeration in ENUMERATIONS {
        let attributes = [("name", enumeration.name.into()), ("description", enumeration.description.into())];
        line(xml, 4, "SimpleType", &attributes, false);
        *xml += "      <Enumeration>\n";
        for (value, (name, description)) in (1..).zip(enumeration.items) {
            let number: i32 = value;
            let item =
                [("name", (*name).into()), ("value", number.to_string()), ("description", (*description).into())];
            line(xml, 8, "Item", &item, true);
        }
        *xml += "      </Enumeration>\n    </SimpleType>\n";
    }
    *xml += "  </TypeDefinitions>\n";
}

fn scalar_variable(xml: &mut String, index: usize, variable: &Variable, starts: &Starts) {
    let causality = match variable.role {
        Role::Input(_) => "input",
        Role::Output(_) => "output",
        Role::Parameter(_) | Role::Choice(_) => "parameter",
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
    let start = settable(starts, variable.role).unwrap_or_default();
    match variable.is {
        Type::Real => line(xml, 6, "Real", &real_attributes(variable, starts), true),
        Type::Enumeration(enumeration) => {
            line(xml, 6, "Enumeration", &[("declaredType", enumeration.name.into()), ("start", number(start))], true);
        }
        Type::Boolean => line(xml, 6, "Boolean", &[("start", (start != 0.0).to_string())], true),
    }
    *xml += "    </ScalarVariable>\n";
}

fn real_attributes(variable: &Variable, starts: &Starts) -> Vec<(&'static str, String)> {
    let quantity = variable.quantity;
    let mut attributes = vec![("declaredType", quantity.name.into())];
    attributes.extend(quantity.unit_attribute());
    attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
    attributes.extend(variable.min.map(|min| ("min", number(min))));
    attributes.extend(variable.max.map(|max| ("max", number(max))));
    attributes.push(("nominal", number(variable.nominal)));
    attributes.extend(settable(starts, variable.role).map(|start| ("start", number(start))));
    if let Role::Rate(state) = variable.role {
        attributes.extend(place_of_state(state).map(|i| ("derivative", (i + 1).to_string())));
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
}
