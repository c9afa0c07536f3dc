//! Building blocks of reports: formatted numbers, charts, pages. Independent of cylinders.
//!
//! | module | contents |
//! |---|---|
//! | [`number`] | significant digits, percentages |
//! | [`axis`], [`series`], [`chart`] | line charts as SVG: round ticks, units on every axis, one palette |
//! | [`document`], [`page`] | sections of text, tables and figures as Markdown or as one self-contained HTML page |

pub mod axis;
mod canvas;
pub mod chart;
pub mod document;
pub mod number;
pub mod page;
pub mod series;

pub use axis::Axis;
pub use chart::Chart;
pub use document::{Block, Section, Table};
pub use number::{digits, percent, seconds, signed_percent};
pub use series::{Colour, Mark, Series};

/// A figure that could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("a figure could not be drawn: {0}")]
pub struct Error(String);
