//! A Latin hypercube: one row in each of `samples` equal slices of every axis, at a random position in its slice.

use super::axes::Axes;
use super::random::{Permutation, Stream, mix, unit};
use pulp::{Arch, Simd, WithSimd};
use std::ops::Range;

/// Permutation of the slices and random positions for each axis.
#[derive(Debug)]
pub struct LatinHypercube {
    axes: Axes,
    samples: u64,
    columns: Vec<(Permutation, Stream)>,
}

impl LatinHypercube {
    /// A Latin hypercube of `samples` rows.
    pub fn new(axes: Axes, samples: u64, seed: u64) -> Self {
        let keys = (0..axes.len() as u64).map(|d| (mix(seed, 2 * d), mix(seed, 2 * d + 1)));
        let columns =
            keys.map(|(permutation, offsets)| (Permutation::new(samples, permutation), Stream::new(offsets))).collect();
        Self { axes, samples, columns }
    }

    /// The sampled axes, one column each.
    pub fn axes(&self) -> &Axes {
        &self.axes
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.samples
    }

    /// Fills one column for each axis with the values of some rows.
    pub fn fill(&self, rows: Range<u64>, columns: &mut [Vec<f64>]) {
        let mut slices = vec![0; (rows.end - rows.start) as usize];
        for ((permutation, offsets), column) in self.columns.iter().zip(columns.iter_mut()) {
            permutation.fill(rows.start, &mut slices);
            column.resize(slices.len(), 0.0);
            let (first_row, samples) = (rows.start, self.samples as f64);
            Arch::new().dispatch(Positions { slices: &slices, samples, offsets: *offsets, first_row, out: column });
        }
        self.axes.map_fractions(columns);
    }
}

/// Random positions in slices of an axis, as fractions of the axis.
struct Positions<'a> {
    slices: &'a [u64],
    samples: f64,
    offsets: Stream,
    first_row: u64,
    out: &'a mut [f64],
}

impl WithSimd for Positions<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let mut i = 0;
        while i < self.slices.len() && i < self.out.len() {
            let within = unit(self.offsets.at(self.first_row + i as u64));
            self.out[i] = (self.slices[i] as f64 + within) / self.samples;
            i += 1;
        }
    }
}
