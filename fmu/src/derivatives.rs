//! Exact derivatives of outputs, states and rates: along a direction of inputs, states and parameters, and in time.
//! Forward mode over the same equations ([`chamber::dual`]); at a kink the derivative is that of the branch taken there:
//! the forward one for flows at zero, zero for |T − Tw| and |ẋ| at zero.

use crate::inputs;
use crate::present::{self, Present, Sensor};
use crate::refusal::Refusal;
use crate::snapshot::{Phase, Snapshot};
use crate::variables::{BASE, INPUTS, OUTPUTS, Parameters, REALS, Role, input, output, table};
use chamber::Chamber;
use chamber::balance::{self, Boundary, ENERGY, MASS, OWN, STATES};
use chamber::dual::Dual;
use chamber::effects::{self, EffectSet};
use chamber::real::Real;

type D = Dual<1>;

/// A direction in the space of inputs, states and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Seed {
    parameters: [f64; REALS],
    inputs: [f64; INPUTS],
    states: [f64; STATES],
    elapsed: f64,
    delayed: f64,
}

impl Seed {
    /// No direction.
    pub const ZERO: Seed =
        Seed { parameters: [0.0; REALS], inputs: [0.0; INPUTS], states: [0.0; STATES], elapsed: 0.0, delayed: 0.0 };

    /// The direction that a host gives. States are knowns once initialization is over.
    ///
    /// # Errors
    /// Variables that cannot be knowns, numbers that are not finite.
    pub fn along(phase: Phase, known: &[u32], direction: &[f64]) -> Result<Self, Refusal> {
        let mut seed = Seed::ZERO;
        let last = table().len() as u32 - 1;
        for (&reference, &value) in known.iter().zip(direction) {
            let variable = table().get(reference as usize).ok_or(Refusal::UnknownReference { reference, last })?;
            if !value.is_finite() {
                return Err(Refusal::NotFinite { name: &variable.name, value, unit: variable.quantity.unit });
            }
            match variable.role {
                Role::Input(i) => seed.inputs[i] += value,
                Role::Parameter(i) => seed.parameters[i] += value,
                Role::State(i) if phase != Phase::Initialization => seed.states[i] += value,
                Role::Output(output::MASS) if phase != Phase::Initialization => seed.states[MASS] += value,
                _ => {
                    let advice = if phase == Phase::Initialization {
                        "knowns are inputs and parameters in initialization mode"
                    } else {
                        "knowns are inputs, continuous states and parameters"
                    };
                    return Err(Refusal::NoDirection { name: &variable.name, place: "a known", advice });
                }
            }
        }
        Ok(seed)
    }

    /// Effects whose parameters the direction changes: they count even where they are off.
    fn effects(&self) -> EffectSet {
        let changed = |&index: &usize| {
            let range = effects::PARAMETER_OFFSETS[index]..effects::PARAMETER_OFFSETS[index + 1];
            self.parameters[BASE..][range].iter().any(|d| *d != 0.0)
        };
        (0..effects::COUNT).filter(changed).collect()
    }
}

/// States of effects that are off begin in equilibrium when the direction switches them on.
fn with_fresh_states(
    chamber: &Chamber<D>,
    seeded: EffectSet,
    on: EffectSet,
    boundary: &Boundary<D>,
    mut states: [D; STATES],
) -> [D; STATES] {
    let mut fresh = [D::ZERO; effects::OWN_STATES];
    effects::initial(&balance::conditions(chamber, boundary, states[MASS], states[ENERGY]), &mut fresh);
    for index in seeded.iter().filter(|&index| !on.has(index)) {
        let own = effects::STATE_OFFSETS[index]..effects::STATE_OFFSETS[index + 1];
        states[OWN..][own.clone()].copy_from_slice(&fresh[own]);
    }
    states
}

fn lifted<const N: usize>(values: &[f64; N], tangent: &[f64; N]) -> [D; N] {
    core::array::from_fn(|i| Dual { value: values[i], tangent: [tangent[i]] })
}

/// Derivatives of everything along a direction.
///
/// # Errors
/// When the present inputs leave the gas no room.
pub fn along(now: &Snapshot, seed: &Seed) -> Result<Present, Refusal> {
    now.present()?;
    let parameters =
        Parameters { real: lifted(&now.parameters.real, &seed.parameters), area_law: now.parameters.area_law };
    let chamber = parameters.chamber();
    let u = lifted(&now.inputs.present(), &seed.inputs);
    let boundary = inputs::boundary(&u);
    let starting = matches!(now.phase, Phase::Instantiated | Phase::Initialization);
    let (states, sensor) = if starting {
        let at_rest = Sensor { elapsed: D::from(0.0), delayed: None };
        (present::initial_states(&parameters, &chamber, &u), at_rest)
    } else {
        (states_along(now, seed, &chamber, &boundary)?, sensor_along(now, seed, &chamber))
    };
    let states = with_fresh_states(&chamber, seed.effects(), now.plant.set, &boundary, states);
    let set = now.plant.set.union(seed.effects());
    let all = present::evaluate(&chamber, set, &boundary, &states, &sensor);
    Ok(Present {
        outputs: all.outputs.map(|d| d.tangent[0]),
        states: all.states.map(|d| d.tangent[0]),
        rates: all.rates.map(|d| d.tangent[0]),
    })
}

/// States at the present position: those the stroke leads to, and the direction's own.
fn states_along(
    now: &Snapshot,
    seed: &Seed,
    chamber: &Chamber<D>,
    boundary: &Boundary<D>,
) -> Result<[D; STATES], Refusal> {
    let mut states = now.gas.states.map(D::from);
    let from = D::from(now.gas.position);
    if boundary.position != from {
        states = present::jump(chamber, now.plant.set, boundary, &states, from).map_err(|e| Refusal::NoStep {
            step: 0.0,
            time: now.time,
            cause: e.to_string(),
        })?;
    }
    for (state, tangent) in states.iter_mut().zip(seed.states) {
        state.tangent[0] += tangent;
    }
    Ok(states)
}

/// What the sensor's chain adds; a longer delay shows an earlier reading.
fn sensor_along(now: &Snapshot, seed: &Seed, chamber: &Chamber<D>) -> Sensor<D> {
    let longer = effects::delay(now.plant.set, &chamber.effects).tangent[0];
    let delayed = now.record.as_ref().map(|record| {
        let (value, rate) = record.at(now.time - now.delay());
        Dual { value, tangent: [seed.delayed - rate * longer] }
    });
    Sensor { elapsed: Dual { value: now.time - now.experiment.start, tangent: [seed.elapsed] }, delayed }
}

/// Rates of the outputs at the present time, with the inputs' present rates.
///
/// # Errors
/// When the present inputs leave the gas no room.
pub fn in_time(now: &Snapshot) -> Result<[f64; OUTPUTS], Refusal> {
    // The gas is taken to the present position first, so that position and states move together from there.
    let mut here = now.clone();
    let present = now.present()?;
    here.gas.states = present.states;
    here.gas.position = now.inputs.present()[input::POSITION];
    let delayed = now.record.as_ref().map_or(0.0, |record| record.at(now.time - now.delay()).1);
    let seed = Seed { inputs: now.inputs.present_rate(), states: present.rates, elapsed: 1.0, delayed, ..Seed::ZERO };
    along_the_stroke(&here, &seed)
}

/// As [`along`], but where states and position change together: no stroke is taken up.
fn along_the_stroke(now: &Snapshot, seed: &Seed) -> Result<[f64; OUTPUTS], Refusal> {
    let chamber = now.parameters.lift::<D>().chamber();
    let boundary = inputs::boundary(&lifted(&now.inputs.present(), &seed.inputs));
    let sensor = sensor_along(now, seed, &chamber);
    let states = lifted(&now.gas.states, &seed.states);
    Ok(present::evaluate(&chamber, now.plant.set, &boundary, &states, &sensor).outputs.map(|d| d.tangent[0]))
}
