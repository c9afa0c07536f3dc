//! Directions in the space of inputs, states and parameters, and the plant's equations along one of them.

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
    /// Components for the real parameters.
    pub parameters: [f64; REALS],
    /// Components for the inputs.
    pub inputs: [f64; INPUTS],
    /// Components for the states.
    pub states: [f64; ALL],
    /// Component for the time since the start.
    pub elapsed: f64,
    /// Component for the reading one delay earlier.
    pub delayed: f64,
}

impl Seed {
    /// The zero direction, whose components can be set.
    pub const ZERO: Seed =
        Seed { parameters: [0.0; REALS], inputs: [0.0; INPUTS], states: [0.0; ALL], elapsed: 0.0, delayed: 0.0 };

    /// Effects whose parameters the direction changes: they take part even if off.
    pub fn effects(&self) -> EffectSet {
        let changed = |&index: &usize| {
            let range = effects::PARAMETER_OFFSETS[index]..effects::PARAMETER_OFFSETS[index + 1];
            self.parameters[BASE..][range].iter().any(|d| *d != 0.0)
        };
        (0..effects::COUNT).filter(changed).collect()
    }
}

/// A plant at one moment, without its states.
#[derive(Clone, Copy, Debug)]
pub struct Here<'a> {
    /// Parameters as the host set them.
    pub parameters: &'a Parameters,
    /// Active effects.
    pub set: EffectSet,
    /// Reference values of the sums.
    pub origin: &'a Origin,
    /// Present inputs, with the piston's actual position and speed.
    pub inputs: [f64; INPUTS],
}

impl Here<'_> {
    /// Reference values of the sums, with zero derivatives.
    pub fn lifted_origin(&self) -> Origin<D> {
        let Origin { mass, energy, position } = *self.origin;
        Origin { mass: mass.into(), energy: energy.into(), position: position.into() }
    }
}

/// Dual numbers with these values and derivatives.
pub fn lifted<const N: usize>(values: &[f64; N], tangent: &[f64; N]) -> [D; N] {
    core::array::from_fn(|i| Dual { value: values[i], tangent: [tangent[i]] })
}

/// The derivatives of all values.
pub fn tangents(all: &Present<D>) -> Present {
    Present {
        outputs: all.outputs.map(|d| d.tangent[0]),
        states: all.states.map(|d| d.tangent[0]),
        rates: all.rates.map(|d| d.tangent[0]),
    }
}

/// Derivatives where states and position change together, without a jump of the stroke.
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

/// Rate of the sensor reading before delay and drift, Pa/s, for these state rates.
pub fn reading_rate(here: &Here<'_>, states: &[f64; ALL], rates: [f64; ALL]) -> f64 {
    let mut inputs = [0.0; INPUTS];
    inputs[input::POSITION] = here.inputs[input::VELOCITY];
    let seed = Seed { inputs, states: rates, ..Seed::ZERO };
    let sensor = |_: &Balances<D>| Sensor { elapsed: D::ZERO, delayed: None };
    moving(here, &seed, states, sensor).outputs[output::MEASURED_PRESSURE]
}
