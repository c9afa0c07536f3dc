//! Saltelli's scheme for Sobol' indices: blocks of rows around two independent points A and B.
//!
//! A block is A; A with one column of B, for each quantity; for second-order indices B with one column of A, for each quantity; B
//! (Saltelli 2002). The points alternate between [`REPLICATES`] independently scrambled Sobol' sequences, so that the scatter
//! between them shows the accuracy of the indices, and further blocks continue all of them.

use super::axes::Axes;
use super::random::mix;
use super::sobol::Sobol;
use std::ops::Range;

/// Number of alternating sequences: block k is point k div `REPLICATES` of sequence k mod `REPLICATES`. More of them would
/// estimate their scatter better but spread the points less evenly.
pub const REPLICATES: u64 = 16;

/// Composition of a block of rows.
#[derive(Clone, Copy, Debug)]
pub struct Scheme {
    /// Number of varied quantities.
    pub axes: usize,
    /// Whether it has rows for second-order indices.
    pub second: bool,
}

impl Scheme {
    /// Rows of a block.
    pub fn rows(self) -> u64 {
        self.axes as u64 * if self.second { 2 } else { 1 } + 2
    }

    /// The pairs of quantities that have an index.
    pub fn pairs(self) -> impl Iterator<Item = (usize, usize)> {
        let n = if self.second { self.axes } else { 0 };
        (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
    }

    /// Whether a row of a block takes a quantity's value from B instead of A.
    fn is_of_b(self, row: u64, quantity: usize) -> bool {
        let (n, quantity) = (self.axes as u64, quantity as u64);
        match row {
            0 => false,
            row if row == self.rows() - 1 => true,
            row if row <= n => row - 1 == quantity,
            row => row - n - 1 != quantity,
        }
    }
}

/// Blocks of Saltelli's scheme.
#[derive(Debug)]
pub struct Saltelli {
    axes: Axes,
    samples: u64,
    scheme: Scheme,
    /// A and B, side by side.
    replicates: Vec<Sobol>,
}

impl Saltelli {
    /// `samples` blocks over the axes; `second` adds the rows for indices of pairs.
    pub fn new(axes: Axes, samples: u64, seed: u64, second: bool) -> Self {
        let scheme = Scheme { axes: axes.len(), second };
        let replicates = (0..REPLICATES).map(|number| Sobol::scrambled(2 * axes.len(), mix(seed, number))).collect();
        Self { axes, samples, scheme, replicates }
    }

    /// The varied quantities.
    pub fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Number of blocks.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Composition of a block.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Number of rows; `None` on overflow.
    pub fn rows(&self) -> Option<u64> {
        self.samples.checked_mul(self.scheme.rows())
    }

    /// Appends the values of some rows to one column for each quantity.
    pub fn fill(&self, rows: Range<u64>, columns: &mut [Vec<f64>]) {
        for (quantity, column) in columns.iter_mut().enumerate() {
            let coordinate = |row: u64| {
                let (block, row) = (row / self.scheme.rows(), row % self.scheme.rows());
                let sequence = &self.replicates[(block % REPLICATES) as usize];
                let of_b = if self.scheme.is_of_b(row, quantity) { self.axes.len() } else { 0 };
                sequence.coordinate(block / REPLICATES, quantity + of_b)
            };
            column.extend(rows.clone().map(coordinate));
        }
        self.axes.map_fractions(columns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::axis::{Axis, Scale};

    /// The rows of a design of three quantities, block after block.
    fn blocks(samples: u64, second: bool) -> Vec<Vec<[f64; 3]>> {
        let axis = Axis::Range { from: 0.0, to: 1.0, count: None, scale: Scale::Linear };
        let design = Saltelli::new(vec![axis; 3].into(), samples, 1, second);
        let mut columns = vec![Vec::new(); 3];
        design.fill(0..design.rows().unwrap(), &mut columns);
        let rows: Vec<[f64; 3]> = (0..columns[0].len()).map(|i| std::array::from_fn(|d| columns[d][i])).collect();
        rows.chunks(design.scheme().rows() as usize).map(<[_]>::to_vec).collect()
    }

    #[test]
    fn a_block_changes_one_column_at_a_time_and_for_second_order_all_but_one_too() {
        for second in [false, true] {
            let blocks = blocks(40, second);
            assert_eq!(blocks.len(), 40);
            for block in blocks {
                let (a, b) = (block[0], block[block.len() - 1]);
                for k in 0..3 {
                    let (mut of_a, mut of_b) = (a, b);
                    (of_a[k], of_b[k]) = (b[k], a[k]);
                    assert_ne!(a[k], b[k]);
                    assert_eq!(block[1 + k], of_a);
                    if second {
                        assert_eq!(block[4 + k], of_b);
                    }
                }
            }
        }
    }

    #[test]
    fn each_replicate_is_a_sequence_of_its_own() {
        let n = 64;
        let blocks = blocks(n * REPLICATES, false);
        let sequence = |number: usize| blocks.iter().skip(number).step_by(REPLICATES as usize).map(|block| block[0][0]);
        for number in 0..REPLICATES as usize {
            let mut slices: Vec<u64> = sequence(number).map(|u| (u * n as f64) as u64).collect();
            slices.sort_unstable();
            assert!(slices.into_iter().eq(0..n), "{number}");
            assert!((0..number).all(|other| !sequence(other).eq(sequence(number))), "{number}");
        }
    }
}
