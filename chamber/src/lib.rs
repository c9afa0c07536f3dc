//! Physics of one gas chamber behind a moving piston.
//!
//! Perfect gas, uniform pressure and temperature, SI units and absolute pressure throughout. No I/O, no threads, no
//! clock, no `unsafe`; the same input gives the same bits.
//!
//! | module | holds |
//! |---|---|
//! | [`real`] | the generic number of the physics: `f64`, [`Dual`](dual::Dual), and the lanes of the crate `ensemble` |
//! | [`gas`], [`geometry`], [`heat_transfer`] | the parts of a chamber |
//! | [`effects`] | what the paper's model neglects: one effect, one file |
//! | [`balance`] | equations (1) and (2) as balances of mass and energy |
//! | [`integrate`], [`tableau`], [`decay`] | adaptive Dormand–Prince 5(4) with dense output; exact decay terms |
//! | [`record`] | integrating a chamber along its inputs, and its sensor's readings |
//! | [`signals`], [`simulate`] | a chamber along a measured or planned stroke, as seen by a sensor |
//! | [`exact`] | closed forms of the closed chamber |
//! | [`seven_steps`] | the paper's evaluation of a push-and-hold test, after its regression |
//! | [`words`] | lists of names in sentences |
//! | [`paper`] | numbers of Carneiro and Gomes de Almeida (2006) used as defaults |
//!
//! Source of the method: J. F. Carneiro and F. Gomes de Almeida, "Heat transfer evaluation of industrial pneumatic
//! cylinders", Proc. IMechE Part I (2006), DOI 10.1243/09596518JSCE188, called "the paper" in these pages.

pub mod balance;
pub mod card;
pub mod decay;
pub mod dual;
pub mod effects;
pub mod exact;
pub mod gas;
pub mod geometry;
pub mod heat_transfer;
pub mod integrate;
mod kink;
pub mod paper;
pub mod papers_chamber;
mod parts;
pub mod real;
pub mod record;
pub mod seven_steps;
pub mod signals;
pub mod simulate;
pub mod tableau;
pub mod unaveraged;
pub mod words;

mod model;

pub use effects::{EffectSet, EffectValues};
pub use gas::Gas;
pub use geometry::{AreaLaw, Geometry};
pub use heat_transfer::HeatTransfer;
pub use model::Chamber;
