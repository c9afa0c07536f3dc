//! The shared library inside the FMU: the C functions of [`fmu::abi`], and nothing else.

#![allow(non_snake_case, reason = "the crate's name is the library's")]

pub use fmu::abi::*;
