//! The curve that a sensor finally applies to its reading: straight lines between bends.

use chamber::effects::{self, EffectSet, EffectValues, OWN_STATES};

/// The curve that a sensor finally applies to its reading.
#[derive(Clone, Copy, Debug)]
pub struct Bends<'a> {
    /// The effects with such a curve.
    set: EffectSet,
    values: &'a EffectValues,
}

impl<'a> Bends<'a> {
    /// The curve by the active effects of a chamber.
    pub fn new(active: EffectSet, values: &'a EffectValues) -> Self {
        let all = Self { set: active.intersection(effects::WITH_READING_KINKS), values };
        let any = all.between(f64::MIN, f64::MAX).next().is_some();
        if any { all } else { Self { set: EffectSet::NONE, values } }
    }

    /// Whether there is no curve: the record is the reading.
    pub fn is_none(&self) -> bool {
        self.set.is_empty()
    }

    /// What the record shows for a reading, Pa.
    pub fn shown(&self, reading: f64) -> f64 {
        self.values.reading(self.set, &[0.0; OWN_STATES], reading, 0.0)
    }

    /// Change of what is shown between a reading and one that is smaller by `by`, Pa.
    pub fn change(&self, reading: f64, by: f64) -> f64 {
        if self.is_none() { by } else { self.shown(reading) - self.shown(reading - by) }
    }

    /// The bends between two readings, Pa, in order.
    pub fn between(&self, from: f64, to: f64) -> impl Iterator<Item = f64> + use<'a> {
        let Self { set, values } = *self;
        let next = move |from: f64| Some(values.reading_kink(set, from, to)).filter(|reading| *reading != to);
        std::iter::successors(next(from), move |from| next(*from))
    }
}

/// The record as a function of the reading along a piece: `level` + `gain` × reading.
#[derive(Clone, Copy, Debug)]
pub struct Straight {
    /// Pa.
    pub level: f64,
    pub gain: f64,
}

impl Straight {
    /// The record of a sensor that shows its reading unchanged.
    pub const READING: Self = Self { level: 0.0, gain: 1.0 };

    /// The line through two readings and what is shown for them.
    pub fn through(readings: [f64; 2], shown: [f64; 2]) -> Self {
        let way = readings[1] - readings[0];
        let gain = if way == 0.0 { 0.0 } else { (shown[1] - shown[0]) / way };
        Self { level: shown[0] - gain * readings[0], gain }
    }
}
