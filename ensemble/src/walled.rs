//! The paper's model with the port closed and a wall that the gas warms and the surroundings cool, in lanes: beside the
//! temperature of the gas, as in [`crate::sealed`], that of the wall is a state. With the same clock,
//!
//! dT/ds = T (q − 4 (γ − 1) w'/w),  q = c p (a1 w⁴ + a0) w (Tw − T),  dTw/ds = −r T q + g p w³ (Tamb − Tw)
//! r = m cv/C_w,  g = G/C_w
//!
//! C_w  J/K  capacity of the wall that takes part; G  W/K  conductance from wall to surroundings. T in K, g in 1/s.
//!
//! While the piston rests T goes one way if, when it comes to rest, (T − Tw) (Tw − Tamb) is not negative: where T first met
//! Tw, the wall would have to be on the other side of Tamb, from which neither the gas nor the surroundings push it there.

use crate::advance::Loadable;
use crate::lanes::Lanes;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::sealed::{self, Holding, OwnTest, Test};
use crate::step::{LaneSystem, Moment, View};
use chamber::effects::{self, EffectSet};
use chamber::real::Real;

/// The effect on the gas, of those that there are, that such tests have.
pub const EFFECTS: EffectSet = EffectSet::from_bits(crate::bit(NAME));
const NAME: &str = "wall_heating";

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct WalledTest {
    gas: Test,
    /// r.
    share: f64,
    /// g, 1/s.
    cooling: f64,
}

/// C_w, J/K, and G, W/K.
fn wall(scenario: &Scenario) -> [f64; 2] {
    let parameters = scenario.chamber.effects.of(const { crate::place(NAME) });
    [parameters[0], parameters[1]]
}

/// Whether there is a wall that warms.
pub fn has_wall(scenario: &Scenario) -> bool {
    wall(scenario)[0] > 0.0
}

impl OwnTest<2> for WalledTest {
    const HAS_ANOTHER_WAY: bool = true;
    type Moving<'a> = Moving<'a>;
    type Held<'a> = Held<'a>;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let (gas, [capacity, conductance]) = (Test::new(s), wall(s));
        Self { gas, share: gas.capacity() / capacity, cooling: conductance / capacity }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 2] {
        [s.initial_temperature_k.sqrt(), s.ambient_temperature_k]
    }

    #[inline]
    fn gas(&self) -> &Test {
        &self.gas
    }

    #[inline]
    fn goes_one_way(&self, &[root, wall]: &[f64; 2]) -> bool {
        let (over_wall, over_ambient) = (root * root - wall, wall - self.gas.closed.ambient_temperature);
        over_wall * over_ambient >= 0.0 && (over_wall != 0.0 || over_ambient == 0.0)
    }

    fn moving(tests: &[Self]) -> Moving<'_> {
        Moving { tests, gas: sealed::Moving::NONE, share: Lanes::ZERO, cooling: Lanes::ZERO }
    }

    fn held(tests: &[Self]) -> Held<'_> {
        Held { tests, gas: sealed::Held::NONE, share: Lanes::ZERO, cooling: Lanes::ZERO }
    }
}

/// Tests, one a lane, while their pistons move.
#[derive(Clone)]
pub struct Moving<'a> {
    tests: &'a [WalledTest],
    /// With the surroundings' temperature in the place of the wall's.
    gas: sealed::Moving<'static>,
    share: Lanes,
    /// g p.
    cooling: Lanes,
}

impl Loadable for Moving<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.gas.load_test(lane, &test.gas);
        self.share[lane] = test.share;
        self.cooling[lane] = test.cooling * test.gas.clock.pace_factor;
    }
}

impl LaneSystem<2> for Moving<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, t: Lanes, &[state, wall]: &[Lanes; 2]) -> Moment<2> {
        let root = self.gas.clock.root(t);
        let square = root * root;
        let temperature = state * state;
        let [heat, work] = self.gas.heat_and_work([root, square], wall - temperature);
        let power = [temperature * heat, temperature * work];
        let warming = self.cooling * (square * root) * (self.gas.wall - wall) - self.share * power[0];
        Moment { slope: [state * 0.5 * (heat - work), warming], view: View::NONE, power }
    }
}

/// Tests, one a lane, while their pistons rest.
#[derive(Clone)]
pub struct Held<'a> {
    tests: &'a [WalledTest],
    /// With the surroundings' temperature in the place of the wall's.
    gas: sealed::Held<'static>,
    share: Lanes,
    cooling: Lanes,
}

impl Loadable for Held<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.gas.load_test(lane, &test.gas);
        self.share[lane] = test.share;
        self.cooling[lane] = test.cooling;
    }
}

impl LaneSystem<2> for Held<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, _: Lanes, &[state, wall]: &[Lanes; 2]) -> Moment<2> {
        let temperature = state * state;
        let heat = self.gas.exchange * (wall - temperature);
        let power = [temperature * heat, Lanes::ZERO];
        let warming = self.cooling * (self.gas.wall - wall) - self.share * power[0];
        // The pressure is in proportion to the temperature.
        let view = View { value: [temperature; 2], slope: [power[0]; 2] };
        Moment { slope: [state * 0.5 * heat, warming], view, power }
    }
}

impl Holding<2> for Held<'_> {
    #[inline(always)]
    fn guess(&self, [state, _]: [&[Lanes; 2]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(state[0] * state[0], begin)
    }

    /// By the equations' recursion: each coefficient follows from those of lower powers.
    #[inline(always)]
    fn series(&self, &[state, wall]: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        let (exchange, cooling) = (self.gas.exchange * length, self.cooling * length);
        let (mut gas, mut wall) =
            ([state * state, Lanes::ZERO, Lanes::ZERO, Lanes::ZERO], [wall, Lanes::ZERO, Lanes::ZERO]);
        let mut lost = cooling * (self.gas.wall - wall[0]);
        for order in 0..3 {
            let mut heat = Lanes::ZERO;
            for part in 0..=order {
                heat += gas[part] * (wall[order - part] - gas[order - part]);
            }
            let (heat, per_order) = (exchange * heat, 1.0 / (order + 1) as f64);
            gas[order + 1] = heat * per_order;
            if order < 2 {
                wall[order + 1] = (lost - self.share * heat) * per_order;
                lost = -cooling * wall[order + 1];
            }
        }
        gas
    }
}

const _: () = assert!(effects::CARDS[crate::place(NAME)].parameters.len() == 2);
