//! One scenario after the other with the plain integrator: the reference that tests hold the lanes against.

use crate::filter::Sensor;
use crate::lanes::Lanes;
use crate::outcome::{Failure, Outcome, Standing, to_be_lost};
use crate::plan::{Plan, Stretch};
use crate::reader::Bends;
use crate::regression::fit;
use crate::regression::samples::{POINTS, SAMPLE_RATE_HZ, Samples};
use crate::regression::{Guess, RecordPart, Records};
use crate::scenario::{Options, Scenario, lets_gas_pass};
use chamber::Chamber;
use chamber::balance::{self, ENERGY, MASS, OWN, STATES};
use chamber::effects::EffectSet;
use chamber::integrate::{Dense, IntegrationError, Integrator};
use chamber::simulate::tolerance;

/// An accepted step with what is needed to look into it.
struct AcceptedStep {
    stretch: usize,
    stretch_begin: f64,
    from: f64,
    to: f64,
    states: Dense<f64, STATES>,
}

struct Run<'a> {
    set: EffectSet,
    chamber: &'a Chamber,
    plan: &'a Plan,
    pieces: Vec<AcceptedStep>,
    initial: [f64; STATES],
}

impl Run<'_> {
    /// Pressure that the record shows, Pa, and gas temperature, K, in a piece at a time of the gas, s.
    fn at(&self, piece: &AcceptedStep, t: f64) -> (f64, f64) {
        self.shown(&self.plan.stretches[piece.stretch], t - piece.stretch_begin, &piece.states.at(t), t)
    }

    fn shown(&self, stretch: &Stretch, local: f64, state: &[f64; STATES], t: f64) -> (f64, f64) {
        let at = balance::conditions(self.chamber, &stretch.boundary(local), state[MASS], state[ENERGY]);
        let own = core::array::from_fn(|i| state[OWN + i]);
        let shown = self.chamber.effects.reading(self.set, &own, at.pressure, t + self.plan.delay);
        (shown, at.temperature)
    }

    /// Pressure on the record at a time of the record, s.
    fn record(&self, time: f64) -> f64 {
        let t = time - self.plan.delay;
        if t <= 0.0 {
            return self.shown(&self.plan.stretches[0], 0.0, &self.initial, t).0;
        }
        let index = self.pieces.partition_point(|p| p.to < t - 1e-12 * t).min(self.pieces.len() - 1);
        self.at(&self.pieces[index], t).0
    }

    /// Largest `sign × value` over the pieces from a stretch on up to before another.
    fn extreme(&self, stretches: [usize; 2], sign: f64, value: impl Fn((f64, f64)) -> f64) -> Option<f64> {
        let mut best: Option<f64> = None;
        for piece in self.pieces.iter().filter(|p| p.stretch >= stretches[0] && p.stretch < stretches[1]) {
            let f = |t: f64| sign * value(self.at(piece, t));
            const PARTS: usize = 32;
            let times: Vec<f64> =
                (0..=PARTS).map(|k| piece.from + (piece.to - piece.from) * k as f64 / PARTS as f64).collect();
            let values: Vec<f64> = times.iter().map(|t| f(*t)).collect();
            for (k, &at_time) in values.iter().enumerate() {
                let mut v = at_time;
                let [before, after] = [k.saturating_sub(1), (k + 1).min(PARTS)];
                if v >= values[before] && v >= values[after] {
                    let (mut a, mut b) = (times[before], times[after]);
                    for _ in 0..60 {
                        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                        if f(c) < f(d) { a = c } else { b = d }
                    }
                    v = v.max(f(0.5 * (a + b)));
                }
                best = Some(best.map_or(v, |x| x.max(v)));
            }
        }
        best.map(|v| sign * v)
    }
}

/// Runs one scenario.
pub fn run(set: EffectSet, scenario: &Scenario, options: &Options) -> Outcome {
    match attempt(set, scenario, options) {
        Ok(outcome) => outcome,
        Err(reason) => Outcome::failed(reason),
    }
}

fn attempt(set: EffectSet, scenario: &Scenario, options: &Options) -> Result<Outcome, Failure> {
    let plan = Plan::new(set, scenario.chamber.active(), scenario)?;
    let chamber = &scenario.chamber;
    let first = plan.stretches[0].boundary(0.0);
    let initial = balance::state_at(chamber, &first, scenario.initial_pressure_pa, scenario.initial_temperature_k);
    let mut run = Run { set, chamber, plan: &plan, pieces: Vec::new(), initial };
    let mut integrator = Integrator::new(0.0, initial, tolerance(options.relative_tolerance, &initial));
    let mut begin = 0.0;
    for (index, stretch) in plan.stretches.iter().enumerate() {
        let system = |t: f64, state: &[f64; STATES]| balance::rates(set, chamber, &stretch.boundary(t - begin), state);
        let pieces = &mut run.pieces;
        integrator
            .advance(&system, begin + stretch.length, |step| {
                let states = step.dense();
                pieces.push(AcceptedStep {
                    stretch: index,
                    stretch_begin: begin,
                    from: step.from,
                    to: step.from + step.length,
                    states,
                });
            })
            .map_err(|e| match e {
                IntegrationError::StepTooSmall { .. } => Failure::StepTooSmall,
                IntegrationError::TooManySteps { .. } => Failure::TooManySteps,
            })?;
        if !(integrator.state[MASS] > 0.0 && integrator.state[ENERGY] > 0.0) {
            return Err(Failure::Empty);
        }
        begin = integrator.time;
    }
    let last = run.pieces.last().ok_or(Failure::EndsInPush)?;
    let temperature_final = run.at(last, plan.duration).1;
    let pressure_final = run.record(plan.duration);
    let sign = if plan.expands { -1.0 } else { 1.0 };
    let edges = [run.record(plan.push_end), pressure_final];
    let at_edges = edges.into_iter().map(|p| sign * p).fold(f64::NEG_INFINITY, f64::max);
    let peak = sign * run.extreme(plan.window, sign, |v| v.0).map_or(at_edges, |p| (sign * p).max(at_edges));
    let temperature_peak = run.extreme([plan.hold, usize::MAX], sign, |v| v.1).ok_or(Failure::EndsInPush)?;
    let gas_final = integrator.state[ENERGY] * (chamber.gas.heat_capacity_ratio - 1.0)
        / chamber.geometry.volume(scenario.final_position_m);
    let rest = chamber.effects.rest_temperature(scenario.ambient_temperature_k);
    let (sensor, bends) = (Sensor::new(set, &chamber.effects), Bends::new(set, &chamber.effects));
    let hold = plan.duration - plan.push_end;
    let at_end = plan.stretches[plan.stretches.len() - 1].boundary(0.0);
    let rates = balance::rates(set, chamber, &at_end, &integrator.state);
    let [inflow, pressure_rate] = [MASS, ENERGY].map(|of| rates[of] / integrator.state[of]);
    let to_be_lost = to_be_lost(gas_final * (1.0 - rest / temperature_final), -gas_final * pressure_rate * hold);
    let reading = sensor.shown(gas_final, plan.duration);
    let to_come = if sensor.lag > 0.0 || plan.delay > 0.0 {
        pressure_final - bends.shown(sensor.shown(gas_final - to_be_lost, plan.duration))
    } else {
        bends.change(reading, to_be_lost)
    };
    let flows = lets_gas_pass(plan.active, scenario);
    let flowing = if flows { bends.change(reading, -gas_final * inflow * hold).abs() } else { 0.0 };
    let distance = (peak - pressure_final).abs();
    let settling = settling(&run, pressure_final, distance);
    let stands = settling == 0.0 && plan.delay < hold;
    let going_on = flowing + (sensor.drift * hold).abs();
    let standing = Standing { distance, to_come: to_come.abs(), going_on, stands };
    let (settling_time_s, flows_on) = standing.judge(settling);
    let fit = if options.fit { evaluate(&run, scenario, sign) } else { None };
    Ok(Outcome {
        pressure_peak_pa: peak,
        pressure_final_pa: pressure_final,
        temperature_final_k: temperature_final,
        temperature_peak_k: temperature_peak,
        fit,
        settling_time_s,
        flows_on,
        energy_error: f64::NAN,
        duration_s: plan.duration,
        exact: false,
        status: Ok(()),
    })
}

/// Last time the record is further than 1 % of `distance` from the final pressure, from the end of the push, s.
fn settling(run: &Run, pressure_final: f64, distance: f64) -> f64 {
    let plan = run.plan;
    let outside = |time: f64| (run.record(time) - pressure_final).abs() > 0.01 * distance;
    const PARTS: usize = 20_000;
    let at = |k: usize| plan.push_end + (plan.duration - plan.push_end) * k as f64 / PARTS as f64;
    let Some(k) = (0..PARTS).rev().find(|&k| outside(at(k))) else { return 0.0 };
    let (mut a, mut b) = (at(k), at(k + 1));
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if outside(middle) { a = middle } else { b = middle }
    }
    0.5 * (a + b) - plan.push_end
}

/// The paper's steps on the record sampled at 100 Hz.
fn evaluate(run: &Run, scenario: &Scenario, sign: f64) -> Option<crate::outcome::Fit> {
    let plan = run.plan;
    let first = (plan.push_end * SAMPLE_RATE_HZ - 1e-9).ceil() as u64;
    let last = (plan.duration * SAMPLE_RATE_HZ + 1e-9).floor() as u64;
    let mut record: Vec<(f64, f64)> = (first..=last)
        .map(|k| k as f64 / SAMPLE_RATE_HZ)
        .map(|time| (time, run.record(time.min(plan.duration))))
        .collect();
    let peak =
        (0..record.len()).max_by(|&a, &b| (sign * record[a].1).total_cmp(&(sign * record[b].1)).then(b.cmp(&a)))?;
    record.drain(..peak);
    if record.len() < 4 {
        return None;
    }
    let mut records = Records::default();
    for (time, pressure) in &record {
        let samples = Samples { first: (time * SAMPLE_RATE_HZ).round(), count: 1.0 };
        records.add(0, RecordPart { samples, pressure: [*pressure; POINTS] });
    }
    let volume = scenario.chamber.geometry.volume(scenario.final_position_m);
    let closed = chamber::exact::Closed::filled(
        &scenario.chamber,
        record.last()?.1,
        scenario.ambient_temperature_k,
        volume,
        scenario.ambient_temperature_k,
    );
    let guess = Guess::TimeConstant(Lanes::from(1.0 / closed.rate(volume)));
    let regression = records.fit(pulp::Arch::new(), guess).lane(0)?;
    fit::steps(scenario, regression)
}
