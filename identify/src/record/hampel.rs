//! What finds readings that are far off, of pressures and of positions alike: Hampel's identifier (J. Am. Stat. Assoc. 69 (1974)
//! 383), by the median of the readings around one and their median distance from it, which a few far ones do not move.

use records::median;

/// More than this share of outliers is no accident but the noise itself.
const MOST: f64 = 0.02;

/// The median of readings and their median distance from it; they are left as these distances. At least one.
pub fn middle_and_scatter(readings: &mut [f64]) -> [f64; 2] {
    let middle = median(&mut *readings);
    readings.iter_mut().for_each(|r| *r = (*r - middle).abs());
    [middle, median(readings)]
}

/// The outliers that were found among so many rows, none where these are too many.
pub fn accidental(found: Vec<usize>, rows: usize) -> Vec<usize> {
    if found.len() as f64 > (MOST * rows as f64).max(3.0) { Vec::new() } else { found }
}
