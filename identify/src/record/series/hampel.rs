//! Identification of outlying readings, of pressures and of positions alike: Hampel's identifier (J. Am. Stat. Assoc. 69 (1974)
//! 383), from the median of the readings around one and their median distance from it, which a few outliers do not change.

use records::median;

/// A larger fraction of outliers is no accident but the noise itself.
const MOST: f64 = 0.02;

/// The median of at least one reading and their median distance from it; the readings are overwritten by these distances.
pub fn middle_and_scatter(readings: &mut [f64]) -> [f64; 2] {
    let middle = median(&mut *readings);
    readings.iter_mut().for_each(|r| *r = (*r - middle).abs());
    [middle, median(readings)]
}

/// The outliers found among `rows` rows; none if they are too many.
pub fn accidental(found: Vec<usize>, rows: usize) -> Vec<usize> {
    if found.len() as f64 > (MOST * rows as f64).max(3.0) { Vec::new() } else { found }
}
