//! `differential-equations` with DOP853, on `WIDTH` scenarios side by side as one system, without storing the trajectory.

use crate::Solve;
use crate::equations::{Equations, Sealed};
use crate::options::Options;
use crate::scenario::{AMBIENT_TEMPERATURE_K, Answer, Case};
use differential_equations::ode::solve_ode;
use differential_equations::prelude::*;
use differential_equations::solution::Solution;
use rayon::prelude::*;

/// Scenarios per thread and piece.
const PIECE: usize = 1 << 13;

/// Time runs from 0 to 1 through the push.
struct Pushed<'a, const WIDTH: usize>(&'a [(f64, Sealed); WIDTH]);
/// Time runs from 0 to 1 through the hold.
struct Held<'a, const WIDTH: usize>(&'a [(f64, Sealed); WIDTH]);

impl<const WIDTH: usize> ODE<f64, [f64; WIDTH]> for Pushed<'_, WIDTH> {
    #[inline(always)]
    fn diff(&self, t: f64, y: &[f64; WIDTH], rates: &mut [f64; WIDTH]) {
        for i in 0..WIDTH {
            let (length, sealed) = &self.0[i];
            rates[i] = length * sealed.pushed(t * length, [y[i]])[0];
        }
    }
}

impl<const WIDTH: usize> ODE<f64, [f64; WIDTH]> for Held<'_, WIDTH> {
    #[inline(always)]
    fn diff(&self, _: f64, y: &[f64; WIDTH], rates: &mut [f64; WIDTH]) {
        for i in 0..WIDTH {
            let (length, sealed) = &self.0[i];
            rates[i] = length * sealed.held([y[i]])[0];
        }
    }
}

/// Keeps only the state at the end of a step instead of a list of all.
struct Last<const WIDTH: usize>([f64; WIDTH]);

impl<const WIDTH: usize> Solout<f64, [f64; WIDTH]> for Last<WIDTH> {
    fn solout<I: Interpolation<f64, [f64; WIDTH]> + ?Sized>(
        &mut self,
        _: f64,
        _: f64,
        now: &[f64; WIDTH],
        _: &[f64; WIDTH],
        _: &mut I,
        _: &mut Solution<f64, [f64; WIDTH]>,
    ) -> ControlFlag<f64, [f64; WIDTH]> {
        self.0 = *now;
        ControlFlag::Continue
    }
}

fn end<const WIDTH: usize, F: ODE<f64, [f64; WIDTH]>>(tolerance: f64, ode: &F, start: &[f64; WIDTH]) -> [f64; WIDTH] {
    let mut method = ExplicitRungeKutta::dop853().rtol(tolerance).atol(tolerance * 1e-3);
    let mut last = Last(*start);
    solve_ode(&mut method, ode, 0.0, 1.0, start, &mut last).map_or([f64::NAN; WIDTH], |_| last.0)
}

/// Solver with `width` scenarios side by side.
pub fn solver(options: &Options) -> Solve {
    let tolerance = options.tolerance();
    let solve = match options.number("width", 1.0) as usize {
        1 => solve::<1>,
        8 => solve::<8>,
        16 => solve::<16>,
        32 => solve::<32>,
        width => panic!("width={width}: 1, 8, 16 or 32 was expected"),
    };
    Box::new(move |cases, answers| solve(tolerance, cases, answers))
}

/// All threads take pieces of the scenarios from the pool; within a piece those of similar stiffness are grouped.
fn solve<const WIDTH: usize>(tolerance: f64, cases: &[Case], answers: &mut [Answer]) {
    cases.par_chunks(PIECE).zip(answers.par_chunks_mut(PIECE)).for_each(|(cases, answers)| {
        let mut sealed: Vec<(usize, Sealed)> = cases.iter().map(<Sealed as Equations<1>>::new).enumerate().collect();
        sealed.sort_by(|a, b| a.1.stiffness().total_cmp(&b.1.stiffness()));
        for group in sealed.chunks(WIDTH) {
            let at = |lane: usize| group[lane.min(group.len() - 1)];
            let push: [_; WIDTH] = std::array::from_fn(|lane| (cases[at(lane).0].push_time_s, at(lane).1));
            let hold: [_; WIDTH] = std::array::from_fn(|lane| {
                let case = &cases[at(lane).0];
                (case.duration_s - case.push_time_s, at(lane).1)
            });
            let peaks = end(tolerance, &Pushed(&push), &[AMBIENT_TEMPERATURE_K; WIDTH]);
            let ends = end(tolerance, &Held(&hold), &peaks);
            for (lane, (row, sealed)) in group.iter().enumerate() {
                answers[*row] =
                    Answer { peak_pa: sealed.pressure([peaks[lane]]), final_pa: sealed.pressure([ends[lane]]) };
            }
        }
    });
}
