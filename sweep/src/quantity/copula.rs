//! Correlated quantities: a Gaussian copula, which gives their probabilities the correlations of normal variables and leaves each
//! quantity's distribution unchanged.
//!
//! With u uniform and independent, z = F Φ⁻¹(u) is normal with the correlations F Fᵀ, and Φ(z) is uniform again. F is made of the
//! eigenvectors, the largest eigenvalue first, so that the first and best dimension of a low-discrepancy sequence carries most of
//! the variation; correlations of one are allowed.

use super::distribution::{normal, normal_quantile};
use nalgebra::{DMatrix, SymmetricEigen};

/// Rounding tolerance of correlations, as an eigenvalue below zero.
const ROUNDING: f64 = 1e-6;
/// Probabilities are kept away from 0 and 1, which have no finite normal variable.
const TAIL: f64 = 1.0 / (1u64 << 53) as f64;

/// The correlations between the probabilities of some columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Copula {
    columns: Vec<usize>,
    correlation: DMatrix<f64>,
    factor: DMatrix<f64>,
}

impl Copula {
    /// Copula of these columns with these correlations; `None` if they contradict each other.
    pub fn new(columns: Vec<usize>, correlation: &DMatrix<f64>) -> Option<Self> {
        let eigen = SymmetricEigen::new(correlation.clone());
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        if order.iter().any(|i| eigen.eigenvalues[*i].is_nan() || eigen.eigenvalues[*i] < -ROUNDING) {
            return None;
        }
        let factor = DMatrix::from_fn(columns.len(), columns.len(), |row, k| {
            eigen.eigenvectors[(row, order[k])] * eigen.eigenvalues[order[k]].max(0.0).sqrt()
        });
        Some(Self { columns, correlation: correlation.clone(), factor })
    }

    /// Indices of the correlated columns.
    pub fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// Correlation matrix of these columns, row by row.
    pub fn correlation(&self) -> Vec<Vec<f64>> {
        self.correlation.row_iter().map(|row| row.iter().copied().collect()).collect()
    }

    /// Whether any two of the columns are correlated.
    pub fn is_correlated(&self) -> bool {
        let n = self.columns.len();
        (0..n).any(|i| (0..i).any(|j| self.correlation[(i, j)] != 0.0))
    }

    /// Replaces independent probabilities with correlated ones.
    pub fn apply(&self, probabilities: &mut [Vec<f64>]) {
        if !self.is_correlated() {
            return;
        }
        let rows = self.columns.first().map_or(0, |column| probabilities[*column].len());
        let mut independent = vec![0.0; self.columns.len()];
        (0..rows).for_each(|row| {
            for (z, column) in independent.iter_mut().zip(&self.columns) {
                *z = normal_quantile(probabilities[*column][row].clamp(TAIL, 1.0 - TAIL));
            }
            for (i, column) in self.columns.iter().enumerate() {
                let z: f64 = independent.iter().enumerate().map(|(k, z)| self.factor[(i, k)] * z).sum();
                probabilities[*column][row] = normal(z);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::random::{Stream, unit};

    fn matrix(rows: [[f64; 3]; 3]) -> DMatrix<f64> {
        DMatrix::from_fn(3, 3, |i, j| rows[i][j])
    }

    #[test]
    fn probabilities_get_their_correlations_and_stay_uniform() {
        let correlation = matrix([[1.0, 0.8, -0.3], [0.8, 1.0, 0.1], [-0.3, 0.1, 1.0]]);
        let copula = Copula::new(vec![2, 0, 1], &correlation).unwrap();
        let n = 100_000;
        let column = |key| (0..n).map(|i| unit(Stream::new(key).at(i))).collect::<Vec<_>>();
        let mut probabilities = [column(1), column(2), column(3)];
        copula.apply(&mut probabilities);
        let z: Vec<Vec<f64>> =
            [2, 0, 1].map(|c: usize| probabilities[c].iter().map(|u| normal_quantile(*u)).collect()).into();
        let mean = |f: &dyn Fn(usize) -> f64| (0..n as usize).map(f).sum::<f64>() / n as f64;
        for i in 0..3 {
            assert!(mean(&|r| z[i][r]).abs() < 0.015 && (mean(&|r| z[i][r] * z[i][r]) - 1.0).abs() < 0.02);
            for j in 0..i {
                // Its standard error is (1 − ρ²)/√n < 0.0032.
                assert!((mean(&|r| z[i][r] * z[j][r]) - correlation[(i, j)]).abs() < 0.015, "{i} {j}");
            }
        }
    }

    #[test]
    fn a_correlation_of_one_is_one_quantity_and_contradictions_are_refused() {
        let ones = matrix([[1.0; 3]; 3]);
        let copula = Copula::new(vec![0, 1, 2], &ones).unwrap();
        let mut probabilities = [vec![0.3, 0.9], vec![0.1, 0.2], vec![0.6, 0.7]];
        copula.apply(&mut probabilities);
        for other in [1, 2] {
            assert!(probabilities[0].iter().zip(&probabilities[other]).all(|(a, b)| (a - b).abs() < 1e-7));
        }
        let impossible = matrix([[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]]);
        assert_eq!(Copula::new(vec![0, 1, 2], &impossible), None);
    }
}
