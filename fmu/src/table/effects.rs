//! Parameters of the effects, from their cards: a new effect's file provides its variables.

use super::units;
use super::variable::{Role, Type, Variability, Variable};
use crate::plant::values::BASE;
use chamber::card::{ActsOn, Card, Kind, Parameter};
use chamber::effects::empirical::{Curve, Empirical, Term};
use chamber::effects::{self, EffectSet};
use chamber::words::listed;

/// The effects of an FMU: all except those on the stroke record, because here the stroke is the true one. For a table effect only
/// its numbers are variables; the term and variable of the table are fixed by the model.
pub fn effects_here() -> impl Iterator<Item = (usize, &'static Card)> {
    effects::all().filter(|(_, card)| card.acts_on != ActsOn::RecordedStroke)
}

/// Checks that an FMU can include an effect with these parameters.
///
/// # Errors
/// The reason, as a sentence.
pub fn exported(effect: usize, values: &[f64]) -> Result<(), String> {
    if effect != Empirical::INDEX {
        return Ok(());
    }
    match Curve::of(values) {
        Some(Curve { term: Term::VolumeShare, .. }) => {
            Err("its empirical term is a share of the volume, and an FMU's volume is that of its position".to_owned())
        }
        _ => Ok(()),
    }
}

/// The parameters of the FMU's effects.
pub(super) fn parameters(table: &mut Vec<Variable>) {
    for (index, card) in effects_here() {
        for (i, p) in card.parameters.iter().enumerate().filter(|(_, p)| p.is_variable()) {
            table.push(Variable {
                name: parameter_name(card, p),
                description: p.doc.into(),
                role: Role::Parameter(BASE + effects::PARAMETER_OFFSETS[index] + i),
                is: Type::Real,
                quantity: units::of_card(p.unit),
                variability: Variability::Tunable,
                min: Some(*p.bounds.start()),
                max: Some(*p.bounds.end()),
                nominal: p.typical.abs(),
            });
        }
    }
}

/// A parameter's structured name: `leakage.conductance`, `empirical.values[1]`.
pub fn parameter_name(card: &Card, parameter: &Parameter) -> String {
    let name = format!("{}.{}", camel(card.name), camel(parameter.name));
    match parameter.kind {
        Kind::ListEntry { index, .. } => format!("{name}[{}]", index + 1),
        Kind::Number | Kind::Word(_) => name,
    }
}

/// The names of a set's effects as a list: `wallHeating, warmWall and wallConduction`.
pub fn names(set: EffectSet) -> String {
    let names: Vec<String> = effects::all().filter(|(i, _)| set.has(*i)).map(|(_, card)| camel(card.name)).collect();
    listed(&names)
}

/// `wall_heating` as `wallHeating`.
pub fn camel(snake: &str) -> String {
    let mut out = String::with_capacity(snake.len());
    let mut raise = false;
    for c in snake.chars() {
        match c {
            '_' => raise = true,
            c if raise => {
                out.extend(c.to_uppercase());
                raise = false;
            }
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::table;
    use super::*;

    #[test]
    fn real_parameters_follow_the_order_of_their_indices() {
        let parameters: Vec<_> =
            table().iter().filter_map(|v| if let Role::Parameter(i) = v.role { Some(i) } else { None }).collect();
        let offsets = effects::PARAMETER_OFFSETS;
        let no_variable = |i: usize| {
            let effect = offsets.partition_point(|offset| *offset <= i) - 1;
            effects::of_recorded_stroke().has(effect)
                || !effects::CARDS[effect].parameters[i - offsets[effect]].is_variable()
        };
        let expected = (0..crate::plant::values::REALS).filter(|i| !i.checked_sub(BASE).is_some_and(no_variable));
        assert_eq!(parameters, expected.collect::<Vec<_>>());
    }
}
