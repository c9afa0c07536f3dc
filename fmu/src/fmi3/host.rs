//! The host's side of an instance in FMI 3.0: its logger.

#![allow(unsafe_code)]

use crate::boundary::{CEnum, Listener};
use crate::protocol::message::Status;
use crate::protocol::refusal::Refusal;
use std::ffi::{CStr, c_char, c_void};

/// `fmi3LogMessageCallback`.
pub type LogMessage = Option<unsafe extern "C" fn(*mut c_void, CEnum, *const c_char, *const c_char)>;

/// The host of one instance.
#[derive(Clone)]
pub struct Host {
    /// Handed to the logger.
    pub environment: *mut c_void,
    /// May be NULL.
    pub log: LogMessage,
}

impl Listener for Host {
    fn words(text: &str) -> String {
        text.replace("fmi2", "fmi3").replace("FMUstate", "FMUState")
    }

    fn terms(refusal: Refusal) -> Refusal {
        let term = |fmi2: &'static str| match fmi2 {
            "Real" => "Float64",
            "Integer" => "Int64",
            other => other,
        };
        match refusal {
            Refusal::WrongType { name, reference, is, asked } => {
                Refusal::WrongType { name, reference, is: term(is), asked: term(asked) }
            }
            other => other,
        }
    }

    unsafe fn hear(&self, status: Status, category: &CStr, text: &CStr) {
        let Some(log) = self.log else { return };
        // SAFETY: the host's function, with pointers that live until it returns.
        unsafe { log(self.environment, status as CEnum, category.as_ptr(), text.as_ptr()) };
    }
}
