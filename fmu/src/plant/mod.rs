//! The chamber between its ports, wall and piston, in numbers by index, independent of names, host and files.
//!
//! | module | holds |
//! |---|---|
//! | [`values`] | indices of inputs, outputs and parameters; parameters as a chamber |
//! | [`inputs`] | the host's inputs, with derivatives within a step |
//! | [`motion_source`] | what moves the piston: the host or the default experiment |
//! | [`stroke`] | the piston's motion: limits, and strokes given by position or by velocity |
//! | [`port`] | flow through a valve's port, ISO 6358 |
//! | [`states`] | the states, their initial values, and instantaneous strokes |
//! | [`rates`] | all values at one moment |
//! | [`tangent`] | the equations along a direction |
//! | [`derivatives`] | exact directional and time derivatives of a simulation |
//! | [`step`] | one communication step with internal integration |
//! | [`event_indicators`] | event indicators: functions that change sign at the kinks of the equations |
//! | [`history`] | past sensor readings, for a delayed record |
//! | [`simulation`] | a running simulation of either kind |

pub mod derivatives;
pub mod event_indicators;
pub mod fault;
pub mod history;
pub mod inputs;
pub mod motion_source;
pub mod port;
pub mod rates;
pub mod simulation;
pub mod states;
pub mod step;
pub mod stroke;
pub mod tangent;
pub mod values;
