//! Options for reading a trace: layout, purpose, time window, and row limit.

use crate::layout::Layout;

/// Row limit of a trace.
pub const MAX_ROWS: usize = 20_000_000;

/// Purpose of reading a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A measurement: requires pressure and every column mapped by the rig.
    Measurement,
    /// A motion to simulate: requires time and position; other columns are optional.
    Motion,
}

/// Time window of a trace. Rows outside are not checked, except for their time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First time, s.
    pub from_s: f64,
    /// Last time, s.
    pub to_s: f64,
}

impl Window {
    /// The whole trace.
    pub const ALL: Window = Window { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY };
}

/// Options for reading a trace.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    /// Quantity and unit of each column.
    pub layout: &'a Layout,
    /// The cylinder's stroke, m: a position beyond it is refused.
    pub stroke_m: Option<f64>,
    /// The time window.
    pub window: Window,
    /// Purpose, which decides the required columns.
    pub need: Need,
}
