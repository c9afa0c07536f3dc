//! The figures of `reproduce`.

pub mod forms;
pub mod pressure_response;
pub mod time_constants;
pub mod trend;

/// Width of every figure, px.
pub const WIDTH: u32 = 760;
