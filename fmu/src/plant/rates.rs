//! All values of the chamber at one moment: outputs, states and their rates, from parameters, inputs and states. Generic over the
//! number type, so that derivatives of all outputs are exact.

use super::port::Around;
use super::states::{ALL, HEAT, Origin, TRAVEL, WORK};
use super::values::{OUTPUTS, output};
use chamber::balance::{Balances, Boundary, Conditions, Contents, ENERGY, MASS, OWN, Rates};
use chamber::effects::{EffectSet, OWN_STATES};
use chamber::real::Scalar;

/// Outputs, states and state rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Present<R = f64> {
    /// Outputs, SI units; indices in [`output`].
    pub outputs: [R; OUTPUTS],
    /// States at the present position, SI units.
    pub states: [R; ALL],
    /// Time derivatives of the states, SI units per s.
    pub rates: [R; ALL],
}

impl Present {
    /// Zero everywhere: the derivative of a constant.
    pub const ZERO: Present = Present { outputs: [0.0; OUTPUTS], states: [0.0; ALL], rates: [0.0; ALL] };

    /// Whether all values are finite, so that a host can continue.
    pub fn is_finite(&self) -> bool {
        self.outputs.iter().chain(&self.states).chain(&self.rates).all(|value| value.is_finite())
    }
}

/// Inputs of the sensor's chain besides the state.
#[derive(Clone, Copy, Debug)]
pub struct Sensor<R = f64> {
    /// Time since the start of the experiment, s.
    pub elapsed: R,
    /// Reading one delay earlier, Pa, if the record is delayed.
    pub delayed: Option<R>,
}

/// A chamber at one moment, without its states.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a, R = f64> {
    /// Gas, geometry, heat transfer and effects, with precomputed constants.
    pub balance: &'a Balances<R>,
    /// Active effects.
    pub set: EffectSet,
    /// Piston, flows and surroundings.
    pub boundary: Boundary<R>,
    /// Prescribed surroundings: the wall's temperature, the ports' far sides.
    pub around: Around<R>,
}

impl<R: Scalar> Moment<'_, R> {
    /// Conditions, rates of the gas, and rates of the effects' own states, for these states.
    #[inline]
    pub fn balances(&self, states: &[R; ALL]) -> (Conditions<R>, Rates<R>, [R; OWN_STATES]) {
        let volume = self.balance.chamber.geometry.volume(self.boundary.position);
        let contents = Contents::new(states[MASS], states[ENERGY], volume);
        let own = own(states);
        self.balance.evaluate_within(&self.around, self.set, &self.boundary, &contents, &own)
    }

    /// All values for these states, which must belong to the boundary's position.
    pub fn evaluate(&self, states: &[R; ALL], sensor: &Sensor<R>, origin: &Origin<R>) -> Present<R> {
        let (at, rates, own_rates) = self.balances(states);
        let (set, values, boundary) = (self.set, &self.balance.chamber.effects, &self.boundary);
        let own = own(states);
        let reading = |time: R| values.reading(set, &own, at.pressure, time);
        // Drift is added after the delay: the change of the reading due to elapsed time is added to the delayed one.
        let shown = reading(sensor.elapsed);
        let measured = sensor.delayed.map_or(shown, |earlier| earlier + (shown - reading(R::ZERO)));
        let gained = states[ENERGY] - origin.energy;
        let mut outputs = [R::ZERO; OUTPUTS];
        outputs[output::PRESSURE] = at.pressure;
        outputs[output::MEASURED_PRESSURE] = measured;
        outputs[output::TEMPERATURE] = at.temperature;
        outputs[output::MASS] = states[MASS];
        outputs[output::VOLUME] = at.volume;
        outputs[output::FORCE] = (at.pressure - boundary.ambient_pressure) * at.piston_area;
        outputs[output::HEAT_FLOW] = rates.heat_flow;
        outputs[output::COEFFICIENT] = rates.heat_transfer_coefficient;
        outputs[output::PISTON_POSITION] = boundary.position;
        outputs[output::SUPPLY_PORT..][..4].copy_from_slice(&self.around.port_flows(&at));
        outputs[output::INTERNAL_ENERGY] = states[ENERGY];
        outputs[output::HEAT_RECEIVED] = states[HEAT];
        outputs[output::WORK_DONE] = states[WORK];
        outputs[output::ENTHALPY_RECEIVED] = gained - states[HEAT] + states[WORK];
        outputs[output::MASS_RECEIVED] = states[MASS] - origin.mass;
        let mut state_rates = [R::ZERO; ALL];
        state_rates[MASS] = rates.mass;
        state_rates[ENERGY] = rates.energy;
        state_rates[OWN..HEAT].copy_from_slice(&own_rates);
        state_rates[HEAT] = rates.heat_flow;
        state_rates[WORK] = rates.work;
        state_rates[TRAVEL] = boundary.velocity;
        Present { outputs, states: *states, rates: state_rates }
    }
}

/// The effects' own states.
pub fn own<R: Copy>(states: &[R; ALL]) -> [R; OWN_STATES] {
    core::array::from_fn(|i| states[OWN + i])
}
