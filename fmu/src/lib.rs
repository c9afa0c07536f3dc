//! The chamber as a Functional Mock-up Unit: FMI 2.0 or 3.0, Model Exchange and co-simulation in one.
//!
//! | folder | contents | depends on |
//! |---|---|---|
//! | [`plant`] | the chamber between its ports, wall and piston: states, rates, inputs, history | numbers by index |
//! | [`table`] | the one table of variables with units and dependencies | the plant |
//! | [`start_values`] | the block of start values inside the library | both |
//! | [`protocol`] | one instance: phases of the life cycle, all-or-nothing batches, saved states, warnings | all of these |
//! | [`identity`] | identity of an FMU | nothing |
//! | [`boundary`], [`description`] | shared by both FMI versions: the checks at the C boundary, the parts of the description,
//! written with [`xml`] | all of these |
//! | [`fmi2`], [`fmi3`] | each version's C functions and dialect of the description; with [`boundary`], the only `unsafe` of the
//! project | all of these |
//! | [`package`] | the FMU as a file: signatures, documentation, reference experiments | all of these |
//!
//! The shared library inside the FMU is built without the feature `package`, hence without descriptions and archives.

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
