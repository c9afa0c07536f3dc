//! FMI 3.0: the C functions, the model description and the terminals, from the same table of variables as FMI 2.0.
//!
//! A variable's value reference is its index in the table, as in FMI 2.0; after the table follow the time and the event
//! indicators, which are variables in FMI 3.0.

pub mod abi;
#[cfg(feature = "package")]
pub mod description;
pub mod host;
#[cfg(feature = "package")]
pub mod terminals;

use crate::plant::event_indicators::EVENT_INDICATORS;
use crate::table::table;

/// Value reference of the independent variable.
pub fn time_reference() -> u32 {
    table().len() as u32
}

/// Value references of the event indicators.
pub fn indicator_references() -> std::ops::Range<u32> {
    let first = time_reference() + 1;
    first..first + EVENT_INDICATORS as u32
}

/// Name of a variable after those of the table, which only FMI 3.0 has.
pub fn further_variable(reference: u32) -> Option<&'static str> {
    if reference == time_reference() {
        Some("time")
    } else {
        indicator_references().contains(&reference).then_some("eventIndicator")
    }
}
