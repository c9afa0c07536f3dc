//! Designs: the points of a study. A row's point is a pure function of the design and the row's number, so that shards, threads
//! and interruptions make no difference and no state is carried between rows.

pub(crate) mod axes;
pub(crate) mod latin_hypercube;
pub(crate) mod random;
pub(crate) mod saltelli;
pub(crate) mod sobol;
pub(crate) mod table;

use crate::error::Error;
use crate::quantity::axis::Axis;
use crate::quantity::copula::Copula;
use latin_hypercube::LatinHypercube;
use saltelli::Saltelli;
use sobol::Sobol;
use std::ops::Range;
use table::Table;

pub use axes::Axes;

/// The points of a study.
#[derive(Debug)]
pub enum Design {
    /// Every combination of the axes' levels, the last axis changing fastest.
    Factorial(Axes),
    /// One row in each of `samples` equal slices of every axis.
    LatinHypercube(LatinHypercube),
    /// A scrambled low-discrepancy sequence.
    Sobol(Axes, u64, Sobol),
    /// Blocks of rows for indices of first, total and second order.
    Saltelli(Saltelli),
    /// Points listed by the user in a file.
    Table(Table),
}

/// Names of the designs in study files.
pub const NAMES: [&str; 5] = ["factorial", "latin-hypercube", "sobol", "saltelli", "table"];

impl Design {
    /// A Latin hypercube of `samples` rows.
    pub fn latin_hypercube(axes: impl Into<Axes>, samples: u64, seed: u64) -> Self {
        Design::LatinHypercube(LatinHypercube::new(axes.into(), samples, seed))
    }

    /// The first `samples` points of a scrambled Sobol' sequence.
    pub fn sobol(axes: impl Into<Axes>, samples: u64, seed: u64) -> Self {
        let axes = axes.into();
        let points = Sobol::scrambled(axes.len(), seed);
        Design::Sobol(axes, samples, points)
    }

    /// `samples` blocks of Saltelli's scheme.
    pub fn saltelli(axes: impl Into<Axes>, samples: u64, seed: u64, second_order: bool) -> Self {
        Design::Saltelli(Saltelli::new(axes.into(), samples, seed, second_order))
    }

    /// Its name in study files.
    pub fn name(&self) -> &'static str {
        match self {
            Design::Factorial(_) => NAMES[0],
            Design::LatinHypercube(_) => NAMES[1],
            Design::Sobol(..) => NAMES[2],
            Design::Saltelli(_) => NAMES[3],
            Design::Table(_) => NAMES[4],
        }
    }

    fn all_axes(&self) -> Option<&Axes> {
        match self {
            Design::Factorial(axes) | Design::Sobol(axes, ..) => Some(axes),
            Design::LatinHypercube(cube) => Some(cube.axes()),
            Design::Saltelli(saltelli) => Some(saltelli.axes()),
            Design::Table(_) => None,
        }
    }

    /// The axes; none for a table.
    pub fn axes(&self) -> &[Axis] {
        self.all_axes().map_or(&[], |axes| &**axes)
    }

    /// Correlations between some of the axes.
    pub fn copula(&self) -> Option<&Copula> {
        self.all_axes()?.copula()
    }

    /// Number of rows; `None` on overflow.
    pub fn rows(&self) -> Option<u64> {
        match self {
            Design::Factorial(axes) => axes.iter().try_fold(1u64, |rows, a| rows.checked_mul(a.levels().unwrap_or(1))),
            Design::LatinHypercube(cube) => Some(cube.rows()),
            Design::Sobol(_, samples, _) => Some(*samples),
            Design::Saltelli(saltelli) => saltelli.rows(),
            Design::Table(table) => Some(table.rows()),
        }
    }

    /// Fills one column for each varied quantity with the values of some rows.
    ///
    /// # Errors
    /// Only for a table: the file cannot be read or contains a value that is no number.
    pub fn fill(&self, rows: Range<u64>, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        for column in columns.iter_mut() {
            column.clear();
        }
        match self {
            Design::Factorial(axes) => {
                let mut repeats = 1;
                for (axis, column) in axes.iter().zip(columns).rev() {
                    let levels = axis.levels().unwrap_or(1);
                    column.extend(rows.clone().map(|row| axis.level(row / repeats % levels)));
                    repeats *= levels;
                }
            }
            Design::LatinHypercube(cube) => cube.fill(rows, columns),
            Design::Sobol(axes, _, points) => {
                for (dimension, column) in columns.iter_mut().enumerate() {
                    column
                        .extend(points.coordinates_from(rows.start, dimension).take((rows.end - rows.start) as usize));
                }
                axes.map_fractions(columns);
            }
            Design::Saltelli(saltelli) => saltelli.fill(rows, columns),
            Design::Table(table) => table.fill(rows, columns)?,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::axis::Scale;
    use proptest::prelude::*;

    fn unit_axes(n: usize) -> Vec<Axis> {
        vec![Axis::Range { from: 0.0, to: 1.0, count: None, scale: Scale::Linear }; n]
    }

    fn points(design: &Design, rows: Range<u64>, quantities: usize) -> Vec<Vec<f64>> {
        let mut columns = vec![Vec::new(); quantities];
        design.fill(rows, &mut columns).unwrap();
        columns
    }

    #[test]
    fn a_factorial_design_has_every_combination_once_and_its_last_axis_runs_fastest() {
        let list = |values: &[f64]| Axis::Values { values: values.to_vec() };
        let design = Design::Factorial(vec![list(&[1.0, 2.0]), list(&[3.0, 4.0, 5.0])].into());
        assert_eq!(design.rows(), Some(6));
        let expected = [vec![1.0, 1.0, 1.0, 2.0, 2.0, 2.0], vec![3.0, 4.0, 5.0, 3.0, 4.0, 5.0]];
        assert_eq!(points(&design, 0..6, 2), expected);
    }

    #[test]
    fn a_latin_hypercube_has_one_row_in_each_slice_of_each_axis() {
        let n = 1000;
        let columns = points(&Design::latin_hypercube(unit_axes(3), n, 5), 0..n, 3);
        for column in columns {
            let mut slices: Vec<u64> = column.iter().map(|u| (u * n as f64) as u64).collect();
            slices.sort_unstable();
            assert!(slices.into_iter().eq(0..n));
        }
    }

    #[test]
    fn another_seed_is_another_design() {
        let saltelli = |axes, samples, seed| Design::saltelli(axes, samples, seed, false);
        for design in [Design::latin_hypercube, Design::sobol, saltelli] {
            assert_ne!(points(&design(unit_axes(2), 64, 1), 0..64, 2), points(&design(unit_axes(2), 64, 2), 0..64, 2));
        }
    }

    proptest! {
        #[test]
        fn a_row_does_not_depend_on_the_rows_around_it(kind in 0..4usize, start in 0..900u64, length in 1..90u64, seed: u64) {
            let axis = Axis::Range { from: 1.0, to: 2.0, count: Some(10), scale: Scale::Log };
            let axes = vec![axis; 3];
            let design = match kind {
                0 => Design::Factorial(axes.into()),
                1 => Design::latin_hypercube(axes, 1000, seed),
                2 => Design::sobol(axes, 1000, seed),
                _ => Design::saltelli(axes, 200, seed, false),
            };
            let whole = points(&design, 0..1000, 3);
            let piece = points(&design, start..start + length, 3);
            for (whole, piece) in whole.iter().zip(&piece) {
                prop_assert_eq!(&whole[start as usize..(start + length) as usize], &piece[..]);
            }
        }
    }
}
