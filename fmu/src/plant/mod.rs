//! The chamber between its ports, its wall and its piston, in numbers by index: it knows no names, no host and no file.
//!
//! | module | holds |
//! |---|---|
//! | [`values`] | places of inputs, outputs and parameters; parameters as a chamber |
//! | [`inputs`] | what the host imposes, with derivatives within a step |
//! | [`leader`] | who moves the piston: the host, or the default experiment |
//! | [`stroke`] | where the piston goes: limits, and strokes given by position or by velocity |
//! | [`port`] | flow through a valve's port, ISO 6358 |
//! | [`states`] | the states, their start, a stroke taken up at once |
//! | [`rates`] | everything that can be asked of one moment |
//! | [`tangent`] | the equations along a direction |
//! | [`derivatives`] | exact directional and time derivatives of a simulation |
//! | [`step`] | one communication step, integrated inside |
//! | [`corners`] | where the equations have corners: event indicators |
//! | [`history`] | the sensor's past, for a delayed record |
//! | [`simulation`] | a simulation under way, of either kind |

pub mod corners;
pub mod derivatives;
pub mod fault;
pub mod history;
pub mod inputs;
pub mod leader;
pub mod port;
pub mod rates;
pub mod simulation;
pub mod states;
pub mod step;
pub mod stroke;
pub mod tangent;
pub mod values;
