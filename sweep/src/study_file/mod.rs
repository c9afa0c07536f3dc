//! Study files. Unknown keys and values out of range are refused with file, line and key.
//!
//! | module | reads |
//! |---|---|
//! | `read` | a whole file: [`Study::read`](crate::Study::read) |
//! | `section` | one of its tables, key by key |
//! | `names` | what people may call a quantity |
//! | `points`, `vary` | `[vary]`, or the columns of a table |
//! | `constraints`, `comparison` | which points make sense |
//! | `test` | `[test]` |
//! | `size` | how many rows and parts there may be |
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

/// Relative tolerances that make sense.
const TOLERANCES: RangeInclusive<f64> = 1e-13..=1e-2;

/// What takes the place of a study file's own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// How the equations are solved.
    pub solver: Option<Solver>,
    /// Relative tolerance of the adaptive integration.
    pub tolerance: Option<f64>,
}

impl Overrides {
    /// The tolerance, where there is one.
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
