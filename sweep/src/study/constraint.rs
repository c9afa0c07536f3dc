//! Constraints between quantities: exclude points of a design before they are solved.
//!
//! `dead_volume_m3 < 0.2 * stroke_volume_m3`: two or more terms of numbers, quantities and values derived from the geometry, with
//! `+ - * / ^` and parentheses, compared by `<`, `<=`, `>` or `>=`. A row that violates a constraint is left out: it has its
//! number, its quantities, nulls and the status `left_out`. A term without a value (0/0) violates the constraint.

use crate::quantity::Base;
use crate::quantity::point::Point;
use crate::result::final_geometry;
use ensemble::Scenario;

/// A comparison that a row must satisfy to be solved.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// As written in the study file.
    pub text: String,
    /// At least two.
    pub terms: Vec<Term>,
    /// Relations between consecutive terms.
    pub relations: Vec<Relation>,
}

/// Relation of a term to the next.
#[derive(Clone, Copy, Debug)]
pub enum Relation {
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// A term of a constraint, by its source.
#[derive(Clone, Debug)]
pub enum Term {
    Number(f64),
    Quantity(usize),
    Geometry(Geometry),
    Negative(Box<Term>),
    Two(Box<Term>, char, Box<Term>),
}

/// Values derived from the geometry of a row.
#[derive(Clone, Copy, Debug)]
pub enum Geometry {
    StrokeVolume,
    InitialVolume,
    Volume,
    Area,
    VolumeToArea,
}

impl Constraint {
    /// The quantities it depends on; for derived values, those that determine the geometry.
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
            Term::Quantity(quantity) => quantity_of(*quantity, point, scenario),
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
            Term::Quantity(quantity) => found.push(*quantity),
            Term::Geometry(_) => found.extend(SHAPE.map(|base| base as usize)),
            Term::Negative(term) => term.quantities(found),
            Term::Two(left, _, right) => [left, right].into_iter().for_each(|term| term.quantities(found)),
        }
    }
}

/// A quantity of a row: the solved value if there is one, else the point's.
fn quantity_of(quantity: usize, point: &Point, scenario: &Scenario) -> f64 {
    let is = |base: Base| quantity == base as usize;
    match () {
        () if is(Base::Bore) => scenario.chamber.geometry.bore,
        () if is(Base::InitialStroke) => scenario.initial_position_m,
        () if is(Base::FinalStroke) => scenario.final_position_m,
        () if is(Base::InitialTemperature) => scenario.initial_temperature_k,
        () if is(Base::TemperatureIn) => scenario.temperature_in_k,
        () if is(Base::VolumeToArea) || is(Base::VolumeToAreaByLength) => Geometry::VolumeToArea.value(scenario),
        () if is(Base::Duration) => scenario.duration_s,
        () => point.0[quantity],
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
