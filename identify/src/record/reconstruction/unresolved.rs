//! What a moving average hides of a stroke: moves hardly longer than the window cannot be recovered.
//!
//! The stroke behind an average ([`chamber::unaveraged`]) lacks what changes faster than its window. The sixth difference δ⁶ of
//! the record over steps of half a window shows where: pushes of 1.25 to 3 windows are recovered with an rms error of 0.6 to 0.9
//! times the largest δ⁶/70 within half a window, which is the error stated here. Position in m, time in s.

use super::true_stroke::TrueStroke;
use crate::record::stroke::{Motion, Phase, Segment};

/// Binomial weights of the sixth difference.
const WEIGHTS: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
/// Fraction of the sixth difference that may be missed.
const MISSED: f64 = 1.0 / 70.0;
/// Where the error is evaluated around a time, in windows.
const AROUND: [f64; 5] = [-0.5, -0.25, 0.0, 0.25, 0.5];

/// Recorded moves of up to this many windows are hardly longer than one: the record lengthens them by a window, and the search
/// for their gentle starts and ends takes in some further rows.
const SHORT: f64 = 8.0;

/// Whether most of the travel of a record averaged over `window`, s, is in moves hardly longer than that.
pub fn hides_moves(motion: &Motion, window: f64) -> bool {
    let travel = |is_asked: &dyn Fn(&Segment) -> bool| -> f64 {
        let moves = motion.segments.iter().filter(|s| s.phase == Phase::Move && is_asked(s));
        moves.map(|s| s.stroke.range()).map(|(low, high)| high - low).sum()
    };
    travel(&|s| s.to_s - s.from_s < SHORT * window) > 0.5 * travel(&|_| true)
}

/// A stroke whose record is a moving average.
pub struct Unresolved<'a> {
    recorded: TrueStroke<'a>,
    extent: (f64, f64),
    window: f64,
}

impl<'a> Unresolved<'a> {
    /// For a record averaged over `window`, s.
    pub fn new(motion: &'a Motion, window: f64) -> Self {
        Self { recorded: TrueStroke::new(motion, 0.0, 0.0, false), extent: motion.extent(), window }
    }

    /// Error of the stroke at a time, m.
    pub fn error_m(&self, time: f64) -> f64 {
        if self.window == 0.0 {
            return 0.0;
        }
        AROUND.iter().map(|place| self.missed(time + place * self.window)).fold(0.0, f64::max)
    }

    /// What the average hides at a time, from the sixth difference, m.
    fn missed(&self, middle: f64) -> f64 {
        let (begin, end) = self.extent;
        let at = |i: usize| {
            let time = middle + 0.5 * self.window * (i as f64 - 3.0);
            self.recorded.recorded(time.clamp(begin, end))[0]
        };
        MISSED * WEIGHTS.iter().enumerate().map(|(i, weight)| weight * at(i)).sum::<f64>().abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A push of this length, s, recorded at 1 kHz as a moving average over 40 ms, and the stroke itself.
    fn push(length: f64) -> (impl Fn(f64) -> f64, Motion) {
        const WINDOW: f64 = 0.04;
        let truth =
            move |t: f64| 0.1 - 0.025 * (1.0 - (std::f64::consts::PI * ((t - 0.5) / length).clamp(0.0, 1.0)).cos());
        let averaged =
            |t: f64| (0..400).map(|k| truth(t + WINDOW * ((f64::from(k) + 0.5) / 400.0 - 0.5))).sum::<f64>() / 400.0;
        let (time, position): (Vec<f64>, Vec<f64>) =
            (0..1200).map(|i| f64::from(i) * 1e-3).map(|t| (t, averaged(t))).unzip();
        (truth, Motion::detect(&time, &position))
    }

    #[test]
    fn the_error_of_a_stroke_recovered_from_an_average_is_of_the_stated_size() {
        for length in [0.05, 0.08, 0.12] {
            let (truth, motion) = push(length);
            let stroke = TrueStroke::new(&motion, 0.04, 0.0, false);
            let unresolved = Unresolved::new(&motion, 0.04);
            let found = |t: f64| stroke.at(stroke.stretch_that_ends_at(t), t).position;
            let (mut off, mut stated) = (0.0, 0.0);
            for t in (0..2000).map(|k| 0.45 + (length + 0.1) * f64::from(k) / 2000.0) {
                off += (found(t) - truth(t)).powi(2);
                stated += unresolved.error_m(t).powi(2);
            }
            let ratio: f64 = (off / stated).sqrt();
            assert!((0.5..1.0).contains(&ratio), "{length}: {ratio}");
        }
    }

    #[test]
    fn short_pushes_are_hidden_and_long_ones_are_not() {
        let hides = [0.04, 0.12, 0.5].map(|length| hides_moves(&push(length).1, 0.04));
        assert_eq!(hides, [true, true, false]);
        assert!(!hides_moves(&push(0.04).1, 0.0));
    }
}
