//! Sampling: when the rows were recorded, and which of them are readings of the pressure sensor.
//!
//! In: the columns of a record as they are in its file. Out: increasing times, and the rows, or the times between rows, at which
//! the sensor was read ([`readout::Readings`]). Called by `prepare` in this order:
//!
//! | module | does |
//! |---|---|
//! | `clock` | leaves out rows whose time does not increase |
//! | `jitter` | corrects the times of a logger that stamps its rows evenly but reads them unevenly |
//! | `row_time` | gives the usual time from row to row, also to the other parts |
//! | [`readout`] | finds a sensor that is read less often than the rows come, whose rows in between are held or interpolated |
//!
//! Which rows are readings of the position is known before the jitter is: see [`super::stroke::positions`].

pub(super) mod clock;
pub(super) mod jitter;
pub mod readout;
pub(super) mod row_time;
