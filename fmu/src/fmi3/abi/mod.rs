//! The C functions of FMI 3.0 for Model Exchange and co-simulation: each turns its pointers into slices and calls the
//! [`Instance`], like those of FMI 2.0. Signatures: fmi3FunctionTypes.h of FMI 3.0.2.
//!
//! Every function is safe to call under the standard's conditions: with an instance created here and not yet freed, from one
//! thread at a time, and with arrays of the stated lengths. Booleans are passed as bytes.

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
use crate::boundary::{self, CEnum, Component, Result, c_functions, destination, elements, elements_mut, text};
use crate::plant::event_indicators::EVENT_INDICATORS;
use crate::plant::simulation::Kind;
use crate::plant::states::ALL;
use crate::protocol::instance::Instance;
use crate::protocol::refusal::Refusal;
use std::ffi::{c_char, c_void};
