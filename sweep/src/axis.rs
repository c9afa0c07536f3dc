//! The values that one varied quantity takes: a list, or a range with a linear or logarithmic scale.

use serde::Serialize;

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
    /// These values.
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
}

impl Axis {
    /// Number of levels in a factorial design; a range needs a count for it.
    pub fn levels(&self) -> Option<u64> {
        match self {
            Axis::Values { values } => Some(values.len() as u64),
            Axis::Range { count, .. } => *count,
        }
    }

    /// The value at a level of a factorial design, counted from zero. The ends of a range are met exactly.
    pub fn level(&self, level: u64) -> f64 {
        match *self {
            Axis::Values { ref values } => values[level as usize],
            Axis::Range { from, to, count, scale } => {
                let last = count.unwrap_or(1).saturating_sub(1);
                if level == 0 {
                    from
                } else if level >= last {
                    to
                } else {
                    between(from, to, scale)(level as f64 / last as f64)
                }
            }
        }
    }

    /// The value at a share `u` in [0, 1) of the axis: of a range's length, or of the values in equal shares.
    pub fn at(&self, u: f64) -> f64 {
        match *self {
            Axis::Values { ref values } => values[((u * values.len() as f64) as usize).min(values.len() - 1)],
            Axis::Range { from, to, scale, .. } => between(from, to, scale)(u),
        }
    }

    /// Adds the values at some shares to a column.
    pub fn fill(&self, shares: impl Iterator<Item = f64>, column: &mut Vec<f64>) {
        match *self {
            Axis::Values { .. } => column.extend(shares.map(|u| self.at(u))),
            Axis::Range { from, to, scale, .. } => column.extend(shares.map(between(from, to, scale))),
        }
    }

    /// Whether a factorial design's values repeat often enough for a dictionary.
    pub fn is_discrete(&self) -> bool {
        matches!(self, Axis::Values { .. })
    }
}

/// From a share of a range to its value.
fn between(from: f64, to: f64, scale: Scale) -> impl Fn(f64) -> f64 {
    let (begin, end) = match scale {
        Scale::Linear => (from, to),
        Scale::Log => (from.ln(), to.ln()),
    };
    move |share| {
        let value = begin + (end - begin) * share;
        (if scale == Scale::Log { value.exp() } else { value }).clamp(from, to)
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
    fn shares_of_a_list_are_equal() {
        let axis = Axis::Values { values: vec![1.0, 2.0, 4.0] };
        assert_eq!([0.0, 0.33, 0.34, 0.66, 0.67, 0.9999999].map(|u| axis.at(u)), [1.0, 1.0, 2.0, 2.0, 4.0, 4.0]);
    }
}
