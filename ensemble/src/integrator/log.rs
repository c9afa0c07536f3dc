//! The log of the steps through holds, some of which are interpolated later. Entries are small so that a chunk's steps stay in a core's
//! cache.

use crate::integrator::advance::{Tried, Watch};
use crate::lanes::Lanes;

/// An attempted step of all lanes.
#[derive(Clone, Copy)]
pub struct Attempted<const N: usize> {
    /// Time at which the step begins, s from the span's start.
    pub from: Lanes,
    /// Length of the step, s.
    pub length: Lanes,
    /// States at its start and its end.
    pub states: [[Lanes; N]; 2],
    /// Positive if the step was accepted.
    pub accepted: Lanes,
}

impl<const N: usize> Attempted<N> {
    /// Copies its length and the states at its ends from its lane `column` to a lane.
    #[inline(always)]
    pub fn put(&self, column: usize, lane: usize, length: &mut Lanes, ends: &mut [[Lanes; N]; 2]) {
        length[lane] = self.length[column];
        for side in 0..2 {
            for i in 0..N {
                ends[side][i][lane] = self.states[side][i][column];
            }
        }
    }
}

/// Keeps every step.
impl<const N: usize> Watch<N> for Vec<Attempted<N>> {
    #[inline(always)]
    fn see(&mut self, tried: &Tried<N>) {
        let &Tried { from, length, begin, end, accepted, .. } = tried;
        self.push(Attempted { from, length, states: [begin, end], accepted });
    }
    #[inline(always)]
    fn stored(&self) -> usize {
        self.len()
    }
}
