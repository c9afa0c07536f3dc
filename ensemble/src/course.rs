//! Rows of any kind by adaptive integration in lanes: stretch after stretch of all rows of a chunk, then what is asked
//! of their records.

use crate::advance::{LONGEST, Problem, Steps, advance};
use crate::filter::Sensor;
use crate::finish::SETTLED;
use crate::fit;
use crate::general::{self, General, Row};
use crate::history::{History, Knot};
use crate::outcome::{Failure, Outcome, closure};
use crate::plan::Plan;
use crate::reader::{self, Answer, ROUNDING, Traces, seen_from};
use crate::regression::Regression;
use crate::scenario::{Options, Scenario};
use crate::step::View;
use chamber::balance::{self, Balance, ENERGY, MASS, STATES};
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::simulate::tolerance;
use pulp::Arch;

/// Share of the initial mass below which a chamber whose equations cannot be followed further has run empty.
const EMPTY: f64 = 0.01;
/// Steps of all lanes that are kept at most, 768 bytes each; the fewest rows together keep as many as they need.
const HISTORY: usize = 1 << 14;
/// The fewest rows that are solved together.
const FEWEST: usize = 16;
/// Knots after which traces are read.
const KNOTS: usize = 1 << 13;

/// A row that is being integrated, stretch by stretch.
struct Course<'a, const N: usize> {
    row: u32,
    scenario: &'a Scenario,
    plan: &'a Plan,
    balance: Balance,
    sensor: Sensor,
    /// Number of states that count in the error norm.
    counted: f64,
    /// All states at its begin.
    initial: [f64; STATES],
    state: [f64; N],
    absolute: [f64; N],
    /// Energy that the gas has received as heat and enthalpy less its work, and the magnitudes of its work, J.
    energy: [f64; 2],
    /// Where the history has each stretch's steps, and what is seen at its begin.
    steps: Vec<(Steps, View<f64>)>,
    failure: Option<Failure>,
}

/// Working memory, kept from one chunk to the next.
#[derive(Default)]
pub struct Memory {
    history: History,
    reader: reader::Memory,
}

/// Runs checked rows (number and plan) that have their area law, and whether they have a profile, in common. `set` are
/// the effects on the gas, `BITS` the same.
pub fn run<const N: usize, const BITS: u32>(
    arch: Arch,
    memory: &mut Memory,
    set: EffectSet,
    rows: &[(u32, Plan)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    let Memory { history, reader } = memory;
    history.limit = (rows.len() > FEWEST).then_some(HISTORY);
    let Some(courses) = integrate::<N, BITS>(arch, history, set, rows, scenarios, options) else {
        // Too many steps to keep: fewer rows at a time.
        for rows in rows.chunks(rows.len().div_ceil(2).next_multiple_of(FEWEST)) {
            run::<N, BITS>(arch, memory, set, rows, scenarios, options, out);
        }
        return;
    };
    let mut rest = &courses[..];
    while !rest.is_empty() {
        let mut traces = Traces::new(reader);
        while let Some(course) = rest.get(traces.len()).filter(|_| traces.knots() < KNOTS) {
            course.trace(history, &mut traces);
        }
        let (group, others) = rest.split_at(traces.len());
        rest = others;
        let answers = traces.answers(arch);
        let regressions = if options.fit {
            traces.regressions(arch, &answers, |course| group[course].time_constant())
        } else {
            vec![None; answers.len()]
        };
        for ((c, answer), regression) in group.iter().zip(&answers).zip(regressions) {
            out[c.row as usize] = match (c.failure, answer) {
                (Some(reason), _) => Outcome::failed(reason),
                (None, None) => Outcome::failed(Failure::EndsInPush),
                (None, Some(answer)) => c.outcome(answer, regression),
            };
        }
    }
}

/// Integrates rows from stretch to stretch; none where the history is too long.
fn integrate<'a, const N: usize, const BITS: u32>(
    arch: Arch,
    history: &mut History,
    set: EffectSet,
    rows: &'a [(u32, Plan)],
    scenarios: &'a [Scenario],
    options: &Options,
) -> Option<Vec<Course<'a, N>>> {
    let relative = options.relative_tolerance;
    let mut courses: Vec<Course<N>> =
        rows.iter().map(|(row, plan)| Course::new::<BITS>(*row, &scenarios[*row as usize], plan, relative)).collect();
    history.clear();
    let mut problems: Vec<Problem<N>> = Vec::with_capacity(courses.len());
    for index in 0.. {
        let active = |c: &Course<N>| c.failure.is_none() && index < c.plan.stretches.len();
        let systems: Vec<Row> = courses
            .iter()
            .filter(|c| active(c))
            .map(|c| Row { balance: &c.balance, stretch: &c.plan.stretches[index], counted: c.counted })
            .collect();
        if systems.is_empty() {
            break;
        }
        problems.clear();
        for c in courses.iter().filter(|c| active(c)) {
            let mut problem = Problem::new(c.plan.stretches[index].length, c.state, c.absolute);
            if index >= seen_from(c.plan, &c.sensor) {
                problem.longest = LONGEST * problem.length;
            }
            problems.push(problem);
        }
        let system = General::<N, BITS>::new(&systems, set);
        history.awake = courses.iter().any(|c| index >= seen_from(c.plan, &c.sensor));
        advance(arch, &system, &mut problems, relative, history);
        if history.is_at_limit() {
            return None;
        }
        for (c, problem) in courses.iter_mut().filter(|c| active(c)).zip(&problems) {
            c.take(problem);
        }
    }
    Some(courses)
}

/// Boundary of the chamber at the end of a stretch, SI units.
struct End {
    position: f64,
    volume: f64,
    ambient_temperature: f64,
}

impl<'a, const N: usize> Course<'a, N> {
    fn new<const BITS: u32>(row: u32, scenario: &'a Scenario, plan: &'a Plan, relative: f64) -> Self {
        let (pressure, temperature) = (scenario.initial_pressure_pa, scenario.initial_temperature_k);
        let initial = balance::state_at(&scenario.chamber, &plan.stretches[0].boundary(0.0), pressure, temperature);
        let absolute = tolerance(relative, &initial).absolute;
        let active = scenario.chamber.active();
        let of_gas = crate::on_the_gas(active);
        Self {
            row,
            scenario,
            plan,
            balance: Balance::of(scenario.chamber),
            sensor: Sensor::new(active, &scenario.chamber.effects),
            counted: general::states(of_gas.bits()) as f64,
            initial,
            state: General::<N, BITS>::states(&initial),
            absolute: General::<N, BITS>::tolerances(&initial, &absolute),
            energy: [0.0; 2],
            steps: Vec::with_capacity(plan.stretches.len()),
            failure: None,
        }
    }

    /// Goes on from where a stretch has ended.
    fn take(&mut self, problem: &Problem<N>) {
        self.state = problem.state;
        let [received, work] = problem.energy;
        self.energy = [self.energy[0] + (received - work), self.energy[1] + work.abs()];
        self.steps.push((problem.steps, problem.view));
        let left = self.mass() / self.initial[MASS];
        self.failure = match problem.failure {
            None if !positive(self.state[MASS]) || !positive(self.state[ENERGY]) => Some(Failure::Empty),
            Some(_) if left.is_nan() || left <= EMPTY => Some(Failure::Empty),
            other => other,
        };
    }

    /// Hands its trace over.
    fn trace(&self, history: &History, traces: &mut Traces<'a>) {
        traces.begin(self.plan, self.sensor, self.scenario.initial_pressure_pa);
        if self.failure.is_some() {
            return;
        }
        for (stretch, &(steps, view)) in self.steps.iter().enumerate().skip(seen_from(self.plan, &self.sensor)) {
            traces.stretch(stretch, |knots| {
                knots.push(Knot { at: 0.0, view });
                history.read(steps, knots);
            });
        }
    }

    /// Mass of the gas, kg.
    fn mass(&self) -> f64 {
        self.state[MASS] * self.state[MASS]
    }

    fn end(&self) -> End {
        let last = &self.plan.stretches[self.plan.stretches.len() - 1];
        let boundary = last.boundary(last.length);
        let (position, ambient_temperature) = (boundary.position, boundary.ambient_temperature);
        let chamber = &self.scenario.chamber;
        let ambient_temperature = effects::rest_temperature(&chamber.effects, ambient_temperature);
        End { position, volume: chamber.geometry.volume(position), ambient_temperature }
    }

    /// The chamber at its end once it has the temperature of its surroundings.
    fn at_rest(&self) -> Closed {
        let chamber = &self.scenario.chamber;
        let End { volume, ambient_temperature: ambient, .. } = self.end();
        let pressure = self.mass() * chamber.gas.gas_constant * ambient / volume;
        Closed::filled(chamber, pressure, ambient, volume, ambient)
    }

    /// τ of a tight chamber in its place, s.
    fn time_constant(&self) -> f64 {
        1.0 / self.at_rest().rate(self.end().volume)
    }

    /// The outcome from what the record has answered.
    fn outcome(&self, a: &Answer, regression: Option<Regression>) -> Outcome {
        let End { position, volume, ambient_temperature: ambient } = self.end();
        let distance = (a.pressure_peak - a.pressure_final).abs();
        let gas_pressure = self.at_rest().pressure(a.temperature_final, volume);
        let unsettled = gas_pressure * (1.0 - ambient / a.temperature_final).abs();
        let stands = a.settling == 0.0 && distance <= ROUNDING * a.pressure_final.abs();
        let positions = [self.plan.stretches[0].position, position];
        let start = self.scenario.initial_pressure_pa;
        Outcome {
            pressure_peak_pa: a.pressure_peak,
            pressure_final_pa: a.pressure_final,
            temperature_final_k: a.temperature_final,
            temperature_peak_k: a.temperature_peak,
            fit: regression.and_then(|found| fit::steps(self.scenario, positions, start, found)),
            settling_time_s: (unsettled <= SETTLED * distance || stands).then_some(a.settling),
            energy_error: closure(self.initial[ENERGY], self.state[ENERGY].powi(2), self.energy[0], self.energy[1]),
            duration_s: self.plan.duration,
            exact: false,
            status: Ok(()),
        }
    }
}

/// Whether a state is a positive number (NaN is not).
fn positive(value: f64) -> bool {
    value > 0.0
}
