//! The interface of tests with specialised equations to [`adaptive`](crate::systems::adaptive): their equations, one test per lane, while the
//! piston moves and while it rests, and the reading as a function of their states.

use crate::integrator::advance::LONGEST_OF_MOVE;
use crate::integrator::problem::Problem;
use crate::integrator::step::LaneSystem;
use crate::lanes::Lanes;
use crate::numerics::hermite::Hermite;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Tests with N states and a reading that is proportional to the pressure during the hold. By default the port is closed, the root of
/// the temperature is the first state, the temperature is the reading, and holds are monotone.
pub trait TestSystem<const N: usize>: Sized {
    /// Whether unsolved tests are left to the general integrator.
    const HAS_ANOTHER_WAY: bool = false;
    /// Whether holds can turn: see [`crate::systems::turns`].
    const TURNS: bool = false;
    /// Longest step through a hold, relative to it: needed for the sums over samples if nothing else limits the change of the record in
    /// a step.
    const LONGEST: f64 = f64::INFINITY;
    /// Tests, one per lane, while their pistons move.
    type Moving: LaneSystem<N, Row = Self> + Default;
    /// The same while their pistons rest.
    type Held: Holding<N, Row = Self> + Default;

    /// From a checked scenario.
    fn new(scenario: &Scenario) -> Self;
    /// A key by which tests are sorted: equal ones should be in neighbouring lanes.
    fn kind(_: &Scenario) -> u8 {
        0
    }
    /// States at the start of the push.
    fn start(&self, scenario: &Scenario) -> [f64; N];
    /// Reading there.
    #[inline]
    fn start_reading(&self, scenario: &Scenario) -> f64 {
        scenario.initial_temperature_k
    }
    /// The gas and its time transformation.
    fn gas(&self) -> &SealedTest;
    /// Temperatures, K, in two states with these readings.
    #[inline]
    fn temperatures(_: [&[f64; N]; 2], readings: [f64; 2]) -> [f64; 2] {
        readings
    }
    /// Two numbers that increase with the reading and with the temperature, respectively.
    #[inline]
    fn order(states: &[f64; N]) -> [f64; 2] {
        [states[0]; 2]
    }
    /// Reading of the same gas at ambient temperature.
    #[inline]
    fn reading_at_rest(&self, _: &[f64; N]) -> f64 {
        self.gas().closed.ambient_temperature
    }
    /// Pressure over reading during the hold, Pa per unit of the reading.
    #[inline]
    fn pressure_per_reading(&self) -> f64 {
        self.gas().pressure_per_temperature()
    }
    /// The push, to be integrated.
    #[inline]
    fn push(&self, scenario: &Scenario) -> Problem<N> {
        let mut push = Problem::new(scenario.push_time_s, self.start(scenario), [0.0; N]);
        push.longest = LONGEST_OF_MOVE * push.length;
        push
    }
    /// Prepares pushes for the integration to a relative tolerance: advances them to where it begins, if that is not their start.
    fn begin(_: Arch, _: &mut [Self], _: &mut [Problem<N>], _: f64) {}
    /// Energy received as heat and enthalpy during the push, and work, from their integrated parts.
    #[inline]
    fn energy_of_push(&self, integrated: [f64; 2]) -> [f64; 2] {
        integrated
    }
    /// States at the start of the hold, from those at the end of the push.
    #[inline]
    fn at_rest(&self, pushed: [f64; N]) -> [f64; N] {
        pushed
    }
    /// Whether the hold is monotone after a push that ends in these states, or turns at most as [`TestSystem::TURNS`] allows.
    #[inline]
    fn goes_one_way(&self, _: &[f64; N]) -> bool {
        true
    }
    /// Whether a reading and a temperature that both fall at the start of a hold cannot have a later peak, given the states at its end.
    #[inline]
    fn falls_on(&self, _: &[f64; N]) -> bool {
        false
    }
}

/// Holds, one per lane.
pub trait Holding<const N: usize>: LaneSystem<N> {
    /// Whether the code of [`Holding::within`] is too long for several copies.
    const IS_LONG: bool = false;
    /// A guess of the paper's exponential for a hold between two states that begins at a time of the test, s.
    fn guess(&self, ends: [&[Lanes; N]; 2], begin: Lanes) -> Guess;
    /// Reading in a state, in the unit of [`TestSystem::start_reading`].
    #[inline(always)]
    fn reading<R: Real>(states: &[R; N]) -> R {
        states[0] * states[0]
    }
    /// Taylor coefficients of the reading in a state, in powers of the time over `length`, s.
    fn series(&self, state: &[Lanes; N], length: Lanes) -> [Lanes; 4];
    /// The reading along a step of `length`, s, between two states, from the equations at its ends: as accurate as the integrator's dense
    /// output of degree 7, for a fraction of its stages.
    #[inline(always)]
    fn within(&self, [begin, end]: [&[Lanes; N]; 2], length: Lanes) -> Hermite {
        // Passes through memory: otherwise the compiler computes lane by lane.
        let before = black_box(self.series(begin, length));
        let after = black_box(self.series(end, length));
        black_box(Hermite::new(before, after))
    }
}

/// [`Holding::within`]; not inlined if it is long.
pub struct Within<'a, const N: usize, H> {
    /// Constants of the tests.
    pub system: &'a H,
    /// States at the start and at the end.
    pub ends: [&'a [Lanes; N]; 2],
    /// Length of the step, s.
    pub length: Lanes,
}

impl<const N: usize, H: Holding<N>> Within<'_, N, H> {
    /// That polynomial, in the instruction set in use.
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
