//! One step of the 8(5,3) pair in lanes, each lane with its own time, length and tolerance.

use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::tableau::{A, C, D, E3, E5};
use chamber::real::Real;

/// Ordinary differential equations of N states, independent systems side by side.
pub trait LaneSystem<const N: usize> {
    /// Whether the rates are so cheap that each stage deserves code of its own.
    const CHEAP: bool;

    /// dy/dt at time `t`, s.
    fn rates(&self, t: Lanes, y: &[Lanes; N]) -> [Lanes; N];

    /// Number of states, from the first on, that move in any lane: the others stay where they begin.
    #[inline(always)]
    fn moving(&self) -> usize {
        N
    }

    /// Share of a step of length `h` from `t` at which it meets a corner of the rates, by its states and their rates at
    /// both ends; 1 where there is none. Steps are made to end there: across a corner their error estimates are blind.
    #[inline(always)]
    fn corner(&self, _t: Lanes, _h: Lanes, _y: [&[Lanes; N]; 2], _rates: [&[Lanes; N]; 2]) -> Lanes {
        Lanes::ONE
    }
}

/// Least e5²/e3³ of a step whose e5 can be believed, e5 and e3 relative to the states: a twentieth of what
/// dy/dt = −y/L gives.
const CHANCE: f64 = 2.5e-4;

/// a b + c, rounded once where `FUSED`: only for machines with the instruction, else it would be a slow call.
#[inline(always)]
pub fn multiply_add<const FUSED: bool>(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    if FUSED { each_lane!(i => a.0[i].mul_add(b.0[i], c.0[i])) } else { a * b + c }
}

/// Σ weight_j slope_j over the listed stages j, the latest last.
macro_rules! weighted {
    ($fused:ident, $slopes:expr, $i:expr, $weights:expr; 0 $($j:tt)*) => {{
        let sum = $slopes[0][$i] * $weights[0];
        $(let sum = multiply_add::<$fused>($slopes[$j][$i], Lanes::from($weights[$j]), sum);)*
        sum
    }};
}

/// One stage of a step (system, time, length, states), from the listed earlier ones: the states it is taken at.
macro_rules! stage_of {
    ($fused:ident, ($system:ident, $t:ident, $h:ident, $y:ident), $slopes:ident, $s:literal; $($j:tt)*) => {{
        let mut at = *$y;
        for i in 0..N {
            at[i] = multiply_add::<$fused>(weighted!($fused, $slopes, i, A[$s]; $($j)*), $h, $y[i]);
        }
        $slopes[$s] = $system.rates(multiply_add::<$fused>($h, Lanes::from(C[$s]), $t), &at);
        at
    }};
}

/// What an attempted step has found.
pub struct Attempt<const N: usize> {
    /// States at its end.
    pub end: [Lanes; N],
    /// dy/dt of stages 0 to 11, and at the end (12).
    pub slopes: [[Lanes; N]; 13],
    /// Error over tolerance, squared: at most 1 where the step is good. NaN where the equations could not be evaluated.
    pub error_squared: Lanes,
}

/// Stages 1 to 12, each in code of its own without the weights that are zero; the states at the end.
#[inline(always)]
fn stages_unrolled<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    slopes: &mut [[Lanes; N]; 13],
) -> [Lanes; N] {
    let mut k = [[Lanes::ZERO; N]; 13];
    k[0] = slopes[0];
    macro_rules! stage {
        ($s:literal; $($j:tt)*) => { stage_of!(FUSED, (system, t, h, y), k, $s; $($j)*) };
    }
    stage!(1; 0);
    stage!(2; 0 1);
    stage!(3; 0 2);
    stage!(4; 0 2 3);
    stage!(5; 0 3 4);
    stage!(6; 0 3 4 5);
    stage!(7; 0 3 4 5 6);
    stage!(8; 0 3 4 5 6 7);
    stage!(9; 0 3 4 5 6 7 8);
    stage!(10; 0 3 4 5 6 7 8 9);
    stage!(11; 0 3 4 5 6 7 8 9 10);
    let end = stage!(12; 0 5 6 7 8 9 10 11);
    *slopes = k;
    end
}

/// Stage number `stage`: the states it is taken at.
#[inline(always)]
fn stage<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    k: &mut [[Lanes; N]],
    stage: usize,
) -> [Lanes; N] {
    let mut at = *y;
    for i in 0..system.moving() {
        let mut sum = k[0][i] * A[stage][0];
        for j in 1..stage {
            sum = multiply_add::<FUSED>(k[j][i], Lanes::from(A[stage][j]), sum);
        }
        at[i] = multiply_add::<FUSED>(sum, h, y[i]);
    }
    k[stage] = system.rates(multiply_add::<FUSED>(h, Lanes::from(C[stage]), t), &at);
    at
}

/// Tries a step of `h` from `y`, where dy/dt is `first`.
#[inline(always)]
pub fn attempt<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    first: &[Lanes; N],
    tolerance: (f64, &[Lanes; N]),
) -> Attempt<N> {
    let mut k = [[Lanes::ZERO; N]; 13];
    k[0] = *first;
    let end = if S::CHEAP {
        stages_unrolled::<N, FUSED, S>(system, t, h, y, &mut k)
    } else {
        let mut at = *y;
        for stage in 1..13 {
            at = self::stage::<N, FUSED, S>(system, t, h, y, &mut k, stage);
        }
        at
    };

    let (mut fifth, mut third) = (Lanes::ZERO, Lanes::ZERO);
    for i in 0..system.moving() {
        let scale = y[i].abs().max(end[i].abs()) * tolerance.0 + tolerance.1[i];
        let per_scale = h / scale;
        let e5 = weighted!(FUSED, k, i, E5; 0 5 6 7 8 9 10 11) * per_scale;
        let e3 = weighted!(FUSED, k, i, E3; 0 5 6 7 8 9 10 11) * per_scale;
        fifth = multiply_add::<FUSED>(e5, e5, fifth);
        third = multiply_add::<FUSED>(e3, e3, third);
    }
    // e5 grows as e3^1.5; where it is far below that, it is about to change sign and says nothing about the step.
    let usual = third * third.sqrt() * (tolerance.0 * CHANCE);
    let fifth = fifth.max(usual);
    // Hairer's combination e5 · e5/√(e5² + 0.01 e3²), in the mean over the states that move; squared, to save the root.
    let error_squared = fifth * fifth / ((third * 0.01 + fifth + 1e-200) * system.moving() as f64);
    Attempt { end, slopes: k, error_squared }
}

/// Stages of an accepted step that count inside it.
pub const DENSE: [usize; 9] = [0, 5, 6, 7, 8, 9, 10, 11, 12];

/// Terms of the states within an accepted step, to be evaluated by [`within`].
#[inline(always)]
pub fn dense<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    end: &[Lanes; N],
    slopes: &[[Lanes; N]; 13],
) -> [[Lanes; N]; 8] {
    let mut k = [[Lanes::ZERO; N]; 16];
    k[..13].copy_from_slice(slopes);
    if S::CHEAP {
        stage_of!(FUSED, (system, t, h, y), k, 13; 0 6 7 8 9 10 11 12);
        stage_of!(FUSED, (system, t, h, y), k, 14; 0 5 6 7 10 11 12 13);
        stage_of!(FUSED, (system, t, h, y), k, 15; 0 5 6 7 8 12 13 14);
    } else {
        for stage in 13..16 {
            self::stage::<N, FUSED, S>(system, t, h, y, &mut k, stage);
        }
    }
    let mut terms = [[Lanes::ZERO; N]; 8];
    terms[0] = *y;
    for i in 0..system.moving() {
        let change = end[i] - y[i];
        let begin = h * k[0][i] - change;
        terms[1][i] = change;
        terms[2][i] = begin;
        terms[3][i] = change - h * k[12][i] - begin;
        for (row, weights) in D.iter().enumerate() {
            terms[4 + row][i] = weighted!(FUSED, k, i, weights; 0 5 6 7 8 9 10 11 12 13 14 15) * h;
        }
    }
    terms
}

/// A state within a step, at the share `x` of its length.
#[inline(always)]
pub fn within<R: Real>(terms: &[R; 8], x: R) -> R {
    let y = R::ONE - x;
    let [t0, t1, t2, t3, t4, t5, t6, t7] = *terms;
    t0 + x * (t1 + y * (t2 + x * (t3 + y * (t4 + x * (t5 + y * (t6 + x * t7))))))
}
