//! The host's side of an instance: its logger, its name, and which categories it wants to hear.
//!
//! Refusals are always reported, unless the host chose categories without them; events only where logging is on.

#![allow(unsafe_code)]

use crate::refusal::{Category, Refusal, Status};
use std::any::Any;
use std::ffi::{CString, c_char, c_uint, c_void};

/// A C enumeration without negative members: `fmi2Status`, `fmi2Type`, `fmi2StatusKind`.
pub type CEnum = c_uint;

/// `fmi2CallbackLogger`.
pub type Logger = Option<unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, ...)>;

/// `fmi2CallbackFunctions`. Only the logger is used (`canNotUseMemoryManagementFunctions`).
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Callbacks {
    /// May be NULL.
    pub logger: Logger,
    /// Not used.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: steps are done when fmi2DoStep returns.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, CEnum)>,
    /// Handed to the logger.
    pub component_environment: *mut c_void,
}

/// The host of one instance.
pub struct Host {
    callbacks: Callbacks,
    name: CString,
    wanted: [bool; Category::ALL.len()],
}

impl Host {
    /// A host with these callbacks, copied.
    pub fn new(callbacks: Callbacks, name: &str, logging_on: bool) -> Self {
        let mut wanted = [true; Category::ALL.len()];
        wanted[Category::Events as usize] = logging_on;
        Self { callbacks, name: c_string(name), wanted }
    }

    /// `fmi2SetDebugLogging`: no categories means all.
    pub fn choose(&mut self, logging_on: bool, categories: &[String]) -> Result<(), Refusal> {
        let known = |name: &String| name == "logAll" || Category::ALL.iter().any(|(_, known, _)| known == name);
        if !categories.iter().all(known) {
            return Err(Refusal::NotOffered {
                what: "a category is none of those that the model description declares",
            });
        }
        for (wanted, (category, name, _)) in self.wanted.iter_mut().zip(Category::ALL) {
            let chosen = categories.is_empty() || categories.iter().any(|c| c == name || c == "logAll");
            *wanted = if logging_on { chosen } else { category != Category::Events };
        }
        Ok(())
    }

    /// Hands a message to the host's logger, as an argument of "%s".
    pub fn log(&self, status: Status, category: Category, message: &str) {
        if !self.wanted[category as usize] {
            return;
        }
        let Some(logger) = self.callbacks.logger else { return };
        let (category, message) = (c_string(category.name()), c_string(message));
        // The logger is the host's; its pointers live until it returns.
        unsafe {
            logger(
                self.callbacks.component_environment,
                self.name.as_ptr(),
                status as CEnum,
                category.as_ptr(),
                c"%s".as_ptr(),
                message.as_ptr(),
            );
        }
    }

    /// Reports a refusal; returns its status.
    pub fn refused(&self, function: &str, refusal: &Refusal) -> Status {
        let status = refusal.status();
        self.log(status, refusal.category(), &format!("{function} refused: {refusal}"));
        status
    }

    /// Reports an event, if the host wants to hear of events.
    pub fn event(&self, message: impl FnOnce() -> String) {
        if self.wanted[Category::Events as usize] {
            self.log(Status::Ok, Category::Events, &message());
        }
    }

    /// Reports a panic.
    pub fn broke_down(&self, function: &str, panic: &(dyn Any + Send)) {
        let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        let message =
            format!("{function} broke down, which is a fault of the FMU ({text}); fmi2Reset makes the instance as new");
        self.log(Status::Error, Category::Error, &message);
    }
}

/// Text for C, without what C cannot hold.
fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}
