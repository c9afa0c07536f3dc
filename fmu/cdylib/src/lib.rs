//! The shared library inside the FMU: the C functions of [`fmu::fmi2::abi`] and [`fmu::fmi3::abi`], and nothing else.

#![allow(non_snake_case, reason = "the crate's name is the library's")]

pub use fmu::fmi2::abi::*;
pub use fmu::fmi3::abi::*;
