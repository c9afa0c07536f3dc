//! The paper's method and the paper's numbers: a coefficient from one push-and-hold test.
//!
//! Push the piston with the port closed, hold it, record the pressure. There are two evaluations of that record:
//!
//! | module | holds |
//! |---|---|
//! | [`time_constant`] | the seven published steps, on a recording or on a regression printed in a table |
//! | [`exact_regression`] | 1/P = (1/Pf)(1 − a e^(−k t)): λ0 without averaging |
//! | [`recording`] | finds push and hold in a recording |
//! | [`decay`], [`statistics`] | the least squares fits and their 95 % intervals |
//! | [`tables`] | the paper's tables, embedded as CSV |
//! | [`section31`] | the paper's simulated test, evaluated both ways, and where its error comes from |
//! | [`measured`] | tables 4 and 5 from tables 1 to 3; the ambient temperature not printed in the paper |
//! | [`geometry_effect`] | dependence of λ on the chamber's shape, from the six measured points: a hypothesis |
//!
//! Source: J. F. Carneiro and F. Gomes de Almeida (2006), DOI 10.1243/09596518JSCE188, called "the paper".

pub mod decay;
mod error;
pub mod exact_regression;
pub mod geometry_effect;
pub mod measured;
pub mod recording;
pub mod section31;
pub mod statistics;
pub mod tables;
pub mod time_constant;

pub use error::Error;
pub use recording::{Recording, Relaxation};
pub use statistics::Estimate;
pub use time_constant::Setup;
