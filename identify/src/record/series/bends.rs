//! Bends of a column: where its rows do not lie on straight lines, as the rows between readings of an interpolated one do.
//! Pressures in Pa, positions in µm.

use super::lattice::{self, lattice};
use records::median;

/// Largest square of a bend that counts, over the usual one of a reading.
pub const MOST_OF_USUAL: f64 = 25.0;

/// Squares of the second differences of a column's rows, from the second row on.
pub struct Bends {
    /// One for each inner row.
    pub squares: Vec<f64>,
    /// The nonzero ones, largest first.
    largest: Vec<f64>,
    /// Square of a bend due to rounding.
    pub rounding: f64,
}

/// Whether rows between readings, with these squared bends, have noise of their own, like those between the corners of a
/// triangle: then they are readings too. Rounding bends a straight line by at most one step; where rows have no steps, only their
/// uneven timing bends it while the column changes.
pub fn scatter(squares: impl Iterator<Item = f64>, rounding: f64) -> bool {
    /// Square of one and a half steps, over that due to rounding.
    const OF_ROUNDING: f64 = 3.0;
    let share = if rounding > 0.0 { 0.05 } else { 0.75 };
    let (mut rows, mut scattered) = (0usize, 0usize);
    for square in squares {
        rows += 1;
        scattered += usize::from(square > OF_ROUNDING * rounding);
    }
    scattered as f64 > share * rows as f64
}

impl Bends {
    /// From a column's rows; one that is NaN, and those beside it, show no bend.
    pub fn of(rows: &[f64]) -> Self {
        /// Smaller bends are arithmetic rounding, Pa.
        const NOTHING: f64 = 1e-6;
        let size = |w: &[f64]| Some((w[0] - 2.0 * w[1] + w[2]).abs()).filter(|size| *size > NOTHING);
        let bends: Vec<Option<f64>> = rows.windows(3).map(size).collect();
        // On straight lines only rounding bends; the slopes need not differ by single steps. Where they do, they also show the
        // sensor's steps in a file whose digits are rounded differently, which bends where the steps do not.
        let steps = lattice::of_changes(rows, NOTHING);
        let step = lattice(&mut bends.iter().copied().flatten().collect::<Vec<f64>>()).max(steps);
        let squares: Vec<f64> = bends.into_iter().map(|bend| bend.map_or(0.0, |size| size * size)).collect();
        let mut largest: Vec<f64> = squares.iter().copied().filter(|s| *s > 0.0).collect();
        largest.sort_unstable_by(|a, b| b.total_cmp(a));
        // Rounding gives a second difference the variance 6 step²/12.
        Self { squares, largest, rounding: 1.5 * 0.5 * step * step }
    }

    fn at(&self, period: usize, first: usize) -> impl Iterator<Item = f64> {
        let row = (first + period - 1) % period;
        self.squares.iter().skip(row).step_by(period).copied()
    }

    /// Where the readings of this period begin if they bend most, and the limit for the square of each of them.
    pub fn largest(&self, period: usize) -> Option<(usize, f64)> {
        let most = MOST_OF_USUAL * self.largest.get(self.squares.len() / (2 * period)).or(self.largest.last())?;
        let sum = |first: &usize| self.at(period, *first).map(|s| s.min(most)).sum::<f64>();
        let first = (0..period).max_by(|a, b| sum(a).total_cmp(&sum(b)))?;
        Some((first, most))
    }

    /// Median square at those readings: a sensor that sticks to its steps bends only here and there, an interpolated one at
    /// nearly every reading.
    pub fn usual(&self, period: usize, first: usize) -> f64 {
        median(self.at(period, first).collect::<Vec<f64>>())
    }

    /// How far those readings stand out from the rows between them, which lie on straight lines; `None` if they do not. Squares
    /// are limited to `most`.
    pub fn stand_out(&self, period: usize, first: usize, most: f64) -> Option<f64> {
        /// Largest mean square at the other rows over that at the readings, where rows are not rounded.
        const SMALL: f64 = 0.01;
        /// The same where rounding hides part of it...
        const CLEAR: f64 = 0.6;
        /// ...and standard deviations by which the readings' sum exceeds the other rows': the best of many periods and starts is
        /// taken.
        const DEVIATIONS: f64 = 8.0;
        let [mut sum, mut squares] = [0.0; 2];
        for square in self.squares.iter().map(|s| s.min(most)) {
            sum += square;
            squares += square * square;
        }
        let (mut at_readings, mut squares_there, mut readings) = (0.0, 0.0, 0.0);
        for square in self.at(period, first).map(|s| s.min(most)) {
            at_readings += square;
            squares_there += square * square;
            readings += 1.0;
        }
        let others = self.squares.len() as f64 - readings;
        let mean = (sum - at_readings) / others;
        let variance = ((squares - squares_there) / others - mean * mean).max(0.0);
        let (there, above) = (at_readings / readings, at_readings - readings * mean);
        let clearly =
            || mean < self.rounding && mean < CLEAR * there && above > DEVIATIONS * (readings * variance).sqrt();
        let scatter = || {
            let between = self.squares.iter().enumerate().filter(|(row, _)| (row + 1) % period != first % period);
            scatter(between.map(|(_, square)| *square), self.rounding)
        };
        ((mean < SMALL * there || clearly()) && !scatter()).then(|| above / readings.sqrt())
    }
}
