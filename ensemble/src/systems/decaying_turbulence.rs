//! The paper's model with the port closed and decaying turbulence, in lanes: beside the gas temperature, as in [`crate::systems::sealed`],
//! the factor f = 1 + k u of the heat transfer coefficient is a state. With the same transformed time,
//!
//! dT/ds = T (f q − 4 (γ − 1) w'/w),  q = c p (a1 w⁴ + a0) w (Tw − T),  df/ds = (1 + k |ẋ| − f) p w³/τ
//!
//! While the piston rests dT/dt = c Aq/√V f T (Tw − T) and df/dt = (1 − f)/τ, so that T is monotone, as f is never below one. u in m/s,
//! k in s/m, τ in s, T in K.

use crate::integrator::step::{LaneSystem, Moment, View};
use crate::lanes::Lanes;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::effects::{self, DecayingTurbulence, EffectSet};
use chamber::real::Real;

/// The only effect on the gas that such tests have.
pub const EFFECTS: EffectSet = DecayingTurbulence::SET;

/// k, s/m, and τ, s.
fn turbulence(scenario: &Scenario) -> [f64; 2] {
    let parameters = scenario.chamber.effects.of(DecayingTurbulence::INDEX);
    [parameters[0], parameters[1]]
}

/// Whether there is turbulence that raises the heat transfer and decays.
pub fn has_turbulence(scenario: &Scenario) -> bool {
    turbulence(scenario).iter().all(|value| *value > 0.0)
}

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct TurbulenceTest {
    gas: SealedTest,
    /// 1 + k |ẋ|, the limit of f while the piston moves.
    steady: f64,
    /// 1/τ, 1/s.
    decay: f64,
}

impl TestSystem<2> for TurbulenceTest {
    type Moving = Moving;
    type Held = Held;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let [coefficient, decay_time] = turbulence(s);
        let speed = (s.final_position_m - s.initial_position_m).abs() / s.push_time_s;
        Self { gas: SealedTest::new(s), steady: 1.0 + coefficient * speed, decay: 1.0 / decay_time }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 2] {
        [s.initial_temperature_k.sqrt(), 1.0]
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        &self.gas
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    gas: sealed::Moving,
    steady: Lanes,
    /// p/τ.
    decay: Lanes,
}

impl LaneSystem<2> for Moving {
    type Row = TurbulenceTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &TurbulenceTest) {
        self.gas.load(lane, &test.gas);
        self.steady[lane] = test.steady;
        self.decay[lane] = test.decay * test.gas.transformation.pace_factor;
    }

    #[inline(always)]
    fn rates(&self, s: Lanes, &[state, factor]: &[Lanes; 2]) -> Moment<2> {
        let root = self.gas.transformation.root(s);
        let square = root * root;
        let temperature = state * state;
        let warmer = factor * (self.gas.wall - temperature);
        let [heat, work] = self.gas.heat_and_work([root, square], warmer);
        let stirring = self.decay * (square * root) * (self.steady - factor);
        let power = [temperature * heat, temperature * work];
        Moment { slope: [state * 0.5 * (heat - work), stirring], view: View::NONE, power }
    }
}

/// Tests, one per lane, while their pistons rest.
#[derive(Clone, Default)]
pub struct Held {
    gas: sealed::Held,
    /// 1/τ, 1/s.
    decay: Lanes,
}

impl LaneSystem<2> for Held {
    type Row = TurbulenceTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &TurbulenceTest) {
        self.gas.load(lane, &test.gas);
        self.decay[lane] = test.decay;
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, &[state, factor]: &[Lanes; 2]) -> Moment<2> {
        let temperature = state * state;
        let heat = self.gas.exchange * factor * (self.gas.wall - temperature);
        let slope = [state * 0.5 * heat, self.decay * (Lanes::ONE - factor)];
        Moment { slope, view: View::NONE, power: [temperature * heat, Lanes::ZERO] }
    }
}

impl Holding<2> for Held {
    #[inline(always)]
    fn guess(&self, [states, _]: [&[Lanes; 2]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(states[0] * states[0], begin)
    }

    /// By the product of the series of f and g = c Aq/√V T (Tw − T).
    #[inline(always)]
    fn series(&self, &[state, factor]: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        let (temperature, exchange) = (state * state, self.gas.exchange * length);
        let decay = self.decay * length;
        let fading = (Lanes::ONE - factor) * decay;
        let fading_on = -(fading * decay) * 0.5;
        let slope = exchange * (self.gas.wall - temperature * 2.0);
        let still = temperature * (exchange * (self.gas.wall - temperature));
        let first = factor * still;
        let rising = slope * first;
        let second = (fading * still + factor * rising) * 0.5;
        let bending = slope * second - exchange * (first * first);
        let third = (fading_on * still + fading * rising + factor * bending) * (1.0 / 3.0);
        [temperature, first, second, third]
    }
}

const _: () = assert!(effects::CARDS[DecayingTurbulence::INDEX].parameters.len() == 2);
