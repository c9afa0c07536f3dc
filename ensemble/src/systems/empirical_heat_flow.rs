//! The paper's model with the port closed and an additional heat flow that is a function of the pressure, in lanes: an
//! [`empirical`](chamber::effects::empirical) curve of that kind. With the transformed time of [`crate::systems::sealed`],
//!
//! dT/ds = T (q − 4 (γ − 1) w'/w) + y(P) p w³/(m cv),  q = c p (a1 w⁴ + a0) w (Tw − T),  P = m R T/w⁴
//! y(P) = y0 + Σ b max(P − P_k, 0)
//!
//! with corners at the P_k, at which steps end ([`crate::integrator::corner`]). While the piston rests T' is a function of T alone, so
//! that T is monotone; between two corners that function is quadratic. The state is √T; y in W, T in K.

use crate::integrator::step::{LaneSystem, Moment, View};
use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::effects::empirical::{Hinges, KNOTS};
use chamber::effects::{EffectSet, Empirical};
use chamber::real::Real;
use core::hint::black_box;

/// The only effect on the gas that such tests have.
pub const EFFECTS: EffectSet = Empirical::SET;

/// y, if a scenario has such a term.
fn heat_flow(scenario: &Scenario) -> Option<Hinges> {
    Hinges::of(scenario.chamber.effects.of(Empirical::INDEX))
}

/// Whether the empirical curve is a heat flow as a function of pressure.
pub fn has_heat_flow(scenario: &Scenario) -> bool {
    heat_flow(scenario).is_some()
}

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct HeatFlowTest {
    gas: SealedTest,
    heat_flow: Hinges,
    /// 1/(m cv), K/J.
    per_capacity: f64,
}

impl TestSystem<1> for HeatFlowTest {
    const HAS_ANOTHER_WAY: bool = true;
    type Moving = Moving;
    type Held = Held;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let gas = SealedTest::new(s);
        let per_capacity = gas.closed.expansion / gas.closed.mass_gas_constant;
        Self { gas, heat_flow: heat_flow(s).unwrap_or(Hinges::NONE), per_capacity }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 1] {
        self.gas.start(s)
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        &self.gas
    }

    #[inline]
    fn goes_one_way(&self, &[root]: &[f64; 1]) -> bool {
        root > 0.0 && root < f64::INFINITY
    }
}

/// The warming of the gas by the heat flow.
#[derive(Clone)]
struct Source {
    /// y/(m cv), K/s, times p while the piston moves.
    warming: Hinges<Lanes>,
    /// P V/T, J/K; while the piston rests P/T, Pa/K.
    per_temperature: Lanes,
}

impl Default for Source {
    fn default() -> Self {
        Self { warming: Hinges::NONE, per_temperature: Lanes::ZERO }
    }
}

impl Source {
    /// Loads a test into a lane, multiplied by `factor`.
    #[inline(always)]
    fn load(&mut self, lane: usize, test: &HeatFlowTest, factor: f64, per_temperature: f64) {
        let (to, from, factor) = (&mut self.warming, &test.heat_flow, test.per_capacity * factor);
        to.first[lane] = from.first * factor;
        for k in 0..KNOTS {
            to.knots[k][lane] = from.knots[k];
            to.slope_changes[k][lane] = from.slope_changes[k] * factor;
        }
        self.per_temperature[lane] = per_temperature;
    }

    /// Warming at a pressure, Pa.
    #[inline(always)]
    fn at(&self, pressure: Lanes) -> Lanes {
        let Hinges { first, knots, slope_changes } = &self.warming;
        let mut sum = *first;
        for k in 0..KNOTS {
            sum += slope_changes[k] * (pressure - knots[k]).max(Lanes::ZERO);
        }
        sum
    }

    /// The warming around a temperature as a linear function of temperature, while the piston rests: intercept and slope.
    #[inline(always)]
    fn line(&self, temperature: Lanes) -> [Lanes; 2] {
        let Hinges { first, knots, slope_changes } = &self.warming;
        let pressure = temperature * self.per_temperature;
        let (mut level, mut steepness) = (*first, Lanes::ZERO);
        for k in 0..KNOTS {
            let bend = (pressure - knots[k]).where_positive(slope_changes[k], Lanes::ZERO);
            level -= bend * knots[k];
            steepness += bend;
        }
        [level, steepness * self.per_temperature]
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    gas: sealed::Moving,
    source: Source,
}

impl LaneSystem<1> for Moving {
    type Row = HeatFlowTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &HeatFlowTest) {
        self.gas.load(lane, &test.gas);
        self.source.load(lane, test, test.gas.transformation.pace_factor, test.gas.closed.mass_gas_constant);
    }

    #[inline(always)]
    fn rates(&self, s: Lanes, &[state]: &[Lanes; 1]) -> Moment<1> {
        let root = self.gas.transformation.root(s);
        let square = root * root;
        // Two quotients by one division.
        let per_both = (root * state).recip();
        let (per_root, per_state) = (per_both * state, per_both * root);
        let (temperature, per_square) = (state * state, per_root * per_root);
        let pressure = self.source.per_temperature * temperature * (per_square * per_square);
        let source = self.source.at(pressure) * (square * root) * (per_state * per_state);
        let heat = self.gas.exchange_at([root, square]) * (self.gas.wall - temperature) + source;
        let work = self.gas.expansion_rate * per_root;
        // P is proportional to T/w⁴.
        let rise = pressure * (heat - work - self.gas.transformation.root_rate * per_root * 4.0);
        let view = View { value: [pressure, temperature], slope: [rise, Lanes::ZERO] };
        let power = [temperature * heat, temperature * work];
        Moment { slope: [state * 0.5 * (heat - work)], view, power }
    }

    #[inline(always)]
    fn has_kinks(&self) -> bool {
        true
    }

    #[inline(always)]
    fn widening(&self, at: Lanes) -> Lanes {
        self.gas.transformation.widening(at)
    }

    #[inline(always)]
    fn kink(&self, from: Lanes, to: Lanes) -> Lanes {
        self.source.warming.pressure_kink(from, to)
    }
}

/// Tests, one per lane, while their pistons rest.
#[derive(Clone, Default)]
pub struct Held {
    gas: sealed::Held,
    source: Source,
}

impl Held {
    /// Taylor coefficients of T in a state, with a heat flow linear in T.
    #[inline(always)]
    fn series_along(&self, [level, steepness]: [Lanes; 2], state: Lanes, length: Lanes) -> [Lanes; 4] {
        let (temperature, exchange) = (state * state, self.gas.exchange * length);
        let linear = exchange * self.gas.wall + steepness * length;
        let first = temperature * (linear - exchange * temperature) + level * length;
        let bend = linear - exchange * temperature * 2.0;
        let second = first * bend * 0.5;
        let third = (second * bend - exchange * (first * first)) * (1.0 / 3.0);
        [temperature, first, second, third]
    }
}

impl LaneSystem<1> for Held {
    type Row = HeatFlowTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &HeatFlowTest) {
        self.gas.load(lane, &test.gas);
        self.source.load(lane, test, 1.0, test.gas.pressure_per_temperature());
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, &[state]: &[Lanes; 1]) -> Moment<1> {
        let temperature = state * state;
        let pressure = self.source.per_temperature * temperature;
        let warming = temperature * (self.gas.exchange * (self.gas.wall - temperature)) + self.source.at(pressure);
        let slope = [self.source.per_temperature * warming, warming];
        let view = View { value: [pressure, temperature], slope };
        Moment { slope: [warming * 0.5 / state], view, power: [warming, Lanes::ZERO] }
    }

    #[inline(always)]
    fn has_kinks(&self) -> bool {
        true
    }

    #[inline(always)]
    fn kink(&self, from: Lanes, to: Lanes) -> Lanes {
        self.source.warming.pressure_kink(from, to)
    }
}

impl Holding<1> for Held {
    #[inline(always)]
    fn guess(&self, [state, _]: [&[Lanes; 1]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(state[0] * state[0], begin)
    }

    #[inline(always)]
    fn series(&self, &[state]: &[Lanes; 1], length: Lanes) -> [Lanes; 4] {
        self.series_along(self.source.line(state * state), state, length)
    }

    /// With the heat flow linearised in the middle of the step.
    #[inline(always)]
    fn within(&self, [begin, end]: [&[Lanes; 1]; 2], length: Lanes) -> Hermite {
        let middle = (begin[0] + end[0]) * 0.5;
        let line = black_box(self.source.line(middle * middle));
        let before = black_box(self.series_along(line, begin[0], length));
        let after = black_box(self.series_along(line, end[0], length));
        black_box(Hermite::new(before, after))
    }
}
