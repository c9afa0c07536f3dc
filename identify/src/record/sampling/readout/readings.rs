//! The readings of a record: all rows, every k-th one, or those taken by the sensor's own clock.

use super::even::{Between, Even};

/// Which rows are readings, outliers included.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Readings {
    /// All.
    #[default]
    EveryRow,
    /// Every k-th one, with the rows before which one is missing, ascending, one entry for each missing row.
    AtRows(Even, Vec<usize>),
    /// Those taken by the sensor's own clock.
    ByOwnClock {
        /// What the rows between two readings do.
        between: Between,
        /// Rows from one reading to the next.
        period: f64,
        /// The readings, ascending.
        taken: Vec<Taken>,
    },
}

/// A reading that was not taken right at a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// The first row that shows it.
    pub row: usize,
    /// When it was taken, s: at that row, or between it and the row before.
    pub time_s: f64,
    /// What it read, Pa.
    pub pressure_pa: f64,
}

impl Readings {
    /// What the rows between two readings do.
    pub fn between(&self) -> Between {
        match self {
            Self::EveryRow => Between::Nothing,
            Self::AtRows(even, _) => even.between,
            Self::ByOwnClock { between, .. } => *between,
        }
    }

    /// Rows from one reading to the next.
    pub fn period(&self) -> f64 {
        match self {
            Self::EveryRow => 1.0,
            Self::AtRows(even, _) => even.period as f64,
            Self::ByOwnClock { period, .. } => *period,
        }
    }

    /// Whether the sensor is read out more slowly than the rows.
    pub fn are_slow(&self) -> bool {
        *self != Self::EveryRow
    }

    /// Whether both have the same period, as closely as two records show it of one clock.
    pub fn are_as_slow_as(&self, other: &Self) -> bool {
        const NEARLY: f64 = 0.01;
        (self.period() / other.period() - 1.0).abs() < NEARLY
    }

    /// Readings per second where rows come `row_s` apart; `None` where every row is one.
    pub fn rate_hz(&self, row_s: f64) -> Option<f64> {
        self.are_slow().then(|| 1.0 / (self.period() * row_s))
    }

    /// Whether a row is a reading.
    #[inline]
    pub fn are_at(&self, row: usize) -> bool {
        match self {
            Self::EveryRow => true,
            Self::AtRows(even, missing) => even.is_reading(on_grid(row, missing)),
            Self::ByOwnClock { taken, .. } => taken.binary_search_by_key(&row, |taken| taken.row).is_ok(),
        }
    }

    /// Times, s, and pressures, Pa, of a record's rows, with each reading at the time at which it was taken; `None` if all were
    /// taken right at the rows.
    pub fn at_their_times(&self, time_s: &[f64], pressure_pa: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let own = self.by_own_clock()?;
        let (mut time_s, mut pressure_pa) = (time_s.to_vec(), pressure_pa.to_vec());
        for taken in own {
            (time_s[taken.row], pressure_pa[taken.row]) = (taken.time_s, taken.pressure_pa);
        }
        Some((time_s, pressure_pa))
    }

    /// Those by the sensor's own clock, which were not taken right at the rows.
    pub fn by_own_clock(&self) -> Option<&[Taken]> {
        match self {
            Self::ByOwnClock { taken, .. } => Some(taken),
            _ => None,
        }
    }
}

/// Number of a row of the file among all rows, counting those missing before it.
#[inline]
pub fn on_grid(row: usize, missing: &[usize]) -> usize {
    row + missing.partition_point(|before| *before <= row)
}
