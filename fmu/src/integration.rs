//! One communication step of the gas, of any length: the same balances as everywhere, integrated as finely as the
//! tolerance asks for.
//!
//! A sealed chamber with its piston held follows the exact solution; one without effects is integrated in mass and energy
//! alone; anything else in all states. Breakpoints lie where a linear speed or flow changes its sign.

use crate::inputs::{self, Inputs};
use crate::present;
use crate::record::{Record, Stretch};
use crate::refusal::Refusal;
use crate::variables::input;
use chamber::Chamber;
use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::exact::Closed;
use chamber::integrate::{IntegrationError, Integrator, Step, Tolerance};

/// Inner steps that a communication step may take: about 0.1 s of computing. A host that wants more takes shorter steps.
const MAX_INNER_STEPS: usize = 200_000;

/// States of the gas at a communication point.
#[derive(Clone, Debug, PartialEq)]
pub struct Gas {
    /// Mass, internal energy, the effects' own states.
    pub states: [f64; STATES],
    /// The position they belong to, m.
    pub position: f64,
    /// Inner step to try next, s.
    pub inner_step: f64,
}

/// A chamber with the effects that take part.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// Its constants.
    pub chamber: Chamber,
    /// Effects that are not neutral.
    pub set: EffectSet,
    /// How finely to integrate.
    pub tolerance: Tolerance<STATES>,
}

impl Gas {
    /// The gas `h` seconds later; `time` is that of the step's begin, `record` takes the sensor's readings if given.
    ///
    /// # Errors
    /// Where no accurate step exists. The record may then hold part of the step.
    pub fn after(
        &self,
        plant: &Plant,
        inputs: &Inputs,
        time: f64,
        h: f64,
        record: Option<(&mut Record, f64)>,
    ) -> Result<Gas, Refusal> {
        let stroke = Stroke::checked(plant, inputs, h)?;
        let states = self.taken_up(plant, inputs).map_err(|e| no_step(h, time, e))?;
        let (states, inner_step) = if stroke.is_sealed_and_held && plant.set.is_empty() {
            (held(plant, inputs, states, h), self.inner_step)
        } else {
            leaves_gas(inputs, states[MASS], h, plant.set)?;
            integrated(plant, inputs, states, self.inner_step, time, h, record).map_err(|e| no_step(h, time, e))?
        };
        if !(states[MASS] > 0.0 && states[ENERGY] > 0.0 && states.iter().all(|s| s.is_finite())) {
            return Err(no_step(h, time, "mass or energy of the gas would not be positive"));
        }
        Ok(Gas { states, position: stroke.end, inner_step })
    }

    /// The states with the stroke taken up adiabatically to where the host says the piston is.
    fn taken_up(&self, plant: &Plant, inputs: &Inputs) -> Result<[f64; STATES], IntegrationError> {
        if inputs.value[input::POSITION] == self.position {
            return Ok(self.states);
        }
        present::jump(&plant.chamber, plant.set, &inputs::boundary(&inputs.value), &self.states, self.position)
    }
}

/// Where the piston goes within a step.
struct Stroke {
    /// Position at its end, m.
    end: f64,
    is_sealed_and_held: bool,
}

impl Stroke {
    fn checked(plant: &Plant, inputs: &Inputs, h: f64) -> Result<Self, Refusal> {
        let (begin, speed) = inputs.stroke(0.0);
        let (end, _) = inputs.stroke(h);
        for position in [begin, end] {
            volume_at(&plant.chamber, position)?;
        }
        let flows = [input::MASS_FLOW_IN, input::MASS_FLOW_OUT];
        let is_sealed_and_held = inputs.is_plain() && speed == 0.0 && flows.iter().all(|&i| inputs.value[i] == 0.0);
        Ok(Self { end, is_sealed_and_held })
    }
}

/// Volumes from here on are refused, m³.
const LARGEST_VOLUME: f64 = 1e9;

/// Volume at a position, m³.
///
/// # Errors
/// When there is none, or more than any machine has: its gas could not be told in numbers.
pub fn volume_at(chamber: &Chamber, position: f64) -> Result<f64, Refusal> {
    let volume = chamber.geometry.volume(position);
    if volume > 0.0 && volume < LARGEST_VOLUME {
        Ok(volume)
    } else {
        Err(Refusal::NoVolume { position, volume, dead_volume: chamber.geometry.dead_volume })
    }
}

fn no_step(step: f64, time: f64, cause: impl ToString) -> Refusal {
    Refusal::NoStep { step, time, cause: cause.to_string() }
}

/// Refuses a constant outflow that takes more than there is. Where an effect lets gas in, the integration decides.
fn leaves_gas(inputs: &Inputs, mass: f64, h: f64, set: EffectSet) -> Result<(), Refusal> {
    let outflow = inputs.value[input::MASS_FLOW_OUT] - inputs.value[input::MASS_FLOW_IN];
    if set.is_empty() && inputs.is_plain() && mass - outflow * h <= 0.0 {
        return Err(Refusal::Emptied { step: h, mass, outflow });
    }
    Ok(())
}

/// Closed form of the sealed chamber with its piston held.
fn held(plant: &Plant, inputs: &Inputs, mut states: [f64; STATES], h: f64) -> [f64; STATES] {
    let chamber = &plant.chamber;
    let cv = chamber.gas.cv();
    let volume = chamber.geometry.volume(inputs.value[input::POSITION]);
    let temperature = states[ENERGY] / (states[MASS] * cv);
    let pressure = (chamber.gas.heat_capacity_ratio - 1.0) * states[ENERGY] / volume;
    let ambient = inputs.value[input::AMBIENT_TEMPERATURE];
    let later = Closed::filled(chamber, pressure, temperature, volume, ambient).held(temperature, volume, h);
    states[ENERGY] = states[MASS] * cv * later;
    states
}

fn integrated(
    plant: &Plant,
    inputs: &Inputs,
    states: [f64; STATES],
    inner_step: f64,
    time: f64,
    h: f64,
    record: Option<(&mut Record, f64)>,
) -> Result<([f64; STATES], f64), IntegrationError> {
    let (breaks, count) = if inputs.is_plain() { ([h; 3], 0) } else { inputs.sign_changes(h) };
    let breaks = &breaks[..count];
    let start = inputs::boundary(&inputs.value);
    let plain = move |s: f64| Boundary { position: start.position + start.velocity * s, ..start };
    let led = |s: f64| inputs.boundary(s);
    let span = Span { breaks, end: h, inner_step };
    match (plant.set.is_empty(), inputs.is_plain()) {
        (true, true) => gas_alone(plant, states, span, plain),
        (true, false) => gas_alone(plant, states, span, led),
        (false, true) => with_effects(plant, states, span, plain, time, record),
        (false, false) => with_effects(plant, states, span, led, time, record),
    }
}

/// What is integrated over: from zero to `end`, broken at `breaks`, s.
struct Span<'a> {
    breaks: &'a [f64],
    end: f64,
    inner_step: f64,
}

impl Span<'_> {
    fn run<const N: usize>(
        &self,
        states: [f64; N],
        tolerance: Tolerance<N>,
        rates: impl Fn(f64, &[f64; N]) -> [f64; N],
        mut on_step: impl FnMut(&Step<f64, N>),
    ) -> Result<([f64; N], f64), IntegrationError> {
        let mut run = Integrator::new(0.0, states, tolerance);
        run.step = self.inner_step;
        run.max_steps = MAX_INNER_STEPS;
        for &until in self.breaks.iter().chain([&self.end]) {
            run.advance(&rates, until, &mut on_step)?;
        }
        Ok((run.state, run.step))
    }
}

fn gas_alone(
    plant: &Plant,
    mut states: [f64; STATES],
    span: Span<'_>,
    boundary: impl Fn(f64) -> Boundary,
) -> Result<([f64; STATES], f64), IntegrationError> {
    let Tolerance { relative, absolute } = plant.tolerance;
    let rates = |s: f64, y: &[f64; 2]| {
        let mut all = [0.0; STATES];
        all[..2].copy_from_slice(y);
        let rates = guarded_rates(EffectSet::NONE, &plant.chamber, &boundary(s), &all);
        [rates[MASS], rates[ENERGY]]
    };
    let tolerance = Tolerance { relative, absolute: [absolute[MASS], absolute[ENERGY]] };
    let (gas, inner_step) = span.run([states[MASS], states[ENERGY]], tolerance, rates, |_| ())?;
    states[..2].copy_from_slice(&gas);
    Ok((states, inner_step))
}

fn with_effects(
    plant: &Plant,
    states: [f64; STATES],
    span: Span<'_>,
    boundary: impl Fn(f64) -> Boundary,
    time: f64,
    record: Option<(&mut Record, f64)>,
) -> Result<([f64; STATES], f64), IntegrationError> {
    let rates = |s: f64, y: &[f64; STATES]| guarded_rates(plant.set, &plant.chamber, &boundary(s), y);
    let Some((record, delay)) = record else {
        return span.run(states, plant.tolerance, rates, |_| ());
    };
    let on_step = |step: &Step<f64, STATES>| {
        let dense = step.dense();
        let reading = |s: f64| reading(plant, &boundary(s), &dense.at(s));
        let stretch = Stretch::of(step.from, step.length, reading);
        record.push(Stretch { from: time + stretch.from, ..stretch }, delay);
    };
    span.run(states, plant.tolerance, rates, on_step)
}

/// What the sensor shows before delay and drift, Pa.
pub fn reading(plant: &Plant, boundary: &Boundary, states: &[f64; STATES]) -> f64 {
    let at = balance::conditions(&plant.chamber, boundary, states[MASS], states[ENERGY]);
    let own: [f64; OWN_STATES] = core::array::from_fn(|i| states[OWN + i]);
    effects::reading(plant.set, &plant.chamber.effects, &own, at.pressure, 0.0)
}

/// Rates, or NaN where there is no gas or no room for it: the integrator then takes no such step.
#[inline(always)]
fn guarded_rates(set: EffectSet, chamber: &Chamber, boundary: &Boundary, states: &[f64; STATES]) -> [f64; STATES] {
    if states[MASS] > 0.0 && states[ENERGY] > 0.0 && chamber.geometry.volume(boundary.position) > 0.0 {
        balance::rates(set, chamber, boundary, states)
    } else {
        [f64::NAN; STATES]
    }
}
