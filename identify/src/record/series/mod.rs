//! Statistics of one column of readings, of pressures or positions alike; nothing here knows what the column measures.
//!
//! In: the values of the rows, some with their times. Out: a number, or rows that stand out. The parts are independent, except
//! that `bends` uses `lattice`:
//!
//! | module | gives |
//! |---|---|
//! | `lattice` | the step of the converter or encoder |
//! | `scatter` | the standard deviation of the noise about a smooth course, from differences |
//! | `hampel` | median and median deviation, against which an outlier is judged |
//! | `local_cubic` | the value and slope of a cubic through the rows around a row |
//! | `bends` | second differences: where straight lines between rows meet |

pub(super) mod bends;
pub(super) mod hampel;
pub(super) mod lattice;
pub(super) mod local_cubic;
pub(super) mod scatter;
