//! The history of an integration: pressure and temperature at the end of each step, one row per lane.
//!
//! It is bounded. When it is full the integration stops, and the caller repeats it with fewer rows at a time.

use crate::integrator::advance::{Tried, Watch};
use crate::integrator::problem::Steps;
use crate::integrator::step::View;
use crate::lanes::Lanes;
use crate::reader::Knot;

/// Steps of all lanes.
#[derive(Debug, Default)]
pub struct History {
    /// For each step its end, whether it was accepted (2 if it ends at a kink), two quantities and their slopes.
    steps: Vec<[Lanes; 6]>,
    /// Whether steps are kept at present.
    pub awake: bool,
    /// Largest number of steps, if limited.
    pub limit: Option<usize>,
}

impl History {
    /// Drops all steps; keeps the memory.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Keeps a step of all lanes: its end, whether it was taken (1) or not (0), and the view there.
    #[inline(always)]
    pub fn push(&mut self, at: Lanes, taken: Lanes, View { value, slope }: &View<Lanes>) {
        if self.awake {
            self.steps.push([at, taken, value[0], value[1], slope[0], slope[1]]);
        }
    }

    /// Number of steps kept.
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
    fn stored(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn is_full(&self) -> bool {
        self.limit.is_some_and(|limit| self.len() >= limit)
    }
}
