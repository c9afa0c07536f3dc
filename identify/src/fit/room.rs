//! How far a step may go in each coordinate: to the bounds of its number, and with a logarithm by a factor of e² at a time.

use crate::parameters::{Axis, Hypothesis, Own};

/// The least and the most that each coordinate may change.
#[derive(Clone, Debug)]
pub struct Room {
    /// Of the rig's coordinates.
    pub rig: Vec<[f64; 2]>,
    /// Of each record's own.
    pub own: Vec<Vec<[f64; 2]>>,
}

impl Room {
    /// Around these coordinates of a hypothesis; `own_axes` are those of each record.
    pub fn around(h: &Hypothesis, own_axes: &[Vec<Axis<Own>>], rig: &[f64], own: &[Vec<f64>]) -> Self {
        Self { rig: each(&h.axes, rig), own: own_axes.iter().zip(own).map(|(axes, own)| each(axes, own)).collect() }
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
