//! Exact derivatives of outputs, states and rates: along a direction of inputs, states and parameters, and in time.
//! Forward mode over the same equations ([`chamber::dual`]); at a kink the derivative is that of the branch taken there:
//! the forward one for flows at zero, zero for |T − Tw| and |ẋ| at zero.

use crate::inputs;
use crate::present::{self, Present, Sensor};
use crate::refusal::Refusal;
use crate::snapshot::{Phase, Snapshot};
use crate::variables::{INPUTS, OUTPUTS, Parameters, REALS, Role, input, output, table};
use chamber::balance::{MASS, STATES};
use chamber::dual::Dual;

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
    let mut sensor = Sensor { elapsed: D::from(0.0), delayed: None };
    let states =
        if matches!(now.phase, Phase::Instantiated | Phase::Initialization) {
            present::initial_states(&parameters, &chamber, &u)
        } else {
            let elapsed = now.time - now.experiment.start;
            sensor.elapsed = Dual { value: elapsed, tangent: [seed.elapsed] };
            sensor.delayed = now.record.as_ref().map(|record| {
                let (value, _) = record.at(now.time - now.delay());
                Dual { value, tangent: [seed.delayed] }
            });
            let mut states = now.gas.states.map(D::from);
            let from = D::from(now.gas.position);
            if boundary.position != from {
                states = present::jump(&chamber, now.plant.set, &boundary, &states, from)
                    .map_err(|e| Refusal::NoStep { step: 0.0, time: now.time, cause: e.to_string() })?;
            }
            // Known states are those at the present position.
            for (state, tangent) in states.iter_mut().zip(seed.states) {
                state.tangent[0] += tangent;
            }
            states
        };
    let all = present::evaluate(&chamber, now.plant.set, &boundary, &states, &sensor);
    let tangents = |d: &[D]| d.iter().map(|d| d.tangent[0]).collect::<Vec<_>>();
    let mut out = Present { outputs: [0.0; OUTPUTS], states: [0.0; STATES], rates: [0.0; STATES] };
    out.outputs.copy_from_slice(&tangents(&all.outputs));
    out.states.copy_from_slice(&tangents(&all.states));
    out.rates.copy_from_slice(&tangents(&all.rates));
    Ok(out)
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
    let sensor = Sensor {
        elapsed: Dual { value: now.time - now.experiment.start, tangent: [seed.elapsed] },
        delayed: now.record.as_ref().map(|_| Dual { value: 0.0, tangent: [seed.delayed] }),
    };
    let states = lifted(&now.gas.states, &seed.states);
    Ok(present::evaluate(&chamber, now.plant.set, &boundary, &states, &sensor).outputs.map(|d| d.tangent[0]))
}
