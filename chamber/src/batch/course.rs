//! Rows of any kind by adaptive integration in lanes: stretch after stretch of all rows of a chunk, then what is asked
//! of each row's record.

use super::advance::{Problem, Steps, advance};
use super::fit;
use super::general::{General, Row, observe};
use super::glimpses::Glimpses;
use super::outcome::{Failure, Outcome};
use super::plan::Plan;
use super::record::{self, Answer, Piece, Question};
use super::regression::Records;
use super::scenario::{Options, Scenario};
use crate::balance::{self, Balance, ENERGY, MASS, STATES};
use crate::effects::EffectSet;
use crate::exact::Closed;
use crate::lanes::{Lanes, WIDTH};
use crate::simulate::tolerance;
use pulp::Arch;

/// Share of the initial mass below which a chamber whose equations cannot be followed further has run empty.
const EMPTY: f64 = 0.01;

/// One row on its way.
struct Course<'a, const N: usize> {
    row: u32,
    scenario: &'a Scenario,
    plan: &'a Plan,
    balance: Balance,
    initial: [f64; STATES],
    state: [f64; N],
    absolute: [f64; N],
    gap: f64,
    steps: Vec<Steps>,
    failure: Option<Failure>,
}

/// Working memory, kept from one chunk to the next.
#[derive(Default)]
pub struct Memory {
    glimpses: Glimpses,
    pieces: Vec<Piece>,
    records: Records,
}

/// Runs checked rows (number and plan) that have their area law, and whether they have a profile, in common.
pub fn run<const N: usize, const BITS: u32>(
    arch: Arch,
    memory: &mut Memory,
    set: EffectSet,
    rows: &[(u32, Plan)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    let relative = options.relative_tolerance;
    let places = General::<N, BITS>::PLACES;
    let mut courses: Vec<Course<N>> = Vec::with_capacity(rows.len());
    for (row, plan) in rows {
        let scenario = &scenarios[*row as usize];
        let (pressure, temperature) = (scenario.initial_pressure_pa, scenario.initial_temperature_k);
        let initial = balance::state_at(&scenario.chamber, &plan.stretches[0].boundary(0.0), pressure, temperature);
        let all = tolerance(relative, &initial).absolute;
        let (mut state, mut absolute) = ([0.0; N], [0.0; N]);
        for i in 0..N {
            (state[i], absolute[i]) = (initial[places[i]], all[places[i]]);
        }
        let steps = Vec::with_capacity(plan.stretches.len());
        let balance = Balance::of(scenario.chamber);
        courses.push(Course {
            row: *row,
            scenario,
            plan,
            balance,
            initial,
            state,
            absolute,
            gap: 0.0,
            steps,
            failure: None,
        });
    }
    let Some(first) = courses.first() else { return };
    let area_law = first.scenario.chamber.geometry.area_law;

    let Memory { glimpses, pieces, records } = memory;
    glimpses.clear();
    let mut problems: Vec<Problem<N>> = Vec::with_capacity(courses.len());
    for index in 0.. {
        let active = |c: &Course<N>| c.failure.is_none() && index < c.plan.stretches.len();
        let systems: Vec<Row> =
            courses.iter().filter(|c| active(c)).map(|c| (&c.balance, &c.plan.stretches[index])).collect();
        if systems.is_empty() {
            break;
        }
        problems.clear();
        for c in courses.iter().filter(|c| active(c)) {
            let mut problem = Problem::new(c.plan.stretches[index].length, c.state, c.absolute);
            problem.gap = c.gap;
            problems.push(problem);
        }
        let system = General::<N, BITS>::new(&systems, set, area_law);
        glimpses.awake = courses.iter().any(|c| index >= seen_from(c.plan));
        advance(arch, &system, &mut problems, relative, glimpses);
        let mut solved = problems.iter();
        for c in courses.iter_mut().filter(|c| active(c)) {
            if let Some(problem) = solved.next() {
                (c.state, c.gap, c.failure) = (problem.state, problem.gap, problem.failure);
                c.steps.push(problem.steps);
                let left = c.state[MASS] / c.initial[MASS];
                c.failure = match c.failure {
                    None if !positive(c.state[MASS]) || !positive(c.state[ENERGY]) => Some(Failure::Empty),
                    Some(_) if left.is_nan() || left <= EMPTY => Some(Failure::Empty),
                    other => other,
                };
            }
        }
    }

    for courses in courses.chunks(WIDTH) {
        records.clear();
        let mut guess = Lanes::from(1.0);
        let mut answers = [None; WIDTH];
        for (lane, c) in courses.iter().enumerate().filter(|(_, c)| c.failure.is_none()) {
            let question = question(set, c);
            pieces.clear();
            for (stretch, steps) in c.plan.stretches.iter().zip(&c.steps).skip(seen_from(c.plan)) {
                glimpses.pieces(*steps, stretch.elapsed - c.plan.delay, pieces);
            }
            answers[lane] = record::answer(arch, pieces, &question);
            if let (true, Some(answer)) = (options.fit, &answers[lane]) {
                record::add_to(records, lane, pieces, &question, answer.peak_time);
                guess[lane] = 1.0 / c.at_rest().rate(c.end().volume);
            }
        }
        let found = options.fit.then(|| records.fit(arch, guess));
        for (lane, c) in courses.iter().enumerate() {
            let regression = found.as_ref().and_then(|found| found.lane(lane));
            out[c.row as usize] = match (c.failure, &answers[lane]) {
                (Some(reason), _) => Outcome::failed(reason),
                (None, None) => Outcome::failed(Failure::EndsInPush),
                (None, Some(answer)) => outcome(c, answer, regression),
            };
        }
    }
}

/// The first stretch of a row that is looked into.
fn seen_from(plan: &Plan) -> usize {
    plan.window[0].min(plan.hold)
}

/// How a row's boundary ends.
struct End {
    position: f64,
    volume: f64,
    ambient_temperature: f64,
}

impl<const N: usize> Course<'_, N> {
    fn end(&self) -> End {
        let last = &self.plan.stretches[self.plan.stretches.len() - 1];
        let boundary = last.boundary(last.length);
        let (position, ambient_temperature) = (boundary.position, boundary.ambient_temperature);
        End { position, volume: self.scenario.chamber.geometry.volume(position), ambient_temperature }
    }

    /// The chamber at its end once it has the temperature of its surroundings.
    fn at_rest(&self) -> Closed {
        let chamber = &self.scenario.chamber;
        let End { volume, ambient_temperature: ambient, .. } = self.end();
        let pressure = self.state[MASS] * chamber.gas.gas_constant * ambient / volume;
        Closed::filled(chamber, pressure, ambient, volume, ambient)
    }
}

/// What is asked of a row's record.
fn question<const N: usize>(set: EffectSet, c: &Course<N>) -> Question {
    let plan = c.plan;
    let shown = |elapsed| observe(set, &c.balance, &plan.stretches[0], 0.0, &c.initial, elapsed)[0];
    Question {
        push_end: plan.push_end,
        duration: plan.duration,
        delay: plan.delay,
        expands: plan.expands,
        before: [shown(0.0), shown(1.0) - shown(0.0)],
    }
}

/// A row's outcome from what its record has answered.
fn outcome<const N: usize>(c: &Course<N>, a: &Answer, regression: Option<[f64; 3]>) -> Outcome {
    let plan = c.plan;
    let End { position, volume, ambient_temperature: ambient } = c.end();
    let distance = (a.pressure_peak - a.pressure_final).abs();
    let gas_pressure = c.at_rest().pressure(a.temperature_final, volume);
    let unsettled = gas_pressure * (1.0 - ambient / a.temperature_final).abs();
    let positions = [plan.stretches[0].position, position];
    let fit = regression.and_then(|found| fit::steps(c.scenario, positions, c.scenario.initial_pressure_pa, found));
    Outcome {
        pressure_peak_pa: a.pressure_peak,
        pressure_final_pa: a.pressure_final,
        temperature_final_k: a.temperature_final,
        temperature_peak_k: a.temperature_peak,
        fit,
        settling_time_s: (unsettled <= 0.01 * distance || distance == 0.0).then_some(a.settling),
        energy_error: c.gap,
        duration_s: plan.duration,
        exact: false,
        status: Ok(()),
    }
}

/// Whether a state is a positive number (NaN is not).
fn positive(value: f64) -> bool {
    value > 0.0
}
