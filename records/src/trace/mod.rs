//! One record over time, in SI units: strictly increasing times, at least three rows, every number finite.
//!
//! Single rows that cannot be used are left out and named in [`Trace::dropped_rows`]; more than one in fifty are refused.

mod clock;
mod content;
mod dialect;
mod dropped_rows;
pub(crate) mod excel;
mod fields;
mod header;
mod header_line;
mod keep;
mod line_numbers;
mod lines;
mod order;
mod read;
mod reading;
mod record;
mod rest;
mod rows;
mod sample;
mod slow_column;

pub use content::Content;
pub use dialect::Dialect;
pub use dropped_rows::DroppedRow;
pub use fields::texts as fields_of_line;
pub(crate) use header::missing_column;
pub use line_numbers::LineNumbers;
pub use reading::{Need, Reading, Window};
pub use record::Trace;
pub(crate) use rest::movement_threshold;
pub use sample::{Sample, near_column, sample};
