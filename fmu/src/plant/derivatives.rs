//! Exact derivatives of outputs, states and rates: along a direction of inputs, states and parameters, and in time. Uses forward
//! mode on the same equations ([`chamber::dual`]); at a kink the derivative is that of the branch taken: the forward one for
//! flows at zero, zero for |T − Tw| and |ẋ| at zero.

use super::fault::Fault;
use super::inputs;
use super::port::Around;
use super::rates::{Moment, Present, Sensor};
use super::simulation::{Kind, Simulation};
use super::states::{self, ALL, Origin, TRAVEL};
use super::tangent::{D, Here, Seed, lifted, moving, tangents};
use super::values::{INPUTS, OUTPUTS, Parameters, input, parameter};
use chamber::balance::{self, Balances, ENERGY, MASS, OWN, STATES};
use chamber::dual::Dual;
use chamber::effects::{self, EffectSet};
use chamber::real::Real;

/// Initialises the states of effects that the direction switches on, in equilibrium.
fn with_fresh_states(moment: &Moment<'_, D>, seeded: EffectSet, on: EffectSet, mut states: [D; ALL]) -> [D; ALL] {
    let mut fresh = [D::ZERO; effects::OWN_STATES];
    let at = balance::conditions(&moment.balance.chamber, &moment.boundary, states[MASS], states[ENERGY]);
    effects::initial(&at, &mut fresh);
    for index in seeded.iter().filter(|&index| !on.has(index)) {
        let own = effects::STATE_OFFSETS[index]..effects::STATE_OFFSETS[index + 1];
        states[OWN..STATES][own.clone()].copy_from_slice(&fresh[own]);
    }
    states
}

/// Present inputs along a direction. The piston follows the position input or the integral of its velocity, unless an end holds
/// it; the far end moves with the stroke parameter.
fn inputs_along(now: &Simulation, seed: &Seed) -> [D; INPUTS] {
    let here = now.here();
    let mut u = lifted(&here, &seed.inputs);
    let said = now.piston();
    let travels = now.started && now.is_moved_by_velocity();
    let position = if travels { seed.states[TRAVEL] } else { seed.inputs[input::POSITION] };
    let held = now.plant.limits.excludes(said.position) && !(travels && now.kind == Kind::ModelExchange);
    let end = if said.position > 0.0 { seed.parameters[parameter::STROKE] } else { 0.0 };
    u[input::POSITION].tangent[0] = if held { end } else { position };
    if here[input::VELOCITY] != said.velocity {
        u[input::VELOCITY].tangent[0] = 0.0;
    }
    u
}

/// Derivatives of everything along a direction. For a port's mean flow, those of its present flow.
///
/// # Errors
/// If the present inputs leave the gas no room.
pub fn along(now: &Simulation, seed: &Seed) -> Result<Present, Fault> {
    now.present()?;
    let parameters =
        Parameters { real: lifted(&now.parameters.real, &seed.parameters), choices: now.parameters.choices };
    let balance = Balances::of(parameters.chamber());
    let u = inputs_along(now, seed);
    let around = Around::of(&u, parameters.choices.external_wall, parameters.critical_ratios());
    let mut moment = Moment { balance: &balance, set: now.plant.set, boundary: inputs::boundary(&u), around };
    let (states, sensor, origin) = if now.started {
        (states_along(now, seed, &moment)?, sensor_along(now, seed, &balance), here(now).lifted_origin())
    } else {
        let states = states::initial(&parameters, &balance.chamber, &moment.boundary);
        let origin = Origin { mass: states[MASS], energy: states[ENERGY], position: moment.boundary.position };
        (states, Sensor { elapsed: D::from(0.0), delayed: None }, origin)
    };
    let seeded = parameters.choices.admitted(seed.effects());
    let states = with_fresh_states(&moment, seeded, now.plant.set, states);
    moment.set = now.plant.set.union(seeded);
    Ok(tangents(&moment.evaluate(&states, &sensor, &origin)))
}

/// States at the present position, including a jump of the stroke, with the direction's own derivatives.
fn states_along(now: &Simulation, seed: &Seed, moment: &Moment<'_, D>) -> Result<[D; ALL], Fault> {
    let mut states = now.gas.states.map(D::from);
    let from = D::from(now.gas.position);
    let jumps = now.kind == Kind::CoSimulation && !now.is_moved_by_velocity();
    if jumps && moment.boundary.position != from {
        states = states::instantaneous_stroke(&moment.balance.chamber, moment.set, &moment.boundary, &states, from)
            .map_err(|e| Fault::no_stroke(now.time, e))?;
    }
    for (state, tangent) in states.iter_mut().zip(seed.states) {
        state.tangent[0] += tangent;
    }
    Ok(states)
}

fn here(now: &Simulation) -> Here<'_> {
    Here { parameters: &now.parameters, set: now.plant.set, origin: &now.origin, inputs: now.here() }
}

/// Inputs of the sensor's chain; a longer delay shows an earlier reading.
fn sensor_along(now: &Simulation, seed: &Seed, balance: &Balances<D>) -> Sensor<D> {
    let longer = balance.chamber.effects.delay(now.plant.set).tangent[0];
    let delayed = now.delayed().map(|(value, rate)| Dual { value, tangent: [seed.delayed - rate * longer] });
    Sensor { elapsed: Dual { value: now.time - now.experiment.start, tangent: [seed.elapsed] }, delayed }
}

/// Rates of the outputs at the present time, with the inputs' present rates.
///
/// # Errors
/// If the present inputs leave the gas no room.
pub fn in_time(now: &Simulation) -> Result<[f64; OUTPUTS], Fault> {
    let present = now.present()?;
    let delayed = now.delayed().map_or(0.0, |(_, rate)| rate);
    let mut inputs = now.inputs.present_rate();
    let here = now.here();
    inputs[input::POSITION] = here[input::VELOCITY];
    if here[input::VELOCITY] != now.piston().velocity {
        inputs[input::VELOCITY] = 0.0;
    }
    let seed = Seed { inputs, states: present.rates, elapsed: 1.0, delayed, ..Seed::ZERO };
    Ok(moving(&self::here(now), &seed, &present.states, |balance| sensor_along(now, &seed, balance)).outputs)
}
