//! A scenario cut into stretches of time over which its boundary is linear, after a check of its numbers.

use crate::integrator::clock::Clock;
use crate::lanes::{Lanes, put};
use crate::outcome::Failure;
use crate::scenario::{Hold, Scenario};
use chamber::balance::Boundary;
use chamber::effects::{self, EffectSet};
use chamber::exact::Closed;
use chamber::real::Real;
use chamber::signals::Knot;

/// A boundary linear in time, from its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch<R: Real = f64> {
    /// Time since the start, s, that the record has reached when it shows the stretch's start.
    pub elapsed: R,
    /// Length, s.
    pub length: R,
    /// Position at its start, m.
    pub position: R,
    /// Velocity, m/s.
    pub velocity: R,
    /// Constant inflow, kg/s, at `temperature_in`, and the profile's inflow at ambient temperature at its start.
    pub inflow: [R; 2],
    /// Rate of the profile's inflow, kg/s².
    pub inflow_rate: R,
    /// Temperature of the constant inflow, K.
    pub temperature_in: R,
    /// Outflow at its start, kg/s.
    pub outflow: R,
    /// Its rate, kg/s².
    pub outflow_rate: R,
    /// Ambient temperature at its start, K.
    pub ambient_temperature: R,
    /// Its rate, K/s.
    pub ambient_temperature_rate: R,
    /// Ambient pressure, Pa.
    pub ambient_pressure: R,
    /// Whether a profile adds to the inflow.
    pub profiled: bool,
    /// The clock that steps are taken by.
    pub clock: Clock<R>,
}

/// Keeps a mean temperature finite where nothing flows, kg/s.
const SMALLEST_FLOW: f64 = 1e-300;

impl<R: Real> Stretch<R> {
    /// The boundary a time `t`, s, after the stretch's start.
    #[inline(always)]
    pub fn boundary(&self, t: R) -> Boundary<R> {
        let mut at = Boundary {
            position: self.position + self.velocity * t,
            velocity: self.velocity,
            mass_flow_in: self.inflow[0],
            temperature_in: self.temperature_in,
            mass_flow_out: self.outflow,
            ambient_temperature: self.ambient_temperature,
            ambient_pressure: self.ambient_pressure,
        };
        if self.profiled {
            at.ambient_temperature += self.ambient_temperature_rate * t;
            at.mass_flow_out += self.outflow_rate * t;
            // One inflow of the mean temperature.
            let from_profile = self.inflow[1] + self.inflow_rate * t;
            let kelvin = at.mass_flow_in * at.temperature_in + from_profile * at.ambient_temperature;
            at.mass_flow_in += from_profile;
            at.temperature_in = kelvin / (at.mass_flow_in + SMALLEST_FLOW);
        }
        at
    }
}

impl Stretch<Lanes> {
    /// Puts of a stretch what the rates read into a lane: no times and no position. [`Stretch::profiled`] is for all lanes alike.
    #[inline(always)]
    pub fn load(&mut self, lane: usize, from: &Stretch) {
        put!(self, lane, from; velocity, temperature_in, outflow, ambient_temperature, ambient_pressure);
        self.inflow[0][lane] = from.inflow[0];
        self.clock.load(lane, &from.clock);
        if self.profiled {
            self.inflow[1][lane] = from.inflow[1];
            put!(self, lane, from; inflow_rate, outflow_rate, ambient_temperature_rate);
        }
    }
}

impl Stretch<f64> {
    /// The stretch from a time `t` after its start on.
    fn after(&self, t: f64) -> Self {
        let at = self.boundary(t);
        Self {
            length: self.length - t,
            position: at.position,
            inflow: [self.inflow[0], self.inflow[1] + self.inflow_rate * t],
            outflow: at.mass_flow_out,
            ambient_temperature: at.ambient_temperature,
            ..*self
        }
    }
}

/// A checked scenario, ready to integrate.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Effects that are not neutral.
    pub active: EffectSet,
    /// Stretches from the start to the end of the test.
    pub stretches: Vec<Stretch>,
    /// End of the push, s.
    pub push_end: f64,
    /// End of the test, s.
    pub duration: f64,
    /// Time by which the sensor's record is behind the gas, s.
    pub delay: f64,
    /// The record shows, from the end of the push to the end of the test, the gas of the stretches from the first of
    /// these indices to before the second.
    pub window: [usize; 2],
    /// The first stretch after the push.
    pub hold: usize,
    /// Whether the piston leaves more gas volume than it found.
    pub expands: bool,
    /// Whether it starts where the law of its heat transfer is no power series; the clock is bent there.
    pub starts_singular: bool,
}

/// Within so many kelvin of the wall's temperature a start is one from there.
const NEAR_EQUILIBRIUM_K: f64 = 1.0;

/// Whether a scenario with these active effects starts where the law of its heat transfer is no power series.
pub fn starts_singular(active: EffectSet, scenario: &Scenario) -> bool {
    let Scenario { chamber, ambient_temperature_k, initial_temperature_k, .. } = scenario;
    let excess = || initial_temperature_k - chamber.effects.rest_temperature(*ambient_temperature_k);
    !active.intersection(effects::SINGULAR).is_empty() && excess().abs() < NEAR_EQUILIBRIUM_K
}

impl Plan {
    /// Checks a scenario with these active effects, all of them in `set`, and cuts it into stretches, in the memory of others.
    pub fn new(others: Vec<Stretch>, set: EffectSet, active: EffectSet, scenario: &Scenario) -> Result<Self, Failure> {
        check(set, active, scenario)?;
        let (push_end, duration) = times(scenario)?;
        let delay = scenario.chamber.effects.delay(active);
        let mut stretches = others;
        stretches.clear();
        match &scenario.profile {
            None => ramp(scenario, duration, &mut stretches),
            Some(knots) => along(scenario, knots, duration, &mut stretches),
        }
        let [begin, end] = [push_end, duration].map(|t| (t - delay).max(0.0));
        // In the order of their times: a later one leaves the indices of the others as they are.
        let from = split(&mut stretches, begin);
        let (hold, to) = if push_end < end {
            let hold = split(&mut stretches, push_end);
            (hold, split(&mut stretches, end))
        } else {
            let to = split(&mut stretches, end);
            (split(&mut stretches, push_end), to)
        };
        let geometry = &scenario.chamber.geometry;
        let mut elapsed = delay;
        for stretch in &mut stretches {
            stretch.elapsed = elapsed;
            elapsed += stretch.length;
            let [from, to] = [0.0, stretch.length].map(|t| geometry.volume(stretch.position + stretch.velocity * t));
            stretch.clock = Clock::new(from, to, stretch.length);
        }
        let starts_singular = starts_singular(active, scenario);
        if starts_singular {
            let first = &mut stretches[0];
            first.clock = first.clock.bent(first.length);
        }
        let last = stretches[stretches.len() - 1];
        let expands = last.position + last.velocity * last.length > stretches[0].position;
        Ok(Self { active, stretches, push_end, duration, delay, window: [from, to], hold, expands, starts_singular })
    }
}

/// Whether a scenario's numbers make sense, and its active effects are in `set`.
pub fn check(set: EffectSet, active: EffectSet, s: &Scenario) -> Result<(), Failure> {
    const POSITIVE: [&str; 11] = [
        "the bore",
        "the piston area",
        "the gas constant",
        "the heat capacity ratio less one",
        "the reference pressure",
        "the reference temperature",
        "the initial pressure",
        "the initial temperature",
        "the ambient temperature",
        "the ambient pressure",
        "the temperature of the inflow",
    ];
    const FINITE: [&str; 7] = [
        "the dead volume",
        "the heat transfer coefficient",
        "the mass flow in (zero or more)",
        "the mass flow out (zero or more)",
        "an effect's parameter",
        "the initial position",
        "the final position",
    ];
    let c = &s.chamber;
    let values = [
        c.geometry.bore,
        c.geometry.piston_area,
        c.gas.gas_constant,
        c.gas.heat_capacity_ratio - 1.0,
        c.heat_transfer.reference_pressure,
        c.heat_transfer.reference_temperature,
        s.initial_pressure_pa,
        s.initial_temperature_k,
        s.ambient_temperature_k,
        s.ambient_pressure_pa,
        s.temperature_in_k,
    ];
    // Bounds that are numbers: what `is_finite` and infinity come to here is many times as long.
    let positive = |value: &f64| *value > 0.0 && *value <= f64::MAX;
    let finite = |value: &f64| value.abs() <= f64::MAX;
    // All at once, and one by one only where one is wrong.
    if !values.iter().fold(true, |all, value| all & positive(value)) {
        let first = values.iter().position(|value| !positive(value)).unwrap_or_default();
        return Err(Failure::NotPositive(POSITIVE[first]));
    }
    let at_least_zero = |value: f64| (0.0..=f64::MAX).contains(&value);
    let fine = [
        finite(&c.geometry.dead_volume),
        at_least_zero(c.heat_transfer.coefficient),
        at_least_zero(s.mass_flow_in_kg_per_s),
        at_least_zero(s.mass_flow_out_kg_per_s),
        // Those of effects that are not active are neutral.
        active.iter().all(|effect| c.effects.of(effect).iter().all(finite)),
        s.profile.is_some() || finite(&s.initial_position_m),
        s.profile.is_some() || finite(&s.final_position_m),
    ];
    if let Some(first) = fine.iter().position(|fine| !fine) {
        return Err(Failure::NotFinite(FINITE[first]));
    }
    if !set.contains(active) {
        return Err(Failure::EffectNotInSet);
    }
    let leaves_gas = |position: f64| {
        let volume = c.geometry.volume(position);
        volume > 0.0 && c.geometry.heat_transfer_area(volume) >= 0.0
    };
    let Some(knots) = &s.profile else {
        if ![s.initial_position_m, s.final_position_m].into_iter().all(leaves_gas) {
            return Err(Failure::NoVolume);
        }
        return if s.push_time_s > 0.0 && s.push_time_s < f64::INFINITY {
            Ok(())
        } else {
            Err(Failure::NotPositive("the push time"))
        };
    };
    let starts_at_zero = knots.first().is_some_and(|k| k.time == 0.0);
    if !starts_at_zero || knots.windows(2).any(|w| !(w[1].time > w[0].time && w[1].time < f64::INFINITY)) {
        return Err(Failure::ProfileTimes);
    }
    if knots.iter().any(|k| !(k.position.is_finite() && k.mass_flow.is_finite())) {
        return Err(Failure::NotFinite("the profile"));
    }
    if !knots.iter().all(|k| leaves_gas(k.position)) {
        return Err(Failure::NoVolume);
    }
    if knots.iter().any(|k| !(k.ambient_temperature > 0.0 && k.ambient_temperature < f64::INFINITY)) {
        return Err(Failure::NotPositive("the profile's ambient temperature"));
    }
    Ok(())
}

/// End of the push and of the test, s.
pub fn times(scenario: &Scenario) -> Result<(f64, f64), Failure> {
    let (push_end, last_position) = match &scenario.profile {
        None => (scenario.push_time_s, scenario.final_position_m),
        Some(knots) => {
            let moving = knots.windows(2).rposition(|w| w[0].position != w[1].position);
            (moving.map_or(0.0, |i| knots[i + 1].time), knots[knots.len() - 1].position)
        }
    };
    let duration = match scenario.hold {
        Hold::Duration(duration) => duration,
        Hold::TimeConstants(count) => {
            let geometry = &scenario.chamber.geometry;
            let first_position = scenario.profile.as_ref().map_or(scenario.initial_position_m, |k| k[0].position);
            let begin = geometry.volume(first_position);
            let (pressure, temperature) = (scenario.initial_pressure_pa, scenario.initial_temperature_k);
            let closed =
                Closed::filled(&scenario.chamber, pressure, temperature, begin, scenario.ambient_temperature_k);
            push_end + count / closed.rate(geometry.volume(last_position))
        }
    };
    if !duration.is_finite() {
        return Err(Failure::NotFinite("the duration"));
    }
    if duration <= push_end { Err(Failure::EndsInPush) } else { Ok((push_end, duration)) }
}

fn still(s: &Scenario, position: f64, length: f64) -> Stretch {
    Stretch {
        length,
        position,
        inflow: [s.mass_flow_in_kg_per_s, 0.0],
        temperature_in: s.temperature_in_k,
        outflow: s.mass_flow_out_kg_per_s,
        ambient_temperature: s.ambient_temperature_k,
        ambient_pressure: s.ambient_pressure_pa,
        ..Stretch::default()
    }
}

fn ramp(s: &Scenario, duration: f64, out: &mut Vec<Stretch>) {
    let velocity = (s.final_position_m - s.initial_position_m) / s.push_time_s;
    out.push(Stretch { velocity, ..still(s, s.initial_position_m, s.push_time_s) });
    out.push(still(s, s.final_position_m, duration - s.push_time_s));
}

/// Stretches between knots, cut where the profile's flow turns round.
fn along(s: &Scenario, knots: &[Knot], duration: f64, out: &mut Vec<Stretch>) {
    out.reserve(knots.len() + 3);
    for (i, from) in knots.iter().enumerate().take_while(|(_, k)| k.time < duration) {
        let end = knots.get(i + 1).copied().unwrap_or(Knot { time: duration, ..*from });
        let span = end.time - from.time;
        let rate = (end.mass_flow - from.mass_flow) / span;
        let turns = from.mass_flow * end.mass_flow < 0.0;
        let mut pieces = vec![0.0];
        if turns {
            pieces.push(-from.mass_flow / rate);
        }
        pieces.push(span);
        for piece in pieces.windows(2) {
            let (begin, middle) =
                (from.mass_flow + rate * piece[0], from.mass_flow + rate * 0.5 * (piece[0] + piece[1]));
            let enters = middle > 0.0;
            let velocity = (end.position - from.position) / span;
            let warming = (end.ambient_temperature - from.ambient_temperature) / span;
            let still = still(
                s,
                from.position + velocity * piece[0],
                (piece[1] - piece[0]).min(duration - from.time - piece[0]),
            );
            if still.length <= 0.0 {
                break;
            }
            out.push(Stretch {
                velocity,
                inflow: [s.mass_flow_in_kg_per_s, if enters { begin.max(0.0) } else { 0.0 }],
                inflow_rate: if enters { rate } else { 0.0 },
                outflow: s.mass_flow_out_kg_per_s + if enters { 0.0 } else { (-begin).max(0.0) },
                outflow_rate: if enters { 0.0 } else { -rate },
                ambient_temperature: from.ambient_temperature + warming * piece[0],
                ambient_temperature_rate: warming,
                profiled: true,
                ..still
            });
        }
    }
}

/// Makes a stretch begin at time `t` and returns its index; the number of stretches where `t` is the end.
fn split(stretches: &mut Vec<Stretch>, t: f64) -> usize {
    let mut begin = 0.0;
    for i in 0..stretches.len() {
        let length = stretches[i].length;
        let near = 1e-12 * t.max(1e-9);
        if t <= begin + near {
            return i;
        }
        if t < begin + length - near {
            let rest = stretches[i].after(t - begin);
            stretches[i].length = t - begin;
            stretches.insert(i + 1, rest);
            return i + 1;
        }
        begin += length;
    }
    stretches.len()
}
