//! Motion of the piston: from the host's position and velocity or from the velocity alone, between the cylinder's ends.
//!
//! x(s) = x_k + ∫ velocity ds, or from the position's own derivatives if the host has set them; then limited to 0 ≤ x ≤ stroke if
//! there is a stroke. At a limit the piston rests. Lengths in m, times in s.

use super::inputs::Inputs;
use super::values::{StrokeInput, input};

/// Range of the piston.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    low: f64,
    high: f64,
}

impl Limits {
    /// No limits.
    pub const NONE: Limits = Limits { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Between the ends of a cylinder with that stroke, m; zero means no limits.
    pub fn of(stroke: f64) -> Self {
        if stroke > 0.0 { Self { low: 0.0, high: stroke } } else { Self::NONE }
    }

    /// Distances to both ends, m, positive inside; `None` without limits.
    pub fn room(&self, position: f64) -> Option<[f64; 2]> {
        self.high.is_finite().then_some([position - self.low, self.high - position])
    }

    /// Position and speed after applying the limits.
    #[inline]
    pub fn apply(&self, position: f64, velocity: f64) -> (f64, f64) {
        if position < self.low || (position == self.low && velocity < 0.0) {
            (self.low, 0.0)
        } else if position > self.high || (position == self.high && velocity > 0.0) {
            (self.high, 0.0)
        } else {
            (position, velocity)
        }
    }

    /// Whether a position is beyond the limits.
    pub fn excludes(&self, position: f64) -> bool {
        position < self.low || position > self.high
    }
}

/// The stroke within one step.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    inputs: &'a Inputs,
    /// Initial position if the velocity alone moves the piston, m.
    begin: Option<f64>,
    limits: Limits,
}

/// Number of parts in which a curved stroke is searched for the limits.
const PARTS: u32 = 32;

impl<'a> Motion<'a> {
    /// The stroke from these inputs for a piston at `reached`, m.
    pub fn new(inputs: &'a Inputs, moved_by: StrokeInput, reached: f64, limits: Limits) -> Self {
        Self { inputs, begin: (moved_by == StrokeInput::Velocity).then_some(reached), limits }
    }

    /// Position, m, and velocity, m/s, from the inputs, `s` seconds into the step.
    #[inline]
    fn said(&self, s: f64) -> (f64, f64) {
        match self.begin {
            Some(begin) => self.inputs.travel_from(begin, s),
            None => self.inputs.stroke(s),
        }
    }

    /// Position and speed of the piston, `s` seconds into the step.
    #[inline]
    pub fn at(&self, s: f64) -> (f64, f64) {
        let (position, velocity) = self.said(s);
        self.limits.apply(position, velocity)
    }

    /// Whether the piston has a constant speed throughout a step of `h` seconds.
    pub fn is_straight(&self, h: f64) -> bool {
        let has_derivative = match self.begin {
            Some(_) => self.inputs.has_derivative[input::VELOCITY],
            None => self.inputs.has_derivative[input::POSITION] || self.inputs.has_derivative[input::VELOCITY],
        };
        let (begin, end) = (self.said(0.0), self.said(h));
        !has_derivative && self.limits.apply(begin.0, begin.1) == begin && !self.limits.excludes(end.0)
    }

    /// Passes to `take` the times within a step of `h` seconds at which the piston reaches or leaves a limit.
    pub fn stops(&self, h: f64, mut take: impl FnMut(f64)) {
        for limit in [self.limits.low, self.limits.high] {
            if !limit.is_finite() {
                continue;
            }
            let beyond = |s: f64| self.said(s).0 - limit;
            for part in 0..PARTS {
                let [mut from, mut to] = [part, part + 1].map(|i| h * f64::from(i) / f64::from(PARTS));
                let sign = beyond(from);
                if sign * beyond(to) >= 0.0 {
                    continue;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (from + to);
                    if sign * beyond(middle) > 0.0 { from = middle } else { to = middle }
                }
                take(to);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::values::start_inputs;
    use super::*;

    fn inputs(position: f64, velocity: f64) -> Inputs {
        let mut values = start_inputs(position, 293.0, 1e5);
        values[input::VELOCITY] = velocity;
        Inputs::new(values)
    }

    #[test]
    fn a_piston_stops_at_the_end_and_leaves_it_when_pulled_back() {
        let inputs = inputs(0.1, 1.0);
        let motion = Motion::new(&inputs, StrokeInput::PositionAndVelocity, 0.1, Limits::of(0.15));
        assert!(motion.is_straight(0.04) && !motion.is_straight(0.06));
        assert_eq!(motion.at(0.06), (0.15, 0.0));
        let mut stops = Vec::new();
        motion.stops(0.1, |s| stops.push(s));
        assert_eq!(stops.len(), 1);
        assert!((stops[0] - 0.05).abs() < 1e-15);
        assert_eq!(Limits::of(0.15).apply(0.15, -0.2), (0.15, -0.2));
        assert_eq!(Limits::of(0.15).apply(0.0, -0.2), (0.0, 0.0));
    }

    #[test]
    fn without_a_stroke_there_are_no_limits() {
        assert_eq!(Limits::of(0.0).apply(-7.0, -1.0), (-7.0, -1.0));
        assert_eq!(Limits::of(0.0).room(0.1), None);
    }

    #[test]
    fn the_velocity_alone_moves_the_piston_from_where_it_is() {
        let inputs = inputs(0.7, 0.5);
        let motion = Motion::new(&inputs, StrokeInput::Velocity, 0.1, Limits::NONE);
        assert_eq!(motion.at(0.2), (0.2, 0.5));
    }
}
