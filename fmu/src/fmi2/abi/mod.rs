//! The C functions of FMI 2.0 for Model Exchange and co-simulation: each turns its pointers into slices and calls the
//! [`Instance`](crate::protocol::instance::Instance). Signatures: fmi2FunctionTypes.h of FMI 2.0.5.
//!
//! Every function is safe to call under the standard's conditions: with a component from `fmi2Instantiate` not yet freed by
//! `fmi2FreeInstance`, from one thread at a time, and with arrays of the stated lengths.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc)]

mod life_cycle;
mod running;
mod saved;
mod values;

pub use life_cycle::*;
pub use running::*;
pub use saved::*;
pub use values::*;

use super::host::{Callbacks, EventInfo, Host};
use crate::boundary::{self, CEnum, c_functions, destination, elements, elements_mut, text};
use crate::plant::simulation::Kind;
use crate::protocol::refusal::Refusal;
use std::ffi::{c_char, c_int, c_uint, c_void};

const FALSE: c_int = 0;
const _: () = assert!(size_of::<c_uint>() == 4 && size_of::<c_int>() == 4);
