//! Messages of an instance for its host's log: a status, a category declared in the model description, and a sentence.

/// Status of a call, numbered as in the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// The call succeeded.
    Ok = 0,
    /// The call succeeded with a warning.
    Warning = 1,
    /// Refused because of its values; the instance is unchanged.
    Discard = 2,
    /// Refused as a protocol violation, or the instance has panicked.
    Error = 3,
}

/// Log category of a message; its name is declared in the model description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// Events within an accepted call.
    Events,
    /// Accepted calls with implausible values.
    Warning,
    /// Refused values: the instance is unchanged and remains usable.
    Discard,
    /// Calls refused as protocol violations.
    Error,
}

impl Category {
    /// All categories with their descriptions, as declared in the model description.
    pub const ALL: [(Category, &'static str, &'static str); 4] = [
        (
            Category::Events,
            "logEvents",
            "Changes within an accepted call: a stroke taken up to the host's position, an effect switched on",
        ),
        (Category::Warning, "logStatusWarning", "Accepted calls that deserve a look"),
        (
            Category::Discard,
            "logStatusDiscard",
            "Refused values and steps, by name and value; the instance stays as it was",
        ),
        (
            Category::Error,
            "logStatusError",
            "Refused calls: wrong order, NULL, unknown references, damaged state bytes",
        ),
    ];

    /// Name of the category in the model description and for the host's logger.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// A message for the host's log.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Status passed to the host's logger.
    pub status: Status,
    /// Log category, by which a host filters messages.
    pub category: Category,
    /// What happened, with value and time, and what to do; in the terms of FMI 2.0.
    pub text: String,
}
