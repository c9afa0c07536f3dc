//! A record after reading.

use super::dropped_rows::{self, DroppedRow};
use super::keep::keep_rows;
use super::line_numbers::LineNumbers;
use super::rest;
use std::path::PathBuf;

/// A measured record or a planned motion. All vectors have the same length.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// The file it was read from.
    pub path: PathBuf,
    /// SHA-256 of the file's bytes, 64 hexadecimal digits.
    pub sha256: String,
    /// Time, s, as in the file.
    pub time_s: Vec<f64>,
    /// Sensor reading, Pa, absolute; absent in a planned motion.
    pub pressure_pa: Option<Vec<f64>>,
    /// Distance of the piston face from the chamber's end, m.
    pub position_m: Vec<f64>,
    /// Temperature of the surroundings, K, if recorded.
    pub ambient_temperature_k: Option<Vec<f64>>,
    /// Reading of a temperature sensor in the gas, K, if there was one.
    pub gas_temperature_k: Option<Vec<f64>>,
    /// Mass flow into the chamber, kg/s, negative out of it.
    pub mass_flow_kg_per_s: Option<Vec<f64>>,
    /// Lines of the rows in the file.
    pub lines: LineNumbers,
    /// Unusable rows of the file, by line; at most one in fifty.
    pub dropped_rows: Vec<DroppedRow>,
    /// Whether the file's rows had to be sorted by time.
    pub sorted: bool,
}

impl Trace {
    /// Keeps the rows that are `true` in `keep`, in every column.
    pub fn retain(&mut self, keep: &[bool]) {
        let Self { pressure_pa, ambient_temperature_k, gas_temperature_k, mass_flow_kg_per_s, .. } = self;
        let columns = [pressure_pa, ambient_temperature_k, gas_temperature_k, mass_flow_kg_per_s].into_iter().flatten();
        columns.chain([&mut self.time_s, &mut self.position_m]).for_each(|column| keep_rows(column, keep));
        self.lines.retain(keep);
    }

    /// Changes made to the file's rows, in sentences; empty if there were none.
    pub fn notes(&self) -> Vec<String> {
        let sorted = self.sorted.then(|| "the rows are not in the order of time and were sorted".to_owned());
        let path = self.path.display();
        sorted.into_iter().chain(dropped_rows::note(&self.dropped_rows)).map(|note| format!("{path}: {note}")).collect()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there are no rows: never the case for a trace that was read.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Number of leading rows before the piston moves: all if it never moves, 1 if it moves from the first row on.
    pub fn rows_at_rest(&self) -> usize {
        rest::rows_at_rest(&self.position_m)
    }
}
