//! Adaptive integration of tests with specialised equations, in lanes: all pushes of a chunk, then all holds, then their outcomes. Holds
//! are monotone, or turn once on the way from the peak ([`crate::systems::turns`]). Others are left to the general integrator, which finds
//! all turns of a record.

use crate::batch::Batch;
use crate::ending::Ending;
use crate::instructions::Wide;
use crate::integrator::advance::advance;
use crate::integrator::log::Attempted;
use crate::integrator::problem::{Problem, Steps};
use crate::integrator::step::LaneSystem;
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::{Failure, Outcome, closure};
use crate::regression::{Guess, Records};
use crate::systems::list::Method;
use crate::systems::settling;
use crate::systems::test_system::{Holding, TestSystem, Within};
use crate::systems::turns;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Working memory, kept from one chunk to the next.
pub struct Memory<const N: usize, T> {
    tests: Vec<T>,
    problems: Vec<Problem<N>>,
    pushed: Vec<PushEnd<N>>,
    log: Vec<Attempted<N>>,
    order: Vec<usize>,
    knots: Vec<StepEnd<N>>,
    records: Records,
}

impl<const N: usize, T> Default for Memory<N, T> {
    fn default() -> Self {
        Self {
            tests: Vec::new(),
            problems: Vec::new(),
            pushed: Vec::new(),
            log: Vec::new(),
            order: Vec::new(),
            knots: Vec::new(),
            records: Records::default(),
        }
    }
}

/// The end of a push.
#[derive(Clone, Copy)]
struct PushEnd<const N: usize> {
    state: [f64; N],
    /// Energy received as heat and enthalpy, and work, in the reading's unit.
    energy: [f64; 2],
}

/// Ends of steps through the hold, one per lane: time since the push, s, and states.
#[derive(Clone, Copy)]
struct StepEnd<const N: usize> {
    time: Lanes,
    state: [Lanes; N],
}

impl<const N: usize> StepEnd<N> {
    const NONE: Self = Self { time: Lanes::ZERO, state: [Lanes::ZERO; N] };
}

/// Replaces the tests by those of `rows` and integrates their pushes.
pub fn push<const N: usize, T: TestSystem<N>>(
    Batch { arch, scenarios, options }: Batch,
    rows: &[u32],
    tests: &mut Vec<T>,
    problems: &mut Vec<Problem<N>>,
) {
    let relative = options.relative_tolerance;
    tests.clear();
    problems.clear();
    for &row in rows {
        let s = &scenarios[row as usize];
        let test = T::new(s);
        problems.push(test.push(s));
        tests.push(test);
    }
    T::begin(arch, tests, problems, relative);
    advance(arch, &T::Moving::default(), tests, problems, relative, &mut ());
}

impl<const N: usize, T: TestSystem<N>> Method for Memory<N, T> {
    fn solve(&mut self, batch: Batch, rows: &mut [u32], left: &mut Vec<u32>, out: &mut [Outcome]) {
        rows.sort_by_cached_key(|row| T::kind(&batch.scenarios[*row as usize]));
        run(batch, self, rows, left, out);
    }
}

/// Solves tests whose numbers are checked.
fn run<const N: usize, T: TestSystem<N>>(
    batch: Batch,
    memory: &mut Memory<N, T>,
    rows: &[u32],
    left: &mut Vec<u32>,
    out: &mut [Outcome],
) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { tests, problems, pushed, log, order, knots, records } = memory;
    let relative = options.relative_tolerance;
    log.clear();
    push(batch, rows, tests, problems);
    pushed.clear();
    for ((problem, test), row) in problems.iter_mut().zip(&*tests).zip(rows) {
        if !test.goes_one_way(&problem.state) {
            problem.failure = Some(Failure::StepTooSmall);
        }
        problem.state = test.at_rest(problem.state);
        pushed.push(PushEnd { state: problem.state, energy: test.energy_of_push(problem.energy) });
        let length = scenarios[*row as usize].hold_s();
        (problem.length, problem.longest, problem.first) = (length, T::LONGEST * length, 0.0);
    }
    advance(arch, &T::Held::default(), tests, problems, relative, log);

    order.clear();
    order.extend(0..rows.len());
    if options.fit {
        // Records of similar length in neighbouring lanes.
        order.sort_unstable_by_key(|&row| problems[row].steps.count());
    }
    for group in order.chunks(WIDTH) {
        let at = |lane: usize| group[lane.min(group.len() - 1)];
        let state: [Lanes; N] = core::array::from_fn(|i| Lanes::from_fn(|lane| pushed[at(lane)].state[i]));
        let end_state: [Lanes; N] = core::array::from_fn(|i| Lanes::from_fn(|lane| problems[at(lane)].state[i]));
        let [begin, end] = [&state, &end_state].map(T::Held::reading);
        let steps: [Steps; WIDTH] = core::array::from_fn(|lane| problems[at(lane)].steps);
        let mut system = T::Held::default();
        for lane in 0..WIDTH {
            system.load(lane, &tests[at(lane)]);
        }
        let turns = T::TURNS.then(|| {
            let expands = |lane: usize| scenarios[rows[at(lane)] as usize].expands();
            let sign = Lanes::from_fn(|lane| if expands(lane) { -1.0 } else { 1.0 });
            let falls_on = core::array::from_fn(|lane| tests[at(lane)].falls_on(&problems[at(lane)].state));
            turns::find::<N, T>(arch, &system, log, &steps, (sign, falls_on), [&state, &end_state])
        });
        // Gas without effects approaches the wall's temperature; with a warming wall, a heat flow or flows it may stay warm.
        let at_end = T::HAS_ANOTHER_WAY.then(|| turns::seen(arch, &system, &end_state));
        let settling = settling::times(arch, &system, log, &steps, turns.as_ref(), [begin, end]);
        let regression = options.fit.then(|| {
            knots.clear();
            knots.push(StepEnd { time: Lanes::ZERO, state });
            for (lane, steps) in steps.iter().enumerate() {
                add_knots(knots, lane, log, *steps);
            }
            let pressure = |lane: usize| tests[at(lane)].pressure_per_reading();
            let push = |lane: usize| scenarios[rows[at(lane)] as usize].push_time_s;
            let guess = arch.dispatch(Wide(Record {
                system: &system,
                knots,
                begin: Lanes::from_fn(push),
                pressure_per_reading: Lanes::from_fn(pressure),
                records,
            }));
            records.fit(arch, guess)
        });
        for (lane, &index) in group.iter().enumerate() {
            let (row, test, problem) = (rows[index], &tests[index], &problems[index]);
            let end = end[lane];
            let is_told = turns.as_ref().is_none_or(|turns| turns.told[lane]);
            if T::HAS_ANOTHER_WAY && (problem.failure.is_some() || !is_told) {
                left.push(row);
                continue;
            }
            out[row as usize] = match problem.failure {
                Some(reason) => Outcome::failed(reason),
                None => {
                    let scenario = &scenarios[row as usize];
                    let PushEnd { state, energy: [received, work] } = &pushed[index];
                    let received = received + problem.energy[0];
                    let hold = scenario.hold_s();
                    let ending = Ending {
                        scenario,
                        wall: test.reading_at_rest(&problem.state),
                        pushed: begin[lane],
                        end,
                        pressure_per_temperature: test.pressure_per_reading(),
                        settling: settling[lane],
                        flowing: turns.as_ref().map_or(0.0, |turns| (end * turns.inflow[lane] * hold).abs()),
                        relative_rate: at_end.map(|view| view.pressure_rate()[lane] * hold),
                        regression: regression.as_ref().and_then(|found| found.lane(lane)),
                    };
                    let outcome = ending.outcome();
                    let temperatures = T::temperatures([state, &problem.state], [begin[lane], end]);
                    Outcome {
                        temperature_final_k: temperatures[1],
                        temperature_peak_k: scenario.peak(temperatures),
                        energy_error: closure(test.start_reading(scenario), end, received - work, *work),
                        exact: false,
                        status: if end > 0.0 { Ok(()) } else { Err(Failure::Empty) },
                        ..outcome
                    }
                }
            };
        }
    }
}

/// Copies the ends of a problem's accepted steps into a lane, after the first knot.
fn add_knots<const N: usize>(knots: &mut Vec<StepEnd<N>>, lane: usize, log: &[Attempted<N>], steps: Steps) {
    let column = steps.lane as usize;
    let mut index = 1;
    for step in &log[steps.from as usize..steps.to as usize] {
        if step.accepted[column] > 0.0 {
            if index == knots.len() {
                knots.push(StepEnd::NONE);
            }
            knots[index].time[lane] = step.from[column] + step.length[column];
            for i in 0..N {
                knots[index].state[i][lane] = step.states[1][i][column];
            }
            index += 1;
        }
    }
}

/// Lays out the records of the holds, one part per step; returns a guess of τ.
struct Record<'a, const N: usize, H> {
    system: &'a H,
    knots: &'a [StepEnd<N>],
    /// Begin of the hold, s.
    begin: Lanes,
    pressure_per_reading: Lanes,
    records: &'a mut Records,
}

impl<const N: usize, H: Holding<N>> WithSimd for Record<'_, N, H> {
    type Output = Guess;

    #[inline(always)]
    fn with_simd<I: Simd>(self, simd: I) -> Guess {
        let Self { system, knots, begin, pressure_per_reading, records } = self;
        records.begin_at(begin);
        let mut from = knots[0];
        for to in &knots[1..] {
            // Passes through memory: otherwise the compiler computes lane by lane.
            let to = black_box(to);
            // A lane without further steps stays in place.
            let time = black_box(to.time.where_positive(to.time, from.time));
            let state: [Lanes; N] =
                black_box(core::array::from_fn(|i| to.time.where_positive(to.state[i], from.state[i])));
            let end = black_box(begin + time);
            let length = black_box(time - from.time);
            if let Some(nodes) = records.nodes_up_to(end) {
                let within = Within { system, ends: [&from.state, &state], length }.polynomial(simd);
                let since = black_box(begin + from.time);
                records.push(&nodes, &nodes.values(&within, since, length, pressure_per_reading));
            }
            from = StepEnd { time, state };
        }
        system.guess([black_box(&knots[0].state), black_box(&from.state)], black_box(begin))
    }
}
