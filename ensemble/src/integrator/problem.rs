//! Initial value problems for lanes to solve, each over one smooth stretch of time.

use crate::integrator::step::{Moment, View};
use crate::lanes::Lanes;
use crate::outcome::Failure;

/// One initial value problem, and after [`advance`](crate::integrator::advance::advance) its solution.
#[derive(Clone, Copy, Debug)]
pub struct Problem<const N: usize> {
    /// Length of the stretch, s.
    pub length: f64,
    /// States at its start; afterwards at its end.
    pub state: [f64; N],
    /// Absolute tolerance of each state.
    pub absolute: [f64; N],
    /// Longest step that may be tried, s.
    pub longest: f64,
    /// Length of its first step, s; zero where that is to be found out.
    pub first: f64,
    /// Rates of the states at the stretch's start, per second.
    pub slope: [f64; N],
    /// What goes into the integrals of [`Problem::energy`] there, W.
    pub power: [f64; 2],
    /// What is seen at its start.
    pub view: View<f64>,
    /// Energy received as heat and enthalpy, and work on the piston: integrals of [`Moment::power`].
    pub energy: [f64; 2],
    /// Where the watch has kept its steps.
    pub steps: Steps,
    /// Why it was given up.
    pub failure: Option<Failure>,
}

impl<const N: usize> Problem<N> {
    /// To be solved over `length`, s, from `state`, with these absolute tolerances.
    pub fn new(length: f64, state: [f64; N], absolute: [f64; N]) -> Self {
        let (slope, power, view, energy) = ([0.0; N], [0.0; 2], View::NONE, [0.0; 2]);
        let (longest, first, steps) = (f64::INFINITY, 0.0, Steps::default());
        Self { length, state, absolute, longest, first, slope, power, view, energy, steps, failure: None }
    }

    /// Notes what a lane has found out about its start.
    #[inline(always)]
    pub fn begin(&mut self, lane: usize, moment: &Moment<N>, first: Lanes) {
        if self.first == 0.0 {
            self.first = first[lane];
        }
        for i in 0..2 {
            self.view.value[i] = moment.view.value[i][lane];
            self.view.slope[i] = moment.view.slope[i][lane];
            self.power[i] = moment.power[i][lane];
        }
        for i in 0..N {
            self.slope[i] = moment.slope[i][lane];
        }
    }
}

/// Where a watch has kept a problem's steps: one lane of consecutive steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steps {
    /// Number of the problem's first step in the watch's history.
    pub from: u32,
    /// Number of the step after the problem's last one.
    pub to: u32,
    /// Lane in which these steps were taken.
    pub lane: u32,
}

impl Steps {
    /// Number of steps kept.
    pub fn count(&self) -> u32 {
        self.to - self.from
    }
}
