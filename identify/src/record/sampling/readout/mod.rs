//! Which rows of a record are data. A sensor that is read out more slowly than the rows fills the rows in between with its last
//! reading, or with straight lines; those rows carry no information.
//!
//! A held readout repeats each reading, even while the pressure changes by many times its noise; an interpolated one bends at
//! every k-th row only. Rows missing from the file count, since the sensor does not wait for them. Rows marked as outliers are
//! not data either, nor are those of a move that the positions do not show.

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

/// Which rows are data: all readings except those listed here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readout {
    /// Which rows are readings.
    pub readings: Readings,
    /// Outliers: rows that are not data although they are readings, ascending.
    pub outliers: Vec<usize>,
    /// Number of rows at the beginning that are not data because a filter that began elsewhere is still settling, or the port is
    /// not shut yet: see [`shut_from`](records::shut_from).
    pub starting: usize,
    /// Rows that are not data because the piston's position is unknown.
    pub unfollowed: Vec<Range<usize>>,
    /// Rows that are not data because rows beside them were lost while the piston moved.
    pub at_gaps: Vec<Range<usize>>,
    /// Rows at the end that are not data because the chamber was opened before: see [`opened_from`](records::opened_from).
    pub opened: Option<Range<usize>>,
    /// Rows that are not data because the record is unlike its repeats, or unlike all others.
    pub unlike_others: Option<Range<usize>>,
    /// Rows that are not data because the sensor was at an end of its range.
    pub saturated: Vec<Range<usize>>,
    /// Standard deviations of the row times, s, where rows were read unevenly; else empty.
    pub time_sd_s: Vec<f64>,
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

    /// Whether at this row a filter is still settling, or the port is not shut yet.
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
