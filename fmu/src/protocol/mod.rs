//! One instance as seen by a host, independent of C and of the FMI version: the phases of its life cycle, all-or-nothing batches,
//! saved states, and refusals and warnings as sentences.

pub mod instance;
pub mod message;
pub mod phases;
pub mod refusal;
pub mod snapshot;
pub mod state_bytes;
pub mod warning;
