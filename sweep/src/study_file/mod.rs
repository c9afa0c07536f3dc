//! Study files. Unknown keys and values out of range are refused, with file, line and key.
//!
//! | module | reads |
//! |---|---|
//! | `read` | a whole file: [`Study::read`](crate::Study::read) |
//! | `section` | one of its tables, key by key |
//! | `names` | accepted names of a quantity |
//! | `points`, `vary` | `[vary]`, or the columns of a table |
//! | `constraints`, `comparison` | which points are solved |
//! | `test` | `[test]` |
//! | `size` | limits on the numbers of rows and parts |
//! | `check` | values that no row could use |
//! | `statistics` | `[statistics]` |

mod check;
mod comparison;
mod constraints;
mod names;
mod points;
mod read;
mod section;
mod size;
mod statistics;
mod test;
mod vary;

use crate::error::Error;
use ensemble::Solver;
use std::ops::RangeInclusive;

/// Names of the solvers in study files and on the command line.
pub const SOLVERS: [(&str, Solver); 3] =
    [("auto", Solver::Auto), ("exact", Solver::Exact), ("adaptive", Solver::Adaptive)];

/// Allowed relative tolerances.
const TOLERANCES: RangeInclusive<f64> = 1e-13..=1e-2;

/// Settings that replace those of a study file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// The solver of the equations.
    pub solver: Option<Solver>,
    /// Relative tolerance of the adaptive integration.
    pub tolerance: Option<f64>,
}

impl Overrides {
    /// The tolerance, if given.
    fn tolerance(&self) -> Result<Option<f64>, Error> {
        match self.tolerance.filter(|tolerance| !TOLERANCES.contains(tolerance)) {
            None => Ok(self.tolerance),
            Some(tolerance) => {
                let (least, most) = (TOLERANCES.start(), TOLERANCES.end());
                Err(Error::Option(format!(
                    "the tolerance is {tolerance}; expected a number from {least:e} to {most:e}"
                )))
            }
        }
    }
}
