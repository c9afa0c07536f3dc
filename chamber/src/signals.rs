//! What a record or a plan imposes on the chamber, piecewise linear in time.

use crate::balance::Boundary;
use crate::record::Inputs;

/// Inputs at one knot in time; linear in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Time, s.
    pub time: f64,
    /// Position of the piston face, m.
    pub position: f64,
    /// Mass flow into the chamber, kg/s, negative out of it (at the gas's temperature); inflow enters at ambient temperature.
    pub mass_flow: f64,
    /// Ambient temperature, K.
    pub ambient_temperature: f64,
}

/// Inputs over time: at least one knot, times strictly increasing.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// The knots, in time order.
    pub knots: Vec<Knot>,
    /// Pressure of the surroundings, Pa.
    pub ambient_pressure: f64,
}

impl Signals {
    /// A closed chamber whose piston passes through these (time s, position m) points.
    pub fn closed(motion: &[(f64, f64)], ambient_temperature: f64, ambient_pressure: f64) -> Self {
        let knot = |&(time, position)| Knot { time, position, mass_flow: 0.0, ambient_temperature };
        Self { knots: motion.iter().map(knot).collect(), ambient_pressure }
    }

    fn at(&self, from: &Knot, share: f64, to: &Knot, velocity: f64) -> Boundary {
        let between = |a: f64, b: f64| a + (b - a) * share;
        let flow = between(from.mass_flow, to.mass_flow);
        let ambient_temperature = between(from.ambient_temperature, to.ambient_temperature);
        Boundary {
            position: between(from.position, to.position),
            velocity,
            mass_flow_in: flow.max(0.0),
            temperature_in: ambient_temperature,
            mass_flow_out: (-flow).max(0.0),
            ambient_temperature,
            ambient_pressure: self.ambient_pressure,
        }
    }
}

impl Inputs for Signals {
    #[inline]
    fn begin(&self) -> f64 {
        self.knots[0].time
    }

    #[inline]
    fn stretches(&self) -> usize {
        self.knots.len()
    }

    #[inline]
    fn end(&self, stretch: usize) -> f64 {
        self.knots.get(stretch + 1).map_or(f64::INFINITY, |knot| knot.time)
    }

    /// Within the stretch that begins at the knot of that number; behind the last knot all stays as it is there.
    #[inline]
    fn boundary(&self, stretch: usize, time: f64) -> Boundary {
        let from = &self.knots[stretch];
        let Some(to) = self.knots.get(stretch + 1) else {
            return self.at(from, 0.0, from, 0.0);
        };
        let length = to.time - from.time;
        self.at(from, (time - from.time) / length, to, (to.position - from.position) / length)
    }
}
