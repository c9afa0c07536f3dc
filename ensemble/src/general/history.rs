//! The history of an integration: what is seen at the end of each step, of as many rows as there are lanes.
//!
//! It is bounded. When it is full the integration stops, and the caller goes on with fewer rows at a time.

use crate::integrator::advance::{Tried, Watch};
use crate::integrator::problem::Steps;
use crate::integrator::step::View;
use crate::lanes::Lanes;
use crate::reader::Knot;

/// Lanes that a step takes: its end, whether it was accepted (2 where up to a kink), two quantities and their slopes.
const STRIDE: usize = 6;

/// Steps of all lanes.
#[derive(Debug, Default)]
pub struct History {
    lanes: Vec<Lanes>,
    /// Whether steps that are seen are kept.
    pub awake: bool,
    /// How many steps it keeps; none is no limit.
    pub limit: Option<usize>,
}

impl History {
    /// Drops every step; the memory stays allocated.
    pub fn clear(&mut self) {
        self.lanes.clear();
    }

    /// Keeps a step of all lanes: its end, whether it is one (1) or not (0), and what is seen there.
    #[inline(always)]
    pub fn push(&mut self, at: Lanes, taken: Lanes, View { value, slope }: &View<Lanes>) {
        if self.awake {
            self.lanes.extend_from_slice(&[at, taken, value[0], value[1], slope[0], slope[1]]);
        }
    }

    /// How many steps are kept.
    pub fn len(&self) -> usize {
        self.lanes.len() / STRIDE
    }

    /// Appends the ends of a problem's accepted steps.
    pub fn read(&self, steps: Steps, to: &mut Vec<Knot>) {
        let lane = steps.lane as usize;
        for step in self.lanes[steps.from as usize * STRIDE..steps.to as usize * STRIDE].chunks_exact(STRIDE) {
            if step[1][lane] > 0.0 {
                let view = View { value: [step[2][lane], step[3][lane]], slope: [step[4][lane], step[5][lane]] };
                to.push(Knot { at: step[0][lane], view, kink: step[1][lane] > 1.0 });
            }
        }
    }
}

impl<const N: usize> Watch<N> for History {
    #[inline(always)]
    fn see(&mut self, tried: &Tried<N>) {
        self.push(tried.from + tried.length, tried.accepted, &tried.view);
    }

    #[inline(always)]
    fn kept(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.limit.is_some_and(|limit| self.lanes.len() >= limit * STRIDE)
    }
}
