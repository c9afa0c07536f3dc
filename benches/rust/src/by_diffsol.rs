//! diffsol with its explicit Tsitouras pair, on systems of several scenarios side by side with common steps: a single one would
//! spend its time on overhead for vectors of one number.

use crate::Solve;
use crate::equations::{Equations, Flows, GasColumn, NaturalConvection, Sealed, WallHeating};
use crate::options::Options;
use crate::scenario::{Answer, Case};
use diffsol::{
    FaerMat, FaerVec, NonLinearOp, OdeBuilder, OdeEquations, OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason,
    Vector,
};
use rayon::prelude::*;
use std::cell::RefCell;

/// Scenarios per thread and piece.
const PIECE: usize = 1 << 13;

/// The scenarios of a system, and whether their pistons are held; time runs from 0 to 1 through push and hold.
struct Now<E> {
    equations: Vec<E>,
    lengths: Vec<f64>,
    held: bool,
}

/// Solver with `width` scenarios side by side, and `equations` by the name of their study.
pub fn solver(options: &Options) -> Solve {
    let (tolerance, width) = (options.tolerance(), options.number("width", 1.0) as usize);
    let solve = match options.word("equations").unwrap_or("sealed") {
        "sealed" => solve::<1, Sealed>,
        "flows" => solve::<2, Flows>,
        "natural_convection" => solve::<1, NaturalConvection>,
        "wall_heating" => solve::<2, WallHeating>,
        "gas_column" => solve::<1, GasColumn>,
        other => panic!("equations={other}: the name of a study was expected"),
    };
    Box::new(move |cases, answers| solve(tolerance, width, cases, answers))
}

/// All threads take pieces of the scenarios from the pool; within a piece those of similar stiffness are grouped. State `k` of
/// scenario `i` is number `k width + i` of the system.
fn solve<const N: usize, E: Equations<N>>(tolerance: f64, width: usize, cases: &[Case], answers: &mut [Answer]) {
    cases.par_chunks(PIECE).zip(answers.par_chunks_mut(PIECE)).for_each(|(cases, answers)| {
        let mut rows: Vec<(usize, E)> = cases.iter().map(E::new).enumerate().collect();
        rows.sort_by(|a, b| a.1.stiffness().total_cmp(&b.1.stiffness()));
        let now = RefCell::new(Now { equations: vec![rows[0].1; width], lengths: vec![0.0; width], held: false });
        let problem = OdeBuilder::<FaerMat<f64>>::new()
            .rtol(tolerance)
            .atol([tolerance * 1e-3])
            .rhs(|y, _p, t, rates| {
                let now = now.borrow();
                for (i, (equations, length)) in now.equations.iter().zip(&now.lengths).enumerate() {
                    let states = std::array::from_fn(|k| y[k * width + i]);
                    let found = if now.held { equations.held(states) } else { equations.pushed(t * length, states) };
                    found.iter().enumerate().for_each(|(k, rate)| rates[k * width + i] = length * rate);
                }
            })
            .init(|_p, _t, y| (0..N * width).for_each(|i| y[i] = E::START[i / width]), N * width)
            .build()
            .expect("the problem");
        let mut solver = problem.tsit45().expect("the solver");
        let start: Vec<f64> = (0..N * width).map(|i| E::START[i / width]).collect();
        for group in rows.chunks(width) {
            let at = |lane: usize| group[lane.min(group.len() - 1)];
            now.replace(Now {
                equations: (0..width).map(|lane| at(lane).1).collect(),
                lengths: (0..width).map(|lane| cases[at(lane).0].push_time_s).collect(),
                held: false,
            });
            let peaks = end(&mut solver, &problem, tolerance, &start);
            {
                let mut now = now.borrow_mut();
                now.held = true;
                for (lane, length) in now.lengths.iter_mut().enumerate() {
                    let case = &cases[at(lane).0];
                    *length = case.duration_s - case.push_time_s;
                }
            }
            let ends = end(&mut solver, &problem, tolerance, &peaks);
            for (lane, (row, equations)) in group.iter().enumerate() {
                let pressure = |y: &[f64]| equations.pressure(std::array::from_fn(|k| y[k * width + lane]));
                answers[*row] = Answer { peak_pa: pressure(&peaks), final_pa: pressure(&ends) };
            }
        }
    });
}

/// Integrates from some states to time 1. The first step is one that a fifth-order pair accepts: the states change by about the
/// fifth root of the tolerance.
fn end<'a, E>(
    solver: &mut impl OdeSolverMethod<'a, E>,
    problem: &OdeSolverProblem<E>,
    tolerance: f64,
    states: &[f64],
) -> Vec<f64>
where
    E: OdeEquations<T = f64, V = FaerVec<f64>, M = FaerMat<f64>> + 'a,
{
    let mut y = solver.state().y.clone();
    states.iter().enumerate().for_each(|(i, state)| y[i] = *state);
    let rates = problem.eqn.rhs().call(&y, 0.0);
    let relative = (0..states.len()).map(|i| (rates[i] / y[i]).abs()).fold(1e-9, f64::max);
    let state = solver.state_mut();
    (*state.t, *state.h) = (0.0, (0.5 * tolerance.powf(0.2) / relative).min(1.0));
    state.y.copy_from(&y);
    state.dy.copy_from(&rates);
    let failed = vec![f64::NAN; states.len()];
    if solver.set_stop_time(1.0).is_err() {
        return failed;
    }
    loop {
        match solver.step() {
            Ok(OdeSolverStopReason::TstopReached) => {
                let state = solver.state();
                return (0..states.len()).map(|i| state.y[i]).collect();
            }
            Ok(_) => {}
            Err(_) => return failed,
        }
    }
}
