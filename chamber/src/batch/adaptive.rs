//! Sealed tests by adaptive integration in lanes: all pushes of a chunk, then all holds, then what is asked of them.

use super::advance::{Loadable, Nobody, Problem, Steps, Tried, Watch, advance};
use super::finish::{self, Relaxation};
use super::fit::{self, Nodes};
use super::glimpses::Glimpses;
use super::outcome::{Failure, Outcome};
use super::record::{self, Piece, Question};
use super::scenario::{Options, Scenario};
use super::sealed::{Ending, Held, Moving, Test};
use crate::lanes::{Lanes, WIDTH};
use pulp::Arch;

/// Working memory of a chunk, kept from one to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<Test>,
    problems: Vec<Problem<1>>,
    peaks: Vec<f64>,
    log: Vec<Tried<1>>,
    glimpses: Glimpses,
    pieces: Vec<Piece>,
    nodes: Nodes,
}

/// Keeps the steps and glimpses of them.
struct Both<'a> {
    log: &'a mut Vec<Tried<1>>,
    glimpses: &'a mut Glimpses,
}

impl Watch<1, Held<'_>> for Both<'_> {
    #[inline(always)]
    fn see<const FUSED: bool>(&mut self, system: &Held, tried: Tried<1>) {
        self.glimpses.see::<FUSED>(system, tried);
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
    let Memory { tests, problems, peaks, log, glimpses, pieces, nodes } = memory;
    let relative = options.relative_tolerance;
    tests.clear();
    problems.clear();
    log.clear();
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
        glimpses.clear();
        glimpses.awake = true;
        advance(arch, &Held::new(tests), problems, relative, &mut Both { log, glimpses });
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
        for (lane, &(row, duration)) in rows.iter().enumerate() {
            let (test, problem) = (&tests[at(lane)], &problems[at(lane)]);
            out[row as usize] = match problem.failure {
                Some(reason) => Outcome::failed(reason),
                None => {
                    let (peak, end) = (peak[lane], end[lane]);
                    let scenario = &scenarios[row as usize];
                    let mut regression = None;
                    if options.fit && end > 0.0 {
                        pieces.clear();
                        glimpses.pieces(problem.steps, scenario.push_time_s, pieces);
                        let question = Question {
                            push_end: scenario.push_time_s,
                            duration,
                            delay: 0.0,
                            expands: test.root_rate > 0.0,
                            before: [scenario.initial_pressure_pa, 0.0],
                            single_samples: 0,
                            guess: Some(fit::time_constant(test.rate, 1.0 - test.closed.ambient_temperature / peak)),
                        };
                        regression = record::regression(arch, pieces, &question, nodes);
                    }
                    let ending = Ending {
                        scenario,
                        duration,
                        peak,
                        end,
                        pressure_per_temperature: test.closed.mass_gas_constant / test.held_volume,
                        settling: settling[lane],
                        regression,
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
