//! The FMI 2.0 dialect of `modelDescription.xml`.

use crate::description::{self, Attributes, Description, Dialect, dependencies, items, of_enumeration};
use crate::identity::Identity;
use crate::plant::event_indicators::EVENT_INDICATORS;
use crate::plant::values::Starts;
use crate::table::settable;
use crate::table::structure::Unknown;
use crate::table::units::Quantity;
use crate::table::variable::{Enumeration, Type, Variable};
use crate::xml::{line, number};
use std::fmt::Write;

/// Renders the description of a chamber with these start values. `generated` is a UTC time such as 2026-01-31T12:00:00Z.
pub fn render(identity: &Identity, starts: &Starts, generated: Option<&str>) -> Description {
    description::render::<Fmi2>(identity, starts, generated)
}

/// Variables and their indices are counted from one.
const FIRST: usize = 1;

struct Fmi2;

impl Dialect for Fmi2 {
    const VERSION: &'static str = "2.0";
    const GUID: &'static str = "guid";

    fn more() -> Attributes {
        vec![("numberOfEventIndicators", EVENT_INDICATORS.to_string())]
    }

    fn capabilities(xml: &mut String, identifier: &str) {
        let yes = || "true".to_owned();
        let common = [
            ("canBeInstantiatedOnlyOncePerProcess", "false".into()),
            ("canNotUseMemoryManagementFunctions", yes()),
            ("canGetAndSetFMUstate", yes()),
            ("canSerializeFMUstate", yes()),
            ("providesDirectionalDerivative", yes()),
        ];
        let begin = [("modelIdentifier", identifier.to_owned()), ("needsExecutionTool", "false".into())];
        let exchange = [("completedIntegratorStepNotNeeded", "false".into())];
        line(xml, 2, "ModelExchange", &[&begin[..], &exchange, &common].concat(), true);
        let simulation = [
            ("canHandleVariableCommunicationStepSize", yes()),
            ("canInterpolateInputs", yes()),
            ("maxOutputDerivativeOrder", "1".into()),
            ("canRunAsynchronuously", "false".into()),
        ];
        line(xml, 2, "CoSimulation", &[&begin[..], &simulation, &common].concat(), true);
    }

    fn quantity(xml: &mut String, quantity: &Quantity) {
        line(xml, 4, "SimpleType", &[("name", quantity.name.into())], false);
        let name = vec![("quantity", quantity.name.into())];
        line(xml, 6, "Real", &[name, description::of_quantity(quantity)].concat(), true);
        *xml += "    </SimpleType>\n";
    }

    fn enumeration(xml: &mut String, enumeration: &Enumeration) {
        line(xml, 4, "SimpleType", &of_enumeration(enumeration), false);
        *xml += "      <Enumeration>\n";
        items(xml, 8, enumeration);
        *xml += "      </Enumeration>\n    </SimpleType>\n";
    }

    fn variable(xml: &mut String, variable: &Variable, attributes: Attributes, starts: &Starts) {
        line(xml, 4, "ScalarVariable", &attributes, false);
        let start = settable(starts, variable.role).unwrap_or_default();
        match variable.is {
            Type::Real => line(xml, 6, "Real", &description::of_real(variable, starts, FIRST), true),
            Type::Enumeration(enumeration) => {
                let attributes = [("declaredType", enumeration.name.into()), ("start", number(start))];
                line(xml, 6, "Enumeration", &attributes, true);
            }
            Type::Boolean => line(xml, 6, "Boolean", &[("start", (start != 0.0).to_string())], true),
        }
        *xml += "    </ScalarVariable>\n";
    }

    fn structure(xml: &mut String, unknowns: [Vec<Unknown>; 3]) {
        for (name, unknowns) in ["Outputs", "Derivatives", "InitialUnknowns"].into_iter().zip(unknowns) {
            let _ = writeln!(xml, "    <{name}>");
            for unknown in unknowns {
                let index = (FIRST + unknown.variable).to_string();
                line(xml, 6, "Unknown", &[("index", index), ("dependencies", dependencies(&unknown, FIRST))], true);
            }
            let _ = writeln!(xml, "    </{name}>");
        }
    }
}
