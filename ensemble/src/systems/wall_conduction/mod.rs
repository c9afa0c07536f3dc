//! Tests with a conducting wall and no other effect: the push by specialised equations ([`push`]), the hold by [`crate::conduction`], and
//! settling time and samples by the steps' polynomials ([`dense`]). Those whose hold may turn, or for which the steps do not suffice,
//! are left to the general integrator, which finds all turns of a record.

mod dense;
mod push;

use crate::batch::Batch;
use crate::conduction::lengths::{LEVELS, OF_NODES};
use crate::conduction::response::Response;
use crate::conduction::step::GasAndWall;
use crate::conduction::{HoldSteps, relative, through};
use crate::ending::HoldsEnded;
use crate::instructions::Wide;
use crate::integrator::advance::advance;
use crate::integrator::problem::Problem;
use crate::lanes::{Lanes, WIDTH};
use crate::outcome::Outcome;
use crate::regression::Records;
use crate::systems::list::Method;
use chamber::effects::wall_conduction::{KERNEL, MODES};
use core::hint::black_box;
use dense::{Passed, Settle};
use pulp::{Simd, WithSimd};
pub use push::EFFECT;
use push::{Moving, N, Test};

/// Working memory, kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<Test>,
    problems: Vec<Problem<N>>,
    /// Indices of the tests whose holds are not solved yet.
    open: Vec<usize>,
    /// Responses over the last steps of the holds, which most rows of a study share.
    last: Box<Response<Lanes>>,
    steps: Vec<Passed>,
    records: Records,
}

/// T in a state.
fn temperature(state: &[f64; N]) -> f64 {
    1.0 / (state[0] * state[0])
}

/// Whether a hold from a state is monotone.
fn goes_one_way(state: &[f64; N], wall: f64) -> bool {
    let (temperature, modes) = (temperature(state), &state[1..]);
    let excess = modes.iter().zip(&KERNEL).fold(temperature - wall, |left, (mode, of)| left - mode * of.weight);
    temperature < f64::INFINITY && excess.abs() > 0.0 && modes.iter().all(|mode| mode * excess >= 0.0)
}

impl Method for Memory {
    fn solve(&mut self, batch: Batch, rows: &mut [u32], left: &mut Vec<u32>, out: &mut [Outcome]) {
        let Batch { arch, scenarios, options } = batch;
        let relative = relative(options);
        let Self { tests, problems, open, .. } = self;
        tests.clear();
        problems.clear();
        for &row in &*rows {
            let s = &scenarios[row as usize];
            let test = Test::new(s);
            problems.push(test.push(s, relative));
            tests.push(test);
        }
        advance(arch, &Moving::default(), tests, problems, relative, &mut ());
        open.clear();
        for (index, ((problem, test), row)) in problems.iter().zip(&*tests).zip(&*rows).enumerate() {
            if problem.failure.is_none() && goes_one_way(&problem.state, test.gas.closed.ambient_temperature) {
                open.push(index);
            } else {
                left.push(*row);
            }
        }
        for level in 0..LEVELS {
            for group in std::mem::take(&mut self.open).chunks(WIDTH) {
                hold(batch, self, level, rows, group, out);
            }
        }
        left.extend(self.open.drain(..).map(|index| rows[index]));
    }
}

/// Solves the holds of up to [`WIDTH`] tests with steps of a level; tests for which these do not suffice stay open.
fn hold(
    Batch { arch, scenarios, options }: Batch,
    memory: &mut Memory,
    level: usize,
    rows: &[u32],
    group: &[usize],
    out: &mut [Outcome],
) {
    let Memory { tests, problems, open, last, steps, records, .. } = memory;
    let at = |lane: usize| group[lane.min(group.len() - 1)];
    let test = |lane: usize| &tests[at(lane)];
    let scenario = |lane: usize| &scenarios[rows[at(lane)] as usize];
    let parts = OF_NODES.parted_all(level, |lane| scenario(lane).hold_s());
    let length = Lanes::from_fn(|lane| parts[lane].1);
    last.reach(length, arch);
    let pushed = Lanes::from_fn(|lane| temperature(&problems[at(lane)].state));
    let wall = Lanes::from_fn(|lane| test(lane).gas.closed.ambient_temperature);
    let [cooling, feed] = [0, 1].map(|of| Lanes::from_fn(|lane| test(lane).held[of]));
    let modes: [Lanes; MODES] =
        core::array::from_fn(|mode| Lanes::from_fn(|lane| problems[at(lane)].state[1 + mode] * KERNEL[mode].weight));
    let counts = Lanes::from_fn(|lane| parts[lane].0 as f64);
    steps.clear();
    let [end, reached] = arch.dispatch(Wide(FollowHolds {
        gas: GasAndWall::of([cooling, feed], wall, pushed, modes),
        steps: HoldSteps { growth: OF_NODES, level, counts, last, relative: relative(options) },
        passed: steps,
    }));
    let [settling, good] = arch.dispatch(Wide(Settle { steps, ends: [pushed, end] }));
    let pressure_per_temperature = Lanes::from_fn(|lane| test(lane).gas.pressure_per_temperature());
    let regressions = options.fit.then(|| {
        let rate = Lanes::from_fn(|lane| test(lane).gas.rate);
        let excess = Lanes::from_fn(|lane| 1.0 - wall[lane] / pushed[lane]);
        let push = Lanes::from_fn(|lane| scenario(lane).push_time_s);
        let (relaxation, per_temperature) = ([rate, excess], pressure_per_temperature);
        let guess = arch.dispatch(Wide(dense::Record { steps, push, per_temperature, relaxation, records }));
        records.fit(arch, guess)
    });
    let ended = HoldsEnded { wall, pushed, end, pressure_per_temperature, settling, regressions };
    for (lane, &index) in group.iter().enumerate() {
        let is_solved = reached[lane] > 0.0 && good[lane] > 0.0;
        if !is_solved {
            open.push(index);
            continue;
        }
        let (row, scenario) = (rows[index], scenario(lane));
        let after = tests[index].gas.after_push(row, scenario, pushed[lane], problems[index].energy);
        out[after.row as usize] = after.outcome(&ended.ending(lane, scenario));
    }
}

/// Solves holds, one per lane: returns the temperatures at their ends, K, and whether they are good.
struct FollowHolds<'a> {
    gas: GasAndWall,
    steps: HoldSteps<'a>,
    passed: &'a mut Vec<Passed>,
}

impl WithSimd for FollowHolds<'_> {
    type Output = [Lanes; 2];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> [Lanes; 2] {
        let Self { mut gas, steps, passed } = self;
        let good = through(&mut gas, steps, passed);
        black_box([gas.temperature, good])
    }
}
