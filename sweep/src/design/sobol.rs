//! Sobol' points with random access: low-discrepancy points in [0, 1)^d, for up to 128 dimensions and 2^52 points.
//!
//! Direction numbers: S. Joe and F. Y. Kuo (2008), "Constructing Sobol sequences with better two-dimensional
//! projections", the first 128 dimensions of their table (`joe_kuo_128.txt`, with its licence beside it). Scrambling:
//! J. Matoušek (1998), "On the L2-discrepancy for anchored boxes" — a random lower triangular matrix on the digits and a
//! random digital shift, as scipy's `qmc.Sobol` does. Points are taken in the natural order of the index rather than in
//! Gray code order; blocks of 2^m points are the same sets.

use super::random::mix;
use std::sync::LazyLock;

/// Binary digits of a point: those that a double has for a number in [0, 1).
const BITS: usize = 52;
/// Dimensions in the table.
pub const DIMENSIONS: usize = 128;

/// Scrambled points of some dimensions.
#[derive(Clone, Debug)]
pub struct Sobol {
    /// For each dimension, the digits added (modulo 2) by each bit of the index, and the shift.
    dimensions: Vec<([u64; BITS], u64)>,
}

impl Sobol {
    /// Points of this many dimensions, at most [`DIMENSIONS`], scrambled by a seed.
    pub fn scrambled(dimensions: usize, seed: u64) -> Self {
        let scrambled = (0..dimensions).map(|d| {
            let key = mix(seed, 0x50b0_1000 + d as u64);
            let shift = mix(key, BITS as u64) >> (64 - BITS);
            (DIRECTIONS[d].map(|direction| scramble(direction, key)), shift)
        });
        Self { dimensions: scrambled.collect() }
    }

    /// Coordinate of a point.
    #[inline]
    pub fn coordinate(&self, index: u64, dimension: usize) -> f64 {
        unit_fraction(self.digits(index, dimension))
    }

    /// Coordinates of a point and of all points after it.
    pub fn coordinates_from(&self, mut index: u64, dimension: usize) -> impl Iterator<Item = f64> {
        let mut digits = self.digits(index, dimension);
        // Incrementing an index flips its lowest bits, up to the one that becomes 1.
        let mut changes = self.dimensions[dimension].0;
        for bit in 1..BITS {
            changes[bit] ^= changes[bit - 1];
        }
        std::iter::repeat_with(move || {
            let value = unit_fraction(digits);
            index += 1;
            digits ^= changes[index.trailing_zeros() as usize];
            value
        })
    }

    #[inline]
    fn digits(&self, index: u64, dimension: usize) -> u64 {
        let (directions, shift) = &self.dimensions[dimension];
        let (mut digits, mut rest) = (*shift, index);
        while rest != 0 {
            digits ^= directions[rest.trailing_zeros() as usize];
            rest &= rest - 1;
        }
        digits
    }
}

/// Binary digits after the point as a number in [0, 1).
#[inline]
fn unit_fraction(digits: u64) -> f64 {
    digits as f64 * (1.0 / (1u64 << BITS) as f64)
}

/// Multiplies digits by a random lower triangular matrix with a unit diagonal, modulo 2: digit i of the result is digit i of the
/// number plus a random selection of its higher digits.
fn scramble(digits: u64, key: u64) -> u64 {
    let mut result = 0;
    for digit in 0..BITS {
        let bit = BITS - 1 - digit;
        let higher = if digit == 0 { 0 } else { (mix(key, digit as u64) << (bit + 1)) & ((1 << BITS) - 1) };
        let row = 1 << bit | higher;
        result |= u64::from((digits & row).count_ones() & 1) << bit;
    }
    result
}

/// Direction numbers of each dimension, as digits: bit BITS − 1 is the first digit after the point.
static DIRECTIONS: LazyLock<Vec<[u64; BITS]>> = LazyLock::new(|| {
    let mut table = vec![std::array::from_fn(|i| 1 << (BITS - 1 - i))];
    for line in include_str!("joe_kuo_128.txt").lines().skip(1) {
        let mut numbers = line.split_ascii_whitespace().map_while(|word| word.parse::<u64>().ok()).skip(1);
        let (Some(degree), Some(polynomial)) = (numbers.next(), numbers.next()) else { break };
        let initial: Vec<u64> = numbers.collect();
        table.push(directions(degree as usize, polynomial, &initial));
    }
    table
});

/// The recurrence of a primitive polynomial x^s + a1 x^(s−1) + … + 1 (Bratley and Fox 1988, Algorithm 659).
fn directions(degree: usize, polynomial: u64, initial: &[u64]) -> [u64; BITS] {
    let mut v = [0; BITS];
    for i in 0..BITS {
        if i < degree {
            v[i] = initial[i] << (BITS - 1 - i);
        } else {
            v[i] = v[i - degree] ^ (v[i - degree] >> degree);
            for k in 1..degree {
                if polynomial >> (degree - 1 - k) & 1 == 1 {
                    v[i] ^= v[i - k];
                }
            }
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(index: u64, dimension: usize) -> f64 {
        let points = Sobol { dimensions: DIRECTIONS.iter().map(|d| (*d, 0)).collect() };
        points.coordinate(index, dimension)
    }

    #[test]
    fn the_table_has_all_its_dimensions() {
        assert_eq!(DIRECTIONS.len(), DIMENSIONS);
    }

    #[test]
    fn unscrambled_points_are_those_of_scipy() {
        // sorted(scipy.stats.qmc.Sobol(128, scramble=False).random(8)[:, d]) is the same for all d; what identifies the
        // table is which points go together: the sum over dimensions of index-weighted coordinates of 1024 points.
        let golden = include_str!("sobol_scipy_1024.txt");
        for line in golden.lines().filter(|line| !line.starts_with('#')) {
            let mut words = line.split_ascii_whitespace();
            let dimension: usize = words.next().unwrap().parse().unwrap();
            for (word, index) in words.zip([1u64, 2, 3, 5, 100, 1000, 1023]) {
                // scipy uses Gray code order: its n-th point is our point n ^ (n >> 1).
                assert_eq!(plain(index ^ (index >> 1), dimension), word.parse::<f64>().unwrap(), "{dimension} {index}");
            }
        }
    }

    #[test]
    fn every_block_of_points_has_one_in_each_interval_scrambled_or_not() {
        for seed in 0..3 {
            let sobol = Sobol::scrambled(DIMENSIONS, seed);
            for dimension in 0..DIMENSIONS {
                for start in [0, 256, 1 << 40] {
                    let mut seen = [false; 256];
                    for i in start..start + 256 {
                        seen[(sobol.coordinate(i, dimension) * 256.0) as usize] = true;
                    }
                    assert!(seen.iter().all(|&s| s), "{seed} {dimension} {start}");
                }
            }
        }
    }

    #[test]
    fn the_first_two_dimensions_are_a_net_after_scrambling() {
        // A (0, m, 2)-net in base 2: every elementary interval of area 2^-m holds exactly one of 2^m points.
        let sobol = Sobol::scrambled(2, 7);
        for split in 0..=8 {
            let (columns, rows) = (1usize << split, 1usize << (8 - split));
            let mut seen = vec![0; 256];
            for i in 0..256 {
                let column = (sobol.coordinate(i, 0) * columns as f64) as usize;
                let row = (sobol.coordinate(i, 1) * rows as f64) as usize;
                seen[column * rows + row] += 1;
            }
            assert!(seen.iter().all(|&n| n == 1), "split {split}");
        }
    }
}
