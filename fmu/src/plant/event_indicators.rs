//! Kinks of the equations as event indicators: functions of order one that change sign there.
//!
//! They cover the directions of flows and ports, choking, the ends of the stroke, and each effect's own kinks. An indicator
//! that rests at its kink would signal an event at each step; each therefore has a dead band, on the side it was on when the
//! last event was handled: z = f + ε above, f − ε below.

use super::rates::Moment;
use super::states::ALL;
use super::stroke::Limits;
use super::values::{INPUTS, input};
use chamber::effects::{self, iso6358};
use chamber::real::Real;

/// Index ranges of the indicators: both mass flows, both ports, both ends of the stroke, then the effects.
const PORTS: usize = 2;
const ENDS: usize = PORTS + 2 * iso6358::KINK_INDICATORS;
const EFFECTS: usize = ENDS + 3;
/// Number of event indicators.
pub const EVENT_INDICATORS: usize = EFFECTS + effects::KINK_INDICATORS;

/// Scale of the mass flows' indicators, kg/s.
const NOMINAL_FLOW: f64 = 1e-3;
/// Width of the dead band as a fraction of the tolerance.
const BAND: f64 = 0.1;

/// Rest position of a piston moved by its velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Rest {
    /// Moving freely.
    #[default]
    Free = 0,
    /// At position zero, pushed against the end.
    Low = 1,
    /// At the full stroke, pushed against the end.
    High = 2,
}

/// Sides of the kinks, and the piston's rest, at the last event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    /// Whether each kink indicator was positive.
    pub above: [bool; EVENT_INDICATORS],
    /// Where the piston rests.
    pub rest: Rest,
}

impl Default for Sides {
    fn default() -> Self {
        Self { above: [true; EVENT_INDICATORS], rest: Rest::Free }
    }
}

/// The piston as seen by the kinks.
#[derive(Clone, Copy, Debug)]
pub struct Piston {
    /// Position set by the host or reached by its velocity, before the limits, m.
    pub position: f64,
    /// Velocity set by the host, m/s.
    pub velocity: f64,
    /// Ends of the stroke that stop the piston.
    pub limits: Limits,
}

impl Sides {
    /// The indicators for these values of [`kink_indicators`]; `tolerance` is the host's.
    pub fn indicators(&self, kinks: &[f64; EVENT_INDICATORS], tolerance: f64) -> [f64; EVENT_INDICATORS] {
        let band = BAND * tolerance;
        core::array::from_fn(|i| kinks[i] + if self.above[i] { band } else { -band })
    }

    /// The sides of the kinks; `None` where the value is within the dead band.
    pub fn clear(kinks: &[f64; EVENT_INDICATORS], tolerance: f64) -> [Option<bool>; EVENT_INDICATORS] {
        kinks.map(|value| (value.abs() > BAND * tolerance).then_some(value > 0.0))
    }

    /// Stores the current sides of the kinks.
    pub fn settle(&mut self, kinks: &[f64; EVENT_INDICATORS]) {
        self.above = kinks.map(|value| value > 0.0);
    }

    /// Stops a piston pushed into an end, and releases one pulled away from it.
    pub fn settle_rest(&mut self, piston: &Piston) {
        let Some([low, high]) = piston.limits.room(piston.position) else {
            self.rest = Rest::Free;
            return;
        };
        self.rest = match self.rest {
            Rest::Free if low <= 0.0 && piston.velocity < 0.0 => Rest::Low,
            Rest::Free if high <= 0.0 && piston.velocity > 0.0 => Rest::High,
            Rest::Low if piston.velocity > 0.0 => Rest::Free,
            Rest::High if piston.velocity < 0.0 => Rest::Free,
            same => same,
        };
    }
}

/// Functions of order one that change sign at the kinks of the equations, without dead bands.
pub fn kink_indicators(
    moment: &Moment<'_>,
    u: &[f64; INPUTS],
    states: &[f64; ALL],
    piston: &Piston,
    rest: Rest,
) -> [f64; EVENT_INDICATORS] {
    let (at, rates, _) = moment.balances(states);
    let mut out = [f64::ONE; EVENT_INDICATORS];
    out[0] = u[input::MASS_FLOW_IN] / NOMINAL_FLOW;
    out[1] = u[input::MASS_FLOW_OUT] / NOMINAL_FLOW;
    for (i, port) in moment.around.ports.iter().flatten().enumerate().filter(|(_, port)| port.conductance > 0.0) {
        let kinks = iso6358::kink_indicators(port.pressure, at.pressure, port.critical_ratio);
        out[PORTS + i * iso6358::KINK_INDICATORS..][..iso6358::KINK_INDICATORS].copy_from_slice(&kinks);
    }
    if let Some([low, high]) = piston.limits.room(piston.position) {
        let stroke = low + high;
        match rest {
            Rest::Free => out[ENDS..ENDS + 2].copy_from_slice(&[low / stroke, high / stroke]),
            _ => out[ENDS + 2] = piston.velocity,
        }
    }
    let own = super::rates::own(states);
    let of_effects = moment.balance.chamber.effects.kink_indicators(moment.set, &own, &at, &rates);
    out[EFFECTS..].copy_from_slice(&of_effects);
    out
}
