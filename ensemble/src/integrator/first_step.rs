//! The first step h of each problem, at which the error, which grows with the eighth power, should equal the tolerance,
//!
//! h = F L (tolerance |y|/(ε |dy/dt| L))^(1/8),  L = |dy/dt|/|d²y/dt²|
//!
//! and at most L, from the rates at the start and a short time ahead. L is the time scale of the solution, ε the error estimate of a step
//! of that length, F a safety factor.

use crate::integrator::step::{LaneSystem, Moment, PROBE, TINY, probe, size};
use crate::lanes::Lanes;
use crate::lanes::math::inverse_eighth_root;
use chamber::real::Real;
use core::hint::black_box;

/// F: the time scale is only an estimate.
const FIRST: f64 = 0.6;
/// ε, relative to the distance |dy/dt| L: the pair's error estimate for dy/dt = −y/L at h = L, where it still grows with the eighth
/// power.
const ERROR_AT_SCALE: f64 = 6.6e-7;

/// Initial rates of a system in states `y`, and its first step over a span of `length`, s.
#[inline(always)]
pub fn begin<const N: usize, S: LaneSystem<N>>(
    system: &S,
    length: Lanes,
    y: &[Lanes; N],
    absolute: &[Lanes; N],
    relative: f64,
) -> (Moment<N>, Lanes) {
    let (mut begin, mut there, mut time, mut ahead) = (Moment::NONE, [Lanes::ZERO; N], Lanes::ZERO, *y);
    // At the start and a short time ahead, with one copy of the rates' code.
    for evaluation in 0..black_box(2) {
        let moment = system.rates(time, &ahead);
        if evaluation > 0 {
            there = moment.slope;
            break;
        }
        time = probe(length, y, absolute, &moment.slope, relative);
        for i in 0..N {
            ahead[i] += moment.slope[i] * time;
        }
        begin = moment;
    }
    (begin, first_step(length, y, absolute, [&begin.slope, &there], time, relative))
}

/// Length of the first step from `y`, s, from the rates there and a time `probe` ahead.
#[inline(always)]
pub fn first_step<const N: usize>(
    length: Lanes,
    y: &[Lanes; N],
    absolute: &[Lanes; N],
    [slope, there]: [&[Lanes; N]; 2],
    probe: Lanes,
    relative: f64,
) -> Lanes {
    // A state that starts from rest has no time scale yet and takes that of the others.
    let mut common = length;
    for i in 0..N {
        let (rate, bend) = (slope[i].abs(), (there[i] - slope[i]).abs());
        common = (rate - bend).where_positive(common.min(rate * probe / (bend + TINY)), common);
    }
    let mut first = length;
    for i in 0..N {
        let (rate, bend) = (slope[i].abs(), (there[i] - slope[i]).abs());
        let moves = rate - bend;
        let scale = moves.where_positive(rate * probe / (bend + TINY), common);
        let rate = moves.where_positive(rate, bend * scale / probe);
        let size = size(y[i], absolute[i], relative) * (relative / ERROR_AT_SCALE);
        let share = inverse_eighth_root(rate * scale / size + 1e-30);
        first = first.min(scale * (share * FIRST).min(Lanes::ONE));
    }
    // Any positive step if the rates vanish or are NaN: its own error decides.
    first.where_positive(first, length * PROBE)
}
