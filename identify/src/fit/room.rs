//! Allowed range of a step in each coordinate: up to the parameter's bounds, and for logarithmic ones a factor of e² at most.

use crate::parameters::{Axis, Hypothesis, RecordSlot};

/// The smallest and the largest change of each coordinate.
#[derive(Clone, Debug)]
pub struct Room {
    /// Of the rig's coordinates.
    pub rig: Vec<[f64; 2]>,
    /// Of each record's coordinates.
    pub records: Vec<Vec<[f64; 2]>>,
}

impl Room {
    /// Range around these coordinates of a hypothesis; `record_axes` are those of each record.
    pub fn around(h: &Hypothesis, record_axes: &[Vec<Axis<RecordSlot>>], rig: &[f64], records: &[Vec<f64>]) -> Self {
        Self {
            rig: each(&h.axes, rig),
            records: record_axes.iter().zip(records).map(|(axes, record)| each(axes, record)).collect(),
        }
    }
}

fn each<S>(axes: &[Axis<S>], x: &[f64]) -> Vec<[f64; 2]> {
    let around = |(axis, x): (&Axis<S>, &f64)| {
        let most = if axis.logarithmic { 2.0 } else { f64::INFINITY };
        let least = (axis.bounds[0] - x).max(-most);
        [least, (axis.bounds[1] - x).min(most).max(least)]
    };
    axes.iter().zip(x).map(around).collect()
}
