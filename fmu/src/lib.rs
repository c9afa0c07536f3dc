//! The chamber as a Functional Mock-up Unit: FMI 2.0 or 3.0, Model Exchange and co-simulation in one.
//!
//! | folder | holds | knows |
//! |---|---|---|
//! | [`plant`] | the chamber between its ports, its wall and its piston: states, rates, inputs, history | numbers by index |
//! | [`table`] | the one table of variables with its units and dependencies | the plant |
//! | [`start_values`] | the block of start values inside the library | both |
//! | [`protocol`] | one instance: phases of the life cycle, batches taken whole or not at all, saved states, warnings | all of these |
//! | [`identity`] | who an FMU is | nothing |
//! | [`boundary`], [`description`] | what both versions of FMI share: the checks at the C boundary, the description's parts, written with [`xml`] | all of these |
//! | [`fmi2`], [`fmi3`] | each version's C functions and its words in the description; with [`boundary`], the only `unsafe` of the project | all of these |
//! | [`package`] | the FMU as a file: signatures, documentation, reference experiments | all of these |
//!
//! The shared library inside the FMU is built without the feature `package`, so without descriptions and archives.

#![warn(clippy::undocumented_unsafe_blocks)]
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod boundary;
#[cfg(feature = "package")]
pub mod description;
pub mod fmi2;
pub mod fmi3;
#[cfg(feature = "package")]
pub mod identity;
#[cfg(feature = "package")]
pub mod package;
pub mod plant;
pub mod protocol;
pub mod start_values;
pub mod table;
#[cfg(feature = "package")]
pub mod xml;
