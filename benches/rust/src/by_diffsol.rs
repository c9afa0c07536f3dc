//! diffsol, its explicit pair of Tsitouras, on systems of several scenarios side by side with common steps: one alone
//! would spend its time on the book-keeping of vectors of one number.

use crate::Solve;
use crate::options::Options;
use crate::scenario::{AMBIENT_TEMPERATURE_K, Answer, Case};
use crate::sealed::Sealed;
use diffsol::{
    FaerMat, FaerVec, NonLinearOp, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason,
    Vector,
};
use rayon::prelude::*;
use std::cell::RefCell;

/// Scenarios that a thread takes at a time.
const PIECE: usize = 1 << 13;

/// The scenarios of a system, and whether their pistons rest; time runs from 0 to 1 through push and hold.
struct Now {
    sealed: Vec<Sealed>,
    lengths: Vec<f64>,
    held: bool,
}

/// With `width` scenarios side by side.
pub fn solver(options: &Options) -> Solve {
    let (tolerance, width) = (options.tolerance(), options.number("width", 1.0) as usize);
    Box::new(move |cases, answers| solve(tolerance, width, cases, answers))
}

/// All threads take pieces of the scenarios from the pool; in a piece those alike in stiffness go together.
fn solve(tolerance: f64, width: usize, cases: &[Case], answers: &mut [Answer]) {
    cases.par_chunks(PIECE).zip(answers.par_chunks_mut(PIECE)).for_each(|(cases, answers)| {
        let mut sealed: Vec<(usize, Sealed)> = cases.iter().map(Sealed::new).enumerate().collect();
        sealed.sort_by(|a, b| a.1.held_exchange.total_cmp(&b.1.held_exchange));
        let now = RefCell::new(Now { sealed: vec![Sealed::default(); width], lengths: vec![0.0; width], held: false });
        let problem = OdeBuilder::<FaerMat<f64>>::new()
            .rtol(tolerance)
            .atol([tolerance * 1e-3])
            .rhs(|y, _p, t, rates| {
                let now = now.borrow();
                for (i, (s, length)) in now.sealed.iter().zip(&now.lengths).enumerate() {
                    rates[i] = length * if now.held { s.held(y[i]) } else { s.pushed(t * length, y[i]) };
                }
            })
            .init(|_p, _t, y| (0..width).for_each(|i| y[i] = AMBIENT_TEMPERATURE_K), width)
            .build()
            .expect("the problem");
        let mut solver = problem.tsit45().expect("the solver");
        for group in sealed.chunks(width) {
            let at = |lane: usize| group[lane.min(group.len() - 1)];
            {
                let mut now = now.borrow_mut();
                now.held = false;
                for lane in 0..width {
                    now.sealed[lane] = at(lane).1;
                    now.lengths[lane] = cases[at(lane).0].push_time_s;
                }
            }
            let start = vec![AMBIENT_TEMPERATURE_K; width];
            let peaks = end(&mut solver, &problem, tolerance, &start);
            {
                let mut now = now.borrow_mut();
                now.held = true;
                for lane in 0..width {
                    let case = &cases[at(lane).0];
                    now.lengths[lane] = case.duration_s - case.push_time_s;
                }
            }
            let ends = end(&mut solver, &problem, tolerance, &peaks);
            for (lane, (row, sealed)) in group.iter().enumerate() {
                answers[*row] = Answer { peak_pa: sealed.pressure(peaks[lane]), final_pa: sealed.pressure(ends[lane]) };
            }
        }
    });
}

/// Goes on from some temperatures to time 1. The first step is one that a fifth-order pair accepts: the temperatures
/// change by the fifth root of the tolerance or so.
fn end<'a, E>(
    solver: &mut impl OdeSolverMethod<'a, E>,
    problem: &OdeSolverProblem<E>,
    tolerance: f64,
    temperatures: &[f64],
) -> Vec<f64>
where
    E: OdeEquations<T = f64, V = FaerVec<f64>, M = FaerMat<f64>> + 'a,
{
    let mut y = solver.state().y.clone();
    temperatures.iter().enumerate().for_each(|(i, temperature)| y[i] = *temperature);
    let rates = problem.eqn.rhs().call(&y, 0.0);
    let relative = (0..temperatures.len()).map(|i| (rates[i] / y[i]).abs()).fold(1e-9, f64::max);
    let state = solver.state_mut();
    (*state.t, *state.h) = (0.0, (0.5 * tolerance.powf(0.2) / relative).min(1.0));
    state.y.copy_from(&y);
    state.dy.copy_from(&rates);
    let failed = vec![f64::NAN; temperatures.len()];
    if solver.set_stop_time(1.0).is_err() {
        return failed;
    }
    loop {
        match solver.step() {
            Ok(OdeSolverStopReason::TstopReached) => {
                let state = solver.state();
                return (0..temperatures.len()).map(|i| state.y[i]).collect();
            }
            Ok(_) => {}
            Err(_) => return failed,
        }
    }
}
