//! What tests with equations of their own have in common for [`adaptive`](crate::own::adaptive): their equations, one test a lane, while
//! the piston moves and while it rests, and what a record shows of their states.

use crate::integrator::advance::LONGEST_OF_MOVE;
use crate::integrator::problem::Problem;
use crate::integrator::step::LaneSystem;
use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::own::gas::SealedTest;
use crate::regression::Guess;
use crate::scenario::Scenario;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Tests of N states, of which a record shows a reading that the pressure of the hold is in proportion to. Unless told otherwise
/// the port is closed, the root of the temperature is the first state, the temperature is the reading, and a hold goes one way.
pub trait OwnTest<const N: usize>: Sized {
    /// Whether tests that this way does not solve are solved in another.
    const HAS_ANOTHER_WAY: bool = false;
    /// Whether holds can turn round: see [`crate::own::turns`].
    const TURNS: bool = false;
    /// Longest step through a hold, as a share of it. Sums over samples need it where nothing else bounds steps by how far the
    /// record goes.
    const LONGEST: f64 = f64::INFINITY;
    /// Tests, one a lane, while their pistons move.
    type Moving: LaneSystem<N, Row = Self> + Default;
    /// The same while their pistons rest.
    type Held: Holding<N, Row = Self> + Default;

    /// From a checked scenario.
    fn new(scenario: &Scenario) -> Self;
    /// A number that tests have in common which should stand side by side.
    fn kind(_: &Scenario) -> u8 {
        0
    }
    /// States at the start of the push.
    fn start(&self, scenario: &Scenario) -> [f64; N];
    /// The reading there.
    #[inline]
    fn start_reading(&self, scenario: &Scenario) -> f64 {
        scenario.initial_temperature_k
    }
    /// The gas and its clock.
    fn gas(&self) -> &SealedTest;
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
    /// The push of a scenario, to be integrated.
    #[inline]
    fn push(&self, scenario: &Scenario) -> Problem<N> {
        let mut push = Problem::new(scenario.push_time_s, self.start(scenario), [0.0; N]);
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
    #[inline]
    fn goes_one_way(&self, _: &[f64; N]) -> bool {
        true
    }
    /// Whether a reading and a temperature that both fall when a hold begins are known to come to no peak behind it, by the states at
    /// its end.
    #[inline]
    fn falls_on(&self, _: &[f64; N]) -> bool {
        false
    }
}

/// Holds, one a lane.
pub trait Holding<const N: usize>: LaneSystem<N> {
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
    fn within(&self, [begin, end]: [&[Lanes; N]; 2], length: Lanes) -> Hermite {
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
    pub fn polynomial<I: Simd>(self, simd: I) -> Hermite {
        if H::IS_LONG { simd.vectorize(self) } else { self.with_simd(simd) }
    }
}

impl<const N: usize, H: Holding<N>> WithSimd for Within<'_, N, H> {
    type Output = Hermite;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Hermite {
        self.system.within(self.ends, self.length)
    }
}
