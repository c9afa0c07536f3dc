//! Which rows of a record are data: a sensor read out more slowly than the rows fills the rows in between with what it
//! showed last, or with straight lines; those rows say nothing new.
//!
//! A held readout repeats each reading, also while the pressure changes by many times its noise; an interpolated one
//! bends at every k-th row only. Rows that are missing in between count, since the sensor does not wait for them. Rows marked
//! as outliers are no data either, nor are those of a move that the position does not show.

mod beat;
mod even;
mod find;
mod held;
mod readings;
mod straight;
mod uneven;

use std::ops::Range;

pub use even::{Between, changes, interpolated};
pub use find::of_logger;
pub use readings::Readings;

/// Which rows are data: all readings but those that it names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readout {
    /// Which rows are readings.
    pub readings: Readings,
    /// Rows that are no data although they are readings, ascending.
    pub outliers: Vec<usize>,
    /// How many rows at the beginning are no data since a filter shows there that began elsewhere, or the port was shut only then: see
    /// [`shut_from`](records::shut_from).
    pub starting: usize,
    /// Rows that are no data since nothing tells where the piston is.
    pub unfollowed: Vec<Range<usize>>,
    /// Rows that are no data since others beside them were lost while the piston moved.
    pub at_gaps: Vec<Range<usize>>,
    /// Rows at the end that are no data since the chamber was opened before: see [`opened_from`](records::opened_from).
    pub opened: Option<Range<usize>>,
    /// Rows that are no data since the record is not like its repeats, or not like all others.
    pub unlike_others: Option<Range<usize>>,
    /// Rows that are no data since the sensor was at an end of its range.
    pub saturated: Vec<Range<usize>>,
    /// Standard deviation of the times of the rows, s, where they were read unevenly; else empty.
    pub open_s: Vec<f64>,
}

impl Readout {
    /// Whether a row is data.
    #[inline]
    pub fn is_data(&self, row: usize) -> bool {
        self.readings.are_at(row)
            && !self.is_early(row)
            && self.outliers.binary_search(&row).is_err()
            && !self.is_open(row)
            && !self.is_saturated(row)
            && !self.unfollowed.iter().chain(&self.at_gaps).chain(&self.unlike_others).any(|rows| rows.contains(&row))
    }

    /// Whether a filter settles, or the port is shut, only after a row.
    #[inline]
    pub fn is_early(&self, row: usize) -> bool {
        row < self.starting
    }

    /// Whether the sensor is at an end of its range at a row.
    pub fn is_saturated(&self, row: usize) -> bool {
        self.saturated.iter().any(|rows| rows.contains(&row))
    }

    /// Whether the chamber is open at a row.
    #[inline]
    pub fn is_open(&self, row: usize) -> bool {
        self.opened.as_ref().is_some_and(|rows| rows.contains(&row))
    }
}
