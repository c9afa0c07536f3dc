//! Readings at every k-th row.

use crate::record::series::bends::{Bends, MOST_OF_USUAL};

/// How the rows between two readings were filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// Every row is a reading.
    Nothing,
    /// The last reading repeated.
    Held,
    /// Straight lines.
    Interpolated,
}

impl Between {
    /// What the rows between two readings do, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nothing => "are readings too",
            Self::Held => "repeat the last reading",
            Self::Interpolated => "lie on straight lines",
        }
    }
}

/// A reading at every `period`-th row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Even {
    /// What the rows between two readings do.
    pub between: Between,
    /// Rows from one reading to the next; 1 where every row is a reading.
    pub period: usize,
    /// The first row that is a reading.
    pub first: usize,
}

/// Longest period searched for, rows: a gauge read ten times a second beside rows at 2 kHz...
pub const LONGEST: usize = 250;
/// ...or at 20 kHz where its readings are held, which shows at once.
pub const LONGEST_HELD: usize = 2000;
/// Fewest readings of a record whose bends are taken to show a period.
pub const FEWEST_READINGS: usize = 20;
/// Largest fraction of the changes that may be disturbances of single rows.
pub const DISTURBED: f64 = 0.05;

impl Even {
    /// Whether a row is a reading.
    #[inline]
    pub fn is_reading(&self, row: usize) -> bool {
        row >= self.first % self.period && (row - self.first % self.period).is_multiple_of(self.period)
    }
}

/// Rows of a column that differ from the row before, where neither is missing.
pub fn changes(column: &[f64]) -> Vec<usize> {
    (1..column.len()).filter(|&i| (column[i] - column[i - 1]).abs() > 0.0).collect()
}

/// Looks for changes on every k-th row only, but for a few disturbed ones, although nearly every reading differs from the one
/// before.
pub fn held(pressure_pa: &[f64]) -> Option<Even> {
    let changes = changes(pressure_pa);
    if 2 * changes.len() > pressure_pa.len() {
        return None;
    }
    let mut distances: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
    distances.sort_unstable();
    let most_frequent = distances.chunk_by(|a, b| a == b).max_by_key(|alike| alike.len())?[0];
    // Where readings stick to a step, most changes may be several readings apart; where single rows are disturbed, less than one.
    [distances[0], most_frequent].into_iter().find_map(|period| held_for(&changes, period))
}

/// The held readout with this period, if the changes fit it.
fn held_for(changes: &[usize], period: usize) -> Option<Even> {
    /// Natural logarithm of the probability that changes on arbitrary rows all fall on a grid: certainly no chance.
    const BY_CHANCE: f64 = -16.0;
    if !(2..=LONGEST_HELD).contains(&period) {
        return None;
    }
    let mut at = vec![0; period];
    changes.iter().for_each(|row| at[row % period] += 1);
    let (first, on_grid) = at.into_iter().enumerate().max_by_key(|(first, count)| (*count, period - first))?;
    let (all, off) = (changes.len() as f64, (changes.len() - on_grid) as f64);
    let chance = ln_choices(off, all) - (on_grid - 1) as f64 * (period as f64).ln();
    // A sensor that sticks to its steps changes on any row, a slow one on its own rows only.
    (off <= DISTURBED * all && chance <= BY_CHANCE).then_some(Even { between: Between::Held, period, first })
}

/// Natural logarithm of the number of ways to choose those off a grid from all (Stirling).
pub fn ln_choices(off: f64, all: f64) -> f64 {
    if off > 0.0 { off * (1.0 + (all / off).ln()) } else { 0.0 }
}

/// Looks for second differences that vanish, to the rounding of the readings, except at every k-th row.
pub fn interpolated(pressure_pa: &[f64]) -> Option<Even> {
    let bends = Bends::of(&pressure_pa[..pressure_pa.len().min(20_000)]);
    let candidates = (2..=LONGEST.min(bends.squares.len() / FEWEST_READINGS)).filter_map(|period| {
        let (first, most) = bends.largest(period)?;
        bends.stand_out(period, first, most)?;
        // Spikes and a push bend few rows much: the usual bend of its readings is what counts for a period.
        let stands_out = bends.stand_out(period, first, MOST_OF_USUAL * bends.usual(period, first))?;
        Some((stands_out, Even { between: Between::Interpolated, period, first }))
    });
    // Where several periods pass, as divisors of the true one do, the one that stands out most is taken.
    candidates.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, readout)| readout)
}

/// Interpolated with this period if the other rows lie on straight lines, even if readings of a sticking sensor lie on one line
/// too.
pub fn on_lines(pressure_pa: &[f64], period: usize) -> Option<Even> {
    let bends = Bends::of(pressure_pa);
    let on_lines = (2..=bends.squares.len() / FEWEST_READINGS).contains(&period).then(|| bends.largest(period));
    let first = on_lines.flatten().filter(|(first, most)| bends.stand_out(period, *first, *most).is_some());
    first.map(|(first, _)| Even { between: Between::Interpolated, period, first })
}

/// Held if hardly any row but every `period`-th changes, interpolated if these have most of the bends; the first reading is where
/// the changes, or bends, are largest. Where the rows in between bend as much, every row is a reading, whatever was stated.
pub fn of_period(pressure_pa: &[f64], period: usize) -> Option<Even> {
    let sums = |squares: &mut dyn Iterator<Item = (usize, f64)>| {
        let mut sums = vec![0.0; period];
        squares.filter(|(_, square)| !square.is_nan()).for_each(|(row, square)| sums[row % period] += square);
        let first = (0..period).max_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
        (first, sums[first], sums.iter().sum::<f64>())
    };
    let changes = pressure_pa.windows(2).enumerate().map(|(i, w)| (i + 1, (w[1] - w[0]).powi(2)));
    let bends = pressure_pa.windows(3).enumerate().map(|(i, w)| (i + 1, (w[0] - 2.0 * w[1] + w[2]).powi(2)));
    let (first, there, all) = sums(&mut { changes });
    if all - there <= 1e-3 * all {
        return Some(Even { between: Between::Held, period, first });
    }
    /// Least fraction of the bends' squares.
    const MOST: f64 = 0.5;
    let (first, there, all) = sums(&mut { bends });
    (there >= MOST * all).then_some(Even { between: Between::Interpolated, period, first })
}
