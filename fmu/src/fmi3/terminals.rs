//! `terminalsAndIcons.xml`: the ports, the piston and the wall as terminals, and their positions on the icon.

use std::fmt::Write;

/// Side length of the icon, in its coordinate system.
const SIDE: f64 = 200.0;

/// A terminal: name, description, position on the icon, and its variables with their member names and kinds.
type Terminal = (&'static str, &'static str, [f64; 2], &'static [(&'static str, &'static str, &'static str)]);

const TERMINALS: [Terminal; 4] = [
    (
        "supplyPort",
        "Valve's port to a supply: state and conductance in, mass and enthalpy flow out",
        [-100.0, 40.0],
        &[
            ("supplyPortPressure", "pressure", "signal"),
            ("supplyPortTemperature", "temperature", "signal"),
            ("supplyPortConductance", "conductance", "signal"),
            ("supplyPortMassFlow", "massFlow", "inflow"),
            ("supplyPortEnthalpyFlow", "enthalpyFlow", "inflow"),
        ],
    ),
    (
        "exhaustPort",
        "Valve's port to the exhaust: state and conductance in, mass and enthalpy flow out",
        [-100.0, -40.0],
        &[
            ("exhaustPortPressure", "pressure", "signal"),
            ("exhaustPortTemperature", "temperature", "signal"),
            ("exhaustPortConductance", "conductance", "signal"),
            ("exhaustPortMassFlow", "massFlow", "inflow"),
            ("exhaustPortEnthalpyFlow", "enthalpyFlow", "inflow"),
        ],
    ),
    (
        "piston",
        "The piston's rod: motion in, force out",
        [100.0, 0.0],
        &[
            ("position", "position", "signal"),
            ("velocity", "velocity", "signal"),
            ("force", "force", "signal"),
            ("pistonPosition", "pistonPosition", "signal"),
        ],
    ),
    (
        "wall",
        "The wall of a thermal network, where externalWall is true: temperature in, heat flow into the gas out",
        [0.0, 100.0],
        &[("wallTemperature", "temperature", "signal"), ("heatFlow", "heatFlow", "inflow")],
    ),
];

/// `terminalsAndIcons.xml`, the same for every model.
pub fn render() -> String {
    let half = 0.5 * SIDE;
    let mut xml =
        String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n");
    let _ = writeln!(
        xml,
        "  <GraphicalRepresentation>\n    <CoordinateSystem x1=\"-{half}\" y1=\"-{half}\" x2=\"{half}\" y2=\"{half}\" suggestedScalingFactorTo_mm=\"0.1\"/>"
    );
    let _ = writeln!(
        xml,
        "    <Icon x1=\"-{half}\" y1=\"-{half}\" x2=\"{half}\" y2=\"{half}\"/>\n  </GraphicalRepresentation>\n  <Terminals>"
    );
    for (name, description, [x, y], members) in TERMINALS {
        let _ = writeln!(xml, "    <Terminal name=\"{name}\" matchingRule=\"bus\" description=\"{description}\">");
        for (variable, member, kind) in members {
            let _ = writeln!(
                xml,
                "      <TerminalMemberVariable variableName=\"{variable}\" memberName=\"{member}\" variableKind=\"{kind}\"/>"
            );
        }
        let (x1, y1, x2, y2) = (x - 10.0, y - 10.0, x + 10.0, y + 10.0);
        let _ = writeln!(
            xml,
            "      <TerminalGraphicalRepresentation defaultConnectionColor=\"0 114 178\" x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" iconBaseName=\"terminal\"/>\n    </Terminal>"
        );
    }
    xml + "  </Terminals>\n</fmiTerminalsAndIcons>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::table;

    #[test]
    fn every_member_is_a_variable() {
        for (_, _, _, members) in TERMINALS {
            for (variable, _, _) in members {
                assert!(table().iter().any(|v| v.name == *variable), "{variable}");
            }
        }
    }
}
