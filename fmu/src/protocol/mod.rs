//! One instance as a host sees it, without C and without a version of FMI: the phases of its life, batches that are taken
//! whole or not at all, saved states, refusals and warnings in sentences.

pub mod instance;
pub mod message;
pub mod phases;
pub mod refusal;
pub mod snapshot;
pub mod state_bytes;
pub mod warning;
