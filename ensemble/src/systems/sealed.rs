//! The paper's model with the port closed and without effects, in lanes: the mass is constant, so that temperature is the only state,
//! and equations (2), (3), (5) and (27) read
//!
//! dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V̇/V),  c = λ0 √(m R/(P0 T0))/(m cv),  Aq = a1 V + a0
//!
//! While the piston moves, the independent variable is that of [`crate::integrator::time_transformation`]: w = V^(1/4) is linear in s, and
//!
//! dT/ds = T (c p (a1 w⁴ + a0) w (Tw − T) − 4 (γ − 1) w'/w),  dt/ds = p w³
//!
//! needs one division per evaluation and no root. While the piston rests, V and all functions of it are constant. The state is √T, so
//! that the integrals of heat and work over a step are independent of the integral of the state. T in K, V in m³, energies over m cv.

use crate::integrator::step::{LaneSystem, Moment, View};
use crate::integrator::time_transformation::TimeTransformation;
use crate::lanes::Lanes;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::exact::Closed;
use chamber::real::Real;

impl TestSystem<1> for SealedTest {
    type Moving = Moving;
    type Held = Held;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let geometry = &s.chamber.geometry;
        let [volume, held_volume] = [s.initial_position_m, s.final_position_m].map(|x| geometry.volume(x));
        let (pressure, start) = (s.initial_pressure_pa, s.initial_temperature_k);
        let closed = Closed::filled(&s.chamber, pressure, start, volume, s.ambient_temperature_k);
        Self {
            closed,
            transformation: TimeTransformation::new(volume, held_volume, s.push_time_s),
            held_volume,
            rate: closed.rate(held_volume),
        }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 1] {
        [s.initial_temperature_k.sqrt()]
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        self
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    /// Their transformations of time.
    pub transformation: TimeTransformation<Lanes>,
    /// c a1 p and c a0 p.
    exchange: [Lanes; 2],
    /// 4 (γ − 1) w'.
    pub expansion_rate: Lanes,
    /// Temperatures of their walls, K.
    pub wall: Lanes,
}

impl Moving {
    /// c p (a1 w⁴ + a0) w, at w and w².
    #[inline(always)]
    pub fn exchange_at(&self, [root, square]: [Lanes; 2]) -> Lanes {
        (self.exchange[0] * (square * square) + self.exchange[1]) * root
    }

    /// Heat and work over m cv T, per unit of transformed time, at w and w²; `warmer` is the wall's temperature less that of the gas, K.
    #[inline(always)]
    pub fn heat_and_work(&self, at: [Lanes; 2], warmer: Lanes) -> [Lanes; 2] {
        [self.exchange_at(at) * warmer, self.expansion_rate / at[0]]
    }
}

impl LaneSystem<1> for Moving {
    type Row = SealedTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &SealedTest) {
        self.transformation.load(lane, &test.transformation);
        self.exchange[0][lane] = test.closed.exchange[0] * test.transformation.pace_factor;
        self.exchange[1][lane] = test.closed.exchange[1] * test.transformation.pace_factor;
        self.expansion_rate[lane] = 4.0 * test.closed.expansion * test.transformation.root_rate;
        self.wall[lane] = test.closed.ambient_temperature;
    }

    #[inline(always)]
    fn rates(&self, t: Lanes, y: &[Lanes; 1]) -> Moment<1> {
        let root = self.transformation.root(t);
        let square = root * root;
        let temperature = y[0] * y[0];
        let [heat, work] = self.heat_and_work([root, square], self.wall - temperature);
        let slope = [y[0] * 0.5 * (heat - work)];
        Moment { slope, view: View::NONE, power: [temperature * heat, temperature * work] }
    }
}

/// Tests, one per lane, while their pistons rest.
#[derive(Clone, Default)]
pub struct Held {
    /// c Aq/√V, 1/(K s).
    pub exchange: Lanes,
    /// Temperatures of their walls, K.
    pub wall: Lanes,
}

impl Held {
    /// A guess of the paper's exponential for a hold that begins at a temperature, K, and a time of the test, s.
    #[inline(always)]
    pub fn guess_from(&self, peak: Lanes, from: Lanes) -> Guess {
        Guess::Relaxation { rate: self.exchange * self.wall, excess: Lanes::ONE - self.wall / peak, from }
    }
}

impl Holding<1> for Held {
    #[inline(always)]
    fn guess(&self, [state, _]: [&[Lanes; 1]; 2], begin: Lanes) -> Guess {
        self.guess_from(state[0] * state[0], begin)
    }

    #[inline(always)]
    fn series(&self, state: &[Lanes; 1], length: Lanes) -> [Lanes; 4] {
        let temperature = state[0] * state[0];
        let exchange = self.exchange * length;
        let first = temperature * (exchange * (self.wall - temperature));
        let bend = exchange * (self.wall - temperature * 2.0);
        let second = first * bend * 0.5;
        let third = (second * bend - exchange * (first * first)) * (1.0 / 3.0);
        [temperature, first, second, third]
    }
}

impl LaneSystem<1> for Held {
    type Row = SealedTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &SealedTest) {
        self.exchange[lane] = test.rate / test.closed.ambient_temperature;
        self.wall[lane] = test.closed.ambient_temperature;
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, y: &[Lanes; 1]) -> Moment<1> {
        let temperature = y[0] * y[0];
        let heat = self.exchange * (self.wall - temperature);
        Moment { slope: [y[0] * 0.5 * heat], view: View::NONE, power: [temperature * heat, Lanes::ZERO] }
    }
}
