//! The reference that batches are compared with: one scenario at a time by the plain integrator, its record read by brute force. It
//! shares the chamber's equations with the kernel and nothing else.

use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::card::Balance;
use chamber::effects::{self, OWN_STATES, SensorDrift, SensorLag};
use chamber::exact::Closed;
use chamber::integrate::{Dense, IntegrationError, Integrator};
use chamber::seven_steps::{self, Push, Regression, Setup};
use chamber::simulate::tolerance;
use chamber::{AreaLaw, EffectSet, Geometry};
use ensemble::{Failure, Fit, Outcome, Scenario};

const SAMPLE_RATE_HZ: f64 = 100.0;

/// An accepted step, over which the boundary is linear in time.
struct Step {
    from: f64,
    to: f64,
    /// The boundary at `origin`, s, of which the position moves on with the velocity.
    boundary: Boundary,
    origin: f64,
    states: Dense<f64, STATES>,
}

/// A solved test. Times are those of the gas unless they are said to be of the record, which is `delay` later.
struct Run<'a> {
    set: EffectSet,
    s: &'a Scenario,
    delay: f64,
    steps: Vec<Step>,
    initial: [f64; STATES],
}

fn moved(boundary: &Boundary, time: f64) -> Boundary {
    Boundary { position: boundary.position + boundary.velocity * time, ..*boundary }
}

impl Run<'_> {
    /// Pressure that the sensor shows, Pa, and gas temperature, K, in a state at a time, s.
    fn shown(&self, boundary: &Boundary, state: &[f64; STATES], time: f64) -> [f64; 2] {
        let at = balance::conditions(&self.s.chamber, boundary, state[MASS], state[ENERGY]);
        let own = core::array::from_fn(|i| state[OWN + i]);
        [self.s.chamber.effects.reading(self.set, &own, at.pressure, time + self.delay), at.temperature]
    }

    fn at(&self, step: &Step, time: f64) -> [f64; 2] {
        self.shown(&moved(&step.boundary, time - step.origin), &step.states.at(time), time)
    }

    /// Pressure on the record at a time of the record, s.
    fn record(&self, time: f64) -> f64 {
        let time = time - self.delay;
        if time <= 0.0 {
            return self.shown(&self.steps[0].boundary, &self.initial, time)[0];
        }
        let index = self.steps.partition_point(|step| step.to < time * (1.0 - 1e-12)).min(self.steps.len() - 1);
        self.at(&self.steps[index], time)[0]
    }

    /// Largest `sign` times pressure or temperature over the steps that lie between two times, s.
    fn extreme(&self, [begin, end]: [f64; 2], sign: f64, of: usize) -> f64 {
        const PARTS: usize = 32;
        let mut best = f64::NEG_INFINITY;
        let near = 1e-9 * self.s.duration_s;
        for step in self.steps.iter().filter(|step| step.from > begin - near && step.to < end + near) {
            let value = |time: f64| sign * self.at(step, time)[of];
            let time = |part: usize| step.from + (step.to - step.from) * part as f64 / PARTS as f64;
            let values: Vec<f64> = (0..=PARTS).map(|part| value(time(part))).collect();
            for (part, &here) in values.iter().enumerate() {
                best = best.max(here);
                let [before, after] = [part.saturating_sub(1), (part + 1).min(PARTS)];
                if here >= values[before] && here >= values[after] {
                    let (mut a, mut b) = (time(before), time(after));
                    for _ in 0..60 {
                        let (c, d) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
                        if value(c) < value(d) { a = c } else { b = d }
                    }
                    best = best.max(value(0.5 * (a + b)));
                }
            }
        }
        best
    }

    /// Last time of the record at which it is further than 1 % of `distance` from its end, from the end of the push, s.
    fn settling(&self, distance: f64) -> f64 {
        const PARTS: usize = 20_000;
        let Scenario { push_time_s, duration_s, .. } = *self.s;
        let last = self.record(duration_s);
        let outside = |time: f64| (self.record(time) - last).abs() > 0.01 * distance;
        let time = |part: usize| push_time_s + (duration_s - push_time_s) * part as f64 / PARTS as f64;
        let Some(part) = (0..PARTS).rev().find(|&part| outside(time(part))) else { return 0.0 };
        let (mut a, mut b) = (time(part), time(part + 1));
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if outside(middle) { a = middle } else { b = middle }
        }
        0.5 * (a + b) - push_time_s
    }

    /// The paper's steps on the record sampled at 100 Hz, from its peak on.
    fn fit(&self, sign: f64) -> Option<Fit> {
        let s = self.s;
        let first = (s.push_time_s * SAMPLE_RATE_HZ - 1e-9).ceil() as u64;
        let last = (s.duration_s * SAMPLE_RATE_HZ + 1e-9).floor() as u64;
        let times = (first..=last).map(|k| (k as f64 / SAMPLE_RATE_HZ).min(s.duration_s));
        let mut pressures: Vec<f64> = times.map(|time| self.record(time)).collect();
        let higher = |&a: &usize, &b: &usize| (sign * pressures[a]).total_cmp(&(sign * pressures[b])).then(b.cmp(&a));
        let peak = (0..pressures.len()).max_by(higher)?;
        pressures.drain(..peak);
        let (chamber, ambient) = (&s.chamber, s.ambient_temperature_k);
        let volume = chamber.geometry.volume(s.final_position_m);
        let guess = 1.0 / Closed::filled(chamber, *pressures.last()?, ambient, volume, ambient).rate(volume);
        let (found, misfit) = exponential(&pressures, guess)?;
        let setup = Setup {
            gas: chamber.gas,
            geometry: Geometry { area_law: AreaLaw::Total, ..chamber.geometry },
            ambient_temperature_k: ambient,
            reference_pressure_pa: chamber.heat_transfer.reference_pressure,
            reference_temperature_k: chamber.heat_transfer.reference_temperature,
        };
        let &Scenario { initial_pressure_pa, initial_position_m, final_position_m, .. } = s;
        let push = Push { initial_pressure_pa, initial_position_m, final_position_m };
        let steps = seven_steps::steps(&setup, ambient, &push, &found);
        let lambda0 = steps.coefficient_0_w_per_m2_k;
        (steps.mass_kg > 0.0 && steps.final_volume_m3 > 0.0 && lambda0.is_finite()).then_some(Fit {
            final_pressure_pa: found.final_pressure_pa,
            pressure_rise_pa: found.pressure_rise_pa,
            time_constant_s: found.time_constant_s,
            lambda_av_w_per_m2_k: steps.coefficient_av_w_per_m2_k,
            lambda0_w_per_m2_k: lambda0,
            misfit,
        })
    }
}

/// P = Pf + ΔP e^(−t/τ) by least squares from a guess of τ, s, on, and the largest residual over the record's rise: Newton's method in
/// ln τ, with Gauss and Newton's curvature where its own is too small to be believed. None where the record determines nothing.
fn exponential(pressures: &[f64], guess: f64) -> Option<(Regression, f64)> {
    if pressures.len() < 5 {
        return None;
    }
    let mean = |of: &dyn Fn(usize) -> f64| (0..pressures.len()).map(of).sum::<f64>() / pressures.len() as f64;
    let reference = pressures[0];
    let pressure = |k: usize| pressures[k] - reference;
    let mean_pressure = mean(&pressure);
    let (mut log_tau, mut last, mut longest) = (guess.ln(), 0.0f64, 1.0f64);
    for _ in 0..60 {
        let x = |k: usize| k as f64 / SAMPLE_RATE_HZ * (-log_tau).exp();
        // e^(−x) and what its first and second derivatives by ln τ are made of.
        let powers: [&dyn Fn(usize) -> f64; 3] =
            [&|k| (-x(k)).exp(), &|k| x(k) * (-x(k)).exp(), &|k| x(k) * x(k) * (-x(k)).exp()];
        let means = powers.map(mean);
        let product = |i: usize, j: usize| mean(&|k| (powers[i](k) - means[i]) * powers[j](k));
        let with_pressure = |i: usize| mean(&|k| (powers[i](k) - means[i]) * (pressure(k) - mean_pressure));
        let [ee, eg, gg, he] = [product(0, 0), product(0, 1), product(1, 1), product(2, 0)];
        let rise = with_pressure(0) / ee;
        let with_g = with_pressure(1) / rise - eg;
        let with_bend = with_pressure(2) / rise - he - with_g;
        let coupling = (eg - with_g) / ee;
        let (newton, gauss) = (gg - with_bend - (eg - with_g) * coupling, gg - eg * eg / ee);
        let step = with_g / if newton > 0.3 * gauss { newton } else { gauss };
        // The kernel's criterion: where no exponential fits, convergence is linear and a tighter one gives a τ half a per cent off.
        if step.abs() < 2e-3 {
            // With the last step taken.
            let pressure_rise_pa = rise * (1.0 - coupling * step);
            let final_pressure_pa = reference + mean_pressure - pressure_rise_pa * means[0] - rise * step * means[1];
            let time_constant_s = (log_tau + step).exp();
            let decay = |k: usize| (-(k as f64) / SAMPLE_RATE_HZ / time_constant_s).exp();
            let residual = |k: usize| (pressures[k] - final_pressure_pa - pressure_rise_pa * decay(k)).abs();
            let farthest = (0..pressures.len()).map(residual).fold(0.0, f64::max);
            let [low, high] = [f64::min, f64::max].map(|of| pressures.iter().copied().fold(reference, of));
            let found = Regression { final_pressure_pa, pressure_rise_pa, time_constant_s };
            return Some((found, farthest / (high - low)));
        }
        if last * step < 0.0 {
            longest = 0.5 * last.abs();
        }
        last = step.clamp(-longest, longest);
        log_tau += last;
        if (log_tau - guess.ln()).abs().is_nan() || (log_tau - guess.ln()).abs() > 12.0 {
            return None;
        }
    }
    None
}

/// Runs one scenario with the effects of a set, to a relative tolerance.
pub fn run(set: EffectSet, s: &Scenario, relative_tolerance: f64) -> Outcome {
    attempt(set, s, relative_tolerance).unwrap_or_else(Outcome::failed)
}

fn attempt(set: EffectSet, s: &Scenario, relative_tolerance: f64) -> Result<Outcome, Failure> {
    let (chamber, effects, active) = (&s.chamber, &s.chamber.effects, s.chamber.active());
    let Scenario { push_time_s: push_end, duration_s: duration, .. } = *s;
    let delay = effects.delay(active);
    let velocity = (s.final_position_m - s.initial_position_m) / push_end;
    let start = s.boundary(s.initial_position_m, velocity);
    let initial = balance::state_at(chamber, &start, s.initial_pressure_pa, s.initial_temperature_k);
    let mut run = Run { set, s, delay, steps: Vec::new(), initial };
    let mut integrator = Integrator::new(0.0, initial, tolerance(relative_tolerance, &initial));
    // What the record shows from the end of the push to that of the test.
    let window = [push_end, duration].map(|time| (time - delay).max(0.0));
    let mut ends = vec![push_end, duration, window[0], window[1]];
    ends.sort_by(f64::total_cmp);
    for end in ends {
        let origin = integrator.time;
        if end <= origin * (1.0 + 1e-12) {
            continue;
        }
        let is_held = origin >= push_end * (1.0 - 1e-12);
        let boundary = if is_held { s.boundary(s.final_position_m, 0.0) } else { moved(&start, origin) };
        let system = |t: f64, y: &[f64; STATES]| balance::rates(set, chamber, &moved(&boundary, t - origin), y);
        let steps = &mut run.steps;
        integrator
            .advance(&system, end, |step| {
                let (from, to) = (step.from, step.from + step.length);
                steps.push(Step { from, to, boundary, origin, states: step.dense() });
            })
            .map_err(|e| match e {
                IntegrationError::StepTooSmall { .. } => Failure::StepTooSmall,
                IntegrationError::TooManySteps { .. } => Failure::TooManySteps,
            })?;
        if !(integrator.state[MASS] > 0.0 && integrator.state[ENERGY] > 0.0) {
            return Err(Failure::Empty);
        }
    }
    let sign = if s.final_position_m > s.initial_position_m { -1.0 } else { 1.0 };
    let [first, last] = [push_end, duration].map(|time| run.record(time));
    let peak = sign * run.extreme(window, sign, 0).max(sign * first).max(sign * last);
    let temperature_peak = sign * run.extreme([push_end, f64::INFINITY], sign, 1);
    let [_, temperature_final] = run.at(run.steps.last().ok_or(Failure::EndsInPush)?, duration);

    let hold = duration - push_end;
    let volume = chamber.geometry.volume(s.final_position_m);
    let gas_final = integrator.state[ENERGY] * (chamber.gas.heat_capacity_ratio - 1.0) / volume;
    let rates = balance::rates(set, chamber, &s.boundary(s.final_position_m, 0.0), &integrator.state);
    let [inflow, pressure_rate] = [MASS, ENERGY].map(|of| rates[of] / integrator.state[of]);
    // What is lost until the gas has the wall's temperature, or, if it is on no way there, in as long as the hold has lasted.
    let to_the_wall = gas_final * (1.0 - effects.rest_temperature(s.ambient_temperature_k) / temperature_final);
    let at_its_rate = -gas_final * pressure_rate * hold;
    let to_be_lost = if at_its_rate.abs() < 0.01 * to_the_wall.abs() { at_its_rate } else { to_the_wall };
    // What a sensor shows of a pressure that stands.
    let standing = |p: f64| effects.reading(set.without(SensorLag::SET), &[0.0; OWN_STATES], p, duration);
    let lost = |by: f64| standing(gas_final) - standing(gas_final - by);
    let looks_back = effects.lag(set) > 0.0 || delay > 0.0;
    let to_come = if looks_back { last - standing(gas_final - to_be_lost) } else { lost(to_be_lost) };
    let on_the_gas = active.without(effects::of_sensor()).without(effects::of_recorded_stroke());
    let passes = |effect: usize| !matches!(effects::CARDS[effect].balance, Balance::Energy | Balance::Volume);
    let is_open = s.mass_flow_in_kg_per_s + s.mass_flow_out_kg_per_s > 0.0 || on_the_gas.iter().any(passes);
    let flowing = if is_open { lost(-gas_final * inflow * hold).abs() } else { 0.0 };
    let going_on = flowing + (effects.of(SensorDrift::INDEX)[0] * hold).abs();
    let distance = (peak - last).abs();
    let settling = run.settling(distance);
    let [at_rest, tight] = [to_come.abs(), going_on].map(|change| change <= 0.01 * distance);
    let settled = settling == 0.0 && delay < hold || at_rest && tight;
    Ok(Outcome {
        pressure_peak_pa: peak,
        pressure_final_pa: last,
        temperature_final_k: temperature_final,
        temperature_peak_k: temperature_peak,
        fit: run.fit(sign),
        settling_time_s: settled.then_some(settling),
        flows_on: !settled && at_rest,
        energy_error: f64::NAN,
        duration_s: duration,
        exact: false,
        status: Ok(()),
    })
}
