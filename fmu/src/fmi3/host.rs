//! The host of an FMI 3.0 instance: its logger.

#![allow(unsafe_code)]

use super::{further_variable, indicator_references};
use crate::boundary::{CEnum, Listener};
use crate::protocol::message::Status;
use crate::protocol::refusal::Refusal;
use std::ffi::{CStr, c_char, c_void};

/// `fmi3LogMessageCallback`: environment, status, category and text.
pub type LogMessage = Option<unsafe extern "C" fn(*mut c_void, CEnum, *const c_char, *const c_char)>;

/// The host of one instance.
#[derive(Clone)]
pub struct Host {
    /// Passed to the logger.
    pub environment: *mut c_void,
    /// Receives refusals, warnings and events; may be NULL.
    pub log: LogMessage,
}

impl Listener for Host {
    fn adapt_text(text: &str) -> String {
        text.replace("fmi2", "fmi3").replace("FMUstate", "FMUState")
    }

    fn adapt_refusal(refusal: Refusal) -> Refusal {
        let term = |fmi2: &'static str| match fmi2 {
            "Real" => "Float64",
            "Integer" => "Int64",
            other => other,
        };
        match refusal {
            Refusal::WrongType { name, reference, is, asked } => {
                Refusal::WrongType { name, reference, is: term(is), asked: term(asked) }
            }
            Refusal::UnknownReference { reference, .. } => match further_variable(reference) {
                Some(name) => Refusal::OnlyRead { name, reference, getter: "fmi3GetFloat64" },
                None => Refusal::UnknownReference { reference, last: indicator_references().end - 1 },
            },
            other => other,
        }
    }

    unsafe fn log(&self, status: Status, category: &CStr, text: &CStr) {
        let Some(log) = self.log else { return };
        // SAFETY: the host's function, with pointers valid until it returns.
        unsafe { log(self.environment, status as CEnum, category.as_ptr(), text.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi3::time_reference;

    #[test]
    fn a_reference_that_fmi_3_alone_has_is_refused_by_name_and_one_beyond_all_with_the_range_of_all() {
        let message = |reference| Host::adapt_refusal(Refusal::UnknownReference { reference, last: 0 }).to_string();
        let end = indicator_references().end;
        let time = time_reference();
        assert_eq!(message(time), format!("time (value reference {time}) can only be read, with fmi3GetFloat64"));
        assert!(message(end - 1).starts_with("eventIndicator"));
        assert!(message(end).ends_with(&format!("the model description lists 0 to {}", end - 1)));
    }
}
