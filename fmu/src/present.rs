//! Everything that can be asked of the chamber at one moment: outputs, states and their rates, from parameters, inputs
//! and states. Written over any number type, so that derivatives of every output are exact.

use crate::inputs;
use crate::variables::{INPUTS, OUTPUTS, Parameters, output};
use chamber::Chamber;
use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::card::Balance;
use chamber::effects::{self, EffectSet, OWN_STATES};
use chamber::integrate::{IntegrationError, Integrator, Tolerance};
use chamber::real::Scalar;

/// Outputs, states and rates of states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Present<R = f64> {
    /// Outputs, see [`output`].
    pub outputs: [R; OUTPUTS],
    /// States at the present position.
    pub states: [R; STATES],
    /// Their rates.
    pub rates: [R; STATES],
}

/// What the sensor's chain needs beside the state.
#[derive(Clone, Copy, Debug)]
pub struct Sensor<R = f64> {
    /// Time since the start of the experiment, s.
    pub elapsed: R,
    /// Reading of a delay earlier, Pa, where the record is delayed.
    pub delayed: Option<R>,
}

/// Evaluates the chamber at these inputs and states; the states belong to that position.
#[inline]
pub fn evaluate<R: Scalar>(
    chamber: &Chamber<R>,
    set: EffectSet,
    boundary: &Boundary<R>,
    states: &[R; STATES],
    sensor: &Sensor<R>,
) -> Present<R> {
    let (at, rates, own_rates) = balance::evaluate(set, chamber, boundary, states);
    let own: [R; OWN_STATES] = core::array::from_fn(|i| states[OWN + i]);
    let reading = |time: R| effects::reading(set, &chamber.effects, &own, at.pressure, time);
    // Drift is added after the delay: what time adds to the reading is added to the delayed one.
    let shown = reading(sensor.elapsed);
    let measured = sensor.delayed.map_or(shown, |earlier| earlier + (shown - reading(R::ZERO)));
    let mut outputs = [R::ZERO; OUTPUTS];
    outputs[output::PRESSURE] = at.pressure;
    outputs[output::MEASURED_PRESSURE] = measured;
    outputs[output::TEMPERATURE] = at.temperature;
    outputs[output::MASS] = states[MASS];
    outputs[output::VOLUME] = at.volume;
    outputs[output::FORCE] = (at.pressure - boundary.ambient_pressure) * at.piston_area;
    outputs[output::HEAT_FLOW] = rates.heat_flow;
    outputs[output::COEFFICIENT] = rates.heat_transfer_coefficient;
    let mut state_rates = [R::ZERO; STATES];
    state_rates[MASS] = rates.mass;
    state_rates[ENERGY] = rates.energy;
    state_rates[OWN..].copy_from_slice(&own_rates);
    Present { outputs, states: *states, rates: state_rates }
}

/// States at the start of an experiment.
pub fn initial_states<R: Scalar>(parameters: &Parameters<R>, chamber: &Chamber<R>, u: &[R; INPUTS]) -> [R; STATES] {
    use crate::variables::parameter::{INITIAL_PRESSURE, INITIAL_TEMPERATURE};
    let (pressure, temperature) = (parameters.real[INITIAL_PRESSURE], parameters.real[INITIAL_TEMPERATURE]);
    balance::state_at(chamber, &inputs::boundary(u), pressure, temperature)
}

/// Duration of a stroke taken up at once, s: no flow and no heat gets anywhere in it.
const INSTANT_S: f64 = 1e-15;

/// The states once the piston is moved at once from one position to another: adiabatically, with no flow.
///
/// U V^(γ−1) stays; where an effect stores gas or has states that follow the pressure, its own equations are integrated
/// along the stroke.
///
/// # Errors
/// Where the equations cannot follow the stroke.
pub fn jump<R: Scalar>(
    chamber: &Chamber<R>,
    set: EffectSet,
    at: &Boundary<R>,
    states: &[R; STATES],
    from: R,
) -> Result<[R; STATES], IntegrationError> {
    let geometry = &chamber.geometry;
    let ratio = geometry.volume(from) / geometry.volume(at.position);
    if !follows_pressure(set) {
        let mut states = *states;
        states[ENERGY] = states[ENERGY] * ratio.powf(chamber.gas.heat_capacity_ratio - 1.0);
        return Ok(states);
    }
    let mut chamber = *chamber;
    chamber.heat_transfer.coefficient = R::ZERO;
    let stroke = at.position - from;
    let still = Boundary { mass_flow_in: R::ZERO, mass_flow_out: R::ZERO, velocity: stroke * (1.0 / INSTANT_S), ..*at };
    let system = |share: f64, states: &[R; STATES]| {
        let boundary = Boundary { position: from + stroke * share, ..still };
        balance::rates(set, &chamber, &boundary, states).map(|rate| rate * INSTANT_S)
    };
    let absolute = core::array::from_fn(|i| 1e-14 * states[i].value().abs() + f64::MIN_POSITIVE);
    let mut run = Integrator::new(0.0, *states, Tolerance { relative: 1e-11, absolute });
    run.advance(&system, 1.0, |_| ())?;
    Ok(run.state)
}

/// Whether an effect in the set stores gas or has states of its own.
fn follows_pressure(set: EffectSet) -> bool {
    !set.is_empty()
        && effects::all().any(|(i, card)| set.has(i) && (card.balance == Balance::Volume || !card.states.is_empty()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variables::Starts;

    #[test]
    fn both_ways_to_take_up_a_stroke_agree() {
        let starts = Starts::default();
        let mut chamber = starts.parameters.chamber();
        let mut boundary: Boundary = inputs::boundary(&starts.inputs);
        let states = balance::state_at(&chamber, &boundary, 3e5, 320.0);
        boundary.position = 0.07;
        let closed = jump(&chamber, EffectSet::NONE, &boundary, &states, 0.1).unwrap();
        let (lag, _) = effects::find("sensor_lag").unwrap();
        chamber.effects.of_mut(lag)[0] = 0.01;
        let integrated = jump(&chamber, chamber.active(), &boundary, &states, 0.1).unwrap();
        assert!((closed[ENERGY] / integrated[ENERGY] - 1.0).abs() < 1e-10);
        assert_eq!(closed[MASS], integrated[MASS]);
        assert!(
            (integrated[OWN + effects::STATE_OFFSETS[lag]] / 3e5 - 1.0).abs() < 1e-12,
            "a lagging sensor does not jump"
        );
    }

    #[test]
    fn a_core_of_gas_is_compressed_like_the_rest() {
        let starts = Starts::default();
        let mut chamber = starts.parameters.chamber();
        let (zones, _) = effects::find("gas_zones").unwrap();
        chamber.effects.of_mut(zones).copy_from_slice(&[0.3, 0.05]);
        let mut boundary: Boundary = inputs::boundary(&starts.inputs);
        let states = balance::state_at(&chamber, &boundary, 3e5, 320.0);
        boundary.position = 0.05;
        let after = jump(&chamber, chamber.active(), &boundary, &states, 0.1).unwrap();
        let core = OWN + effects::STATE_OFFSETS[zones];
        assert!((after[core] / states[core] - after[ENERGY] / states[ENERGY]).abs() < 1e-10);
    }
}
