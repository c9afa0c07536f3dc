//! The FMI 3.0 dialect of `modelDescription.xml`.

use super::{indicator_references, time_reference};
use crate::description::{self, Attributes, Description, Dialect, dependencies, items, of_enumeration};
use crate::identity::Identity;
use crate::plant::values::Starts;
use crate::table::settable;
use crate::table::states::state_of_role;
use crate::table::structure::Unknown;
use crate::table::units::Quantity;
use crate::table::variable::{Enumeration, Type, Variable};
use crate::xml::{line, number};
use std::fmt::Write;

/// Renders the description of a chamber with these start values. `generated` is a UTC time such as 2026-01-31T12:00:00Z.
pub fn render(identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
    description::render::<Fmi3>(identity, starts, generated)
}

struct Fmi3;

impl Dialect for Fmi3 {
    const VERSION: &'static str = "3.0";
    const GUID: &'static str = "instantiationToken";

    fn capabilities(xml: &mut String, identifier: &str) {
        let yes = || "true".to_owned();
        let common = [
            ("modelIdentifier", identifier.to_owned()),
            ("needsExecutionTool", "false".into()),
            ("canBeInstantiatedOnlyOncePerProcess", "false".into()),
            ("canGetAndSetFMUState", yes()),
            ("canSerializeFMUState", yes()),
            ("providesDirectionalDerivatives", yes()),
        ];
        let exchange = [("needsCompletedIntegratorStep", yes())];
        line(xml, 2, "ModelExchange", &[&common[..], &exchange].concat(), true);
        let simulation = [
            ("canHandleVariableCommunicationStepSize", yes()),
            ("maxOutputDerivativeOrder", "1".into()),
            ("mightReturnEarlyFromDoStep", yes()),
            ("hasEventMode", yes()),
        ];
        line(xml, 2, "CoSimulation", &[&common[..], &simulation].concat(), true);
    }

    fn quantity(xml: &mut String, quantity: &Quantity) {
        let name = vec![("name", quantity.name.into()), ("quantity", quantity.name.into())];
        line(xml, 4, "Float64Type", &[name, description::of_quantity(quantity)].concat(), true);
    }

    fn enumeration(xml: &mut String, enumeration: &Enumeration) {
        line(xml, 4, "EnumerationType", &of_enumeration(enumeration), false);
        items(xml, 6, enumeration);
        *xml += "    </EnumerationType>\n";
    }

    fn variable(xml: &mut String, variable: &Variable, mut attributes: Attributes, starts: &Starts) {
        let start = settable(starts, variable.role);
        let tag = match variable.is {
            Type::Real => {
                attributes.extend(description::of_real(variable, starts, 0));
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

    /// The variables that FMI 2.0 lacks: the time and the event indicators.
    fn further_variables(xml: &mut String) {
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

    fn structure(xml: &mut String, unknowns: [Vec<Unknown>; 3]) {
        let tags = ["Output", "ContinuousStateDerivative", "InitialUnknown"];
        for (tag, unknowns) in tags.into_iter().zip(unknowns) {
            for unknown in unknowns {
                let reference = ("valueReference", unknown.variable.to_string());
                line(xml, 4, tag, &[reference, ("dependencies", dependencies(&unknown, 0))], true);
            }
        }
        for reference in indicator_references() {
            let _ = writeln!(xml, "    <EventIndicator valueReference=\"{reference}\"/>");
        }
    }
}
