//! The values that one varied quantity takes: a list, a range with a linear or logarithmic scale, or a distribution.

use super::distribution::Distribution;
use chamber::real::Real;
use ensemble::lanes::{Lanes, WIDTH};
use pulp::{Arch, Simd, WithSimd};
use serde::Serialize;
use std::ops::RangeInclusive;

/// How a range is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal ratios.
    Log,
}

/// The values of one varied quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Axis {
    /// A list of values, each of which is a level.
    Values {
        /// In the order of the study file.
        values: Vec<f64>,
    },
    /// From one value to another, both included.
    Range {
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
        /// Number of levels of a factorial design; the sampled designs do not use it.
        #[serde(skip_serializing_if = "Option::is_none")]
        count: Option<u64>,
        /// Equal steps or equal ratios.
        scale: Scale,
    },
    /// Drawn from a distribution; not in a factorial design.
    Drawn(Distribution),
}

impl Axis {
    /// Number of levels in a factorial design; `None` for a range without a count, and for a distribution.
    pub fn levels(&self) -> Option<u64> {
        match self {
            Axis::Values { values } => Some(values.len() as u64),
            Axis::Range { count, .. } => *count,
            Axis::Drawn(_) => None,
        }
    }

    /// The value at a level of a factorial design, counted from zero. Includes the ends of a range exactly.
    pub fn level(&self, level: u64) -> f64 {
        match *self {
            Axis::Values { ref values } => values[level as usize],
            Axis::Drawn(ref distribution) => distribution.quantile(0.5),
            Axis::Range { from, to, count, scale } => {
                let last = count.unwrap_or(1).saturating_sub(1);
                if level == 0 {
                    from
                } else if level >= last {
                    to
                } else {
                    Between::new(from, to, scale).value(level as f64 / last as f64)
                }
            }
        }
    }

    /// Maps fractions in [0, 1) to values: along a range, over the values equally often, or as probabilities of a distribution.
    pub fn map_fractions(&self, fractions: &mut [f64]) {
        match *self {
            Axis::Values { ref values } => {
                let value = |u: f64| values[((u * values.len() as f64) as usize).min(values.len() - 1)];
                fractions.iter_mut().for_each(|fraction| *fraction = value(*fraction));
            }
            Axis::Range { from, to, scale, .. } => {
                Arch::new().dispatch(MapInLanes { between: Between::new(from, to, scale), fractions });
            }
            Axis::Drawn(ref distribution) => {
                fractions.iter_mut().for_each(|fraction| *fraction = distribution.quantile(*fraction));
            }
        }
    }

    /// Minimum and maximum.
    pub fn bounds(&self) -> RangeInclusive<f64> {
        match *self {
            Axis::Values { ref values } => {
                values.iter().copied().fold(f64::MAX, f64::min)..=values.iter().copied().fold(f64::MIN, f64::max)
            }
            Axis::Range { from, to, .. } => from..=to,
            Axis::Drawn(ref distribution) => distribution.bounds(),
        }
    }

    /// Whether a factorial design's values repeat often enough for a dictionary.
    pub fn is_discrete(&self) -> bool {
        matches!(self, Axis::Values { .. })
    }
}

/// Maps a fraction of a range to its value.
struct Between {
    from: f64,
    to: f64,
    scale: Scale,
    /// Start and length of the range of the values, or of their logarithms.
    begin: f64,
    length: f64,
}

impl Between {
    fn new(from: f64, to: f64, scale: Scale) -> Self {
        let (begin, end) = match scale {
            Scale::Linear => (from, to),
            Scale::Log => (from.ln(), to.ln()),
        };
        Self { from, to, scale, begin, length: end - begin }
    }

    #[inline(always)]
    fn value<R: Real>(&self, fraction: R) -> R {
        let value = fraction * self.length + self.begin;
        let value = if self.scale == Scale::Log { value.exp() } else { value };
        value.max(R::from(self.from)).min(R::from(self.to))
    }
}

/// Maps fractions to values, several at a time.
struct MapInLanes<'a> {
    between: Between,
    fractions: &'a mut [f64],
}

impl WithSimd for MapInLanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (whole, rest) = self.fractions.as_chunks_mut::<WIDTH>();
        for fractions in whole {
            *fractions = self.between.value(Lanes(*fractions)).0;
        }
        let last = self.between.value(Lanes::from_fn(|lane| rest.get(lane).copied().unwrap_or(0.0)));
        rest.copy_from_slice(&last.0[..rest.len()]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_meets_both_ends_exactly_and_keeps_its_steps_or_ratios() {
        for scale in [Scale::Linear, Scale::Log] {
            let axis = Axis::Range { from: 0.016, to: 0.063, count: Some(12), scale };
            let levels: Vec<f64> = (0..12).map(|i| axis.level(i)).collect();
            assert_eq!((levels[0], levels[11]), (0.016, 0.063));
            let step = |a: f64, b: f64| if scale == Scale::Log { b / a } else { b - a };
            let first = step(levels[0], levels[1]);
            assert!(levels.windows(2).all(|w| (step(w[0], w[1]) / first - 1.0).abs() < 1e-12));
        }
    }

    #[test]
    fn fractions_select_each_value_of_a_list_equally_often() {
        let axis = Axis::Values { values: vec![1.0, 2.0, 4.0] };
        let mut fractions = [0.0, 0.33, 0.34, 0.66, 0.67, 0.9999999];
        axis.map_fractions(&mut fractions);
        assert_eq!(fractions, [1.0, 1.0, 2.0, 2.0, 4.0, 4.0]);
    }

    #[test]
    fn fractions_map_to_the_values_of_a_range_in_proportion_to_its_scale() {
        let fractions: Vec<f64> = (0..37).map(|i| f64::from(i) / 37.0).collect();
        for (scale, expected) in [(Scale::Linear, 1.0 + 6.0 * 0.5), (Scale::Log, 7f64.sqrt())] {
            let axis = Axis::Range { from: 1.0, to: 7.0, count: None, scale };
            let mut values = fractions.clone();
            axis.map_fractions(&mut values);
            assert!(values[0] == 1.0 && values.is_sorted() && values[36] < 7.0);
            let mut middle = [0.5];
            axis.map_fractions(&mut middle);
            assert!((middle[0] / expected - 1.0).abs() < 1e-15);
        }
    }
}
