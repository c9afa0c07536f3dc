//! Checks a scenario's numbers and cuts it into spans of time over which its boundary is linear: the push and the hold, each cut
//! once more if the record is delayed.

use crate::integrator::time_transformation::TimeTransformation;
use crate::outcome::Failure;
use crate::scenario::Scenario;
use chamber::balance::Boundary;
use chamber::effects::{self, EffectSet};

/// A part of a test over which its boundary is linear in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpan {
    /// Time of the record at which it shows the span's start, s.
    pub elapsed: f64,
    /// Duration, s.
    pub length: f64,
    /// Boundary at its start; the position changes with the velocity.
    pub start: Boundary,
    /// The integrator's transformation of time.
    pub transformation: TimeTransformation,
}

impl TimeSpan {
    /// A span of `length`, s, that starts at a position, m, with a velocity, m/s.
    fn new(s: &Scenario, position: f64, velocity: f64, length: f64) -> Self {
        Self {
            elapsed: 0.0,
            length,
            start: s.boundary(position, velocity),
            transformation: TimeTransformation::default(),
        }
    }

    /// Boundary a time `t`, s, after the span's start.
    pub fn boundary(&self, t: f64) -> Boundary {
        Boundary { position: self.start.position + self.start.velocity * t, ..self.start }
    }
}

/// A checked scenario, ready to integrate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Active effects.
    pub active: EffectSet,
    /// Spans from the start to the end of the test.
    pub spans: Vec<TimeSpan>,
    /// Half-open range of the spans that the record shows between the end of the push and the end of the test.
    pub window: [usize; 2],
    /// The first span after the push.
    pub hold: usize,
    /// Whether it starts where its heat transfer law has no power series; the first transformation is bent then.
    pub starts_singular: bool,
}

/// A start within this distance of the wall's temperature, K, counts as a start at that temperature.
const NEAR_EQUILIBRIUM_K: f64 = 1.0;

/// Whether a scenario with these active effects starts where its heat transfer law has no power series.
pub fn starts_singular(active: EffectSet, scenario: &Scenario) -> bool {
    let Scenario { chamber, ambient_temperature_k, initial_temperature_k, .. } = scenario;
    let excess = || initial_temperature_k - chamber.effects.rest_temperature(*ambient_temperature_k);
    !active.intersection(effects::SINGULAR).is_empty() && excess().abs() < NEAR_EQUILIBRIUM_K
}

/// Push and hold, each of them cut at most once.
pub const MOST_SPANS: usize = 4;

impl Plan {
    /// Checks a scenario with these active effects, all of them in `set`, and cuts it into spans.
    pub fn new(set: EffectSet, active: EffectSet, scenario: &Scenario) -> Result<Self, Failure> {
        check(set, active, scenario)?;
        let &Scenario { push_time_s: push_end, duration_s: duration, .. } = scenario;
        let delay = scenario.chamber.effects.delay(active);
        let [from, to] = [scenario.initial_position_m, scenario.final_position_m];
        let mut spans = Vec::with_capacity(MOST_SPANS);
        spans.push(TimeSpan::new(scenario, from, (to - from) / push_end, push_end));
        spans.push(TimeSpan::new(scenario, to, 0.0, duration - push_end));
        let [begin, end] = [push_end, duration].map(|t| (t - delay).max(0.0));
        // In chronological order, so that a split does not shift indices found earlier.
        let from = split(&mut spans, begin);
        let (hold, to) = if push_end < end {
            let hold = split(&mut spans, push_end);
            (hold, split(&mut spans, end))
        } else {
            let to = split(&mut spans, end);
            (split(&mut spans, push_end), to)
        };
        let geometry = &scenario.chamber.geometry;
        let mut elapsed = delay;
        for span in &mut spans {
            span.elapsed = elapsed;
            elapsed += span.length;
            let [from, to] = [0.0, span.length].map(|t| geometry.volume(span.boundary(t).position));
            span.transformation = TimeTransformation::new(from, to, span.length);
        }
        let starts_singular = starts_singular(active, scenario);
        if starts_singular {
            let first = &mut spans[0];
            first.transformation = first.transformation.bent(first.length);
        }
        Ok(Self { active, spans, window: [from, to], hold, starts_singular })
    }
}

/// The numbers of a scenario that must be positive.
#[inline(always)]
fn positive_numbers(s: &Scenario) -> [(&'static str, f64); 11] {
    let c = &s.chamber;
    [
        ("the bore", c.geometry.bore),
        ("the piston area", c.geometry.piston_area),
        ("the gas constant", c.gas.gas_constant),
        ("the heat capacity ratio less one", c.gas.heat_capacity_ratio - 1.0),
        ("the reference pressure", c.heat_transfer.reference_pressure),
        ("the reference temperature", c.heat_transfer.reference_temperature),
        ("the initial pressure", s.initial_pressure_pa),
        ("the initial temperature", s.initial_temperature_k),
        ("the ambient temperature", s.ambient_temperature_k),
        ("the ambient pressure", s.ambient_pressure_pa),
        ("the temperature of the inflow", s.temperature_in_k),
    ]
}

/// The numbers that must be finite, and whether they are.
#[inline(always)]
fn finite_numbers(active: EffectSet, s: &Scenario) -> [(&'static str, bool); 7] {
    let c = &s.chamber;
    // Comparisons with finite bounds compile to far less code here than `is_finite` or infinite bounds.
    let finite = |value: &f64| value.abs() <= f64::MAX;
    let at_least_zero = |value: f64| (0.0..=f64::MAX).contains(&value);
    [
        ("the dead volume", finite(&c.geometry.dead_volume)),
        ("the heat transfer coefficient", at_least_zero(c.heat_transfer.coefficient)),
        ("the mass flow in (zero or more)", at_least_zero(s.mass_flow_in_kg_per_s)),
        ("the mass flow out (zero or more)", at_least_zero(s.mass_flow_out_kg_per_s)),
        // Parameters of inactive effects are neutral.
        ("an effect's parameter", active.iter().all(|effect| c.effects.of(effect).iter().all(finite))),
        ("the initial position", finite(&s.initial_position_m)),
        ("the final position", finite(&s.final_position_m)),
    ]
}

/// Checks that a scenario's numbers are valid and that its active effects are in `set`.
pub fn check(set: EffectSet, active: EffectSet, s: &Scenario) -> Result<(), Failure> {
    let positive = |value: f64| value > 0.0 && value <= f64::MAX;
    // All at once; one by one only if one is wrong.
    if !positive_numbers(s).iter().fold(true, |all, (_, value)| all & positive(*value)) {
        let first = positive_numbers(s).into_iter().find(|(_, value)| !positive(*value));
        return Err(Failure::NotPositive(first.unwrap_or_default().0));
    }
    if !finite_numbers(active, s).iter().fold(true, |all, (_, fine)| all & fine) {
        let first = finite_numbers(active, s).into_iter().find(|(_, fine)| !fine);
        return Err(Failure::NotFinite(first.unwrap_or_default().0));
    }
    if !set.contains(active) {
        return Err(Failure::EffectNotInSet);
    }
    let leaves_gas = |position: f64| {
        let volume = s.chamber.geometry.volume(position);
        volume > 0.0 && s.chamber.geometry.heat_transfer_area(volume) >= 0.0
    };
    if ![s.initial_position_m, s.final_position_m].into_iter().all(leaves_gas) {
        return Err(Failure::NoVolume);
    }
    if !(s.push_time_s > 0.0 && s.push_time_s < f64::INFINITY) {
        return Err(Failure::NotPositive("the push time"));
    }
    check_duration(s)
}

/// Checks that a test's duration is finite and exceeds its push.
pub fn check_duration(s: &Scenario) -> Result<(), Failure> {
    if !s.duration_s.is_finite() {
        return Err(Failure::NotFinite("the duration"));
    }
    if s.duration_s <= s.push_time_s { Err(Failure::EndsInPush) } else { Ok(()) }
}

/// Makes a span begin at time `t` and returns its index, or the number of spans if `t` is the end.
fn split(spans: &mut Vec<TimeSpan>, t: f64) -> usize {
    let mut begin = 0.0;
    for i in 0..spans.len() {
        let length = spans[i].length;
        let near = 1e-12 * t.max(1e-9);
        if t <= begin + near {
            return i;
        }
        if t < begin + length - near {
            let (done, all) = (t - begin, &mut spans[i]);
            let rest = TimeSpan { length: length - done, start: all.boundary(done), ..*all };
            all.length = done;
            spans.insert(i + 1, rest);
            return i + 1;
        }
        begin += length;
    }
    spans.len()
}
