//! Initial value problems, each over one smooth span of time.

use crate::integrator::step::{Moment, View};
use crate::lanes::Lanes;
use crate::outcome::Failure;

/// An initial value problem and, after [`advance`](crate::integrator::advance::advance), its solution.
#[derive(Clone, Copy, Debug)]
pub struct Problem<const N: usize> {
    /// Length of the span, s.
    pub length: f64,
    /// States at its start; afterwards at its end.
    pub state: [f64; N],
    /// Absolute tolerance of each state.
    pub absolute: [f64; N],
    /// Longest step that may be tried, s.
    pub longest: f64,
    /// First step, s; zero if it is to be estimated.
    pub first: f64,
    /// Rates of the states at the span's start, per second.
    pub slope: [f64; N],
    /// Integrand of [`Problem::energy`] there, W.
    pub power: [f64; 2],
    /// View at its start.
    pub view: View<f64>,
    /// Energy received as heat and enthalpy, and work on the piston: integrals of [`Moment::power`].
    pub energy: [f64; 2],
    /// Its steps in the watch's history.
    pub steps: Steps,
    /// Why it failed, if it did.
    pub failure: Option<Failure>,
}

impl<const N: usize> Problem<N> {
    /// A problem over `length`, s, from `state`, with these absolute tolerances.
    pub fn new(length: f64, state: [f64; N], absolute: [f64; N]) -> Self {
        let (slope, power, view, energy) = ([0.0; N], [0.0; 2], View::NONE, [0.0; 2]);
        let (longest, first, steps) = (f64::INFINITY, 0.0, Steps::default());
        Self { length, state, absolute, longest, first, slope, power, view, energy, steps, failure: None }
    }

    /// Stores the initial rates and the first step, from a lane.
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

/// A problem's steps in a watch's history: one lane of consecutive entries.
#[derive(Clone, Copy, Debug, Default)]
pub struct Steps {
    /// Index of the first step.
    pub from: u32,
    /// Index after the last step.
    pub to: u32,
    /// Lane of the steps.
    pub lane: u32,
}

impl Steps {
    /// Number of steps.
    pub fn count(&self) -> u32 {
        self.to - self.from
    }
}
