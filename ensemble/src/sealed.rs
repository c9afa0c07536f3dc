//! The paper's model with the port closed and without effects, in lanes: the mass is constant, so temperature is the
//! only state, and equations (2), (3), (5) and (27) in it read
//!
//! dT/dt = T (c (a1 V + a0)/√V (Tw − T) − (γ − 1) V̇/V),  c = λ0 √(m R/(P0 T0))/(m cv),  Aq = a1 V + a0
//!
//! While the piston moves, the clock is that of [`crate::clock`]: w = V^(1/4) is linear in s, and
//!
//! dT/ds = T (c p (a1 w⁴ + a0) w (Tw − T) − 4 (γ − 1) w'/w),  dt/ds = p w³
//!
//! takes one division an evaluation and no root. While the piston rests, V and all that follows from it alone is
//! constant. The state is √T: in it the integrals of heat and work over a step are others than that of the state. T in K, V
//! in m³, energies over m cv.

use crate::advance::LONGEST_OF_MOVE;
use crate::clock::Clock;
use crate::fit;
use crate::hermite::Hermite;
use crate::lanes::Lanes;
use crate::outcome::{Outcome, Standing, to_be_lost};
use crate::problem::{Loadable, Problem};
use crate::regression::{Guess, Regression};
use crate::scenario::Scenario;
use crate::step::{LaneSystem, Moment, View};
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Tests of N states, of which a record shows a reading that the pressure of the hold is in proportion to. Unless told otherwise
/// the port is closed, the root of the temperature is the first state, and the temperature is the reading.
pub trait OwnTest<const N: usize>: Sized {
    /// Whether tests that this way does not solve are solved in another.
    const HAS_ANOTHER_WAY: bool;
    /// Whether holds can turn round: see [`crate::turns`].
    const TURNS: bool = false;
    /// Longest step through a hold, as a share of it. Sums over samples need it where nothing else bounds steps by how far the
    /// record goes.
    const LONGEST: f64 = f64::INFINITY;
    /// Tests, one a lane, while their pistons move.
    type Moving<'a>: LaneSystem<N> + Loadable + Clone
    where
        Self: 'a;
    /// The same while their pistons rest.
    type Held<'a>: Holding<N> + Clone
    where
        Self: 'a;

    /// From a checked scenario.
    fn new(scenario: &Scenario) -> Self;
    /// States at the start of the push.
    fn start(&self, scenario: &Scenario) -> [f64; N];
    /// The reading there.
    #[inline]
    fn start_reading(&self, scenario: &Scenario) -> f64 {
        scenario.initial_temperature_k
    }
    /// The gas and its clock.
    fn gas(&self) -> &Test;
    /// Temperatures, K, in some states with these readings.
    #[inline]
    fn temperatures(_: [&[f64; N]; 2], readings: [f64; 2]) -> [f64; 2] {
        readings
    }
    /// Numbers that rise with the reading and with the temperature.
    #[inline]
    fn order(states: &[f64; N]) -> [f64; 2] {
        [states[0]; 2]
    }
    /// The reading of the same gas at the temperature of the surroundings.
    #[inline]
    fn reading_at_rest(&self, _: &[f64; N]) -> f64 {
        self.gas().closed.ambient_temperature
    }
    /// Pressure of the hold, Pa, over the reading.
    #[inline]
    fn pressure_per_reading(&self) -> f64 {
        self.gas().pressure_per_temperature()
    }
    /// Length of the push's first step, as a share of the push; zero where that is to be found out.
    fn first_step(&self) -> f64 {
        0.0
    }
    /// The push of a scenario, to be integrated.
    #[inline]
    fn push(&self, scenario: &Scenario) -> Problem<N> {
        let mut push = Problem::new(scenario.push_time_s, self.start(scenario), [0.0; N]);
        push.first = self.first_step() * push.length;
        push.longest = LONGEST_OF_MOVE * push.length;
        push
    }
    /// Prepares pushes for their integration, to a relative tolerance: takes them ahead to where it begins, if that is not where they
    /// start.
    fn begin(_: Arch, _: &mut [Self], _: &mut [Problem<N>], _: f64) {}
    /// Energy received as heat and enthalpy during the push, and work, by what of them was integrated.
    #[inline]
    fn energy_of_push(&self, integrated: [f64; 2]) -> [f64; 2] {
        integrated
    }
    /// States of the hold by those that the push ends with.
    #[inline]
    fn at_rest(&self, pushed: [f64; N]) -> [f64; N] {
        pushed
    }
    /// Whether a hold goes one way from where the push ends with these states, or may turn round as [`OwnTest::TURNS`] has it.
    fn goes_one_way(&self, states: &[f64; N]) -> bool;
    /// Whether a reading and a temperature that both fall when a hold begins are known to come to no peak behind it, by the states at
    /// its end.
    #[inline]
    fn falls_on(&self, _: &[f64; N]) -> bool {
        false
    }
    /// No test loaded yet.
    fn moving(tests: &[Self]) -> Self::Moving<'_>;
    /// No test loaded yet.
    fn held(tests: &[Self]) -> Self::Held<'_>;
}

/// Holds, one a lane.
pub trait Holding<const N: usize>: LaneSystem<N> + Loadable {
    /// Whether the code of [`Holding::within`] is so long that there should be one copy.
    const IS_LONG: bool = false;
    /// A guess of the paper's exponential near to a hold from some states to others, that begins at a time of the test, s.
    fn guess(&self, ends: [&[Lanes; N]; 2], begin: Lanes) -> Guess;
    /// What the record shows of some states, in the unit of [`OwnTest::start_reading`].
    #[inline(always)]
    fn reading<R: Real>(states: &[R; N]) -> R {
        states[0] * states[0]
    }
    /// Taylor coefficients of the reading in some states, in powers of the time over `length`, s.
    fn series(&self, state: &[Lanes; N], length: Lanes) -> [Lanes; 4];
    /// The reading over a step of `length`, s, between two states. It comes from the equations at its ends: as good as the
    /// integrator's own polynomial of degree 7, at a fraction of its stages.
    #[inline(always)]
    fn within(&self, [begin, end]: [&[Lanes; N]; 2], length: Lanes) -> Hermite<Lanes> {
        // Results pass through memory: else the compiler computes them lane by lane.
        let before = black_box(self.series(begin, length));
        let after = black_box(self.series(end, length));
        black_box(Hermite::new(before, after))
    }
}

/// [`Holding::within`], where that is long as a function of its own.
pub struct Within<'a, const N: usize, H> {
    /// Constants of the tests.
    pub system: &'a H,
    /// States at the start and at the end.
    pub ends: [&'a [Lanes; N]; 2],
    /// Length of the step, s.
    pub length: Lanes,
}

impl<const N: usize, H: Holding<N>> Within<'_, N, H> {
    /// That polynomial, with the instructions of the function around.
    #[inline(always)]
    pub fn polynomial<I: Simd>(self, simd: I) -> Hermite<Lanes> {
        if H::IS_LONG { simd.vectorize(self) } else { self.with_simd(simd) }
    }
}

impl<const N: usize, H: Holding<N>> WithSimd for Within<'_, N, H> {
    type Output = Hermite<Lanes>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Hermite<Lanes> {
        self.system.within(self.ends, self.length)
    }
}

/// One test, reduced to the numbers its equation needs.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// c a1, c a0, γ − 1, Tw and m R.
    pub closed: Closed,
    /// The clock of the push.
    pub clock: Clock,
    /// Volume of the hold, m³.
    pub held_volume: f64,
    /// 1/τ_f, 1/s: c Aq/√V Tw in the hold.
    pub rate: f64,
}

impl OwnTest<1> for Test {
    const HAS_ANOTHER_WAY: bool = false;
    type Moving<'a> = Moving<'a>;
    type Held<'a> = Held<'a>;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let geometry = &s.chamber.geometry;
        let [volume, held_volume] = [s.initial_position_m, s.final_position_m].map(|x| geometry.volume(x));
        let (pressure, start) = (s.initial_pressure_pa, s.initial_temperature_k);
        let closed = Closed::filled(&s.chamber, pressure, start, volume, s.ambient_temperature_k);
        Self {
            closed,
            clock: Clock::new(volume, held_volume, s.push_time_s),
            held_volume,
            rate: closed.rate(held_volume),
        }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 1] {
        [s.initial_temperature_k.sqrt()]
    }

    #[inline]
    fn gas(&self) -> &Test {
        self
    }

    #[inline]
    fn goes_one_way(&self, _: &[f64; 1]) -> bool {
        true
    }

    fn moving(tests: &[Self]) -> Moving<'_> {
        Moving { tests, ..Moving::NONE }
    }

    fn held(tests: &[Self]) -> Held<'_> {
        Held { tests, ..Held::NONE }
    }
}

impl Test {
    /// P/T in the hold, Pa/K.
    #[inline]
    pub fn pressure_per_temperature(&self) -> f64 {
        self.closed.mass_gas_constant / self.held_volume
    }

    /// m cv, J/K.
    #[inline]
    pub fn capacity(&self) -> f64 {
        self.closed.mass_gas_constant / self.closed.expansion
    }
}

/// How a test has ended, by the temperature of its gas, or by whatever else the pressure of its hold is in proportion to.
pub struct Ending<'a> {
    /// What was pushed and held, and how.
    pub scenario: &'a Scenario,
    /// Length of the test, s.
    pub duration: f64,
    /// Temperature that the wall has at last, K.
    pub wall: f64,
    /// Temperature at the end of the push, K: from there it goes one way.
    pub pushed: f64,
    /// Temperature at the end, K.
    pub end: f64,
    /// P/T in the hold, Pa/K.
    pub pressure_per_temperature: f64,
    /// From the end of the push until within 1 %, s.
    pub settling: f64,
    /// What gas that flows in or out as at the end changes in as long as the hold has lasted, K; zero of a closed chamber.
    pub flowing: f64,
    /// The rate of its pressure at the end over the pressure, times the hold; none of a closed chamber, in which the wall tells it.
    pub relative_rate: Option<f64>,
    /// The paper's regression of its record, where it was asked for.
    pub regression: Option<Regression>,
}

impl Ending<'_> {
    /// The outcome, of the exact solution.
    #[inline]
    pub fn outcome(&self) -> Outcome {
        let (s, pushed, end) = (self.scenario, self.pushed, self.end);
        let positions = [s.initial_position_m, s.final_position_m];
        let peak = s.peak([pushed, end]);
        let to_be_lost = self.relative_rate.map_or(end - self.wall, |rate| to_be_lost(end - self.wall, -end * rate));
        let (to_come, distance) = (to_be_lost.abs(), (peak - end).abs());
        let standing = Standing { distance, to_come, going_on: self.flowing, stands: pushed == end };
        let (settling_time_s, flows_on) = standing.judge(self.settling);
        Outcome {
            pressure_peak_pa: peak * self.pressure_per_temperature,
            pressure_final_pa: end * self.pressure_per_temperature,
            temperature_final_k: end,
            temperature_peak_k: peak,
            // A record that peaks at its end has no relaxation to describe.
            fit: (self.regression.filter(|_| peak == pushed))
                .and_then(|found| fit::steps(s, positions, s.initial_pressure_pa, found)),
            settling_time_s,
            flows_on,
            energy_error: 0.0,
            duration_s: self.duration,
            exact: true,
            status: Ok(()),
        }
    }
}

/// Tests, one a lane, while their pistons move.
#[derive(Clone)]
pub struct Moving<'a> {
    tests: &'a [Test],
    /// Their clocks.
    pub clock: Clock<Lanes>,
    /// c a1 p and c a0 p.
    exchange: [Lanes; 2],
    /// 4 (γ − 1) w'.
    pub expansion_rate: Lanes,
    /// Temperatures of their walls, K.
    pub wall: Lanes,
}

impl Loadable for Moving<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        self.load_test(lane, &self.tests[index]);
    }
}

impl Moving<'_> {
    /// For tests that are loaded as they come.
    pub const NONE: Moving<'static> = Moving {
        tests: &[],
        clock: Clock::NONE,
        exchange: [Lanes::ZERO; 2],
        expansion_rate: Lanes::ZERO,
        wall: Lanes::ZERO,
    };

    /// Puts the constants of a test into a lane.
    #[inline(always)]
    pub fn load_test(&mut self, lane: usize, test: &Test) {
        self.clock.load(lane, &test.clock);
        self.exchange[0][lane] = test.closed.exchange[0] * test.clock.pace_factor;
        self.exchange[1][lane] = test.closed.exchange[1] * test.clock.pace_factor;
        self.expansion_rate[lane] = 4.0 * test.closed.expansion * test.clock.root_rate;
        self.wall[lane] = test.closed.ambient_temperature;
    }

    /// c p (a1 w⁴ + a0) w, at w and w².
    #[inline(always)]
    pub fn exchange_at(&self, [root, square]: [Lanes; 2]) -> Lanes {
        (self.exchange[0] * (square * square) + self.exchange[1]) * root
    }

    /// Heat and work over m cv T, per unit of the clock, at w and w², where the wall is so much warmer than the gas.
    #[inline(always)]
    pub fn heat_and_work(&self, at: [Lanes; 2], warmer: Lanes) -> [Lanes; 2] {
        [self.exchange_at(at) * warmer, self.expansion_rate / at[0]]
    }
}

impl LaneSystem<1> for Moving<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, t: Lanes, y: &[Lanes; 1]) -> Moment<1> {
        let root = self.clock.root(t);
        let square = root * root;
        let temperature = y[0] * y[0];
        let [heat, work] = self.heat_and_work([root, square], self.wall - temperature);
        let slope = [y[0] * 0.5 * (heat - work)];
        Moment { slope, view: View::NONE, power: [temperature * heat, temperature * work] }
    }
}

/// Tests, one a lane, while their pistons rest.
#[derive(Clone)]
pub struct Held<'a> {
    tests: &'a [Test],
    /// c Aq/√V, 1/(K s).
    pub exchange: Lanes,
    /// Temperatures of their walls, K.
    pub wall: Lanes,
}

impl Held<'_> {
    /// For tests that are loaded as they come.
    pub const NONE: Held<'static> = Held { tests: &[], exchange: Lanes::ZERO, wall: Lanes::ZERO };

    /// Puts the constants of a test into a lane.
    #[inline(always)]
    pub fn load_test(&mut self, lane: usize, test: &Test) {
        self.exchange[lane] = test.rate / test.closed.ambient_temperature;
        self.wall[lane] = test.closed.ambient_temperature;
    }

    /// A guess of the paper's exponential near to a hold that begins at a temperature, K, and a time of the test, s.
    #[inline(always)]
    pub fn guess_from(&self, peak: Lanes, from: Lanes) -> Guess {
        Guess::Relaxation { rate: self.exchange * self.wall, excess: Lanes::ONE - self.wall / peak, from }
    }
}

impl Holding<1> for Held<'_> {
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

impl Loadable for Held<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        self.load_test(lane, &self.tests[index]);
    }
}

impl LaneSystem<1> for Held<'_> {
    const CHEAP: bool = true;

    #[inline(always)]
    fn rates(&self, _: Lanes, y: &[Lanes; 1]) -> Moment<1> {
        let temperature = y[0] * y[0];
        let heat = self.exchange * (self.wall - temperature);
        Moment { slope: [y[0] * 0.5 * heat], view: View::NONE, power: [temperature * heat, Lanes::ZERO] }
    }
}
