//! The host of an FMI 2.0 instance: its callbacks, of which only the logger is used.

#![allow(unsafe_code)]

use crate::boundary::{CEnum, Listener, c_string};
use crate::protocol::message::Status;
use std::ffi::{CStr, c_char, c_void};
use std::sync::Arc;

/// `fmi2CallbackLogger`: environment, instance name, status, category, format and its arguments.
pub type Logger = Option<unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, ...)>;

/// `fmi2CallbackFunctions`. Only the logger is used (`canNotUseMemoryManagementFunctions`).
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Callbacks {
    /// Receives refusals, warnings and events; may be NULL.
    pub logger: Logger,
    /// Not used: the FMU allocates its own memory.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used: the FMU allocates its own memory.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: steps are complete when fmi2DoStep returns.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, CEnum)>,
    /// Passed to the logger.
    pub component_environment: *mut c_void,
}

/// `fmi2EventInfo`: what an event changed and the time of the next one, s.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
#[allow(missing_docs, reason = "the standard's names")]
pub struct EventInfo {
    pub new_discrete_states_needed: i32,
    pub terminate_simulation: i32,
    pub nominals_of_continuous_states_changed: i32,
    pub values_of_continuous_states_changed: i32,
    pub next_event_time_defined: i32,
    pub next_event_time: f64,
}

/// The host of one instance: a copy of its callbacks and the instance name.
#[derive(Clone)]
pub struct Host {
    callbacks: Callbacks,
    name: Arc<CStr>,
}

impl Host {
    /// A host with these callbacks, for the instance with that name.
    pub fn new(callbacks: Callbacks, name: &str) -> Self {
        Self { callbacks, name: c_string(name).into() }
    }
}

impl Listener for Host {
    unsafe fn log(&self, status: Status, category: &CStr, text: &CStr) {
        let Some(logger) = self.callbacks.logger else { return };
        // SAFETY: the host's function, with pointers valid until it returns; the text is an argument of "%s".
        unsafe {
            logger(
                self.callbacks.component_environment,
                self.name.as_ptr(),
                status as CEnum,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
