//! FMI 2.0.5: the C functions and the model description, for Model Exchange and co-simulation.

pub mod abi;
#[cfg(feature = "package")]
pub mod description;
pub mod host;
