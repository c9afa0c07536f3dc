//! The chamber as an FMI 2.0 co-simulation unit.
//!
//! | module | holds |
//! |---|---|
//! | [`abi`], [`host`] | the C boundary, the only `unsafe` of the project |
//! | [`instance`] | the life cycle, safe: batches taken whole or not at all |
//! | [`snapshot`], [`integration`], [`present`], [`inputs`], [`record`] | a simulation under way |
//! | [`derivatives`] | exact directional and time derivatives |
//! | [`state_bytes`] | saved states as checked bytes |
//! | [`variables`], [`units`], [`structure`] | the one table of variables, its units and dependencies |
//! | [`description`], [`documentation`], [`block`], [`mach_o`], [`package`] | the FMU as a file |

pub mod abi;
pub mod block;
pub mod derivatives;
pub mod description;
pub mod documentation;
pub mod host;
pub mod inputs;
pub mod instance;
pub mod integration;
pub mod mach_o;
pub mod package;
pub mod present;
pub mod record;
pub mod refusal;
pub mod snapshot;
pub mod state_bytes;
pub mod structure;
pub mod units;
pub mod variables;
