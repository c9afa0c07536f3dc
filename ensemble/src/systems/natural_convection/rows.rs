//! Solves tests with natural convection: by the push of [`super`] and a hold that is a series ([`hold`]) or, if that is not valid, an
//! integral over temperature ([`relaxation_rows`]).

use super::hold::{self, Ends, Holds, Solve};
use super::record::Record;
use super::{EFFECTS, NaturalConvectionTest};
use crate::batch::Batch;
use crate::ending::{AfterPush, HoldsEnded};
use crate::general::relaxation_rows;
use crate::instructions::Wide;
use crate::integrator::problem::Problem;
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::Outcome;
use crate::regression::Records;
use crate::systems::adaptive;
use crate::systems::list::Method;
use crate::systems::test_system::TestSystem;
use chamber::AreaLaw;

/// Working memory, kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<NaturalConvectionTest>,
    problems: Vec<Problem<2>>,
    /// Tests whose holds are series, with their indices, and the others.
    in_series: Vec<(usize, AfterPush)>,
    pushed: Vec<AfterPush>,
    records: Records,
    relaxing: relaxation_rows::Memory,
}

impl Method for Memory {
    fn solve(&mut self, batch: Batch, rows: &mut [u32], left: &mut Vec<u32>, out: &mut [Outcome]) {
        let law = |row: &u32| batch.scenarios[*row as usize].chamber.geometry.area_law;
        rows.sort_by_key(|row| law(row) == AreaLaw::Swept);
        for rows in rows.chunk_by(|a, b| law(a) == law(b)) {
            run(batch, self, rows, left, out);
        }
    }
}

/// Solves tests of one area law. Those whose pushes fail are left.
fn run(batch: Batch, memory: &mut Memory, rows: &[u32], left: &mut Vec<u32>, out: &mut [Outcome]) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { tests, problems, in_series, pushed, records, relaxing } = memory;
    adaptive::push(batch, rows, tests, problems);
    pushed.clear();
    in_series.clear();
    for (index, ((problem, test), &row)) in problems.iter().zip(&*tests).zip(rows).enumerate() {
        if problem.failure.is_some() {
            left.push(row);
            continue;
        }
        let (gas, temperature) = (test.gas(), problem.state[0] * problem.state[0]);
        let energy = test.energy_of_push(problem.energy);
        let after = gas.after_push(row, &scenarios[row as usize], temperature, energy);
        let wall = gas.closed.ambient_temperature;
        if after.failure.is_none() && hold::has_series(test.exponent, temperature, wall) {
            in_series.push((index, after));
        } else {
            pushed.push(after);
        }
    }
    relaxation_rows::run(batch, relaxing, EFFECTS, pushed, out);
    for group in in_series.chunks(WIDTH) {
        let at = |lane: usize| &group[lane.min(group.len() - 1)];
        let test = |lane: usize| &tests[at(lane).0];
        let scenario = |lane: usize| &scenarios[at(lane).1.row as usize];
        let per_temperature = Lanes::from_fn(|lane| test(lane).gas().pressure_per_temperature());
        let holds = Holds {
            exponent: Lanes::from_fn(|lane| test(lane).exponent),
            rate: Lanes::from_fn(|lane| test(lane).gas().rate),
            wall: Lanes::from_fn(|lane| test(lane).gas().closed.ambient_temperature),
            pushed: Lanes::from_fn(|lane| problems[at(lane).0].state[0] * problems[at(lane).0].state[0]),
            push: Lanes::from_fn(|lane| scenario(lane).push_time_s),
            hold: Lanes::from_fn(|lane| scenario(lane).hold_s()),
        };
        let ends = arch.dispatch(Wide(Solve(&holds)));
        let regressions = options.fit.then(|| {
            let guess = arch.dispatch(Wide(Record { holds: &holds, ends: &ends, per_temperature, records }));
            records.fit(arch, guess)
        });
        let (Holds { wall, pushed, .. }, Ends { end, settling, .. }) = (holds, ends);
        let pressure_per_temperature = per_temperature;
        let ended = HoldsEnded { wall, pushed, end, pressure_per_temperature, settling, regressions };
        for (lane, (_, after)) in group.iter().enumerate() {
            out[after.row as usize] = after.outcome(&ended.ending(lane, scenario(lane)));
        }
    }
}
