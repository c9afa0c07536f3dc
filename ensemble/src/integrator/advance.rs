//! Solves many initial value problems, each over one smooth span of time: one per lane, each with its own steps; a lane that is done
//! takes the next problem. Steps are those of a Runge–Kutta pair ([`crate::integrator::step`]) or of the Taylor series of the solution
//! ([`crate::integrator::expansion`]).

use crate::integrator::corner;
use crate::integrator::expansion::{ORDER, Stride};
use crate::integrator::first_step::{begin, first_step};
use crate::integrator::problem::{Problem, Steps};
use crate::integrator::step::{Attempt, FEELING, LaneSystem, Moment, Stages, View, attempt, judge, stages_in_turn};
use crate::integrator::tableau::STAGES;
use crate::lanes::math::inverse_eighth_root;
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::outcome::Failure;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Largest number of attempted steps; a push-and-hold test takes about twenty. A history of this length takes 23 MB.
const MAX_ATTEMPTS: f64 = 3e4;
const SAFETY: f64 = 0.9;
/// Largest growth of a step: an error estimate that happens to vanish must not make the next step arbitrarily long.
const GROW: f64 = 2.5;
const SHRINK: f64 = 0.3;
/// Factor of the next step after one that gave NaN.
const NOT_A_NUMBER: f64 = 0.1;
/// Longest step, relative to the span, of a solution that is interpolated: the interpolant needs neighbouring knots.
pub const LONGEST: f64 = 0.26;
/// Longest step, relative to the span, while the piston moves: over a whole push both error estimates can vanish at once, and a step
/// with twenty times the tolerated error would pass. Longer steps are rejected so often that they gain nothing.
pub const LONGEST_OF_MOVE: f64 = 0.34;
/// First step of a test, relative to the span, if the rates do not determine it: with a bent transformation, and with a conducting
/// wall, whose modes all start from rest.
pub const FIRST_OF_BENT: f64 = 0.15;
/// Farthest prediction of a kink, in lengths of the last step.
const FORESIGHT: f64 = 1.0;
/// A step of at least this fraction of the rest goes to the end.
const NEARLY: f64 = 1.0 - 1e-12;
/// Shortest step, relative to the span.
const SMALLEST_SHARE: f64 = 1e-14;

/// An attempted step of all lanes.
#[derive(Clone, Copy, Debug)]
pub struct Tried<const N: usize> {
    /// Time at which the step begins, s from the span's start.
    pub from: Lanes,
    /// Length of the step, s.
    pub length: Lanes,
    /// States at its start.
    pub begin: [Lanes; N],
    /// States at its end.
    pub end: [Lanes; N],
    /// View at its end.
    pub view: View<Lanes>,
    /// By lane: 1 if the step was accepted, 2 if it was accepted and ends at a kink, else 0.
    pub accepted: Lanes,
}

/// Selects `yes` in lanes where `condition` > 0, else `no`.
#[inline(always)]
fn choose<const N: usize>(condition: Lanes, yes: &[Lanes; N], no: &[Lanes; N]) -> [Lanes; N] {
    let mut out = *no;
    for i in 0..N {
        out[i] = condition.where_positive(yes[i], no[i]);
    }
    out
}

/// An observer of the attempted steps.
pub trait Watch<const N: usize> {
    /// Called for each attempted step, accepted or not.
    fn see(&mut self, tried: &Tried<N>);
    /// Number of steps stored so far, to which [`Steps`] refers.
    fn stored(&self) -> usize;
    /// Whether it can keep no more: then the integration stops.
    #[inline(always)]
    fn is_full(&self) -> bool {
        false
    }
}

/// Keeps nothing: for solutions of which only the end matters.
impl<const N: usize> Watch<N> for () {
    #[inline(always)]
    fn see(&mut self, _: &Tried<N>) {}
    #[inline(always)]
    fn stored(&self) -> usize {
        0
    }
}

/// Owner of a lane without a problem.
const IDLE: usize = usize::MAX;
/// The set of all lanes; bit i represents lane i.
const ALL: u32 = (1 << WIDTH) - 1;

/// Removes the first lane from a set.
#[inline(always)]
fn first(lanes: &mut u32) -> Option<usize> {
    if *lanes == 0 {
        return None;
    }
    let lane = lanes.trailing_zeros() as usize;
    *lanes &= *lanes - 1;
    Some(lane)
}

/// Problems under integration, one per lane.
struct Group<const N: usize, S> {
    system: S,
    owner: [usize; WIDTH],
    attempts: Lanes,
    /// Positive while a lane has to go on, and may.
    going: Lanes,
    /// Lanes whose problem has ended, and lanes without one, one bit each.
    ended: u32,
    idle: u32,
    t: Lanes,
    h: Lanes,
    /// Step length to continue with after a kink that shortens a step.
    beyond: Lanes,
    /// Pressure and its slope at the start of the last accepted step of the span, and its length; zero if there was none.
    before: [Lanes; 2],
    since: Lanes,
    /// Rate of widening of the chamber at `t`, if there are kinks.
    widening: Lanes,
    length: Lanes,
    longest: Lanes,
    y: [Lanes; N],
    /// Rates of the system at `t` and `y`.
    moment: Moment<N>,
    absolute: [Lanes; N],
    /// Running sums as in [`Problem::energy`], J.
    energy: [Lanes; 2],
}

/// Solves each problem that has not failed, with the row of the same index, and reports the steps to `watch`. The lanes of `system` need
/// not be loaded.
pub fn advance<const N: usize, S: LaneSystem<N>>(
    arch: Arch,
    system: &S,
    rows: &[S::Row],
    problems: &mut [Problem<N>],
    relative: f64,
    watch: &mut impl Watch<N>,
) {
    arch.dispatch(Advance { system, rows, problems, relative, watch });
}

struct Advance<'a, const N: usize, S: LaneSystem<N>, W> {
    system: &'a S,
    rows: &'a [S::Row],
    problems: &'a mut [Problem<N>],
    relative: f64,
    watch: &'a mut W,
}

impl<const N: usize, S: LaneSystem<N>, W: Watch<N>> WithSimd for Advance<'_, N, S, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        let Self { system, rows, problems, relative, watch } = self;
        // Every instruction set beyond plain SSE2 that pulp knows of fuses multiplication and addition.
        if !I::IS_SCALAR {
            run::<N, true, S, W>(system, rows, problems, relative, watch);
        } else if S::ANYWHERE {
            run::<N, false, S, W>(system, rows, problems, relative, watch);
        } else {
            unreachable!("a system that is not compiled for any machine");
        }
    }
}

/// As [`advance`], inlined into the code of an instruction set.
#[inline(always)]
pub fn run<const N: usize, const FUSED: bool, S: LaneSystem<N>, W: Watch<N>>(
    system: &S,
    rows: &[S::Row],
    problems: &mut [Problem<N>],
    relative: f64,
    watch: &mut W,
) {
    let Some(any) = problems.iter().position(|p| p.failure.is_none()) else { return };
    let mut group: Group<N, S> = Group {
        system: system.clone(),
        owner: [IDLE; WIDTH],
        attempts: Lanes::ZERO,
        going: Lanes::ZERO,
        ended: ALL,
        idle: 0,
        t: Lanes::ZERO,
        h: Lanes::ZERO,
        beyond: Lanes::ZERO,
        before: [Lanes::ZERO; 2],
        since: Lanes::ZERO,
        widening: Lanes::ZERO,
        length: Lanes::ZERO,
        longest: Lanes::ZERO,
        y: [Lanes::ONE; N],
        moment: Moment::NONE,
        absolute: [Lanes::ONE; N],
        energy: [Lanes::ZERO; 2],
    };
    if S::CHEAP && !S::BY_SERIES {
        for base in (0..problems.len()).step_by(WIDTH) {
            group.load_to_begin(rows, problems, base);
            let Group { system, length, y, absolute, .. } = group.through_memory();
            let (moment, first) = begin(system, *length, y, absolute, relative);
            begin_from(&mut problems[base..], &moment, first);
        }
    }
    // Lanes without a problem get the start of this one.
    for lane in 0..WIDTH {
        group.system.load(lane, &rows[any]);
        for i in 0..N {
            group.y[i][lane] = problems[any].state[i];
        }
    }
    let mut next = 0;
    if !S::CHEAP {
        return run_in_turn::<N, FUSED, S, W>(group, rows, problems, relative, watch);
    }
    loop {
        group.through_memory().halt();
        if group.ended != 0 {
            group.refill(rows, problems, &mut next, watch.stored() as u32);
        }
        if group.idle == ALL {
            return;
        }
        let group = group.through_memory();
        if S::BY_SERIES {
            group.stride(relative, watch);
            continue;
        }
        let tried = group.planned();
        let (y, absolute) = (&group.y, (relative, &group.absolute));
        let step = attempt::<N, FUSED, S>(&group.system, group.t, tried, y, &group.moment, absolute);
        group.take(tried, step, watch);
    }
}

/// Stores the initial rates and first steps of the first of these problems.
#[inline(always)]
fn begin_from<const N: usize>(problems: &mut [Problem<N>], moment: &Moment<N>, first: Lanes) {
    for (lane, problem) in problems.iter_mut().take(WIDTH).enumerate() {
        problem.begin(lane, moment, first);
    }
}

/// The same with a single copy of the rates' code: first for the starts of all problems, then for their steps.
#[inline(always)]
fn run_in_turn<const N: usize, const FUSED: bool, S: LaneSystem<N>, W: Watch<N>>(
    mut group: Group<N, S>,
    rows: &[S::Row],
    problems: &mut [Problem<N>],
    relative: f64,
    watch: &mut W,
) {
    let (mut begun, mut next) = (0, 0);
    let mut all = Stages::NONE;
    loop {
        let begins = begun < problems.len();
        if begins {
            group.load_to_begin(rows, problems, begun);
        } else {
            group.through_memory().halt();
            if group.ended != 0 {
                group.refill(rows, problems, &mut next, watch.stored() as u32);
            }
            if group.idle == ALL || watch.is_full() {
                return;
            }
        }
        let group = group.through_memory();
        let tried = if begins { Lanes::ZERO } else { group.planned() };
        let stages = black_box(if begins { FEELING } else { 1..STAGES });
        all.begin(&group.moment);
        let (length, y, absolute) = (group.length, &group.y, &group.absolute);
        let (end, moment, reached) = stages_in_turn::<N, FUSED, S>(
            &group.system,
            [group.t, tried],
            y,
            &mut all,
            stages,
            (length, absolute, relative),
        );
        if begins {
            let first = first_step(length, y, absolute, [&all.slopes[0], &all.slopes[1]], reached, relative);
            begin_from(&mut problems[begun..], &moment, first);
            begun += WIDTH;
            // A lane without a problem is at its end.
            group.length = Lanes::ZERO;
        } else {
            let tolerance = (relative, absolute);
            let step = judge::<N, FUSED, S>(&group.system, tried, y, (end, moment), &all, tolerance);
            group.take(tried, step, watch);
        }
    }
}

impl<const N: usize, S: LaneSystem<N>> Group<N, S> {
    /// Prevents the compiler from carrying lanes into the next phase as scalars and computing with them one by one.
    #[inline(always)]
    fn through_memory(&mut self) -> &mut Self {
        black_box(self)
    }

    /// Stores the solutions of lanes that have ended, with a failure if before the end of the span, and loads the next problems.
    #[inline(always)]
    fn refill(&mut self, rows: &[S::Row], problems: &mut [Problem<N>], next: &mut usize, stored: u32) {
        while let Some(lane) = first(&mut self.ended) {
            if let Some(done) = problems.get_mut(self.owner[lane]) {
                if self.t[lane] < self.length[lane] {
                    let stuck = self.attempts[lane] < MAX_ATTEMPTS;
                    done.failure = Some(if stuck { Failure::StepTooSmall } else { Failure::TooManySteps });
                }
                done.steps.to = stored;
                for i in 0..N {
                    done.state[i] = self.y[i][lane];
                }
                for part in 0..2 {
                    done.energy[part] = self.energy[part][lane];
                }
            }
            while problems.get(*next).is_some_and(|p| p.failure.is_some()) {
                *next += 1;
            }
            let Some(problem) = problems.get_mut(*next) else {
                self.owner[lane] = IDLE;
                self.idle |= 1 << lane;
                (self.t[lane], self.length[lane], self.h[lane]) = (0.0, 0.0, 0.0);
                continue;
            };
            problem.steps = Steps { from: stored, to: 0, lane: lane as u32 };
            self.system.load(lane, &rows[*next]);
            for i in 0..N {
                self.y[i][lane] = problem.state[i];
            }
            for part in 0..2 {
                self.energy[part][lane] = 0.0;
            }
            (self.t[lane], self.length[lane], self.longest[lane]) = (0.0, problem.length, problem.longest);
            self.attempts[lane] = 0.0;
            self.owner[lane] = *next;
            if !S::BY_SERIES {
                self.begin(lane, problem);
            }
            *next += 1;
        }
    }

    /// Loads what the steps of the pair need at the start of a problem beside the states.
    #[inline(always)]
    fn begin(&mut self, lane: usize, problem: &Problem<N>) {
        for i in 0..N {
            self.moment.slope[i][lane] = problem.slope[i];
            self.absolute[i][lane] = problem.absolute[i];
        }
        for i in 0..2 {
            self.moment.view.value[i][lane] = problem.view.value[i];
            self.moment.view.slope[i][lane] = problem.view.slope[i];
            self.moment.power[i][lane] = problem.power[i];
        }
        self.h[lane] = problem.first.min(problem.longest);
        (self.beyond[lane], self.since[lane]) = (0.0, 0.0);
    }

    /// Loads the problems from `base` on into the lanes, to evaluate their starts.
    #[inline(always)]
    fn load_to_begin(&mut self, rows: &[S::Row], problems: &[Problem<N>], base: usize) {
        for lane in 0..WIDTH {
            let index = (base + lane).min(problems.len() - 1);
            let problem = &problems[index];
            self.system.load(lane, &rows[index]);
            self.length[lane] = problem.length;
            for i in 0..N {
                self.y[i][lane] = problem.state[i];
                self.absolute[i][lane] = problem.absolute[i];
            }
        }
    }

    /// Length of the next step.
    #[inline(always)]
    fn planned(&mut self) -> Lanes {
        let left = self.length - self.t;
        let last = self.h - left * NEARLY;
        // Two equal steps rather than a full one and a tiny one.
        let planned = last.where_positive(left, self.h.min(left * 0.5));
        if self.system.has_kinks() { self.up_to_kink(planned) } else { planned }
    }

    /// Fraction of a step at which it meets its first kink, 1 if none, given pressure and slope at both ends.
    #[inline(always)]
    fn kink(&self, length: Lanes, ends: [[Lanes; 2]; 2]) -> Lanes {
        let [begin, end] = corner::inside(ends[0][0], ends[1][0]);
        corner::met([self.system.kink(begin, end), end], length, ends, self.widening)
    }

    /// Ends steps at predicted kinks.
    #[inline(always)]
    fn up_to_kink(&mut self, planned: Lanes) -> Lanes {
        let at = self.moment.view.pressure();
        self.widening = self.system.widening(self.t);
        let ahead = corner::ahead(planned, at, self.widening, self.before, self.since);
        let cut = planned * self.kink(planned, [at, ahead]);
        // In a hold not predicted from far away.
        let near = self.since.min(self.since * FORESIGHT - cut);
        let comes = (planned - cut).min(self.widening.abs().where_positive(Lanes::ONE, near));
        self.beyond = comes.where_positive(self.h, self.beyond);
        comes.where_positive(cut, planned)
    }

    /// Accepts or rejects an attempted step in each lane.
    #[inline(always)]
    fn take<W: Watch<N>>(&mut self, tried: Lanes, step: Attempt<N>, watch: &mut W) {
        let (t, h, length, y) = (self.t, self.h, self.length, self.y);
        let last = tried - (length - t) * NEARLY;
        let kinked = self.system.has_kinks();
        let at = self.moment.view.pressure();
        let kink = if kinked { self.kink(tried, [at, step.moment.view.pressure()]) } else { Lanes::ONE };
        // Positive if the step is good; not for NaN.
        let good = each_lane!(i => if step.error_squared.0[i] <= 1.0 && kink.0[i] >= 1.0 { 1.0 } else { 0.0 });
        let accepted =
            if kinked { good.where_positive(self.beyond.where_positive(Lanes::from(2.0), good), good) } else { good };
        watch.see(&Tried { from: t, length: tried, begin: y, end: step.end, view: step.moment.view, accepted });
        // error^(−1/8) from its square.
        let error = (step.error_squared + 1e-40).sqrt();
        let root = inverse_eighth_root(error) * SAFETY;
        let factor = root.max(Lanes::from(SHRINK)).min(Lanes::from(GROW));
        let by_error = each_lane!(i => if step.error_squared.0[i] > 1.0 { factor.0[i].min(0.9) } else { NOT_A_NUMBER });
        let smooth = each_lane!(i => if step.error_squared.0[i] <= 1.0 { 1.0 } else { by_error.0[i] });
        let shrunk = tried * smooth.min(kink);
        let grown = tried * factor;
        // A step shortened by the end or by a kink does not shorten the next one.
        let behind = if kinked { grown.max(self.beyond) } else { grown };
        let next = last.where_positive(h.max(grown), behind);
        let h = good.where_positive(next, shrunk);
        let t = good.where_positive(last.where_positive(length, t + tried), t);
        for part in 0..2 {
            self.energy[part] += good.where_positive(step.energy[part], Lanes::ZERO);
        }
        self.y = choose(good, &step.end, &y);
        if kinked {
            let on = (Lanes::ONE - kink).where_positive(tried * smooth, Lanes::ZERO);
            self.beyond = good.where_positive(Lanes::ZERO, on);
            self.since = good.where_positive(tried, self.since);
            self.before = choose(good, &at, &self.before);
        }
        let (to, from) = (&mut self.moment, &step.moment);
        to.slope = choose(good, &from.slope, &to.slope);
        to.view.value = choose(good, &from.view.value, &to.view.value);
        to.view.slope = choose(good, &from.view.slope, &to.view.slope);
        to.power = choose(good, &from.power, &to.power);
        let h = h.min(self.longest);
        (self.t, self.h) = (t, h);
        self.rest_or_go();
    }

    /// Takes a step by the system's series, in every lane where it is not NaN.
    #[inline(always)]
    fn stride<W: Watch<N>>(&mut self, relative: f64, watch: &mut W) {
        let expansion = self.system.expansion(&self.y);
        let expansion = black_box(&expansion);
        self.h = black_box(expansion.reach(relative)).min(self.longest);
        let tried = black_box(self.planned());
        let Stride { end, rise } = black_box(expansion.stride(tried));
        let (t, length) = (self.t, self.length);
        let received = tried * self.system.rates(t + tried, &end).power[0];
        self.energy[0] +=
            tried.where_positive(end[0] - self.y[0] - (rise - received) * (1.0 / ORDER as f64), Lanes::ZERO);
        watch.see(&Tried { from: t, length: tried, begin: self.y, end, view: View::NONE, accepted: tried });
        self.y = choose(tried, &end, &self.y);
        let last = tried - (length - t) * NEARLY;
        self.t = tried.where_positive(last.where_positive(length, t + tried), t);
        self.rest_or_go();
    }

    /// Counts an attempt and updates `going`.
    #[inline(always)]
    fn rest_or_go(&mut self) {
        self.attempts = self.attempts + 1.0;
        let enough = self.h - self.length * SMALLEST_SHARE;
        self.going = (self.length - self.t).min(enough).min(-self.attempts + MAX_ATTEMPTS);
    }

    /// Marks lanes that have ended.
    #[inline(always)]
    fn halt(&mut self) {
        let mut resting = 0;
        for lane in 0..WIDTH {
            // NaN counts as ended.
            let going = self.going[lane] > 0.0;
            resting |= u32::from(!going) << lane;
        }
        self.ended = resting & !self.idle;
    }
}
