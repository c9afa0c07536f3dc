//! The history of an integration: what is seen at the end of each step, of as many rows as there are lanes.
//!
//! It is bounded. When it is full the integration stops, and the caller goes on with fewer rows at a time.

use crate::integrator::advance::{Tried, Watch};
use crate::integrator::problem::Steps;
use crate::integrator::step::View;
use crate::lanes::Lanes;
use crate::reader::Knot;

/// Steps of all lanes.
#[derive(Debug, Default)]
pub struct History {
    /// Of each its end, whether it was accepted (2 where up to a kink), two quantities and their slopes.
    steps: Vec<[Lanes; 6]>,
    /// Whether steps that are seen are kept.
    pub awake: bool,
    /// How many steps it keeps; none is no limit.
    pub limit: Option<usize>,
}

impl History {
    /// Drops every step; the memory stays allocated.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Keeps a step of all lanes: its end, whether it is one (1) or not (0), and what is seen there.
    #[inline(always)]
    pub fn push(&mut self, at: Lanes, taken: Lanes, View { value, slope }: &View<Lanes>) {
        if self.awake {
            self.steps.push([at, taken, value[0], value[1], slope[0], slope[1]]);
        }
    }

    /// How many steps are kept.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Appends the ends of a problem's accepted steps.
    pub fn read(&self, steps: Steps, to: &mut Vec<Knot>) {
        let lane = steps.lane as usize;
        for step in &self.steps[steps.from as usize..steps.to as usize] {
            let [at, taken, value @ .., rise, warming] = step;
            if taken[lane] > 0.0 {
                let view = View { value: [value[0][lane], value[1][lane]], slope: [rise[lane], warming[lane]] };
                to.push(Knot { at: at[lane], view, kink: taken[lane] > 1.0 });
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
        self.limit.is_some_and(|limit| self.len() >= limit)
    }
}
