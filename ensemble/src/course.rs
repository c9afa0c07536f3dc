//! Rows of any kind by adaptive integration in lanes: stretch after stretch of all rows of a chunk, then what is asked
//! of their records.

use crate::advance::{FIRST_OF_BENT, LONGEST, LONGEST_OF_MOVE, Problem, Steps, advance};
use crate::conduction;
use crate::filter::Sensor;
use crate::fit;
use crate::general::{self, General, Row};
use crate::history::{History, Knot};
use crate::outcome::SETTLED;
use crate::outcome::{Failure, Outcome, closure};
use crate::plan::Plan;
use crate::reader::{self, Answer, Bends, ROUNDING, Traces, seen_from};
use crate::regression::Regression;
use crate::relaxing_rows::{self, AfterPush};
use crate::scenario::Scenario;
use crate::step::View;
use crate::{Batch, Kind};
use chamber::balance::{Balance, ENERGY, MASS};
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::simulate::tolerance;

/// Share of the initial mass below which a chamber whose equations cannot be followed further has run empty.
const EMPTY: f64 = 0.01;
/// Steps of all lanes that are kept at most, 768 bytes each; the fewest rows together keep as many as they need.
const HISTORY: usize = 1 << 14;
/// The fewest rows that are solved together.
const FEWEST: usize = 16;
/// Knots after which traces are read: they and what is made of them stay in a core's nearest cache.
const KNOTS: usize = 1 << 11;

/// A row that is being integrated, stretch by stretch.
struct Course<'a, const N: usize> {
    row: u32,
    scenario: &'a Scenario,
    plan: &'a Plan,
    balance: &'a Balance,
    sensor: Sensor,
    bends: Bends<'a>,
    /// Number of states that count in the error norm.
    counted: f64,
    /// Mass, kg, and internal energy, J, at its begin.
    initial: [f64; 2],
    state: [f64; N],
    /// Mass, kg, and internal energy, J, in that state.
    contents: [f64; 2],
    absolute: [f64; N],
    /// Energy that the gas has received as heat and enthalpy less its work, and the magnitudes of its work, J.
    energy: [f64; 2],
    /// The place of its first stretch among the [`Passed`] ones, and how many it has passed.
    first: usize,
    passed: usize,
    failure: Option<Failure>,
}

/// Where the history has the steps of a stretch that a row has passed, and what is seen at its begin.
type Passed = (Steps, View<f64>);

/// Working memory, kept from one chunk to the next.
#[derive(Default)]
pub struct Memory {
    balances: Vec<Balance>,
    passed: Vec<Passed>,
    history: History,
    reader: reader::Memory,
    relaxing: relaxing_rows::Memory,
    conduction: conduction::Memory,
}

/// Runs checked rows (number and plan) that have their area law and their kind in common. `set` are the effects on the gas,
/// `BITS` the same.
pub fn run<const N: usize, const BITS: u32>(
    batch: Batch,
    memory: &mut Memory,
    set: EffectSet,
    kind: Kind,
    rows: &[(u32, Plan)],
    out: &mut [Outcome],
) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { balances, passed, history, reader, relaxing, conduction } = memory;
    balances.resize(rows.len(), Balance::of(scenarios[rows[0].0 as usize].chamber));
    for (balance, (row, _)) in balances.iter_mut().zip(rows) {
        balance.chamber = scenarios[*row as usize].chamber;
        balance.work_out();
    }
    history.limit = (rows.len() > FEWEST).then_some(HISTORY);
    let courses: Vec<Course<N>> = Course::all::<BITS>(rows, balances, scenarios, options.relative_tolerance);
    let relaxes = kind == Kind::Relaxing;
    let stretches = if relaxes { 1 } else { usize::MAX };
    let remembers = (kind == Kind::Remembering).then_some(conduction);
    let Some(courses) = integrate::<N, BITS>(batch, history, passed, set, courses, stretches, remembers) else {
        // Too many steps to keep: fewer rows at a time.
        for rows in rows.chunks(rows.len().div_ceil(2).next_multiple_of(FEWEST)) {
            run::<N, BITS>(batch, memory, set, kind, rows, out);
        }
        return;
    };
    if relaxes {
        let mut pushed: Vec<AfterPush> = courses.iter().map(Course::after_push).collect();
        return relaxing_rows::run(batch, relaxing, set, &mut pushed, out);
    }
    let mut rest = &courses[..];
    while !rest.is_empty() {
        let mut traces = Traces::new(reader);
        while let Some(course) = rest.get(traces.len()).filter(|_| traces.knots() < KNOTS) {
            course.trace(history, passed, &mut traces);
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

/// Integrates rows over so many stretches at most; none where the history is too long. With walls that remember, `remembers`
/// has the memory for their holds.
fn integrate<'a, const N: usize, const BITS: u32>(
    batch: Batch,
    history: &mut History,
    passed: &mut Vec<Passed>,
    set: EffectSet,
    mut courses: Vec<Course<'a, N>>,
    stretches: usize,
    mut remembers: Option<&mut conduction::Memory>,
) -> Option<Vec<Course<'a, N>>> {
    history.clear();
    passed.clear();
    let all = courses.last().map_or(0, |last| last.first + last.plan.stretches.len());
    passed.resize(all, (Steps::default(), View { value: [0.0; 2], slope: [0.0; 2] }));
    let mut problems: Vec<Problem<N>> = Vec::with_capacity(courses.len());
    for index in 0..stretches {
        let mut active: Vec<usize> = (0..courses.len()).filter(|&c| courses[c].goes_on(index)).collect();
        if active.is_empty() {
            break;
        }
        history.awake = courses.iter().any(|c| index >= seen_from(c.plan, &c.sensor));
        if General::<N, BITS>::REMEMBERS
            && let Some(memory) = &mut remembers
        {
            let rests = |c: &usize| courses[*c].plan.stretches[index].velocity == 0.0;
            let (held, mut others): (Vec<usize>, Vec<usize>) = active.iter().partition(|c| rests(c));
            let systems: Vec<Row> = held.iter().map(|&c| courses[c].system(index)).collect();
            problems.clear();
            problems.extend(held.iter().map(|&c| courses[c].problem(index)));
            let levels: Vec<usize> = held.iter().map(|&c| conduction::coarsest(&courses[c].sensor)).collect();
            let places = General::<N, BITS>::places_of_wall();
            let solved = conduction::hold(batch, memory, set, places, (&systems, &levels), &mut problems, history);
            for ((&c, problem), solved) in held.iter().zip(&problems).zip(solved) {
                if solved {
                    courses[c].pass::<BITS>(index, problem, passed);
                } else {
                    others.push(c);
                }
            }
            active = others;
            if active.is_empty() {
                continue;
            }
        }
        let systems: Vec<Row> = active.iter().map(|&c| courses[c].system(index)).collect();
        problems.clear();
        problems.extend(active.iter().map(|&c| courses[c].problem(index)));
        let system = General::<N, BITS>::new(&systems, set);
        advance(batch.arch, &system, &mut problems, batch.options.relative_tolerance, history);
        if history.is_at_limit() {
            return None;
        }
        for (&c, problem) in active.iter().zip(&problems) {
            courses[c].pass::<BITS>(index, problem, passed);
        }
    }
    (!history.is_at_limit()).then_some(courses)
}

/// Boundary of the chamber at the end of a stretch, SI units.
struct End {
    position: f64,
    volume: f64,
    ambient_temperature: f64,
}

impl<'a, const N: usize> Course<'a, N> {
    /// Rows at their begin.
    fn all<const BITS: u32>(
        rows: &'a [(u32, Plan)],
        balances: &'a [Balance],
        scenarios: &'a [Scenario],
        relative: f64,
    ) -> Vec<Self> {
        let mut first = 0;
        let begin = |((row, plan), balance): (&'a (u32, Plan), &'a Balance)| {
            let scenario = &scenarios[*row as usize];
            let (pressure, temperature) = (scenario.initial_pressure_pa, scenario.initial_temperature_k);
            let of_gas = crate::on_the_gas(plan.active);
            let states = balance.state_at(of_gas, &plan.stretches[0].boundary(0.0), pressure, temperature);
            let absolute = tolerance(relative, &states).absolute;
            let initial = [states[MASS], states[ENERGY]];
            first += plan.stretches.len();
            Self {
                row: *row,
                scenario,
                plan,
                balance,
                sensor: Sensor::new(plan.active, &scenario.chamber.effects),
                bends: Bends::new(plan.active, &scenario.chamber.effects),
                counted: general::states(of_gas.bits() | BITS & general::TIGHT) as f64,
                initial,
                state: General::<N, BITS>::states(&states),
                contents: initial,
                absolute: General::<N, BITS>::tolerances(&states, &absolute),
                energy: [0.0; 2],
                first: first - plan.stretches.len(),
                passed: 0,
                failure: None,
            }
        };
        rows.iter().zip(balances).map(begin).collect()
    }

    /// What the integrator needs of it for a stretch.
    fn system(&self, stretch: usize) -> Row<'_> {
        let stretch = &self.plan.stretches[stretch];
        Row { balance: self.balance, stretch, counted: self.counted, mass: self.initial[MASS] }
    }

    /// The same as an initial value problem.
    fn problem(&self, index: usize) -> Problem<N> {
        let stretch = &self.plan.stretches[index];
        let mut problem = Problem::new(stretch.length, self.state, self.absolute);
        if index >= seen_from(self.plan, &self.sensor) {
            problem.longest = LONGEST * stretch.length;
        } else if stretch.velocity != 0.0 {
            problem.longest = LONGEST_OF_MOVE * stretch.length;
        }
        let remembers = !self.plan.active.intersection(effects::REMEMBERING).is_empty();
        if index == 0 && (self.plan.starts_singular || remembers) {
            problem.first = FIRST_OF_BENT * stretch.length;
        }
        problem
    }

    /// Whether it goes through a stretch.
    fn goes_on(&self, index: usize) -> bool {
        self.failure.is_none() && index < self.plan.stretches.len()
    }

    /// Goes on from where a stretch has ended, whose steps it notes.
    fn pass<const BITS: u32>(&mut self, index: usize, problem: &Problem<N>, passed: &mut [Passed]) {
        passed[self.first + index] = (problem.steps, problem.view);
        self.take::<BITS>(problem);
    }

    /// Goes on from a problem's end.
    fn take<const BITS: u32>(&mut self, problem: &Problem<N>) {
        self.contents = General::<N, BITS>::mass_and_energy(&problem.state, self.initial[MASS]);
        self.state = problem.state;
        let [received, work] = problem.energy;
        self.energy = [self.energy[0] + (received - work), self.energy[1] + work.abs()];
        self.passed += 1;
        let left = self.contents[MASS] / self.initial[MASS];
        self.failure = match problem.failure {
            None if !General::<N, BITS>::holds_gas(&self.state) => Some(Failure::Empty),
            Some(_) if left.is_nan() || left <= EMPTY => Some(Failure::Empty),
            other => other,
        };
    }

    /// How its push has ended, where only that was integrated.
    fn after_push(&self) -> AfterPush {
        AfterPush {
            row: self.row,
            duration: self.plan.duration,
            relaxations: (self.plan.duration - self.plan.push_end) / self.time_constant(),
            mass: self.contents[MASS],
            energy: [self.initial[ENERGY], self.contents[ENERGY]],
            received: self.energy,
            failure: self.failure,
        }
    }

    /// Hands its trace over.
    fn trace(&self, history: &History, passed: &[Passed], traces: &mut Traces<'a>) {
        traces.begin(self.plan, self.sensor, self.bends, self.scenario.initial_pressure_pa);
        if self.failure.is_some() {
            return;
        }
        let passed = &passed[self.first..self.first + self.passed];
        for (stretch, &(steps, view)) in passed.iter().enumerate().skip(seen_from(self.plan, &self.sensor)) {
            traces.stretch(stretch, |knots| {
                knots.push(Knot { at: 0.0, view, kink: false });
                history.read(steps, knots);
            });
        }
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
        let pressure = self.contents[MASS] * chamber.gas.gas_constant * ambient / volume;
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
        let gas_pressure = self.contents[MASS] * self.scenario.chamber.gas.gas_constant * a.temperature_final / volume;
        let to_be_lost = gas_pressure * (1.0 - ambient / a.temperature_final);
        let reading = self.sensor.shown(gas_pressure, self.plan.duration);
        let unsettled = self.bends.change(reading, to_be_lost).abs();
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
            energy_error: closure(self.initial[ENERGY], self.contents[ENERGY], self.energy[0], self.energy[1]),
            duration_s: self.plan.duration,
            exact: false,
            status: Ok(()),
        }
    }
}
