//! Sealed tests by adaptive integration in lanes: all pushes of a chunk, then all holds, then what is asked of them.

use super::advance::{Loadable, Nobody, Problem, Steps, Tried, Watch, advance};
use super::finish::{self, Relaxation};
use super::fit;
use super::outcome::{Failure, Outcome};
use super::regression::{Part, Records};
use super::scenario::{Options, Scenario};
use super::sealed::{Ending, Held, Moving, Test};
use super::step::dense;
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use pulp::Arch;

/// Working memory of a chunk, kept from one to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<Test>,
    problems: Vec<Problem<1>>,
    peaks: Vec<f64>,
    log: Vec<Tried<1>>,
    parts: Vec<Part<Lanes>>,
    records: Records,
}

/// Keeps the steps and the record within them.
struct Both<'a> {
    log: &'a mut Vec<Tried<1>>,
    parts: &'a mut Vec<Part<Lanes>>,
}

impl Watch<1, Held<'_>> for Both<'_> {
    #[inline(always)]
    fn see<const FUSED: bool>(&mut self, system: &Held, tried: Tried<1>) {
        let Tried { from, length, begin, end, slopes, accepted } = &tried;
        let terms = dense::<1, FUSED, Held>(system, *from, *length, begin, end, slopes);
        let mut part = system.part(&terms, *from, *length);
        part.samples.count = accepted.where_positive(part.samples.count, Lanes::ZERO);
        self.parts.push(part);
        self.log.see::<FUSED>(system, tried);
    }
    #[inline(always)]
    fn kept(&self) -> usize {
        self.log.len()
    }
}

/// Runs tests that [`sealed`](super::sealed) covers and whose numbers are checked; `durations` in s.
pub fn run(
    arch: Arch,
    memory: &mut Memory,
    rows: &[(u32, f64)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    let Memory { tests, problems, peaks, log, parts, records } = memory;
    let relative = options.relative_tolerance;
    tests.clear();
    problems.clear();
    log.clear();
    parts.clear();
    for &(row, _) in rows {
        let s = &scenarios[row as usize];
        tests.push(Test::new(s));
        problems.push(Problem::new(s.push_time_s, [s.initial_temperature_k], [0.0]));
    }
    advance(arch, &Moving::new(tests), problems, relative, &mut Nobody);
    peaks.clear();
    for (problem, (_, duration)) in problems.iter_mut().zip(rows) {
        peaks.push(problem.state[0]);
        problem.length = duration - problem.length;
    }
    if options.fit {
        advance(arch, &Held::new(tests), problems, relative, &mut Both { log, parts });
    } else {
        advance(arch, &Held::new(tests), problems, relative, log);
    }

    for (group, rows) in rows.chunks(WIDTH).enumerate() {
        let base = group * WIDTH;
        let at = |lane: usize| base + lane.min(rows.len() - 1);
        let peak = Lanes::from_fn(|lane| peaks[at(lane)]);
        let end = Lanes::from_fn(|lane| problems[at(lane)].state[0]);
        let steps: [Steps; WIDTH] = core::array::from_fn(|lane| problems[at(lane)].steps);
        let relaxation = Relaxation { log, steps, state: 0, peak, end };
        let mut system = Held::new(tests);
        for lane in 0..WIDTH {
            system.load(lane, at(lane));
        }
        let settling = finish::settling(arch, &relaxation, &system);
        let regression = options.fit.then(|| {
            records.clear();
            for lane in 0..rows.len() {
                add_record(records, lane, parts, problems[at(lane)].steps);
            }
            let guess = |lane: usize| {
                let test = &tests[at(lane)];
                fit::time_constant(test.rate, 1.0 - test.closed.ambient_temperature / peak[lane])
            };
            records.fit(arch, Lanes::from_fn(guess))
        });
        for (lane, &(row, duration)) in rows.iter().enumerate() {
            let (test, problem) = (&tests[at(lane)], &problems[at(lane)]);
            let (peak, end) = (peak[lane], end[lane]);
            out[row as usize] = match problem.failure {
                Some(reason) => Outcome::failed(reason),
                None => {
                    let ending = Ending {
                        scenario: &scenarios[row as usize],
                        duration,
                        peak,
                        end,
                        pressure_per_temperature: test.closed.mass_gas_constant / test.held_volume,
                        settling: settling[lane],
                        regression: regression.as_ref().and_then(|found| found.lane(lane)),
                    };
                    Outcome {
                        energy_error: problem.gap,
                        exact: false,
                        status: if end > 0.0 { Ok(()) } else { Err(Failure::Empty) },
                        ..ending.outcome()
                    }
                }
            };
        }
    }
}

/// Copies the parts of a problem's steps that have samples.
fn add_record(records: &mut Records, lane: usize, parts: &[Part<Lanes>], steps: Steps) {
    let column = steps.lane as usize;
    for part in &parts[steps.from as usize..steps.to as usize] {
        if part.samples.count[column] > 0.0 {
            records.add(lane, part.lane(column));
        }
    }
}
