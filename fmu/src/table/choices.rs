//! The chamber's non-numerical parameters: two enumerations, which the model description declares as types, and a Boolean.

use super::effects;
use super::units;
use super::variable::{Enumeration, Role, Type, Variability, Variable};
use crate::plant::values::Choice;
use chamber::effects::OF_WALL;

/// Which area exchanges heat.
pub static AREA_LAW: Enumeration = Enumeration {
    name: "AreaLaw",
    description: "Lateral area that exchanges heat, beside both end faces",
    items: &[("total", "Of the whole gas volume, dead volume included"), ("swept", "Of the swept length only")],
};

/// What moves the piston.
pub static STROKE_INPUT: Enumeration = Enumeration {
    name: "StrokeInput",
    description: "Inputs that move the piston",
    items: &[
        ("positionAndVelocity", "Both; the volume at a communication point is that of the position"),
        ("velocity", "The velocity alone, from the start value of position"),
    ],
};

/// The enumerations declared in the model description.
pub static ENUMERATIONS: [&Enumeration; 2] = [&AREA_LAW, &STROKE_INPUT];

/// The parameters that are enumerations or Booleans.
pub(super) fn parameters(table: &mut Vec<Variable>) {
    let choices = [
        (
            "areaLaw",
            "Lateral area that exchanges heat: that of the whole gas volume, or of the swept length only",
            Choice::AreaLaw,
            Type::Enumeration(&AREA_LAW),
        ),
        (
            "strokeInput",
            "Inputs that move the piston: position and velocity, or velocity alone; pistonPosition is the result",
            Choice::StrokeInput,
            Type::Enumeration(&STROKE_INPUT),
        ),
        (
            "externalWall",
            &format!(
                "Whether the input wallTemperature is the temperature of the wall, for a thermal network that supplies heatFlow; {} have no influence then",
                effects::names(OF_WALL)
            ),
            Choice::ExternalWall,
            Type::Boolean,
        ),
    ];
    for (name, description, choice, is) in choices {
        let (min, max) = match is {
            Type::Enumeration(enumeration) => (1.0, enumeration.items.len() as f64),
            _ => (0.0, 1.0),
        };
        table.push(Variable {
            name: name.into(),
            description: description.into(),
            role: Role::Choice(choice),
            is,
            quantity: &units::DIMENSIONLESS,
            variability: Variability::Fixed,
            min: Some(min),
            max: Some(max),
            nominal: 1.0,
        });
    }
}
