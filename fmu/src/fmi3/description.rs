//! `modelDescription.xml` of FMI 3.0, rendered from the one table of variables.

use super::{indicator_references, time_reference};
use crate::package::experiment;
use crate::package::identity::Identity;
use crate::plant::simulation::DEFAULT_TOLERANCE;
use crate::plant::values::Starts;
use crate::protocol::message::Category;
use crate::table::structure::{self, Unknown};
use crate::table::units::{QUANTITIES, UNITS};
use crate::table::{
    ENUMERATIONS, Role, STEP_S, Type, Variability, Variable, place_of_state, settable, state_of_role, table,
};
use crate::xml::{Description, described, line, number};
use std::fmt::Write;

/// Renders the description of a chamber with these start values. `generated` is a UTC time as in 2026-01-31T12:00:00Z.
pub fn render(identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
    described(|token| document(identity, starts, generated, token))
}

fn document(identity: &Identity, starts: &Starts, generated: Option<&str>, token: &str) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    head(&mut xml, identity, generated, token);
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
    for (reference, variable) in (0..).zip(table()) {
        self::variable(&mut xml, reference, variable, starts);
    }
    of_fmi3(&mut xml);
    xml += "  </ModelVariables>\n";
    model_structure(&mut xml);
    xml += "</fmiModelDescription>\n";
    xml
}

fn head(xml: &mut String, identity: &Identity, generated: Option<&str>, token: &str) {
    let mut attributes = vec![
        ("fmiVersion", "3.0".into()),
        ("modelName", identity.name.clone()),
        ("instantiationToken", token.into()),
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
    attributes.extend(generated.map(|generated| ("generationDateAndTime", generated.into())));
    attributes.push(("variableNamingConvention", "structured".into()));
    line(xml, 0, "fmiModelDescription", &attributes, false);
    let yes = || "true".to_owned();
    let common = || {
        vec![
            ("modelIdentifier", identity.identifier.clone()),
            ("needsExecutionTool", "false".into()),
            ("canBeInstantiatedOnlyOncePerProcess", "false".into()),
            ("canGetAndSetFMUState", yes()),
            ("canSerializeFMUState", yes()),
            ("providesDirectionalDerivatives", yes()),
        ]
    };
    let mut exchange = common();
    exchange.push(("needsCompletedIntegratorStep", yes()));
    line(xml, 2, "ModelExchange", &exchange, true);
    let mut simulation = common();
    simulation.extend([
        ("canHandleVariableCommunicationStepSize", yes()),
        ("maxOutputDerivativeOrder", "1".into()),
        ("mightReturnEarlyFromDoStep", yes()),
        ("hasEventMode", yes()),
    ]);
    line(xml, 2, "CoSimulation", &simulation, true);
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
        let mut attributes = vec![("name", quantity.name.into()), ("quantity", quantity.name.into())];
        attributes.extend(quantity.unit_attribute());
        attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
        attributes.extend(quantity.min.map(|min| ("min", number(min))));
        attributes.push(("nominal", number(quantity.nominal)));
        line(xml, 4, "Float64Type", &attributes, true);
    }
    for enumeration in ENUMERATIONS {
        let attributes = [("name", enumeration.name.into()), ("description", enumeration.description.into())];
        line(xml, 4, "EnumerationType", &attributes, false);
        for (value, (name, description)) in (1..).zip(enumeration.items) {
            let value: i32 = value;
            let item = [("name", (*name).into()), ("value", value.to_string()), ("description", (*description).into())];
            line(xml, 6, "Item", &item, true);
        }
        *xml += "    </EnumerationType>\n";
    }
    *xml += "  </TypeDefinitions>\n";
}

fn variable(xml: &mut String, reference: u32, variable: &Variable, starts: &Starts) {
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
        ("valueReference", reference.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality.into()),
        ("variability", variability.into()),
    ];
    match causality {
        "parameter" => attributes.push(("initial", "exact".into())),
        "output" | "local" => attributes.push(("initial", "calculated".into())),
        _ => {}
    }
    let start = settable(starts, variable.role);
    let tag = match variable.is {
        Type::Real => {
            let quantity = variable.quantity;
            attributes.push(("declaredType", quantity.name.into()));
            attributes.extend(quantity.unit_attribute());
            attributes.extend(quantity.display.map(|display| ("displayUnit", display.into())));
            attributes.extend(variable.min.map(|min| ("min", number(min))));
            attributes.extend(variable.max.map(|max| ("max", number(max))));
            attributes.push(("nominal", number(variable.nominal)));
            attributes.extend(start.map(|start| ("start", number(start))));
            if let Role::Rate(state) = variable.role {
                attributes.extend(place_of_state(state).map(|place| ("derivative", place.to_string())));
            }
            if state_of_role(variable.role).is_some() {
                attributes.push(("reinit", "true".into()));
            }
            "Float64"
        }
        Type::Enumeration(enumeration) => {
            attributes.push(("declaredType", enumeration.name.into()));
            attributes.extend(start.map(|start| ("start", number(start))));
            "Enumeration"
        }
        Type::Boolean => {
            attributes.extend(start.map(|start| ("start", (start != 0.0).to_string())));
            "Boolean"
        }
    };
    line(xml, 4, tag, &attributes, true);
}

/// The variables that FMI 2.0 does not have: the time and the event indicators.
fn of_fmi3(xml: &mut String) {
    let time = [
        ("name", "time".to_owned()),
        ("valueReference", time_reference().to_string()),
        ("description", "Time".into()),
        ("causality", "independent".into()),
        ("variability", "continuous".into()),
        ("declaredType", "Time".into()),
        ("unit", "s".into()),
    ];
    line(xml, 4, "Float64", &time, true);
    for (i, reference) in indicator_references().enumerate() {
        let indicator = [
            ("name", format!("eventIndicator[{}]", i + 1)),
            ("valueReference", reference.to_string()),
            ("description", "Changes its sign where the equations have a corner".into()),
            ("causality", "local".into()),
            ("variability", "continuous".into()),
            ("initial", "calculated".into()),
        ];
        line(xml, 4, "Float64", &indicator, true);
    }
}

fn model_structure(xml: &mut String) {
    let outputs = structure::between_steps(|role| matches!(role, Role::Output(_)));
    let rates = structure::between_steps(|role| matches!(role, Role::Rate(_)));
    *xml += "  <ModelStructure>\n";
    for (tag, unknowns) in
        [("Output", outputs), ("ContinuousStateDerivative", rates), ("InitialUnknown", structure::in_initialization())]
    {
        for Unknown { variable, dependencies } in unknowns {
            let dependencies: Vec<String> = dependencies.iter().map(usize::to_string).collect();
            let attributes = [("valueReference", variable.to_string()), ("dependencies", dependencies.join(" "))];
            line(xml, 4, tag, &attributes, true);
        }
    }
    for reference in indicator_references() {
        let _ = writeln!(xml, "    <EventIndicator valueReference=\"{reference}\"/>");
    }
    *xml += "  </ModelStructure>\n";
}
