//! How a trace is to be read: by which layout, for what, which part of it, and how many rows at most.

use crate::layout::Layout;

/// The most rows a trace may have.
pub const MAX_ROWS: usize = 20_000_000;

/// What a trace is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A measurement: pressure, and every column that the rig maps.
    Measurement,
    /// A motion to simulate along: time and position; the rest where it is there.
    Motion,
}

/// The part of a trace that counts. Rows outside are not looked at, but for their time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
}

impl Window {
    /// All of it.
    pub const ALL: Window = Window { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };
}

/// How a trace is to be read.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    /// Which column holds what, in which unit.
    pub layout: &'a Layout,
    /// The cylinder's stroke, m: a position beyond it is refused.
    pub stroke_m: Option<f64>,
    /// The part that counts.
    pub window: Window,
    /// What the rows are for: which columns must be there.
    pub need: Need,
}
