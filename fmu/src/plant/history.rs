//! Past sensor readings, kept for the record's delay: y(t − d).
//!
//! Stores one quartic for each accepted inner step, through five equidistant points; neighbours that one quartic can represent
//! are merged, so that memory depends on the signal and not on the host's step size. Pa and s.

use std::collections::VecDeque;

/// Relative error allowed in a merge.
const MERGE_ERROR: f64 = 1e-10;
/// Stretches shorter than this fraction of the delay are merged whatever the error.
const FINEST: f64 = 1.0 / 32_768.0;
/// Merged stretches are no longer than this fraction of the delay, so that old ones can be dropped.
const COARSEST: f64 = 1.0 / 16.0;

/// Limit on the size of readings, Pa, so that values computed from them are finite.
const LARGEST: f64 = 1e300;

/// Whether a record can store these readings, Pa.
pub fn can_keep(readings: &[f64]) -> bool {
    readings.iter().all(|reading| reading.abs() < LARGEST)
}

/// The sensor's reading at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time of the reading, s.
    pub time: f64,
    /// Reading, Pa.
    pub value: f64,
    /// Its time derivative, Pa/s.
    pub rate: f64,
}

/// A stretch of the reading's time course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Time at which it begins, s.
    pub from: f64,
    /// Duration, s; positive.
    pub length: f64,
    /// Readings at 0, ¼, ½, ¾ and 1 of the length, Pa.
    pub reading: [f64; 5],
}

impl Stretch {
    /// A stretch with the readings given by `reading` for a time in s.
    pub fn of(from: f64, length: f64, reading: impl Fn(f64) -> f64) -> Self {
        Self { from, length, reading: core::array::from_fn(|i| reading(from + length * (i as f64 / 4.0))) }
    }

    /// A stretch between two known readings, Pa, with their rates, Pa/s: cubic Hermite interpolation.
    pub fn between(from: &Reading, to: &Reading) -> Self {
        let length = to.time - from.time;
        Self::of(from.time, length, |t| {
            let s = (t - from.time) / length;
            let (rise, left) = (s * s * (3.0 - 2.0 * s), 1.0 - s);
            from.value + (to.value - from.value) * rise + length * s * left * (left * from.rate - s * to.rate)
        })
    }

    fn end(&self) -> f64 {
        self.from + self.length
    }

    /// Reading, Pa, and its rate, Pa/s, at time `t`, s: Newton's form of the quartic.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let s = ((t - self.from) / self.length).clamp(0.0, 1.0) * 4.0;
        let mut d = self.reading;
        for order in 1..5 {
            for i in (order..5).rev() {
                d[i] = (d[i] - d[i - 1]) / order as f64;
            }
        }
        let (mut value, mut slope) = (d[4], 0.0);
        for i in (0..4).rev() {
            let x = s - i as f64;
            slope = slope * x + value;
            value = value * x + d[i];
        }
        (value, slope * 4.0 / self.length)
    }

    /// Both stretches as one, if one quartic represents them.
    fn merged(&self, next: &Stretch, delay: f64) -> Option<Stretch> {
        let length = next.end() - self.from;
        if length > COARSEST * delay {
            return None;
        }
        let reading = |t: f64| if t < next.from { self.at(t).0 } else { next.at(t).0 };
        let both = Stretch::of(self.from, length, reading);
        let serves = (0..4).all(|i| {
            let t = self.from + length * (2.0 * f64::from(i) + 1.0) / 8.0;
            (both.at(t).0 - reading(t)).abs() <= MERGE_ERROR * reading(t).abs()
        });
        ((serves || self.length < FINEST * delay) && can_keep(&both.reading)).then_some(both)
    }
}

/// The readings of the last `delay`, s.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Reading before the first stretch, Pa.
    pub first: f64,
    /// Stretches in time order.
    pub stretches: VecDeque<Stretch>,
    /// Number of leading stretches unchanged since the mark.
    unchanged: usize,
    /// The stretches after those as they were at the mark, last first.
    changed: Vec<Stretch>,
}

/// Compares only what records show, not their earlier states.
impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        self.first == other.first && self.stretches == other.stretches
    }
}

impl Record {
    /// An empty record that shows `reading`, Pa.
    pub fn new(reading: f64) -> Self {
        Self { first: reading, stretches: VecDeque::with_capacity(256), ..Self::default() }
    }

    /// Marks the record before a step, for a rewind.
    pub fn mark(&mut self) {
        self.unchanged = self.stretches.len();
        self.changed.clear();
    }

    /// Restores the record to the mark.
    pub fn rewind(&mut self) {
        self.stretches.truncate(self.unchanged);
        self.stretches.extend(self.changed.drain(..).rev());
        self.unchanged = self.stretches.len();
    }

    /// Saves the last stretch, which is about to be removed or changed, if it existed at the mark.
    fn keep_last(&mut self) {
        if self.stretches.len() == self.unchanged {
            self.changed.extend(self.stretches.back());
            self.unchanged -= 1;
        }
    }

    /// Appends a stretch. The host's clock may differ from the last end by rounding: a stretch that adds no time is dropped, and
    /// those it overlaps are removed, so that stretches stay in time order.
    pub fn push(&mut self, stretch: Stretch, delay: f64) {
        // A subnormal length is too short to divide by: readings within it would not be finite.
        let adds_time = stretch.length.is_normal() && self.end().is_none_or(|end| stretch.end() > end);
        if !adds_time {
            return;
        }
        while self.stretches.back().is_some_and(|last| last.from >= stretch.from) {
            self.keep_last();
            self.stretches.pop_back();
        }
        let both = self.stretches.back().and_then(|last| last.merged(&stretch, delay));
        if both.is_some() {
            self.keep_last();
            self.stretches.pop_back();
        }
        self.stretches.push_back(both.unwrap_or(stretch));
    }

    /// End of the last stretch, s.
    pub fn end(&self) -> Option<f64> {
        self.stretches.back().map(Stretch::end)
    }

    /// Drops readings older than `until`, s.
    pub fn forget(&mut self, until: f64) {
        while let Some(front) = self.stretches.front().filter(|s| s.end() < until) {
            self.first = front.reading[4];
            self.stretches.pop_front();
        }
    }

    /// Reading, Pa, and its rate, Pa/s, at time `t`, s.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let after = self.stretches.partition_point(|s| s.from <= t);
        match after.checked_sub(1) {
            Some(index) => self.stretches[index].at(t),
            None => (self.first, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(t: f64) -> f64 {
        1e5 + 1e4 * (3.0 * t).sin()
    }

    #[test]
    fn a_clock_that_stops_or_steps_back_a_little_keeps_the_stretches_in_order() {
        let mut record = filled(0.002, 40, 0.05);
        let end = record.end().unwrap();
        for (back, length) in [(0.0, 0.0), (1e-10, 1e-10), (0.067, 1e-3), (0.01, 0.02), (1e-12, 0.002)] {
            record.push(Stretch::of(end - back, length, wave), 0.05);
            assert!(record.stretches.iter().all(|s| s.length > 0.0), "{back} {length}");
            assert!(record.stretches.iter().zip(record.stretches.iter().skip(1)).all(|(a, b)| a.from < b.from));
            let (shown, _) = record.at(end - 0.001);
            assert!((shown - wave(end - 0.001)).abs() < 1.0, "{back} {length}: {shown}");
        }
    }

    fn filled(step: f64, steps: i32, delay: f64) -> Record {
        let mut record = Record::new(wave(0.0));
        for k in 0..steps {
            let from = f64::from(k) * step;
            record.push(Stretch::of(from, step, wave), delay);
            record.forget(from + step - delay);
        }
        record
    }

    #[test]
    fn a_smooth_signal_is_kept_in_few_stretches_whatever_the_step() {
        let fine = filled(1e-4, 20_000, 1.0);
        assert!(fine.stretches.len() < 600, "{}", fine.stretches.len());
        for k in 0..100 {
            let t = 1.0 + f64::from(k) * 0.00987;
            let (value, rate) = fine.at(t);
            assert!((value / wave(t) - 1.0).abs() < 1e-8, "{t}: {value}");
            assert!((rate - 3e4 * (3.0 * t).cos()).abs() < 5.0, "{t}: {rate}");
        }
    }

    #[test]
    fn noise_cannot_fill_the_memory() {
        let mut record = Record::new(0.0);
        let mut noise = 1u64;
        for k in 0..200_000 {
            noise = noise.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let level = 1e5 + (noise >> 50) as f64;
            record.push(Stretch::of(f64::from(k) * 1e-6, 1e-6, |_| level), 1.0);
        }
        assert!(record.stretches.len() < 30_000, "{}", record.stretches.len());
    }

    #[test]
    fn a_rewound_record_is_as_before() {
        let mut record = filled(0.01, 100, 10.0);
        let before = record.clone();
        // The second start lies before the record's last stretches, which the new ones replace.
        for begin in [1.0, 0.93] {
            record.mark();
            for k in 0..15 {
                record.push(Stretch::of(begin + 0.01 * f64::from(k), 0.01, |t| wave(t) + 7.0 * t), 10.0);
            }
            assert_ne!(record, before);
            record.rewind();
            assert_eq!(record, before);
        }
    }

    #[test]
    fn a_stretch_between_two_readings_is_the_cubic_through_both() {
        let cubic = |t: f64| 1e5 + 3.0 * t - 7.0 * t * t + 2.0 * t * t * t;
        let rate = |t: f64| 3.0 - 14.0 * t + 6.0 * t * t;
        let [from, to] = [0.3, 0.8].map(|time| Reading { time, value: cubic(time), rate: rate(time) });
        let stretch = Stretch::between(&from, &to);
        for t in [0.3, 0.41, 0.55, 0.8] {
            assert!((stretch.at(t).0 - cubic(t)).abs() < 1e-10);
        }
    }

    #[test]
    fn what_readings_as_large_as_can_be_kept_are_merged_into_can_be_kept() {
        let wild = |t: f64| if ((t * 1e10) as u64).is_multiple_of(2) { 0.999 * LARGEST } else { -0.999 * LARGEST };
        let mut record = Record::new(0.0);
        for k in 0..20 {
            record.push(Stretch::of(f64::from(k) * 1e-9, 1e-9, wild), 1.0);
        }
        assert!(record.stretches.iter().all(|stretch| can_keep(&stretch.reading)));
    }

    #[test]
    fn before_the_first_stretch_the_record_shows_the_first_reading() {
        assert_eq!(filled(0.01, 3, 10.0).at(-5.0), (wave(0.0), 0.0));
    }
}
