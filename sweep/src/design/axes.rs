//! The axes of a design: the values of each varied quantity, and their correlations.

use crate::quantity::axis::Axis;
use crate::quantity::copula::Copula;

/// The varied quantities of a design: the values of each, and their correlations.
#[derive(Clone, Debug)]
pub struct Axes {
    list: Vec<Axis>,
    /// Correlations between some of the axes.
    copula: Option<Copula>,
}

impl From<Vec<Axis>> for Axes {
    fn from(list: Vec<Axis>) -> Self {
        Self { list, copula: None }
    }
}

impl Axes {
    /// Axes, and the correlations between some of them.
    pub fn new(list: Vec<Axis>, copula: Option<Copula>) -> Self {
        Self { list, copula }
    }

    /// Correlations between some of the axes.
    pub fn copula(&self) -> Option<&Copula> {
        self.copula.as_ref()
    }

    /// Maps fractions in [0, 1) to values, one column for each axis.
    pub fn map_fractions(&self, columns: &mut [Vec<f64>]) {
        if let Some(copula) = &self.copula {
            copula.apply(columns);
        }
        for (axis, column) in self.list.iter().zip(columns) {
            axis.map_fractions(column);
        }
    }
}

impl std::ops::Deref for Axes {
    type Target = [Axis];

    fn deref(&self) -> &[Axis] {
        &self.list
    }
}
