//! The paper's model with the port closed and a wall that the gas warms and the surroundings cool, in lanes: beside the gas temperature,
//! as in [`crate::systems::sealed`], the wall temperature is a state. With the same transformed time,
//!
//! dT/ds = T (q − 4 (γ − 1) w'/w),  q = c p (a1 w⁴ + a0) w (Tw − T),  dTw/ds = −r T q + g p w³ (Tamb − Tw)
//! r = m cv/C_w,  g = G/C_w
//!
//! C_w  J/K  capacity of the wall that takes part; G  W/K  conductance from wall to surroundings. T in K, g in 1/s.
//!
//! While the piston rests the equations are dT/dt = k T (Tw − T) and dTw/dt = −r dT/dt + g (Tamb − Tw), k = c Aq/√V: steps use their
//! Taylor series ([`crate::integrator::expansion`]), each coefficient of which takes one product of series.
//!
//! While the piston rests T is monotone if (T − Tw) (Tw − Tamb) is not negative initially: to let T meet Tw, the wall would have to be
//! on the other side of Tamb, where neither the gas nor the surroundings drive it.

use crate::integrator::expansion::Expansion;
use crate::integrator::step::{LaneSystem, Moment, View};
use crate::lanes::{Lanes, multiply_add};
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::effects::{self, EffectSet, WallHeating};
use chamber::real::Real;
use core::hint::black_box;

/// The only effect on the gas that such tests have.
pub const EFFECTS: EffectSet = WallHeating::SET;

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct WallHeatingTest {
    gas: SealedTest,
    /// r.
    share: f64,
    /// g, 1/s.
    cooling: f64,
    /// Approximate decay rate of small temperature differences, 1/s.
    pace: f64,
}

/// C_w, J/K, and G, W/K.
fn wall(scenario: &Scenario) -> [f64; 2] {
    let parameters = scenario.chamber.effects.of(WallHeating::INDEX);
    [parameters[0], parameters[1]]
}

/// Whether the wall can warm.
pub fn has_wall(scenario: &Scenario) -> bool {
    wall(scenario)[0] > 0.0
}

impl TestSystem<2> for WallHeatingTest {
    const HAS_ANOTHER_WAY: bool = true;
    type Moving = Moving;
    type Held = Held;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let (gas, [capacity, conductance]) = (SealedTest::new(s), wall(s));
        let (share, cooling) = (gas.capacity() / capacity, conductance / capacity);
        let pace = (gas.rate * (1.0 + share) + cooling).max(f64::MIN_POSITIVE);
        Self { gas, share, cooling, pace }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 2] {
        [s.initial_temperature_k.sqrt(), s.ambient_temperature_k]
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        &self.gas
    }

    #[inline]
    fn goes_one_way(&self, &[root, wall]: &[f64; 2]) -> bool {
        let (over_wall, over_ambient) = (root * root - wall, wall - self.gas.closed.ambient_temperature);
        over_wall * over_ambient >= 0.0 && (over_wall != 0.0 || over_ambient == 0.0)
    }

    /// T itself, as its series takes one product of series and that of √T two.
    #[inline]
    fn at_rest(&self, [root, wall]: [f64; 2]) -> [f64; 2] {
        [root * root, wall]
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    /// With the surroundings' temperature in the place of the wall's.
    gas: sealed::Moving,
    share: Lanes,
    /// g p.
    cooling: Lanes,
}

impl LaneSystem<2> for Moving {
    type Row = WallHeatingTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &WallHeatingTest) {
        self.gas.load(lane, &test.gas);
        self.share[lane] = test.share;
        self.cooling[lane] = test.cooling * test.gas.transformation.pace_factor;
    }

    #[inline(always)]
    fn rates(&self, t: Lanes, &[state, wall]: &[Lanes; 2]) -> Moment<2> {
        let root = self.gas.transformation.root(t);
        let square = root * root;
        let temperature = state * state;
        let [heat, work] = self.gas.heat_and_work([root, square], wall - temperature);
        let power = [temperature * heat, temperature * work];
        let warming = self.cooling * (square * root) * (self.gas.wall - wall) - self.share * power[0];
        Moment { slope: [state * 0.5 * (heat - work), warming], view: View::NONE, power }
    }
}

/// Tests, one per lane, while their pistons rest. The states are T and Tw.
#[derive(Clone, Default)]
pub struct Held {
    /// With the surroundings' temperature in the place of the wall's.
    gas: sealed::Held,
    share: Lanes,
    cooling: Lanes,
    /// Approximate decay rate of small temperature differences, 1/s, and its reciprocal.
    pace: Lanes,
    unit: Lanes,
}

/// Applies a macro to the powers from 1 on, each with those between it and 0, the middle ones first, so that the latest results are
/// needed last.
macro_rules! each_power {
    ($apply:ident) => {
        $apply! {
            1: ; 2: 1; 3: 1 2; 4: 2 1 3; 5: 2 3 1 4; 6: 3 2 4 1 5; 7: 3 4 2 5 1 6; 8: 4 3 5 2 6 1 7; 9: 4 5 3 6 2 7 1 8;
            10: 5 4 6 3 7 2 8 1 9; 11: 5 6 4 7 3 8 2 9 1 10;
        }
    };
}

impl Held {
    /// Taylor coefficients of T and Tw in powers of the time over `unit`, s. Each follows from those of lower powers,
    ///
    /// (j + 1) T_(j+1) = k u Σ T_i D_(j−i),  (j + 1) Tw_(j+1) = −r (j + 1) T_(j+1) − g u (Tw − Tamb)_j,  D = Tw − T
    ///
    /// The terms with i = j and i = 0 of the sum combine to T_j (D_0 − (1 + r) T_0), so that little depends on T_j.
    // The last difference is not used.
    #[allow(unused_assignments)]
    #[inline(always)]
    fn terms<const M: usize>(&self, &[temperature, wall]: &[Lanes; 2], unit: Lanes) -> [[Lanes; M]; 2] {
        let (exchange, cooling) = (self.gas.exchange * unit, self.cooling * unit);
        // Coefficients of T, of Tw and of Tw − T.
        let [mut gas, mut warm, mut warmer] = [[Lanes::ZERO; M]; 3];
        (gas[0], warm[0], warmer[0]) = (temperature, wall, wall - temperature);
        let both = self.share + 1.0;
        let balance = warmer[0] - both * temperature;
        let mut lost = (wall - self.gas.wall) * cooling;
        let mut rise = temperature * warmer[0] * exchange;
        macro_rules! next {
            ($($power:literal: $($part:literal)*;)*) => {$(
                if $power + 1 < M {
                    gas[$power] = rise;
                    warm[$power] = -multiply_add::<true>(self.share, rise, lost);
                    warmer[$power] = -multiply_add::<true>(both, rise, lost);
                    let mut heat = -(temperature * lost);
                    $(heat = multiply_add::<true>(gas[$part], warmer[$power - $part], heat);)*
                    heat = multiply_add::<true>(rise, balance, heat);
                    let per_power = 1.0 / ($power + 1) as f64;
                    rise = heat * (exchange * per_power);
                    lost = warm[$power] * (cooling * per_power);
                }
            )*};
        }
        each_power!(next);
        gas[M - 1] = rise;
        warm[M - 1] = -multiply_add::<true>(self.share, rise, lost);
        [gas, warm]
    }
}

impl LaneSystem<2> for Held {
    type Row = WallHeatingTest;
    const BY_SERIES: bool = true;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &WallHeatingTest) {
        self.gas.load(lane, &test.gas);
        self.share[lane] = test.share;
        self.cooling[lane] = test.cooling;
        (self.pace[lane], self.unit[lane]) = (test.pace, 1.0 / test.pace);
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, &[temperature, wall]: &[Lanes; 2]) -> Moment<2> {
        let heat = temperature * (self.gas.exchange * (wall - temperature));
        let warming = self.cooling * (self.gas.wall - wall) - self.share * heat;
        // The pressure is in proportion to the temperature.
        let view = View { value: [temperature; 2], slope: [heat; 2] };
        Moment { slope: [heat, warming], view, power: [heat, Lanes::ZERO] }
    }

    #[inline(always)]
    fn expansion(&self, states: &[Lanes; 2]) -> Expansion<2> {
        // States and result pass through memory: otherwise the compiler shares subexpressions and computes lanes in odd groups.
        let [temperature, wall] = black_box(states);
        let decay = self.gas.exchange * ((self.share + 2.0) * *temperature - *wall) + self.cooling;
        let decay = black_box(decay * self.unit);
        let terms = self.terms(black_box(states), self.unit);
        Expansion { terms, decay, unit: self.unit, per_unit: self.pace }
    }
}

impl Holding<2> for Held {
    #[inline(always)]
    fn guess(&self, [states, _]: [&[Lanes; 2]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(states[0], begin)
    }

    #[inline(always)]
    fn reading<R: Real>(states: &[R; 2]) -> R {
        states[0]
    }

    #[inline(always)]
    fn series(&self, states: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        let [gas, _] = self.terms(states, length);
        gas
    }
}

const _: () = assert!(effects::CARDS[WallHeating::INDEX].parameters.len() == 2);
