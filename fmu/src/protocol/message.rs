//! What an instance says to its host's log: a status, a category that the model description declares, a sentence.

/// Outcome of a call, with the numbers of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Status {
    /// The call was done.
    Ok = 0,
    /// Done, but something is to be looked at.
    Warning = 1,
    /// Refused for its numbers; the instance is as before.
    Discard = 2,
    /// Refused as a breach of the protocol, or the instance is broken.
    Error = 3,
}

/// Log category of a message: its name is declared in the model description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// What happens inside an accepted call.
    Events,
    /// Calls that were done, though numbers in them are implausible.
    Warning,
    /// Numbers that were refused: the instance is as before and can be used on.
    Discard,
    /// Calls that were refused as a breach of the protocol.
    Error,
}

impl Category {
    /// Every category with what it holds, as the model description declares them.
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

    /// Name of the category, as the model description declares it and the host's logger gets it.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// A sentence for the host's log.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// Status that the host's logger gets with it.
    pub status: Status,
    /// Log category, by which a host chooses what it hears of.
    pub category: Category,
    /// What happened, at which value and time, and what to do; in the words of FMI 2.0.
    pub text: String,
}
