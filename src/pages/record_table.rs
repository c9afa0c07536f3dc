//! The table of records with their per-record parameters.

use super::quantities::{Quantity, spaced};
use identify::outcome::estimates::Estimates;
use report::document::Table;

/// One row per record: the cells under `head`, then its per-record parameters, each column headed by name and unit.
pub fn table(head: &[&str], records: &[(Vec<String>, &Estimates)]) -> Table {
    let mut table = Table::new(head);
    let Some((_, first)) = records.first() else { return table };
    let of = |own: &Estimates, name: &str| own.iter().find(|(n, _)| n == name).map(|(_, e)| e.value);
    let largest = |name: &str| records.iter().filter_map(|(_, own)| of(own, name)).map(f64::abs).fold(0.0, f64::max);
    let quantities: Vec<(&str, Quantity)> =
        first.iter().map(|(name, e)| (name.as_str(), Quantity::of(name, &e.unit, largest(name)))).collect();
    for (name, quantity) in &quantities {
        let effect = name.split_once('.').map(|(effect, _)| effect);
        let alike = |other: &str| other.split_once('.').map(|(effect, _)| effect) == effect;
        // If an effect has only one parameter here, the effect's name is sufficient.
        let is_alone = first.iter().filter(|(other, _)| alike(other)).count() == 1;
        table.head.push(match effect {
            Some(effect) if is_alone => quantity.under(&spaced(effect)),
            _ => quantity.headed(),
        });
    }
    for (cells, own) in records {
        let values = quantities.iter().map(|(name, quantity)| {
            let digits = if *name == "initial_pressure_pa" { 5 } else { 3 };
            of(own, name).map_or("–".to_owned(), |value| quantity.number(value, digits))
        });
        table.rows.push(cells.iter().cloned().chain(values).collect());
    }
    table
}
