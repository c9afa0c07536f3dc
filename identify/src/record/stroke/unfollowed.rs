//! Moves that end before the position has been read often enough to show their course.
//!
//! The curve through fewer than three readings in motion misses 1 to 5 % of a move's travel, far more than the noise of a
//! pressure: readings in such a move give information on the stroke, not on the gas. The hold after it depends on the course
//! through the heat exchanged in the move, the integral of (T − Tw) A. To first order a wrong course is one that is early or late
//! as a whole, as its mean position shows ([`Spline::open_shift`]). Since T − Tw is no linear function of the position, a further
//! uncertainty remains: [`SHIFT`].

use super::spline::Spline;

/// Fewest readings in motion that show a move's course.
const FEWEST_READINGS: usize = 3;
/// Standard deviation of the time by which the course is early or late for the gas if its mean position is right, over the time
/// between two readings. With two readings in motion it is a third of this.
pub const SHIFT: f64 = 0.015;

/// Whether a move has too few readings in motion.
pub fn is_unfollowed(stroke: &Spline) -> bool {
    !stroke.is_line() && stroke.knots_inside() < FEWEST_READINGS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Move, Random, Shape, Stroke};
    use std::cell::Cell;

    /// Number of integration steps over a move.
    const STEPS: usize = 1000;

    /// How late a course is for the gas beyond what its mean position shows, over the time between two readings. The volume ratio
    /// is that of the move's end; half of the initial wall area does not depend on the position.
    fn beyond_mean(random: &mut Random) -> Option<f64> {
        let (length, begin) = (random.between(0.2, 1.99), random.uniform());
        let shape = random.one_of(&Shape::ALL);
        let pushed = Move { begin_s: begin, length_s: length, ends_m: [0.0, 1.0], shape };
        let stroke = Stroke { moves: vec![pushed], creep_m_per_s: 0.0 };
        let progress = |t: f64| stroke.at(t, t).0;
        let times: Vec<f64> = (-2..5).map(f64::from).collect();
        let readings = times.iter().map(|t| progress(*t)).collect();
        let curve = Spline::through(times, readings, [Some(0.0); 2]);
        if curve.knots_inside() > 1 {
            return None;
        }
        let ratio = random.log_uniform(1.5, 3.0).powf(random.one_of(&[-1.0, 1.0]));
        let heat = |progress: f64| {
            let volume = 1.0 + (1.0 / ratio - 1.0) * progress;
            (volume.powf(-0.4) - 1.0) * 0.5 * (1.0 + volume)
        };
        let near = Cell::new(0);
        let [mut by_heat, mut by_progress] = [0.0; 2];
        for k in 0..STEPS {
            let t = -2.0 + 6.0 * (k as f64 + 0.5) / STEPS as f64;
            let (truth, found) = (progress(t), curve.at(t, &near).0);
            by_heat += (heat(truth) - heat(found)) / heat(1.0);
            by_progress += truth - found;
        }
        Some(6.0 / STEPS as f64 * (by_heat - by_progress))
    }

    #[test]
    fn the_unknown_course_of_a_move_shifts_it_by_the_stated_fraction_of_the_time_between_readings() {
        let mut random = Random::new(17);
        let shifts: Vec<f64> = (0..4000).filter_map(|_| beyond_mean(&mut random)).collect();
        let rms = (shifts.iter().map(|s| s * s).sum::<f64>() / shifts.len() as f64).sqrt();
        assert!((0.8..1.2).contains(&(rms / SHIFT)), "{rms}");
    }
}
