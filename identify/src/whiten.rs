//! Block residuals in units of their noise, made independent of each other.
//!
//! The blocks of one hold share the error of that hold's mean position and of the time at which its move was over: their
//! covariance is D + c₁ c₁ᵀ + c₂ c₂ᵀ with D diagonal and c the common deviations. One c at a time: with D^(−1/2) applied,
//! w = D^(−1/2) c and Σ' = I + w wᵀ, whose inverse root is I − (1 − 1/√(1 + |w|²)) w wᵀ/|w|². It is applied to residuals,
//! to every column of sensitivities, and to the next c.

use crate::prepare::Block;
use nalgebra::DMatrix;

/// Divides each row of `columns` (one for each block) by its block's deviation and takes out what holds have in common.
pub fn whiten(blocks: &[Block], columns: &mut DMatrix<f64>) {
    for (row, b) in blocks.iter().enumerate().take(columns.nrows()) {
        columns.row_mut(row).scale_mut(1.0 / b.sd_pa);
    }
    let mut first = 0;
    while first < columns.nrows() {
        let segment = blocks[first].segment;
        let end = (first..columns.nrows()).find(|&i| blocks[i].segment != segment).unwrap_or(columns.nrows());
        let mut common: Vec<Vec<f64>> =
            (0..2).map(|k| blocks[first..end].iter().map(|b| b.common_sd_pa[k] / b.sd_pa).collect()).collect();
        while let Some(w) = common.pop() {
            let square: f64 = w.iter().map(|w| w * w).sum();
            if square < 1e-6 {
                continue;
            }
            let share = (1.0 - 1.0 / (1.0 + square).sqrt()) / square;
            let take_out = |column: &mut [f64]| {
                let along: f64 = w.iter().zip(&*column).map(|(w, x)| w * x).sum();
                column.iter_mut().zip(&w).for_each(|(x, w)| *x -= share * along * w);
            };
            common.iter_mut().for_each(|next| take_out(next));
            for mut column in columns.column_iter_mut() {
                take_out(&mut column.as_mut_slice()[first..end]);
            }
        }
        first = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Phase;

    #[test]
    fn a_deviation_that_a_hold_has_in_common_counts_once() {
        let block = |segment, sd_pa, common_sd_pa: [f64; 2]| Block {
            first: 0,
            end: 1,
            points_s: [0.0; 2],
            mean_pa: 1e5,
            sd_pa,
            common_sd_pa,
            phase: Phase::Hold,
            segment,
        };
        let blocks =
            [block(0, 2.0, [0.0; 2]), block(1, 1.0, [3.0, 1.0]), block(1, 2.0, [3.0, 0.5]), block(1, 0.5, [3.0, -0.2])];
        // The inverse covariance is what the whitened unit vectors' products give.
        let mut root = DMatrix::identity(4, 4);
        whiten(&blocks, &mut root);
        let ours = root.transpose() * root;
        let covariance = DMatrix::from_fn(4, 4, |i, j| {
            let common: f64 = (0..2).map(|k| blocks[i].common_sd_pa[k] * blocks[j].common_sd_pa[k]).sum();
            let common = if blocks[i].segment == blocks[j].segment { common } else { 0.0 };
            common + if i == j { blocks[i].sd_pa.powi(2) } else { 0.0 }
        });
        assert!((ours * covariance - DMatrix::<f64>::identity(4, 4)).norm() < 1e-12);
    }
}
