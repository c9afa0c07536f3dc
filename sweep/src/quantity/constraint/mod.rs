//! Constraints between quantities: which points of a design make sense, before any row is solved.
//!
//! `dead_volume_m3 < 0.2 * stroke_volume_m3`: two or more terms of numbers, quantities and what follows from the geometry,
//! with `+ - * / ^` and parentheses, compared by `<`, `<=`, `>` or `>=`. A row that breaks a constraint is left out: it has its
//! number, its quantities, nulls and the status `left_out`. A term without a value (0/0) keeps no constraint.

mod reader;

use crate::quantity::Base;
use crate::quantity::point::Point;
use crate::row::geometry::final_geometry;
use ensemble::{Hold, Scenario};
use reader::Reader;

/// Characters of a constraint at most; nesting follows.
const LONGEST: usize = 500;

/// A comparison that a row has to satisfy in order to be solved.
#[derive(Clone, Debug)]
pub struct Constraint {
    text: String,
    terms: Vec<Term>,
    relations: Vec<Relation>,
}

#[derive(Clone, Copy, Debug)]
enum Relation {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// A number of a row, by where it comes from.
#[derive(Clone, Debug)]
enum Term {
    Number(f64),
    Quantity(usize),
    Geometry(Geometry),
    Negative(Box<Term>),
    Two(Box<Term>, char, Box<Term>),
}

/// What follows from the geometry of a row.
#[derive(Clone, Copy, Debug)]
enum Geometry {
    StrokeVolume,
    InitialVolume,
    Volume,
    Area,
    VolumeToArea,
}

/// Names of what follows from the geometry.
const GEOMETRY: [(&str, Geometry); 5] = [
    ("stroke_volume_m3", Geometry::StrokeVolume),
    ("initial_volume_m3", Geometry::InitialVolume),
    ("volume_m3", Geometry::Volume),
    ("area_m2", Geometry::Area),
    ("volume_to_area_m", Geometry::VolumeToArea),
];

impl Constraint {
    /// A constraint from its text.
    ///
    /// # Errors
    /// What is wrong with it, in words that follow it.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("is longer than {LONGEST} characters"));
        }
        let mut reader = Reader { rest: text.trim() };
        let mut terms = vec![reader.sum()?];
        let mut relations = Vec::new();
        while !reader.rest.is_empty() {
            relations.push(reader.relation()?);
            terms.push(reader.sum()?);
        }
        if relations.is_empty() {
            return Err("compares nothing; expected <, <=, > or >=".into());
        }
        Ok(Self { text: text.trim().to_owned(), terms, relations })
    }

    /// The constraint as the study file writes it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The quantities it rests on; of what follows from the geometry, those that shape it.
    pub fn quantities(&self) -> Vec<usize> {
        let mut found = Vec::new();
        self.terms.iter().for_each(|term| term.quantities(&mut found));
        found
    }

    /// Whether a row satisfies the constraint.
    pub fn holds(&self, point: &Point, scenario: &Scenario) -> bool {
        let values: Vec<f64> = self.terms.iter().map(|term| term.value(point, scenario)).collect();
        values.windows(2).zip(&self.relations).all(|(pair, relation)| match relation {
            Relation::Less => pair[0] < pair[1],
            Relation::AtMost => pair[0] <= pair[1],
            Relation::Greater => pair[0] > pair[1],
            Relation::AtLeast => pair[0] >= pair[1],
        })
    }
}

impl Term {
    fn value(&self, point: &Point, scenario: &Scenario) -> f64 {
        match self {
            Term::Number(number) => *number,
            Term::Quantity(place) => quantity_of(*place, point, scenario),
            Term::Geometry(geometry) => geometry.value(scenario),
            Term::Negative(term) => -term.value(point, scenario),
            Term::Two(left, operator, right) => {
                let (left, right) = (left.value(point, scenario), right.value(point, scenario));
                match operator {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    '/' => left / right,
                    _ => left.powf(right),
                }
            }
        }
    }

    fn quantities(&self, found: &mut Vec<usize>) {
        use Base::{Bore, DeadVolume, FinalStroke, InitialStroke, Rod, VolumeToArea, VolumeToAreaByLength};
        const SHAPE: [Base; 7] =
            [Bore, Rod, DeadVolume, InitialStroke, FinalStroke, VolumeToArea, VolumeToAreaByLength];
        match self {
            Term::Number(_) => {}
            Term::Quantity(place) => found.push(*place),
            Term::Geometry(_) => found.extend(SHAPE.map(|base| base as usize)),
            Term::Negative(term) => term.quantities(found),
            Term::Two(left, _, right) => [left, right].into_iter().for_each(|term| term.quantities(found)),
        }
    }
}

/// A quantity of a row: as it is solved for where it is, else as the point has it.
fn quantity_of(place: usize, point: &Point, scenario: &Scenario) -> f64 {
    let is = |base: Base| place == base as usize;
    match () {
        () if is(Base::Bore) => scenario.chamber.geometry.bore,
        () if is(Base::InitialStroke) => scenario.initial_position_m,
        () if is(Base::FinalStroke) => scenario.final_position_m,
        () if is(Base::InitialTemperature) => scenario.initial_temperature_k,
        () if is(Base::TemperatureIn) => scenario.temperature_in_k,
        () if is(Base::VolumeToArea) || is(Base::VolumeToAreaByLength) => Geometry::VolumeToArea.value(scenario),
        () if is(Base::Duration) => match scenario.hold {
            Hold::Duration(duration) => duration,
            Hold::TimeConstants(_) => f64::NAN,
        },
        () => point.0[place],
    }
}

impl Geometry {
    fn value(self, scenario: &Scenario) -> f64 {
        let geometry = &scenario.chamber.geometry;
        let (volume, area) = final_geometry(scenario);
        match self {
            Geometry::StrokeVolume => {
                geometry.piston_area * (scenario.final_position_m - scenario.initial_position_m).abs()
            }
            Geometry::InitialVolume => geometry.volume(scenario.initial_position_m),
            Geometry::Volume => volume,
            Geometry::Area => area,
            Geometry::VolumeToArea => volume / area,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a comparison of numbers holds.
    fn holds(text: &str) -> bool {
        let chamber = chamber::Chamber::new(
            chamber::Gas::AIR,
            chamber::Geometry::new(0.02, 0.0, 1e-6, chamber::AreaLaw::Total),
            chamber::HeatTransfer::at_paper_reference(30.0),
        );
        let scenario = Scenario::push(chamber, 1e5, [0.1, 0.05], 0.04, Hold::Duration(3.0));
        Constraint::parse(text).unwrap().holds(&Point::EMPTY, &scenario)
    }

    #[test]
    fn operators_bind_as_in_algebra() {
        for text in [
            "1 + 2 * 3 > 6.9", "(1 + 2) * 3 >= 9", "2 - 1 - 1 <= 0", "8 / 4 / 2 < 1.1", "-2 ^ 2 < 0",
            "2 ^ 3 ^ 2 > 511", "2 ^ -1 < 0.6", "1e-3 < 1.5E+2", "1e-3-1 < 0", "1 < 2 <= 2 < 3", "bore_m < 0.021",
            "chamber.bore_m > 0.019", "stroke_volume_m3 < 1.571e-5", "stroke_volume_m3 > 1.570e-5", "duration_s >= 3",
        ] {
            assert!(holds(text), "{text}");
        }
        for text in ["1 < 2 < 2", "0 / 0 < 1", "0 / 0 >= 1", "2 - (1 - 1) < 2"] {
            assert!(!holds(text), "{text}");
        }
    }

    #[test]
    fn what_is_no_constraint_is_said() {
        for (text, expected) in [
            ("", "ends; expected a number or a quantity"),
            ("1", "compares nothing"),
            ("bore_m = 0.02", "has `=`; expected an operator, <, <=, > or >="),
            ("bore_m < ", "ends; expected a number"),
            ("(1 < 2", "has `<`; expected `)`"),
            ("1 < 2)", "has `)`; expected an operator"),
            ("1.2.3 < 2", "`1.2.3`, which is no number"),
            ("boer_m < 1", "did you mean `bore_m`?"),
            ("dead_volume_m3 < 0.2 * stroke_volume", "did you mean `stroke_volume_m3`?"),
            ("pressure_peak_pa < 1e6", "is not known before the row is solved"),
            ("bore_m < 2 and 1 < 2", "has `a`; expected an operator"),
            ("bore_m < 20 mm", "has `m`; expected an operator"),
            ("bore_m < §", "has `§`; expected a number"),
            (&"(".repeat(600), "is longer than 500"),
        ] {
            let message = Constraint::parse(text).unwrap_err();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
