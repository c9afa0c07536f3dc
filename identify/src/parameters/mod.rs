//! Which numbers a fit may change, and the coordinates in which it does.
//!
//! Three scopes. The *rig's* numbers hold for all its records: λ0, the dead volume unless known, the fitted parameters of
//! each effect. A *record's* numbers are its own: its initial pressure (that is, its mass of gas), its initial temperature
//! where it begins in motion or the model has initial temperatures, the gas's temperature behind each of its gaps, and the
//! parameters of effects that belong to the recording where the records do not share them. What the rig *states* — bore, scale and
//! zero of the position, ambient temperature — stays as stated, but is known within its tolerance only: its sensitivities with that
//! prior take part in every evidence, test and interval.
//! Secondary parameters of an effect stay as its card has them unless the records speak for others; how far they are known
//! takes part in the intervals of the rest.
//! λ0, wall capacities and times of decay move on a logarithmic scale, everything else on a linear one within the bounds of its card.

mod axis;
mod curve;
mod hypothesis;
mod model;
mod sizes;
mod stated;

pub use axis::{Axis, Own, Slot};
pub use curve::curve_of;
pub use hypothesis::{Hypothesis, Setting, first_chamber};
pub use model::{Model, OwnStart, delays_position, delays_pressure, is_timing, names};
pub use sizes::{Sizes, is_decay};
