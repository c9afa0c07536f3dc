//! Parameters that a fit may change, and the coordinates in which it does.
//!
//! Three scopes. *Rig* parameters hold for all records: λ0, the dead volume unless known, the fitted parameters of each effect.
//! *Per-record* parameters are the initial pressure (that is, the mass of gas), the initial temperature if the record begins in
//! motion or the model has initial temperatures, the gas temperature behind each gap, and the parameters of recording effects
//! that the records do not share. *Stated* parameters — bore, scale and zero of the position, ambient temperature — stay as
//! stated, but are known only within tolerances: their sensitivities, with that prior, take part in every evidence, test and
//! interval. Secondary parameters of an effect stay as on its card unless the records favour other values; their uncertainty
//! takes part in the intervals of the rest. λ0, wall capacities and decay times are fitted on a logarithmic scale, everything
//! else on a linear one within the bounds of its card.

mod axis;
mod curve;
mod hypothesis;
mod model;
mod sizes;
mod stated;

pub use axis::{Axis, RecordSlot, Slot};
pub use curve::curve_of;
pub use hypothesis::{Hypothesis, Setting, first_chamber};
pub use model::{Model, RecordStart, delays_position, delays_pressure, is_timing, names};
pub use sizes::{Sizes, is_decay};
