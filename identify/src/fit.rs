//! All traces of a rig at once: weighted least squares by Levenberg–Marquardt with bounds.
//!
//! Minimises Σ ((block mean − model)/σ)², what the blocks of a hold have in common taken out ([`crate::whiten`]). The
//! normal equations are bordered: each trace's own numbers (initial pressure, initial temperature) appear in its rows
//! only and are eliminated trace by trace (Schur complement), so that the system solved has the size of the globals.
//! Sensitivities are exact (dual numbers). Traces are simulated in parallel and summed in order: the same data gives the
//! same bits on any number of threads.

use crate::forward::Run;
use crate::hypothesis::{self, Hypothesis};
use crate::prepare::{Block, Data, Prepared};
use crate::whiten::whiten;
use chamber::Chamber;
use chamber::dual::Dual;
use chamber::effects::EffectSet;
use chamber::integrate::IntegrationError;
use chamber::real::Real;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Integration error relative to the states: a hundredth of a typical sensor's noise.
pub const RELATIVE_TOLERANCE: f64 = 3e-8;
/// A step that promises less than this much of χ² ends the fit.
const SETTLED: f64 = 2e-3;
const MOST_ITERATIONS: usize = 40;

/// Which blocks take part: the number of leading blocks of each trace.
pub type Selection = [usize];

/// Residuals and sensitivities of one trace's blocks, whitened: each of standard deviation one, independent of the others.
#[derive(Clone, Debug)]
pub struct Linear {
    /// (mean − model)/σ.
    pub residual: Vec<f64>,
    /// d(model/σ)/d(global coordinate), a row for each block.
    pub by_global: DMatrix<f64>,
    /// d(model/σ)/d(local coordinate).
    pub by_local: DMatrix<f64>,
}

/// A fitted hypothesis.
#[derive(Clone, Debug)]
pub struct Fit {
    /// What was fitted.
    pub hypothesis: Hypothesis,
    /// Global coordinates.
    pub globals: Vec<f64>,
    /// Local coordinates of each trace.
    pub locals: Vec<Vec<f64>>,
    /// Σ of squares of the block residuals.
    pub chi2: f64,
    /// Blocks that took part.
    pub blocks: usize,
    /// The linearised problem at the solution, trace by trace.
    pub linear: Vec<Linear>,
    /// Normal matrix of the globals with the locals eliminated.
    pub information: DMatrix<f64>,
    /// Globals that ended at a bound.
    pub at_bound: Vec<bool>,
    /// Iterations used.
    pub iterations: usize,
}

impl Fit {
    /// The fitted chamber.
    pub fn chamber(&self) -> Chamber {
        self.hypothesis.chamber(&self.globals)
    }
}

/// Fits a hypothesis to the selected blocks, beginning from coordinates.
///
/// # Errors
/// The trace whose simulation failed at the very begin, and why.
pub fn fit(
    data: &Data,
    hypothesis: &Hypothesis,
    globals: Vec<f64>,
    locals: Vec<Vec<f64>>,
    selection: &Selection,
) -> Result<Fit, (usize, IntegrationError)> {
    fit_with(data, hypothesis, globals, locals, selection, MOST_ITERATIONS)
}

/// [`fit`] with a limit of iterations.
///
/// # Errors
/// As [`fit`].
pub fn fit_with(
    data: &Data,
    hypothesis: &Hypothesis,
    mut globals: Vec<f64>,
    mut locals: Vec<Vec<f64>>,
    selection: &Selection,
    most_iterations: usize,
) -> Result<Fit, (usize, IntegrationError)> {
    let mut linear = linearise(data, hypothesis, &globals, &locals, selection)?;
    let mut chi2 = total(&linear);
    let mut damping = 1e-4;
    let mut iterations = 0;
    let mut system = System::new(&linear, hypothesis.axes.len());
    'outer: while iterations < most_iterations {
        iterations += 1;
        for _ in 0..12 {
            let Some((step, local_steps, promised)) = system.step(hypothesis, &globals, damping) else {
                damping = (damping * 10.0).max(1e-6);
                continue;
            };
            if promised < SETTLED {
                break 'outer;
            }
            let bounds = hypothesis.axes.iter().map(|axis| axis.bounds);
            let trial = moved(&globals, &step, bounds);
            let local_steps = locals.iter().zip(&local_steps);
            let trial_locals =
                local_steps.map(|(x, step)| moved(x, step, std::iter::repeat([0.2, 5.0]))).collect::<Vec<_>>();
            if let Ok(next) = linearise(data, hypothesis, &trial, &trial_locals, selection) {
                let next_chi2 = total(&next);
                if next_chi2 < chi2 {
                    let gained = chi2 - next_chi2;
                    (globals, locals, linear, chi2) = (trial, trial_locals, next, next_chi2);
                    system = System::new(&linear, hypothesis.axes.len());
                    damping = if gained > 0.7 * promised { damping * 0.1 } else { damping }.max(1e-9);
                    if gained < SETTLED {
                        break 'outer;
                    }
                    continue 'outer;
                }
            }
            damping = (damping * 10.0).max(1e-3);
            if damping > 1e8 {
                break 'outer;
            }
        }
        break;
    }
    let at_bound = globals
        .iter()
        .zip(&hypothesis.axes)
        .map(|(x, a)| *x <= a.bounds[0] + 1e-9 || *x >= a.bounds[1] - 1e-9)
        .collect();
    Ok(Fit {
        hypothesis: hypothesis.clone(),
        chi2,
        blocks: linear.iter().map(|l| l.residual.len()).sum(),
        information: system.reduced(0.0).map_or_else(|| DMatrix::zeros(0, 0), |(m, _)| m),
        globals,
        locals,
        linear,
        at_bound,
        iterations,
    })
}

/// Coordinates after a step, within their bounds.
fn moved(x: &[f64], step: &[f64], bounds: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
    x.iter().zip(step).zip(bounds).map(|((x, step), [low, high])| (x + step).clamp(low, high)).collect()
}

/// Residuals and sensitivities of all selected blocks, or the trace whose simulation failed and why.
fn linearise(
    data: &Data,
    hypothesis: &Hypothesis,
    globals: &[f64],
    locals: &[Vec<f64>],
    selection: &Selection,
) -> Result<Vec<Linear>, (usize, IntegrationError)> {
    (0..data.traces.len())
        .into_par_iter()
        .map(|k| trace(&data.traces[k], hypothesis, globals, &locals[k], selection[k]).map_err(|e| (k, e)))
        .collect()
}

/// One trace; the dual numbers are no longer than they need be.
fn trace(
    t: &Prepared,
    h: &Hypothesis,
    globals: &[f64],
    local: &[f64],
    blocks: usize,
) -> Result<Linear, IntegrationError> {
    match globals.len() + local.len() {
        ..=3 => trace_dual::<3>(t, h, globals, local, blocks),
        4 => trace_dual::<4>(t, h, globals, local, blocks),
        5..=6 => trace_dual::<6>(t, h, globals, local, blocks),
        7..=8 => trace_dual::<8>(t, h, globals, local, blocks),
        _ => trace_dual::<12>(t, h, globals, local, blocks),
    }
}

fn trace_dual<const N: usize>(
    t: &Prepared,
    h: &Hypothesis,
    globals: &[f64],
    local: &[f64],
    count: usize,
) -> Result<Linear, IntegrationError> {
    let (g, l) = (globals.len(), local.len());
    assert!(g + l <= N, "{} free numbers are more than the {N} a fit can have", g + l);
    let blocks = &t.blocks[..count];
    let x: Vec<Dual<N>> = globals.iter().enumerate().map(|(i, v)| Dual::variable(*v, i)).collect();
    let own: Vec<Dual<N>> = local.iter().enumerate().map(|(i, v)| Dual::variable(*v, g + i)).collect();
    let chamber = h.chamber(&x);
    let shown = run(t, &chamber, h.effects, &own).pressures(&points(blocks))?;
    // Columns: residual, globals, locals.
    let mut columns = DMatrix::zeros(count, 1 + g + l);
    let mut shown = shown.into_iter();
    for (row, block) in blocks.iter().enumerate() {
        let model = mean(block, &mut shown);
        columns[(row, 0)] = block.mean_pa - model.value;
        for i in 0..g + l {
            columns[(row, 1 + i)] = model.tangent[i];
        }
    }
    whiten(blocks, &mut columns);
    let out = Linear {
        residual: columns.column(0).iter().copied().collect(),
        by_global: columns.columns(1, g).into_owned(),
        by_local: columns.columns(1 + g, l).into_owned(),
    };
    if out.residual.iter().all(|r| r.is_finite()) { Ok(out) } else { Err(IntegrationError::StepTooSmall { at: 0.0 }) }
}

/// The model along a trace that begins at its local coordinates.
pub fn run<'a, R: Real>(t: &'a Prepared, chamber: &'a Chamber<R>, set: EffectSet, local: &[R]) -> Run<'a, R> {
    let start = hypothesis::start(t, local);
    Run { chamber, set, start, course: &t.course, relative_tolerance: RELATIVE_TOLERANCE }
}

/// Times at which the blocks' means need the model.
pub fn points(blocks: &[Block]) -> Vec<f64> {
    let mut times = Vec::with_capacity(2 * blocks.len());
    for b in blocks {
        times.push(b.points_s[0]);
        if b.rows() > 1 {
            times.push(b.points_s[1]);
        }
    }
    times
}

/// The model's mean over a block, from its values at [`points`].
pub fn mean<R: Real>(block: &Block, shown: &mut impl Iterator<Item = R>) -> R {
    let first = shown.next().unwrap_or(R::ZERO);
    if block.rows() > 1 { (first + shown.next().unwrap_or(R::ZERO)) * 0.5 } else { first }
}

fn total(linear: &[Linear]) -> f64 {
    linear.iter().flat_map(|l| &l.residual).map(|r| r * r).sum()
}

/// The bordered normal equations.
struct System {
    globals: usize,
    whole: DMatrix<f64>,
    right: DVector<f64>,
    parts: Vec<Part>,
}

/// One trace's share.
struct Part {
    coupling: DMatrix<f64>,
    own: DMatrix<f64>,
    right: DVector<f64>,
}

impl System {
    fn new(linear: &[Linear], globals: usize) -> Self {
        let mut whole = DMatrix::zeros(globals, globals);
        let mut right = DVector::zeros(globals);
        let mut parts = Vec::with_capacity(linear.len());
        for l in linear {
            let r = DVector::from_column_slice(&l.residual);
            whole += l.by_global.tr_mul(&l.by_global);
            right += l.by_global.tr_mul(&r);
            parts.push(Part {
                coupling: l.by_global.tr_mul(&l.by_local),
                own: l.by_local.tr_mul(&l.by_local),
                right: l.by_local.tr_mul(&r),
            });
        }
        Self { globals, whole, right, parts }
    }

    /// Normal matrix and right side of the globals, locals eliminated.
    fn reduced(&self, damping: f64) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let (mut matrix, mut right) = (self.whole.clone(), self.right.clone());
        for part in &self.parts {
            if part.own.iter().all(|v| *v == 0.0) {
                continue;
            }
            let inverse = damped(&part.own, damping).cholesky()?;
            let solved = inverse.solve(&part.coupling.transpose());
            matrix -= &part.coupling * &solved;
            right -= &part.coupling * inverse.solve(&part.right);
        }
        Some((matrix, right))
    }

    /// A step in all coordinates and the decrease of χ² it promises; coordinates at a bound that they push against rest.
    fn step(&self, h: &Hypothesis, x: &[f64], damping: f64) -> Option<(Vec<f64>, Vec<Vec<f64>>, f64)> {
        let (matrix, right) = self.reduced(damping)?;
        let mut free: Vec<usize> = (0..self.globals).filter(|&i| self.whole[(i, i)] > 0.0).collect();
        let mut step = vec![0.0; self.globals];
        loop {
            let n = free.len();
            if n == 0 {
                break;
            }
            let sub = DMatrix::from_fn(n, n, |i, j| matrix[(free[i], free[j])]);
            let rhs = DVector::from_fn(n, |i, _| right[free[i]]);
            let mut damped_sub = sub;
            for (i, &f) in free.iter().enumerate() {
                damped_sub[(i, i)] += damping * self.whole[(f, f)] + 1e-14 * self.whole[(f, f)];
            }
            let solution = damped_sub.cholesky()?.solve(&rhs);
            let pushed: Vec<usize> = free
                .iter()
                .enumerate()
                .filter(|&(k, &i)| {
                    let b = h.axes[i].bounds;
                    (x[i] <= b[0] && solution[k] < 0.0) || (x[i] >= b[1] && solution[k] > 0.0)
                })
                .map(|(_, &i)| i)
                .collect();
            if pushed.is_empty() {
                for (k, &i) in free.iter().enumerate() {
                    let b = h.axes[i].bounds;
                    // A logarithm may change by at most a factor of e² at a time.
                    let most = if h.axes[i].logarithmic { 2.0 } else { f64::INFINITY };
                    step[i] = solution[k].clamp(-most, most).clamp(b[0] - x[i], b[1] - x[i]);
                }
                break;
            }
            free.retain(|i| !pushed.contains(i));
        }
        let globals = DVector::from_column_slice(&step);
        let mut promised = 2.0 * self.right.dot(&globals) - globals.dot(&(&self.whole * &globals));
        let mut locals = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            if part.own.iter().all(|v| *v == 0.0) {
                locals.push(vec![0.0; part.right.len()]);
                continue;
            }
            let rhs = &part.right - part.coupling.tr_mul(&globals);
            let own = damped(&part.own, damping).cholesky()?.solve(&rhs);
            promised += 2.0 * own.dot(&rhs) - own.dot(&(&part.own * &own));
            locals.push(own.as_slice().to_vec());
        }
        Some((step, locals, promised))
    }
}

fn damped(matrix: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut m = matrix.clone();
    for i in 0..m.nrows() {
        m[(i, i)] *= 1.0 + damping + 1e-14;
    }
    m
}

/// First coordinates of every trace's locals.
pub fn first_locals(data: &Data) -> Vec<Vec<f64>> {
    data.traces.iter().map(|t| vec![1.0; hypothesis::locals(t)]).collect()
}

/// Every block of every trace.
pub fn all_blocks(data: &Data) -> Vec<usize> {
    data.traces.iter().map(|t| t.blocks.len()).collect()
}

/// The model's reading at every row of a trace, Pa, for plain numbers.
///
/// # Errors
/// Where the state leaves what the equations can follow.
pub fn readings(t: &Prepared, chamber: &Chamber, local: &[f64]) -> Result<Vec<f64>, IntegrationError> {
    run(t, chamber, chamber.active(), local).pressures(&t.time_s)
}
