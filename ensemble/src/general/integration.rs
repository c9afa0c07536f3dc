//! Adaptive integration of rows in lanes: span by span for all rows of a chunk, then the evaluation of their records.

use crate::batch::Batch;
use crate::ending::AfterPush;
use crate::general::equations::{self, General, Row};
use crate::general::history::History;
use crate::general::kind::Kind;
use crate::general::relaxation_rows;
use crate::general::wall_conduction;
use crate::integrator::advance::{FIRST_OF_BENT, LONGEST, LONGEST_OF_MOVE, Watch, advance};
use crate::integrator::problem::{Problem, Steps};
use crate::integrator::step::View;
use crate::outcome::{Failure, Outcome, ROUNDING, Standing, closure, to_be_lost};
use crate::plan::{MOST_SPANS, Plan};
use crate::reader::{self, Bends, Knot, RowAnswer, Traces, seen_from};
use crate::regression::Regression;
use crate::regression::fit;
use crate::scenario::Scenario;
use crate::sensor::Sensor;
use crate::sets;
use chamber::balance::{Balances, ENERGY, MASS, STATES};
use chamber::card::Balance;
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::simulate::tolerance;

/// A chamber whose integration fails below this fraction of its initial mass has run empty.
const EMPTY: f64 = 0.01;
/// Largest number of kept steps of all lanes, 768 bytes each; unlimited for the smallest group of rows.
const HISTORY: usize = 1 << 14;
/// Smallest group of rows that is solved together.
const FEWEST: usize = 16;
/// Number of knots after which traces are read, so that they fit a core's nearest cache.
const KNOTS: usize = 1 << 11;

/// A row under integration.
struct IntegratedRow<'a> {
    row: u32,
    scenario: &'a Scenario,
    plan: &'a Plan,
    balance: &'a Balances,
    sensor: Sensor,
    bends: Bends<'a>,
    /// Number of states in the error norm.
    counted: f64,
    /// Initial mass, kg, and internal energy, J.
    initial: [f64; 2],
    /// Current mass, kg, and internal energy, J.
    contents: [f64; 2],
    /// Energy received as heat and enthalpy less work done, and the sum of the magnitudes of the work, J.
    energy: [f64; 2],
    /// For each span its steps in the history, and the view at its start.
    passed: [(Steps, View<f64>); MOST_SPANS],
    failure: Option<Failure>,
}

/// Current states of a row, and their absolute tolerances.
struct States<const N: usize> {
    state: [f64; N],
    absolute: [f64; N],
}

/// Working memory, kept from one chunk to the next.
#[derive(Default)]
pub struct Memory {
    balances: Vec<Balances>,
    history: History,
    reader: reader::Memory,
    relaxing: relaxation_rows::Memory,
    conduction: wall_conduction::Memory,
}

/// Solves checked rows (index and plan) of one area law and kind. `set` are the effects on the gas, all contained in `BITS`.
pub fn run<const N: usize, const BITS: u32>(
    batch: Batch,
    memory: &mut Memory,
    set: EffectSet,
    kind: Kind,
    rows: &[(u32, Plan)],
    out: &mut [Outcome],
) {
    let Memory { balances, history, reader, relaxing, conduction } = memory;
    work_out(balances, rows, batch.scenarios);
    history.limit = (rows.len() > FEWEST).then_some(HISTORY);
    let (mut integrated, mut states) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
    for ((row, plan), balance) in rows.iter().zip(&*balances) {
        let (mut row, all) = IntegratedRow::begin(*row, plan, balance, &batch.scenarios[*row as usize]);
        row.counted -= if BITS & equations::TIGHT == 0 { 0.0 } else { 1.0 };
        let absolute = tolerance(batch.options.relative_tolerance, &all).absolute;
        let (state, absolute) = (General::<N, BITS>::states(&all), General::<N, BITS>::tolerances(&all, &absolute));
        states.push(States { state, absolute });
        integrated.push(row);
    }
    let conduction = (kind == Kind::WallConduction).then_some(conduction);
    let spans = if kind == Kind::Relaxing { 1 } else { MOST_SPANS };
    if !integrate::<N, BITS>(batch, history, set, (&mut integrated, &mut states), spans, conduction) {
        // Too many steps to keep: solves fewer rows at a time.
        for rows in rows.chunks(rows.len().div_ceil(2).next_multiple_of(FEWEST)) {
            run::<N, BITS>(batch, memory, set, kind, rows, out);
        }
    } else if kind == Kind::Relaxing {
        let mut pushed: Vec<AfterPush> = integrated.iter().map(IntegratedRow::after_push).collect();
        relaxation_rows::run(batch, relaxing, set, &mut pushed, out);
    } else {
        read(batch, reader, history, &integrated, out);
    }
}

/// The balances of rows.
fn work_out(balances: &mut Vec<Balances>, rows: &[(u32, Plan)], scenarios: &[Scenario]) {
    balances.resize(rows.len(), Balances::of(scenarios[rows[0].0 as usize].chamber));
    for (balance, (row, _)) in balances.iter_mut().zip(rows) {
        balance.chamber = scenarios[*row as usize].chamber;
        balance.recompute_constants();
    }
}

/// Reads the outcomes of rows from their traces.
fn read(
    batch: Batch,
    reader: &mut reader::Memory,
    history: &History,
    integrated: &[IntegratedRow],
    out: &mut [Outcome],
) {
    let Batch { arch, options, .. } = batch;
    let mut rest = integrated;
    while !rest.is_empty() {
        let mut traces = Traces::new(reader);
        while let Some(row) = rest.get(traces.len()).filter(|_| traces.knots() < KNOTS) {
            row.trace(history, &mut traces);
        }
        let (group, others) = rest.split_at(traces.len());
        rest = others;
        let answers = traces.answers(arch);
        let regressions = if options.fit {
            traces.regressions(arch, &answers, |row| group[row].time_constant())
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

/// Integrates rows over at most `spans` spans; false if the history is full. `conduction` is the memory for the holds of rows
/// with a conducting wall.
fn integrate<const N: usize, const BITS: u32>(
    batch: Batch,
    history: &mut History,
    set: EffectSet,
    (integrated, states): (&mut [IntegratedRow], &mut [States<N>]),
    spans: usize,
    mut conduction: Option<&mut wall_conduction::Memory>,
) -> bool {
    history.clear();
    let mut problems: Vec<Problem<N>> = Vec::with_capacity(integrated.len());
    for index in 0..spans {
        let mut active: Vec<usize> = (0..integrated.len()).filter(|&c| integrated[c].goes_on(index)).collect();
        if active.is_empty() {
            break;
        }
        history.awake = integrated.iter().any(|c| index >= seen_from(c.plan, &c.sensor));
        let pass = |row: &mut IntegratedRow, states: &mut States<N>, problem: &Problem<N>| {
            row.passed[index] = (problem.steps, problem.view);
            states.state = problem.state;
            let contents = General::<N, BITS>::mass_and_energy(&problem.state, row.initial[MASS]);
            let is_gas = General::<N, BITS>::holds_gas(&problem.state);
            row.pass(contents, problem.energy, problem.failure.or((!is_gas).then_some(Failure::Empty)));
        };
        let problem = |row: &IntegratedRow, states: &States<N>| {
            let mut problem = Problem::new(row.plan.spans[index].length, states.state, states.absolute);
            (problem.longest, problem.first) = row.steps(index);
            problem
        };
        if General::<N, BITS>::REMEMBERS
            && let Some(memory) = &mut conduction
        {
            let rests = |c: &usize| integrated[*c].plan.spans[index].start.velocity == 0.0;
            let (held, mut others): (Vec<usize>, Vec<usize>) = active.iter().partition(|c| rests(c));
            let systems: Vec<Row> = held.iter().map(|&c| integrated[c].system(index)).collect();
            problems.clear();
            problems.extend(held.iter().map(|&c| problem(&integrated[c], &states[c])));
            let levels: Vec<usize> = held.iter().map(|&c| wall_conduction::coarsest(&integrated[c].sensor)).collect();
            let places = General::<N, BITS>::places_of_wall();
            let solved = wall_conduction::hold(batch, memory, set, places, (&systems, &levels), &mut problems, history);
            for ((&c, problem), solved) in held.iter().zip(&problems).zip(solved) {
                if solved {
                    pass(&mut integrated[c], &mut states[c], problem);
                } else {
                    others.push(c);
                }
            }
            active = others;
            if active.is_empty() {
                continue;
            }
        }
        let systems: Vec<Row> = active.iter().map(|&c| integrated[c].system(index)).collect();
        problems.clear();
        problems.extend(active.iter().map(|&c| problem(&integrated[c], &states[c])));
        let system = General::<N, BITS>::new(&systems, set);
        advance(batch.arch, &system, &systems, &mut problems, batch.options.relative_tolerance, history);
        if Watch::<N>::is_full(history) {
            return false;
        }
        for (&c, problem) in active.iter().zip(&problems) {
            pass(&mut integrated[c], &mut states[c], problem);
        }
    }
    !Watch::<N>::is_full(history)
}

impl<'a> IntegratedRow<'a> {
    /// A row at its start, and all states of its chamber.
    fn begin(row: u32, plan: &'a Plan, balance: &'a Balances, scenario: &'a Scenario) -> (Self, [f64; STATES]) {
        let (pressure, temperature) = (scenario.initial_pressure_pa, scenario.initial_temperature_k);
        let of_gas = sets::on_the_gas(plan.active);
        let states = balance.state_at(of_gas, &plan.spans[0].boundary(0.0), pressure, temperature);
        let initial = [states[MASS], states[ENERGY]];
        let row = Self {
            row,
            scenario,
            plan,
            balance,
            sensor: Sensor::new(plan.active, &scenario.chamber.effects),
            bends: Bends::new(plan.active, &scenario.chamber.effects),
            counted: equations::states(of_gas.bits()) as f64,
            initial,
            contents: initial,
            energy: [0.0; 2],
            passed: [(Steps::default(), View::NONE); MOST_SPANS],
            failure: None,
        };
        (row, states)
    }

    /// Its data for the integration of a span.
    fn system(&self, span: usize) -> Row<'_> {
        let span = &self.plan.spans[span];
        Row { balance: self.balance, span, counted: self.counted, mass: self.initial[MASS] }
    }

    /// Longest and first step of a span, s; zero if the first is to be estimated.
    fn steps(&self, index: usize) -> (f64, f64) {
        let span = &self.plan.spans[index];
        let longest = if index >= seen_from(self.plan, &self.sensor) {
            LONGEST * span.length
        } else if span.start.velocity != 0.0 {
            LONGEST_OF_MOVE * span.length
        } else {
            f64::INFINITY
        };
        let conducts = !self.plan.active.intersection(effects::REMEMBERING).is_empty();
        let bent = index == 0 && (self.plan.starts_singular || conducts);
        (longest, if bent { FIRST_OF_BENT * span.length } else { 0.0 })
    }

    /// Whether it still has to pass a span.
    fn goes_on(&self, index: usize) -> bool {
        self.failure.is_none() && index < self.plan.spans.len()
    }

    /// Records the end of a span: mass, kg, and internal energy, J, energy received as heat and enthalpy and work done over the
    /// span, J, and the failure, if any.
    fn pass(&mut self, contents: [f64; 2], [received, work]: [f64; 2], failure: Option<Failure>) {
        self.contents = contents;
        self.energy = [self.energy[0] + (received - work), self.energy[1] + work.abs()];
        let left = contents[MASS] / self.initial[MASS];
        self.failure = failure.map(|reason| if left.is_nan() || left <= EMPTY { Failure::Empty } else { reason });
    }

    /// The end of its push, if only that was integrated.
    fn after_push(&self) -> AfterPush {
        AfterPush {
            row: self.row,
            relaxations: self.scenario.hold_s() / self.time_constant(),
            mass: self.contents[MASS],
            energy: [self.initial[ENERGY], self.contents[ENERGY]],
            received: self.energy,
            failure: self.failure,
        }
    }

    /// Adds its trace.
    fn trace(&self, history: &History, traces: &mut Traces<'a>) {
        traces.begin(self.scenario, self.plan, self.sensor, self.bends);
        if self.failure.is_some() {
            return;
        }
        let passed = self.passed.iter().take(self.plan.spans.len());
        for (span, &(steps, view)) in passed.enumerate().skip(seen_from(self.plan, &self.sensor)) {
            traces.span(span, |knots| {
                knots.push(Knot { at: 0.0, view, kink: false });
                history.read(steps, knots);
            });
        }
    }

    /// Volume of the hold, m³, and temperature of gas and wall at rest, K.
    fn held(&self) -> [f64; 2] {
        let Scenario { chamber, final_position_m, ambient_temperature_k, .. } = self.scenario;
        [chamber.geometry.volume(*final_position_m), chamber.effects.rest_temperature(*ambient_temperature_k)]
    }

    /// τ of a tight chamber with its gas at rest, s.
    fn time_constant(&self) -> f64 {
        let (chamber, [volume, rest]) = (&self.scenario.chamber, self.held());
        let pressure = self.contents[MASS] * chamber.gas.gas_constant * rest / volume;
        1.0 / Closed::filled(chamber, pressure, rest, volume, rest).rate(volume)
    }

    /// What is outstanding at the end of its record, given the gas pressure, Pa, and the final temperature of the wall, K.
    fn standing(&self, a: &RowAnswer, gas_pressure: f64, wall: f64) -> Standing {
        let (duration, hold) = (self.scenario.duration_s, self.scenario.hold_s());
        let reading = self.sensor.shown(gas_pressure, duration);
        let to_be_lost =
            to_be_lost(gas_pressure * (1.0 - wall / a.temperature_final), -gas_pressure * a.pressure_rate * hold);
        let to_come = if self.sensor.looks_back() {
            a.pressure_final - self.bends.shown(self.sensor.shown(gas_pressure - to_be_lost, duration))
        } else {
            self.bends.change(reading, to_be_lost)
        };
        // Gas exchanged with a tube does not count.
        let passes = |effect: usize| !matches!(effects::CARDS[effect].balance, Balance::Energy | Balance::Volume);
        let flows = !self.scenario.is_sealed() || sets::on_the_gas(self.plan.active).iter().any(passes);
        let flowing = if flows { self.bends.change(reading, -gas_pressure * a.inflow * hold).abs() } else { 0.0 };
        let going_on = flowing + (self.sensor.drift * hold).abs();
        let distance = (a.pressure_peak - a.pressure_final).abs();
        let stands = a.settling == 0.0 && distance <= ROUNDING * a.pressure_final.abs() && self.sensor.delay < hold;
        Standing { distance, to_come: to_come.abs(), going_on, stands }
    }

    /// The outcome, from what was read from the record.
    fn outcome(&self, a: &RowAnswer, regression: Option<Regression>) -> Outcome {
        let [volume, rest] = self.held();
        let gas_pressure = self.contents[MASS] * self.scenario.chamber.gas.gas_constant * a.temperature_final / volume;
        let (settling_time_s, flows_on) = self.standing(a, gas_pressure, rest).judge(a.settling);
        Outcome {
            pressure_peak_pa: a.pressure_peak,
            pressure_final_pa: a.pressure_final,
            temperature_final_k: a.temperature_final,
            temperature_peak_k: a.temperature_peak,
            fit: regression.and_then(|found| fit::steps(self.scenario, found)),
            settling_time_s,
            flows_on,
            energy_error: closure(self.initial[ENERGY], self.contents[ENERGY], self.energy[0], self.energy[1]),
            duration_s: self.scenario.duration_s,
            exact: false,
            status: Ok(()),
        }
    }
}
