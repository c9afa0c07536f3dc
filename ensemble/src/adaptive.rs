//! Sealed tests by adaptive integration in lanes: all pushes of a chunk, then all holds, then what is asked of them.

use crate::Batch;
use crate::advance::{LONGEST_OF_MOVE, Loadable, Nobody, Problem, Steps, Tried, Watch, advance};
use crate::finish;
use crate::hermite::Hermite;
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::outcome::{Failure, Outcome, closure};
use crate::regression::Records;
use crate::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use crate::sealed::{Ending, Held, Moving, Test};
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Simd, WithSimd};

/// Working memory of a chunk, kept from one to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<Test>,
    problems: Vec<Problem<1>>,
    pushed: Vec<Pushed>,
    log: Vec<Tried<1>>,
    order: Vec<usize>,
    knots: Vec<Knot>,
    records: Records,
}

/// How the push of a test has ended.
#[derive(Clone, Copy)]
struct Pushed {
    /// Temperature, K.
    temperature: f64,
    /// Energy received as heat, and work, over m cv, K.
    energy: [f64; 2],
}

/// Ends of steps through the hold, one of each test: time in the hold, s, and temperature, K.
#[derive(Clone, Copy)]
struct Knot {
    time: Lanes,
    temperature: Lanes,
}

impl Knot {
    const NONE: Self = Self { time: Lanes::ZERO, temperature: Lanes::ZERO };
}

/// Keeps every step, to look into some of them later.
impl Watch<1> for Vec<Tried<1>> {
    #[inline(always)]
    fn see(&mut self, tried: &Tried<1>) {
        self.push(*tried);
    }
    #[inline(always)]
    fn kept(&self) -> usize {
        self.len()
    }
}

/// Runs tests that [`sealed`](crate::sealed) covers and whose numbers are checked; `durations` in s.
pub fn run(batch: Batch, memory: &mut Memory, rows: &[(u32, f64)], out: &mut [Outcome]) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { tests, problems, pushed, log, order, knots, records } = memory;
    let relative = options.relative_tolerance;
    tests.clear();
    problems.clear();
    log.clear();
    for &(row, _) in rows {
        let s = &scenarios[row as usize];
        tests.push(Test::new(s));
        let mut push = Problem::new(s.push_time_s, [s.initial_temperature_k.sqrt()], [0.0]);
        push.longest = LONGEST_OF_MOVE * push.length;
        problems.push(push);
    }
    advance(arch, &Moving::new(tests), problems, relative, &mut Nobody);
    pushed.clear();
    for (problem, (_, duration)) in problems.iter_mut().zip(rows) {
        pushed.push(Pushed { temperature: problem.state[0] * problem.state[0], energy: problem.energy });
        (problem.length, problem.longest, problem.first) = (duration - problem.length, f64::INFINITY, 0.0);
    }
    advance(arch, &Held::new(tests), problems, relative, log);

    order.clear();
    order.extend(0..rows.len());
    if options.fit {
        // Records of about the same length side by side.
        order.sort_unstable_by_key(|&row| problems[row].steps.count());
    }
    for group in order.chunks(WIDTH) {
        let at = |lane: usize| group[lane.min(group.len() - 1)];
        let begin = Lanes::from_fn(|lane| pushed[at(lane)].temperature);
        let end = Lanes::from_fn(|lane| problems[at(lane)].state[0]);
        let end = end * end;
        let steps: [Steps; WIDTH] = core::array::from_fn(|lane| problems[at(lane)].steps);
        let mut system = Held::new(tests);
        for lane in 0..WIDTH {
            system.load(lane, at(lane));
        }
        let settling = finish::settling(arch, &system, log, &steps, begin, end);
        let regression = options.fit.then(|| {
            knots.clear();
            knots.push(Knot { time: Lanes::ZERO, temperature: begin });
            for (lane, steps) in steps.iter().enumerate() {
                add_knots(knots, lane, log, *steps);
            }
            let pressure = |lane: usize| tests[at(lane)].pressure_per_temperature();
            let push = |lane: usize| scenarios[rows[at(lane)].0 as usize].push_time_s;
            let guess = arch.dispatch(Record {
                system: &system,
                knots,
                begin: Lanes::from_fn(push),
                pressure_per_temperature: Lanes::from_fn(pressure),
                records,
            });
            records.fit(arch, guess)
        });
        for (lane, &index) in group.iter().enumerate() {
            let ((row, duration), test, problem) = (rows[index], &tests[index], &problems[index]);
            let end = end[lane];
            out[row as usize] = match problem.failure {
                Some(reason) => Outcome::failed(reason),
                None => {
                    let scenario = &scenarios[row as usize];
                    let Pushed { energy: [received, work], .. } = pushed[index];
                    let received = received + problem.energy[0];
                    let start = scenario.initial_temperature_k;
                    let ending = Ending {
                        scenario,
                        duration,
                        wall: test.closed.ambient_temperature,
                        pushed: begin[lane],
                        end,
                        pressure_per_temperature: test.pressure_per_temperature(),
                        settling: settling[lane],
                        regression: regression.as_ref().and_then(|found| found.lane(lane)),
                    };
                    Outcome {
                        energy_error: closure(start, end, received - work, work),
                        exact: false,
                        status: if end > 0.0 { Ok(()) } else { Err(Failure::Empty) },
                        ..ending.outcome()
                    }
                }
            };
        }
    }
}

/// Copies the ends of a problem's accepted steps into a lane, after the first knot.
fn add_knots(knots: &mut Vec<Knot>, lane: usize, log: &[Tried<1>], steps: Steps) {
    let column = steps.lane as usize;
    let mut index = 1;
    for step in &log[steps.from as usize..steps.to as usize] {
        if step.accepted[column] > 0.0 {
            if index == knots.len() {
                knots.push(Knot::NONE);
            }
            knots[index].time[lane] = step.from[column] + step.length[column];
            knots[index].temperature[lane] = step.end[0][column] * step.end[0][column];
            index += 1;
        }
    }
}

/// The records through the hold, a part for each step. Its polynomial comes from the equation at its ends: as good as the
/// integrator's own of degree 7, at a fraction of its stages. The answer is a guess of τ, s.
struct Record<'a> {
    system: &'a Held<'a>,
    knots: &'a [Knot],
    /// Begin of the hold, s.
    begin: Lanes,
    pressure_per_temperature: Lanes,
    records: &'a mut Records,
}

impl WithSimd for Record<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Lanes {
        let Self { system, knots, begin, pressure_per_temperature, records } = self;
        records.clear();
        let mut from = knots[0];
        let mut first = each_lane!(i => samples::from(begin.0[i]));
        for to in &knots[1..] {
            // Results pass through memory: else the compiler computes them lane by lane.
            let to = black_box(to);
            // A lane without further steps stays where it is.
            let time = black_box(to.time.where_positive(to.time, from.time));
            let temperature = black_box(to.time.where_positive(to.temperature, from.temperature));
            let end = black_box(begin + time);
            let next = black_box(each_lane!(i => samples::after(end.0[i])));
            let length = black_box(time - from.time);
            let before = black_box(system.series(from.temperature, length));
            let after = black_box(system.series(temperature, length));
            let within = black_box(Hermite::new(before, after));
            let nodes = black_box(Samples { first, count: next - first }.nodes());
            let since = black_box(begin + from.time);
            let per_length = black_box(length.where_positive(length, Lanes::ONE).recip());
            let mut pressure = [Lanes::ZERO; POINTS];
            for k in 0..POINTS {
                let place = (nodes.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - since) * per_length;
                pressure[k] = black_box(within.at(place) * pressure_per_temperature);
            }
            records.push(first, &nodes, &pressure);
            first = next;
            from = Knot { time, temperature };
        }
        system.time_constant(black_box(knots[0].temperature))
    }
}
