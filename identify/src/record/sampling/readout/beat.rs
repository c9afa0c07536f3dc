//! The beat of marks in a record's rows, such as changes: a period, in rows, that need not be a whole number.
//!
//! Marks with a frequency f are in phase in the sum of w exp(2πi f row). The strongest f is searched for over all frequencies
//! among the marks that lie closest together, then in ever longer parts of the record near what the shorter part showed.

use std::f64::consts::TAU;
use std::ops::Range;

/// A marked row and its weight.
pub type Mark = (f64, f64);

/// Beats at `first` + k `period`, rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beat {
    /// Time of one of them, rows.
    pub first: f64,
    /// Rows from one to the next.
    pub period: f64,
}

/// Number of marks that show a beat.
const SHOW: usize = 96;
/// Frequency steps per 1/length, the change that puts the marks at both ends out of phase.
const FINE: f64 = 8.0;
/// Beats that are tried: where a reading lasts for many rows, those of half, a third, … of its period are nearly as strong.
const TRIED: usize = 6;

/// Natural logarithm of the probability that marks in arbitrary rows keep to a beat by chance: for the best of all beats, and for
/// one whose period is known.
pub const BY_CHANCE: [f64; 2] = [-25.0, -8.0];

impl Beat {
    /// The beats that these marks, ascending, may have: near the known period `like`, or else with one of `periods`.
    pub fn candidates(marks: &[Mark], like: Option<f64>, periods: Range<f64>) -> Vec<Self> {
        match like {
            Some(period) => vec![Self::like(marks, period)],
            None if periods.is_empty() => Vec::new(),
            None => Self::of(marks, periods),
        }
    }

    /// Those with one of these periods, the strongest first.
    fn of(marks: &[Mark], periods: Range<f64>) -> Vec<Self> {
        let Some(mut part) = closest_together(marks) else { return Vec::new() };
        let step = 1.0 / (FINE * length(&marks[part.clone()]));
        let count = ((1.0 / periods.start - 1.0 / periods.end) / step).ceil() as usize;
        let strengths: Vec<[f64; 2]> = (0..=count)
            .map(|i| 1.0 / periods.end + i as f64 * step)
            .map(|frequency| [strength(&marks[part.clone()], frequency), frequency])
            .collect();
        let is_peak = |i: &usize| {
            let at = |i: usize| strengths.get(i).map_or(0.0, |s| s[0]);
            at(*i) >= i.checked_sub(1).map_or(0.0, at) && at(*i) > at(i + 1)
        };
        let mut peaks: Vec<[f64; 2]> = (0..strengths.len()).filter(is_peak).map(|i| strengths[i]).collect();
        peaks.sort_by(|a, b| b[0].total_cmp(&a[0]));
        let mut found: Vec<f64> = peaks.into_iter().take(TRIED).map(|[_, frequency]| frequency).collect();
        let mut known_to = step;
        while part.len() < marks.len() {
            part = part.start.saturating_sub(part.len() / 2)..(part.end + part.len().div_ceil(2)).min(marks.len());
            let marks = &marks[part.clone()];
            let finer = 1.0 / (FINE * length(marks));
            found.iter_mut().for_each(|frequency| *frequency = strongest(marks, *frequency, known_to, finer));
            known_to = finer;
        }
        found.into_iter().map(|frequency| Self::in_phase(marks, 1.0 / frequency)).collect()
    }

    /// The beat of these marks near a known period.
    fn like(marks: &[Mark], period: f64) -> Self {
        /// Two clocks agree to this fraction.
        const FREQUENCY_KNOWN_TO: f64 = 3e-4;
        let frequency = 1.0 / period;
        let finer = 1.0 / (FINE * length(marks));
        Self::in_phase(marks, 1.0 / strongest(marks, frequency, FREQUENCY_KNOWN_TO * frequency, finer))
    }

    fn in_phase(marks: &[Mark], period: f64) -> Self {
        let [real, imaginary] = sum(marks, 1.0 / period);
        Self { first: imaginary.atan2(real) / TAU * period, period }
    }

    /// Number of the beat nearest to a row.
    pub fn nearest(&self, row: f64) -> f64 {
        ((row - self.first) / self.period).round()
    }

    /// Time of a beat, rows.
    pub fn at(&self, beat: f64) -> f64 {
        self.first + beat * self.period
    }

    /// Fits the beat to known beats, each with its row and weight; unchanged where these are too few.
    pub fn through(self, known: &[[f64; 3]]) -> Self {
        let weight = known.iter().map(|[.., w]| w).sum::<f64>();
        let [beat, row] = [0, 1].map(|k| known.iter().map(|of| of[2] * of[k]).sum::<f64>() / weight);
        let along = known.iter().map(|[b, _, w]| w * (b - beat).powi(2)).sum::<f64>();
        let across = known.iter().map(|[b, r, w]| w * (b - beat) * (r - row)).sum::<f64>();
        let period = across / along;
        if along > 0.0 && period.is_finite() { Self { first: row - beat * period, period } } else { self }
    }
}

fn sum(marks: &[Mark], frequency: f64) -> [f64; 2] {
    marks.iter().fold([0.0; 2], |[real, imaginary], (row, weight)| {
        let (sine, cosine) = (TAU * (frequency * row).fract()).sin_cos();
        [real + weight * cosine, imaginary + weight * sine]
    })
}

fn strength(marks: &[Mark], frequency: f64) -> f64 {
    let [real, imaginary] = sum(marks, frequency);
    real.hypot(imaginary)
}

/// Strongest frequency within `within` of `frequency`.
fn strongest(marks: &[Mark], frequency: f64, within: f64, step: f64) -> f64 {
    let steps = (within / step).ceil();
    let frequencies = (0..=2 * steps as usize).map(|i| frequency + (i as f64 - steps) * step);
    let of = frequencies.map(|f| (strength(marks, f), f));
    of.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(frequency, |(_, f)| f)
}

/// Rows from the first mark to the last.
fn length(marks: &[Mark]) -> f64 {
    (marks[marks.len() - 1].0 - marks[0].0).max(1.0)
}

/// The marks that lie closest together, as many as show a beat, or all of them; none for fewer than three.
fn closest_together(marks: &[Mark]) -> Option<Range<usize>> {
    let count = SHOW.min(marks.len());
    let parts = (0..=marks.len() - count).map(|first| first..first + count);
    parts.filter(|_| count > 2).min_by(|a, b| length(&marks[a.clone()]).total_cmp(&length(&marks[b.clone()])))
}
