//! Directions in the space of inputs, states and parameters, and the plant's equations along one.

use super::inputs;
use super::port::Around;
use super::rates::{Moment, Present, Sensor};
use super::states::{ALL, Origin};
use super::values::{BASE, INPUTS, Parameters, REALS, input, output};
use chamber::balance::Balances;
use chamber::dual::Dual;
use chamber::effects::{self, EffectSet};
use chamber::real::Real;

/// A number with its derivative along the direction.
pub type D = Dual<1>;

/// A direction in the space of inputs, states and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Seed {
    /// Of the real parameters.
    pub parameters: [f64; REALS],
    /// Of the inputs.
    pub inputs: [f64; INPUTS],
    /// Of the states.
    pub states: [f64; ALL],
    /// Of the time since the start.
    pub elapsed: f64,
    /// Of the reading of a delay earlier.
    pub delayed: f64,
}

impl Seed {
    /// The direction in which nothing changes, to set components of.
    pub const ZERO: Seed =
        Seed { parameters: [0.0; REALS], inputs: [0.0; INPUTS], states: [0.0; ALL], elapsed: 0.0, delayed: 0.0 };

    /// Effects whose parameters the direction changes: they count even where they are off.
    pub fn effects(&self) -> EffectSet {
        let changed = |&index: &usize| {
            let range = effects::PARAMETER_OFFSETS[index]..effects::PARAMETER_OFFSETS[index + 1];
            self.parameters[BASE..][range].iter().any(|d| *d != 0.0)
        };
        (0..effects::COUNT).filter(changed).collect()
    }
}

/// A plant at one moment, but for its states.
#[derive(Clone, Copy, Debug)]
pub struct Here<'a> {
    /// Parameters as the host set them.
    pub parameters: &'a Parameters,
    /// The effects that take part.
    pub set: EffectSet,
    /// What sums are counted from.
    pub origin: &'a Origin,
    /// Present inputs, with the position and the speed that the piston has.
    pub inputs: [f64; INPUTS],
}

impl Here<'_> {
    /// What sums are counted from, the same along every direction.
    pub fn lifted_origin(&self) -> Origin<D> {
        let Origin { mass, energy, position } = *self.origin;
        Origin { mass: mass.into(), energy: energy.into(), position: position.into() }
    }
}

/// Numbers with these derivatives.
pub fn lifted<const N: usize>(values: &[f64; N], tangent: &[f64; N]) -> [D; N] {
    core::array::from_fn(|i| Dual { value: values[i], tangent: [tangent[i]] })
}

/// The derivatives of everything.
pub fn tangents(all: &Present<D>) -> Present {
    Present {
        outputs: all.outputs.map(|d| d.tangent[0]),
        states: all.states.map(|d| d.tangent[0]),
        rates: all.rates.map(|d| d.tangent[0]),
    }
}

/// Derivatives where states and position change together: no stroke is taken up.
pub fn moving(
    here: &Here<'_>,
    seed: &Seed,
    states: &[f64; ALL],
    sensor: impl Fn(&Balances<D>) -> Sensor<D>,
) -> Present {
    let parameters = here.parameters.lift::<D>();
    let balance = Balances::of(parameters.chamber());
    let u = lifted(&here.inputs, &seed.inputs);
    let around = Around::of(&u, parameters.choices.external_wall, parameters.critical_ratios());
    let moment = Moment { balance: &balance, set: here.set, boundary: inputs::boundary(&u), around };
    tangents(&moment.evaluate(&lifted(states, &seed.states), &sensor(&balance), &here.lifted_origin()))
}

/// Rate of what the sensor shows before delay and drift, Pa/s, where the states change at these rates.
pub fn reading_rate(here: &Here<'_>, states: &[f64; ALL], rates: [f64; ALL]) -> f64 {
    let mut inputs = [0.0; INPUTS];
    inputs[input::POSITION] = here.inputs[input::VELOCITY];
    let seed = Seed { inputs, states: rates, ..Seed::ZERO };
    let sensor = |_: &Balances<D>| Sensor { elapsed: D::ZERO, delayed: None };
    moving(here, &seed, states, sensor).outputs[output::MEASURED_PRESSURE]
}
