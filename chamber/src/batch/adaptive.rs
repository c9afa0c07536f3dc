//! Sealed tests by adaptive integration in lanes: all pushes of a chunk, then all holds, then what is asked of them.

use super::advance::{Loadable, Log, Problem, Steps, advance};
use super::finish::{self, Relaxation};
use super::fit;
use super::outcome::{Failure, Outcome};
use super::record::{Piece, Question, Record};
use super::scenario::{Options, Scenario};
use super::sealed::{Held, Moving, Test};
use crate::lanes::{Lanes, WIDTH};
use pulp::Arch;

/// Working memory of a chunk, kept from one to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<Test>,
    problems: Vec<Problem<1>>,
    peaks: Vec<f64>,
    log: Log<1>,
    pieces: Vec<Piece<1>>,
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
    let Memory { tests, problems, peaks, log, pieces } = memory;
    let relative = options.relative_tolerance;
    tests.clear();
    problems.clear();
    log.iter_mut().for_each(Vec::clear);
    for &(row, _) in rows {
        let s = &scenarios[row as usize];
        tests.push(Test::new(s));
        problems.push(Problem {
            length: s.push_time_s,
            state: [s.initial_temperature_k],
            absolute: [0.0],
            gap: 0.0,
            steps: Steps::default(),
            failure: None,
        });
    }
    advance::<1, false, _>(arch, &Moving::new(tests), problems, relative, log);
    peaks.clear();
    for (problem, (_, duration)) in problems.iter_mut().zip(rows) {
        peaks.push(problem.state[0]);
        problem.length = duration - problem.length;
    }
    advance::<1, true, _>(arch, &Held::new(tests), problems, relative, log);

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
                    let per_temperature = test.mass_gas_constant / test.held_volume;
                    let (peak, end) = (peak[lane], end[lane]);
                    let settled = (end - test.wall).abs() <= 0.01 * (peak - end).abs() || peak == end;
                    let scenario = &scenarios[row as usize];
                    let mut regression = None;
                    if options.fit && end > 0.0 {
                        let mut record = Record::new(system.clone(), pieces, 0.0);
                        record.add(arch, log, problem.steps, at(lane), scenario.push_time_s);
                        regression = record.answer(
                            arch,
                            &Question {
                                push_end: scenario.push_time_s,
                                duration,
                                delay: 0.0,
                                expands: test.root_rate > 0.0,
                                before: [scenario.initial_pressure_pa, 0.0],
                                guess: Some(1.0 / test.rate),
                            },
                        );
                    }
                    let fit = regression.and_then(|a| a.regression).and_then(|regression| {
                        let positions = [scenario.initial_position_m, scenario.final_position_m];
                        fit::steps(scenario, positions, scenario.initial_pressure_pa, regression)
                    });
                    Outcome {
                        pressure_peak_pa: peak * per_temperature,
                        pressure_final_pa: end * per_temperature,
                        temperature_final_k: end,
                        temperature_peak_k: peak,
                        fit,
                        settling_time_s: settled.then(|| settling[lane]),
                        energy_error: problem.gap,
                        duration_s: duration,
                        exact: false,
                        status: if end > 0.0 { Ok(()) } else { Err(Failure::Empty) },
                    }
                }
            };
        }
    }
}
