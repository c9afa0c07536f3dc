//! Scenarios that are solved together.

use crate::scenario::{Options, Scenario};
use pulp::Arch;

/// Scenarios that are solved together: as many as keep their working memory in a core's cache.
pub const CHUNK: usize = 512;

/// Scenarios that are solved together, how, and with which instructions.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    pub arch: Arch,
    pub scenarios: &'a [Scenario],
    pub options: &'a Options,
}
