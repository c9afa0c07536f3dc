//! Piecewise linear inputs of a chamber, from a record or a plan.

use crate::balance::Boundary;
use crate::effects::{EffectSet, EffectValues};
use crate::real::Real;
use crate::record::Inputs;
use crate::unaveraged::{self, Unaveraged};
use std::cell::Cell;

/// Inputs at one knot in time; linear in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// Time of the knot, s.
    pub time: f64,
    /// Position of the piston face, m.
    pub position: f64,
    /// Mass flow into the chamber, kg/s, negative out of it (at the gas's temperature); inflow enters at ambient temperature.
    pub mass_flow: f64,
    /// Ambient temperature, K.
    pub ambient_temperature: f64,
}

/// Knots closer together than this fraction of the whole duration are merged.
const SMALLEST_STRETCH: f64 = 1e-12;

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

    /// These signals with the true stroke in place of the recorded one, as the effects in `set` relate them: still piecewise
    /// linear, with further knots. The recorded stroke is assumed at rest before and after the record.
    pub fn with_true_stroke(self, set: EffectSet, values: &EffectValues) -> Self {
        let delay = values.stroke_delay(set);
        let window = values.stroke_window(set);
        let filter = values.stroke_filter(set);
        if delay == 0.0 && window == 0.0 && filter == 0.0 {
            return self;
        }
        let (begin, end) = (self.knots[0].time, self.knots[self.knots.len() - 1].time);
        let mut record = self.clone();
        record.knots.iter_mut().zip(self.slopes()).for_each(|(knot, slope)| knot.position += filter * slope);
        let recorded = |time: f64| record.knot(time).position;
        let unaveraged = unaveraged::around(recorded, window, [begin, end], record.slope_changes(window), false);
        let of_stroke = self.knots.iter().map(|knot| knot.time).chain(unaveraged.iter().flat_map(Unaveraged::knots));
        let mut times: Vec<f64> =
            self.knots.iter().map(|knot| knot.time).chain(of_stroke.map(|time| time - delay)).collect();
        times.retain(|time| (begin..=end).contains(time));
        times.sort_by(f64::total_cmp);
        times.dedup_by(|later, earlier| *later - *earlier < SMALLEST_STRETCH * (end - begin));
        let near = Cell::new(0);
        let stroke = |time: f64| match unaveraged::containing(&unaveraged, &near, time) {
            Some(spline) => spline.at(time).derivatives[0],
            None => recorded(time),
        };
        let knots = times.iter().map(|&time| Knot { time, position: stroke(time + delay), ..self.knot(time) });
        Self { knots: knots.collect(), ambient_pressure: self.ambient_pressure }
    }

    /// Times, s, at which the slope of the stroke changes enough for an average over `window`, s, to show it, each as an
    /// interval of zero length; an end of the record counts if the stroke moves there.
    fn slope_changes(&self, window: f64) -> impl Iterator<Item = [f64; 2]> {
        /// Fraction of the stroke's extent: rounding deflects a line by this much within a window.
        const ROUNDING: f64 = 1e-6;
        let [low, high] = self.knots.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], knot| {
            [low.min(knot.position), high.max(knot.position)]
        });
        // It rests before its first knot and after its last.
        let slope = |k: usize| match (k.checked_sub(1).and_then(|k| self.knots.get(k)), self.knots.get(k)) {
            (Some(from), Some(to)) => (to.position - from.position) / (to.time - from.time),
            _ => 0.0,
        };
        let changes = move |k: &usize| (slope(k + 1) - slope(*k)).abs() * window > ROUNDING * (high - low);
        (0..self.knots.len()).filter(changes).map(|k| [self.knots[k].time; 2])
    }

    /// Slope of the position at each knot, m/s: the mean of those before and after it, which are zero outside the record.
    fn slopes(&self) -> Vec<f64> {
        let of = |k: &[Knot]| (k[1].position - k[0].position) / (k[1].time - k[0].time);
        let chords = || self.knots.windows(2).map(of);
        chords()
            .chain([0.0])
            .zip([0.0].into_iter().chain(chords()))
            .map(|(after, before)| 0.5 * (before + after))
            .collect()
    }

    /// All inputs at a time, s; constant before the first knot and after the last.
    pub fn knot(&self, time: f64) -> Knot {
        let next = self.knots.partition_point(|knot| knot.time <= time);
        let (Some(from), Some(to)) = (next.checked_sub(1).map(|k| &self.knots[k]), self.knots.get(next)) else {
            return Knot { time, ..self.knots[next.min(self.knots.len() - 1)] };
        };
        from.towards(to, time)
    }
}

impl Knot {
    /// All inputs at a time, s, on the straight line to another knot.
    fn towards(&self, to: &Knot, time: f64) -> Knot {
        let fraction = (time - self.time) / (to.time - self.time);
        let between = |a: f64, b: f64| a + (b - a) * fraction;
        Knot {
            time,
            position: between(self.position, to.position),
            mass_flow: between(self.mass_flow, to.mass_flow),
            ambient_temperature: between(self.ambient_temperature, to.ambient_temperature),
        }
    }
}

impl<R: Real> Inputs<R> for Signals {
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

    /// The boundary within the stretch that begins at this knot; constant after the last knot.
    #[inline]
    fn boundary(&self, stretch: usize, time: f64) -> Boundary<R> {
        let from = &self.knots[stretch];
        let (knot, velocity) = match self.knots.get(stretch + 1) {
            Some(to) => (from.towards(to, time), (to.position - from.position) / (to.time - from.time)),
            None => (*from, 0.0),
        };
        let ambient_temperature = knot.ambient_temperature;
        let boundary = Boundary {
            position: knot.position,
            velocity,
            mass_flow_in: knot.mass_flow.max(0.0),
            temperature_in: ambient_temperature,
            mass_flow_out: (-knot.mass_flow).max(0.0),
            ambient_temperature,
            ambient_pressure: self.ambient_pressure,
        };
        boundary.lift()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{PositionAveraging, PositionDelay};

    fn recorded(times: impl Iterator<Item = f64>, stroke: impl Fn(f64) -> f64) -> Signals {
        let motion: Vec<(f64, f64)> = times.map(|t| (t, stroke(t))).collect();
        Signals::closed(&motion, 293.0, 1e5)
    }

    #[test]
    fn a_stroke_recorded_late_happened_earlier() {
        let values = EffectValues::NEUTRAL.with(PositionDelay::INDEX, &[0.03]);
        let record =
            recorded((0..=100).map(|k| f64::from(k) * 0.01), |t| 0.1 - 0.05 * ((t - 0.03).clamp(0.2, 0.4) - 0.2));
        let signals = record.with_true_stroke(PositionDelay::SET, &values);
        for k in 0..96 {
            let t = f64::from(k) * 0.01 + 0.003;
            let truth = 0.1 - 0.05 * (t.clamp(0.2, 0.4) - 0.2);
            assert!((signals.knot(t).position - truth).abs() < 1e-15, "{t}");
        }
        assert_eq!((signals.knots[0].time, signals.knots.last().unwrap().time), (0.0, 1.0));
    }

    #[test]
    fn a_stroke_recorded_through_a_low_pass_is_recovered() {
        let (filter, speed) = (0.05, 0.2);
        let values = EffectValues::NEUTRAL.with(PositionDelay::INDEX, &[0.0, filter]);
        let stroke = |t: f64| 0.1 - speed * (t.clamp(0.2, 0.4) - 0.2);
        // Filtered: a ramp minus τ v (1 − e^(−t/τ)), at its start and, with the other sign, at its end.
        let filtered = |t: f64| if t > 0.0 { speed * (t - filter * (1.0 - (-t / filter).exp())) } else { 0.0 };
        let record = recorded((0..=1000).map(|k| f64::from(k) * 1e-3), |t| 0.1 - filtered(t - 0.2) + filtered(t - 0.4));
        let signals = record.with_true_stroke(PositionDelay::SET, &values);
        for k in 0..999 {
            let t = f64::from(k) * 1e-3;
            assert!((signals.knot(t).position - stroke(t)).abs() < speed * 1e-3, "{t}");
        }
    }

    #[test]
    fn a_moving_average_is_undone() {
        let stroke = |t: f64| 0.1 + 0.02 * (5.0 * t).sin();
        for window in [0.2, 0.4] {
            let values = EffectValues::NEUTRAL.with(PositionAveraging::INDEX, &[window]);
            let averaged = |t: f64| {
                let (a, b) = (t - 0.5 * window, t + 0.5 * window);
                0.1 + 0.02 * ((5.0 * a).cos() - (5.0 * b).cos()) / (5.0 * window)
            };
            let record = recorded((0..=4000).map(|k| f64::from(k) * 5e-4), averaged);
            let errors = [&record, &record.clone().with_true_stroke(PositionAveraging::SET, &values)].map(|s| {
                (0..2000)
                    .map(|k| f64::from(k) * 1e-3)
                    .map(|t| (s.knot(t).position - stroke(t)).abs())
                    .fold(0.0, f64::max)
            });
            assert!(errors[1] < 0.1 * errors[0], "{window}: {errors:?}");
        }
    }

    #[test]
    fn a_true_stroke_is_left_as_it_is() {
        let record = recorded((0..9).map(f64::from), |t| 0.1 - 0.01 * t);
        assert_eq!(record.clone().with_true_stroke(EffectSet::ALL, &EffectValues::NEUTRAL), record);
    }
}
