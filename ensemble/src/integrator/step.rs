//! One step of the 8(5,3) pair in lanes; each lane has its own time, length and tolerance.

use crate::integrator::expansion::Expansion;
use crate::integrator::tableau::{A, C, E3, E5, STAGES};
use crate::lanes::{Lanes, multiply_add};
use chamber::real::Real;
use core::hint::black_box;
use core::ops::Range;

/// The observable quantities of a system at one time: pressure, Pa, temperature, K, and their rates in integrator time.
#[derive(Clone, Copy, Debug)]
pub struct View<R> {
    /// Pressure, Pa, and temperature, K.
    pub value: [R; 2],
    /// Rates of pressure and temperature in integrator time.
    pub slope: [R; 2],
}

impl<R: Real> View<R> {
    /// All zero.
    pub const NONE: Self = Self { value: [R::ZERO; 2], slope: [R::ZERO; 2] };

    /// Net inflow relative to the gas in the chamber, M = P V/(R T), for a constant volume, in integrator time.
    #[inline(always)]
    pub fn inflow(&self) -> R {
        self.slope[0] / self.value[0] - self.slope[1] / self.value[1]
    }

    /// Relative rate of the pressure in integrator time.
    #[inline(always)]
    pub fn pressure_rate(&self) -> R {
        self.slope[0] / self.value[0]
    }
}

impl View<Lanes> {
    /// Pressure, Pa, and its slope.
    #[inline(always)]
    pub fn pressure(&self) -> [Lanes; 2] {
        [self.value[0], self.slope[0]]
    }
}

/// Extrapolates a quantity and its slope by a time `ahead` from `at`, on the cubic that connects `before`, a time `since` ago, with `at`.
#[inline(always)]
pub fn extrapolated(ahead: Lanes, at: [Lanes; 2], before: [Lanes; 2], [since, per_since]: [Lanes; 2]) -> [Lanes; 2] {
    let x = ahead * per_since;
    let (way, from, to) = (at[0] - before[0], before[1] * since, at[1] * since);
    let (bend, twist) = (to * 2.0 + from - way * 3.0, from + to - way * 2.0);
    [at[0] + ((twist * x + bend) * x + to) * x, ((twist * x * 3.0 + bend * 2.0) * x + to) * per_since]
}

/// A system at one time.
#[derive(Clone, Copy, Debug)]
pub struct Moment<const N: usize> {
    /// dy/dt, in integrator time.
    pub slope: [Lanes; N],
    /// Pressure and temperature there.
    pub view: View<Lanes>,
    /// Power received as heat and enthalpy, and power delivered to the piston. No state is linear in the energy, so that the integrals of
    /// these over a step are independent of the step's own error.
    pub power: [Lanes; 2],
}

impl<const N: usize> Moment<N> {
    /// All zero.
    pub const NONE: Self = Self { slope: [Lanes::ZERO; N], view: View::NONE, power: [Lanes::ZERO; 2] };
}

/// Systems of ordinary differential equations with N states, one per lane.
pub trait LaneSystem<const N: usize>: Clone {
    /// The data of one system.
    type Row;
    /// Whether the rates are cheap enough for a copy of their code in each stage.
    const CHEAP: bool = true;
    /// Whether it is also compiled for machines without wide instructions.
    const ANYWHERE: bool = false;
    /// Whether steps are taken by [`LaneSystem::expansion`] instead of the pair.
    const BY_SERIES: bool = false;

    /// Loads the constants of a row into a lane.
    fn load(&mut self, lane: usize, row: &Self::Row);

    /// The system at time `t`, s.
    fn rates(&self, t: Lanes, y: &[Lanes; N]) -> Moment<N>;

    /// The Taylor series of the states from `y` on.
    #[inline(always)]
    fn expansion(&self, _: &[Lanes; N]) -> Expansion<N> {
        unreachable!("a system whose steps are taken by the pair")
    }

    /// Recomputes states that are functions of others, at the end of a step, to remove their accumulated error.
    #[inline(always)]
    fn restore(&self, _: &mut [Lanes; N]) {}

    /// Number of states, the first ones, that change in any lane; the others are constant.
    #[inline(always)]
    fn moving(&self) -> usize {
        N
    }

    /// Number of states in the error norm, by lane: those that a row has.
    #[inline(always)]
    fn counted(&self) -> Lanes {
        Lanes::from(N as f64)
    }

    /// Whether the rates can have kinks.
    #[inline(always)]
    fn has_kinks(&self) -> bool {
        false
    }

    /// w'/w of w = V^(1/4) at a transformed time.
    #[inline(always)]
    fn widening(&self, _: Lanes) -> Lanes {
        Lanes::ZERO
    }

    /// The first pressure between `from` and `to`, Pa, at which the rates have a kink; `to` if there is none. Steps end there, as error
    /// estimates do not see a kink inside a step.
    #[inline(always)]
    fn kink(&self, _from: Lanes, to: Lanes) -> Lanes {
        to
    }
}

/// Smallest plausible e5²/e3³ of a step, with e5 and e3 relative to the states: a twentieth of the value for dy/dt = −y/L.
const CHANCE: f64 = 2.5e-4;

/// Size of the probing step for the first step, relative to the states and to the span.
pub const PROBE: f64 = 0.01;
/// Added to divisors (choosing between quotients would become branches).
pub const TINY: f64 = 1e-300;

/// Σ weight_j slope_j over the listed stages j, in ascending order.
macro_rules! weighted {
    ($fused:ident, $slopes:expr, $i:expr, $weights:expr; 0 $($j:tt)*) => {{
        let sum = $slopes[0][$i] * $weights[0];
        $(let sum = multiply_add::<$fused>($slopes[$j][$i], Lanes::from($weights[$j]), sum);)*
        sum
    }};
}

/// One stage of a step (system, time, length, states), from the listed earlier ones. Returns the states at the stage, and its rates.
macro_rules! stage_of {
    ($fused:ident, ($system:ident, $t:ident, $h:ident, $y:ident), ($slopes:ident, $powers:ident), $s:literal; $($j:tt)*) => {{
        let mut at = *$y;
        for i in 0..N {
            at[i] = multiply_add::<$fused>(weighted!($fused, $slopes, i, A[$s]; $($j)*), $h, $y[i]);
        }
        if $s == STAGES - 1 {
            $system.restore(&mut at);
        }
        let moment = $system.rates(multiply_add::<$fused>($h, Lanes::from(C[$s]), $t), &at);
        ($slopes[$s], $powers[$s]) = (moment.slope, moment.power);
        (at, moment)
    }};
}

/// Applies a macro to the stages from 1 on, each with the stages after the first that have nonzero weights in it; the last is the end
/// of the step.
macro_rules! each_stage {
    ($apply:ident) => {
        $apply! {
            1: ; 2: 1; 3: 2; 4: 2 3; 5: 3 4; 6: 3 4 5; 7: 3 4 5 6; 8: 3 4 5 6 7; 9: 3 4 5 6 7 8; 10: 3 4 5 6 7 8 9;
            11: 3 4 5 6 7 8 9 10;
            => 12: 5 6 7 8 9 10 11
        }
    };
}

/// The result of an attempted step.
pub struct Attempt<const N: usize> {
    /// States at its end.
    pub end: [Lanes; N],
    /// Rates and view at the end of the step.
    pub moment: Moment<N>,
    /// Energy received as heat and enthalpy, and work, over the step: integrals of [`Moment::power`].
    pub energy: [Lanes; 2],
    /// Squared ratio of error to tolerance: at most 1 if the step is good. NaN if the equations could not be evaluated.
    pub error_squared: Lanes,
}

/// Slopes and powers at the stages of a step.
#[derive(Clone, Copy)]
pub struct Stages<const N: usize> {
    /// dy/dt, by stage.
    pub slopes: [[Lanes; N]; STAGES],
    powers: [[Lanes; 2]; STAGES],
}

impl<const N: usize> Stages<N> {
    /// All zero.
    pub const NONE: Self = Self { slopes: [[Lanes::ZERO; N]; STAGES], powers: [[Lanes::ZERO; 2]; STAGES] };

    /// Begins a step: sets stage 0.
    #[inline(always)]
    pub fn begin(&mut self, at: &Moment<N>) {
        (self.slopes[0], self.powers[0]) = (at.slope, at.power);
    }
}

/// Evaluates stages 1 to 12, unrolled and without zero weights; returns the states at the end, and the rates there.
#[inline(always)]
fn stages_unrolled<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    stages: &mut Stages<N>,
) -> ([Lanes; N], Moment<N>) {
    let Stages { slopes: mut k, powers: mut p } = *stages;
    macro_rules! stages {
        ($($s:literal: $($j:literal)*;)* => $end:literal: $($i:literal)*) => {{
            $(stage_of!(FUSED, (system, t, h, y), (k, p), $s; 0 $($j)*);)*
            stage_of!(FUSED, (system, t, h, y), (k, p), $end; 0 $($i)*)
        }};
    }
    let end = each_stage!(stages);
    *stages = Stages { slopes: k, powers: p };
    end
}

/// Scale of a state: its size plus the absolute tolerance over the relative one.
#[inline(always)]
pub fn size(y: Lanes, absolute: Lanes, relative: f64) -> Lanes {
    y.abs() + absolute * (1.0 / relative)
}

/// Length of the probing step, s, over which the change of the rates is measured.
#[inline(always)]
pub fn probe<const N: usize>(
    length: Lanes,
    y: &[Lanes; N],
    absolute: &[Lanes; N],
    slope: &[Lanes; N],
    relative: f64,
) -> Lanes {
    let mut probe = length * PROBE;
    for i in 0..N {
        probe = probe.min(size(y[i], absolute[i], relative) * PROBE / (slope[i].abs() + TINY));
    }
    probe
}

/// Additional stages for estimating the first step: at the start, and a short time ahead.
pub const FEELING: Range<usize> = STAGES..STAGES + 2;

/// Evaluates stages in a loop, with one copy of the rates' code. Returns the states and the rates at the last one, and the length of the
/// step. For [`FEELING`] that length is a [`probe`] of a span of `length`; the rates at the start become stage 0, those ahead stage
/// 1, and the returned rates are those at the start.
#[inline(always)]
pub fn stages_in_turn<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    [t, mut h]: [Lanes; 2],
    y: &[Lanes; N],
    Stages { slopes: k, powers }: &mut Stages<N>,
    stages: Range<usize>,
    (length, absolute, relative): (Lanes, &[Lanes; N], f64),
) -> ([Lanes; N], Moment<N>, Lanes) {
    let (mut at, mut last) = (*y, Moment::NONE);
    for stage in stages {
        macro_rules! reach {
            ($($s:literal: $($j:literal)*;)* => $end:literal: $($i:literal)*) => {
                match stage {
                    $($s => from_those!($s; $($j)*),)*
                    $end => from_those!($end; $($i)*),
                    // A stage for the first step.
                    _ => from_those!(stage;),
                }
            };
        }
        macro_rules! from_those {
            ($s:expr; $($j:literal)*) => {
                for i in 0..system.moving() {
                    // Otherwise the compiler vectorises across states instead of lanes.
                    let k = black_box(&*k);
                    at[i] = multiply_add::<FUSED>(weighted!(FUSED, k, i, A[$s]; 0 $($j)*), h, y[i]);
                }
            };
        }
        each_stage!(reach);
        let moment = system.rates(multiply_add::<FUSED>(h, Lanes::from(C[stage]), t), &at);
        if stage == STAGES - 1 || stage == FEELING.start {
            last = moment;
        }
        match stage.checked_sub(FEELING.start) {
            None => (k[stage], powers[stage]) = (moment.slope, moment.power),
            Some(place) => {
                k[place] = moment.slope;
                if place == 0 {
                    h = probe(length, y, absolute, &moment.slope, relative);
                }
            }
        }
    }
    (at, last, h)
}

/// Attempts a step of `h` from `y`, with the rates `begin` there, for a system with cheap rates.
#[inline(always)]
pub fn attempt<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    t: Lanes,
    h: Lanes,
    y: &[Lanes; N],
    begin: &Moment<N>,
    tolerance: (f64, &[Lanes; N]),
) -> Attempt<N> {
    let mut stages = Stages::NONE;
    stages.begin(begin);
    let end = stages_unrolled::<N, FUSED, S>(system, t, h, y, &mut stages);
    judge::<N, FUSED, S>(system, h, y, end, &stages, tolerance)
}

/// Evaluates an attempted step from `y`, given its end and its stages.
#[inline(always)]
pub fn judge<const N: usize, const FUSED: bool, S: LaneSystem<N>>(
    system: &S,
    h: Lanes,
    y: &[Lanes; N],
    (end, moment): ([Lanes; N], Moment<N>),
    Stages { slopes: k, powers }: &Stages<N>,
    tolerance: (f64, &[Lanes; N]),
) -> Attempt<N> {
    let (mut fifth, mut third) = (Lanes::ZERO, Lanes::ZERO);
    for i in 0..system.moving() {
        let scale = y[i].abs().max(end[i].abs()) * tolerance.0 + tolerance.1[i];
        let per_scale = h / scale;
        let e5 = weighted!(FUSED, k, i, E5; 0 5 6 7 8 9 10 11) * per_scale;
        let e3 = weighted!(FUSED, k, i, E3; 0 5 6 7 8 9 10 11) * per_scale;
        fifth = multiply_add::<FUSED>(e5, e5, fifth);
        third = multiply_add::<FUSED>(e3, e3, third);
    }
    // e5 grows as e3^1.5; far below that it is about to change sign and is no measure of the error.
    let usual = third * third.sqrt() * (tolerance.0 * CHANCE);
    let fifth = fifth.max(usual);
    // Hairer's combination e5 · e5/√(e5² + 0.01 e3²), averaged over the states; squared, to save the root.
    let error_squared = fifth * fifth / ((third * 0.01 + fifth + 1e-200) * system.counted());
    let mut energy = [Lanes::ZERO; 2];
    for part in 0..2 {
        energy[part] = weighted!(FUSED, powers, part, A[12]; 0 5 6 7 8 9 10 11) * h;
    }
    Attempt { end, moment, energy, error_squared }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stage_has_all_weights_that_are_not_zero() {
        macro_rules! listed {
            ($($s:literal: $($j:literal)*;)* => $end:literal: $($i:literal)*) => {
                [$(($s, vec![0 $(, $j)*]),)* ($end, vec![0 $(, $i)*])]
            };
        }
        let listed: [(usize, Vec<usize>); STAGES - 1] = each_stage!(listed);
        for (stage, earlier) in listed {
            let weights = A[stage].iter().enumerate().filter(|(_, weight)| **weight != 0.0);
            assert_eq!(earlier, weights.map(|(j, _)| j).collect::<Vec<_>>(), "{stage}");
        }
    }

    #[test]
    fn what_moves_along_a_cubic_is_extrapolated_as_it_goes_on() {
        let cubic = |t: f64| 3.0 - 2.0 * t + 0.5 * t * t - 0.25 * t * t * t;
        let slope = |t: f64| -2.0 + t - 0.75 * t * t;
        let at = |t: f64| [cubic(t), slope(t)].map(Lanes::from);
        for (from, to, ahead) in [(0.0, 0.5, 0.4), (-1.0, 1.0, 3.0)] {
            let since = [to - from, 1.0 / (to - from)].map(Lanes::from);
            let found = extrapolated(Lanes::from(ahead), at(to), at(from), since);
            let expected = at(to + ahead);
            for i in 0..2 {
                assert!((found[i][3] - expected[i][3]).abs() < 1e-12, "{found:?}");
            }
        }
    }
}
