//! The C functions of FMI 3.0 for Model Exchange and co-simulation: each turns its pointers into slices and hands over to
//! the [`Instance`], as those of FMI 2.0 do. Signatures: fmi3FunctionTypes.h of FMI 3.0.2.
//!
//! Every function is safe to call as the standard has it: with an instance that was made here and has not been freed, from
//! one thread at a time, and with arrays as long as the lengths beside them say. Booleans arrive as bytes.

#![allow(unsafe_code, non_snake_case, clippy::missing_safety_doc, clippy::too_many_arguments)]

mod absent;
mod life_cycle;
mod running;
mod saved;
mod values;

pub use absent::*;
pub use life_cycle::*;
pub use running::*;
pub use saved::*;
pub use values::*;

use super::host::{Host, LogMessage};
use super::{indicator_references, time_reference};
use crate::boundary::{self, CEnum, Component, Result, c_functions, elements, elements_mut, place, text};
use crate::plant::corners::CORNERS;
use crate::plant::simulation::Kind;
use crate::plant::states::ALL;
use crate::protocol::instance::Instance;
use crate::protocol::refusal::Refusal;
use std::ffi::{c_char, c_void};
