//! Strokes of synthetic rigs: analytic functions of time, in m and s.

use std::f64::consts::PI;

/// Course of a piston from one end of a move to the other: fraction of the travel over u, the fraction of the move's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// u³ (10 − 15 u + 6 u²): no jump in speed or acceleration.
    Quintic,
    /// u² (3 − 2 u): jumps in acceleration.
    Cubic,
    /// (1 − cos π u)/2: a drive's sine move.
    Cosine,
    /// u: corners, anywhere between two rows.
    Ramp,
    /// A quarter of the time speeding up, half at constant speed, a quarter slowing down.
    Trapezoid,
}

impl Shape {
    /// All of them.
    pub const ALL: [Shape; 5] = [Shape::Quintic, Shape::Cubic, Shape::Cosine, Shape::Ramp, Shape::Trapezoid];

    /// Fraction of the travel and its derivative by u.
    fn at(self, u: f64) -> (f64, f64) {
        match self {
            Shape::Quintic => (u * u * u * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * u * u * (1.0 - u) * (1.0 - u)),
            Shape::Cubic => (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u)),
            Shape::Cosine => (0.5 * (1.0 - (PI * u).cos()), 0.5 * PI * (PI * u).sin()),
            Shape::Ramp => (u, 1.0),
            Shape::Trapezoid => {
                const SPEED: f64 = 4.0 / 3.0;
                if u < 0.25 {
                    (2.0 * SPEED * u * u, 4.0 * SPEED * u)
                } else if u > 0.75 {
                    let v = 1.0 - u;
                    (1.0 - 2.0 * SPEED * v * v, 4.0 * SPEED * v)
                } else {
                    (SPEED * (u - 0.125), SPEED)
                }
            }
        }
    }
}

/// One move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    /// Start, s.
    pub begin_s: f64,
    /// Duration, s.
    pub length_s: f64,
    /// Start and end position, m.
    pub ends_m: [f64; 2],
    /// How speed varies from start to end.
    pub shape: Shape,
}

/// Moves one after the other, with holds in between.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The moves, in time order.
    pub moves: Vec<Move>,
    /// Speed at which the piston creeps from the end of the first move on, m/s.
    pub creep_m_per_s: f64,
}

impl Stroke {
    /// Position and speed at time `t`, in the part of the stroke in which the time `inside` lies: the speeds on the two sides of
    /// a corner differ.
    pub fn at(&self, t: f64, inside: f64) -> (f64, f64) {
        let (position, speed) = self.driven(t, inside);
        match self.moves.first() {
            Some(first) if inside > first.begin_s + first.length_s => {
                let since_s = t - first.begin_s - first.length_s;
                (position + self.creep_m_per_s * since_s, speed + self.creep_m_per_s)
            }
            _ => (position, speed),
        }
    }

    /// The same without creep.
    fn driven(&self, t: f64, inside: f64) -> (f64, f64) {
        let Some(first) = self.moves.first() else { return (0.0, 0.0) };
        if inside < first.begin_s {
            return (first.ends_m[0], 0.0);
        }
        let m = self.moves[self.moves.partition_point(|m| m.begin_s <= inside) - 1];
        if inside >= m.begin_s + m.length_s {
            return (m.ends_m[1], 0.0);
        }
        let (progress, rate) = m.shape.at(((t - m.begin_s) / m.length_s).clamp(0.0, 1.0));
        let span = m.ends_m[1] - m.ends_m[0];
        (m.ends_m[0] + span * progress, span * rate / m.length_s)
    }

    /// Whether the stroke has a corner within `reach` of time `t`.
    pub fn has_corner_near(&self, t: f64, reach: f64) -> bool {
        self.moves.iter().any(|m| (t - m.begin_s).abs() < reach || (t - m.begin_s - m.length_s).abs() < reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_makes_the_whole_travel_at_its_stated_speed() {
        for shape in Shape::ALL {
            assert_eq!(shape.at(0.0).0, 0.0, "{shape:?}");
            assert!((shape.at(1.0).0 - 1.0).abs() < 1e-15, "{shape:?}");
            for k in 1..100 {
                let u = f64::from(k) / 100.0;
                let (a, b) = (shape.at(u - 1e-6).0, shape.at(u + 1e-6).0);
                assert!(((b - a) / 2e-6 - shape.at(u).1).abs() < 1e-5, "{shape:?} at {u}");
            }
        }
    }
}
