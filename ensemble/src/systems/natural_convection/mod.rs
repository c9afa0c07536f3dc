//! Tests with natural convection alone and the port closed, in lanes: the heat transfer coefficient is proportional to a power of the
//! temperature difference. The equation of [`crate::systems::sealed`] has the additional factor u = |(T − Tw)/20 K|^n, which is a state
//! beside T, so that the rates need no power. While the piston moves,
//!
//! dT/ds = T (q u − 4 (γ − 1) w'/w),  du/ds = n u/(T − Tw) dT/ds,  q = c p (a1 w⁴ + a0) w (Tw − T)
//!
//! starting, from near T = Tw, where the solution has no power series, with a series of another kind ([`start`]) and with the bent
//! transformation. While it rests T − Tw cancels in the second equation:
//!
//! dT/dt = k u T (Tw − T),  du/dt = −n k T u²,  k = c Aq/√V
//!
//! The gas has to stay on one side of the wall's temperature ([`stays_on_a_side`]). T in K, k in 1/(K s), u a pure number.

mod hold;
mod record;
pub mod rows;
mod start;

use crate::instructions::Wide;
use crate::integrator::advance::LONGEST;
use crate::integrator::problem::Problem;
use crate::integrator::step::{LaneSystem, Moment, View};
use crate::integrator::time_transformation::TimeTransformation;
use crate::lanes::math;
use crate::lanes::{Lanes, WIDTH};
use crate::plan::starts_singular;
use crate::regression::Guess;
use crate::scenario::Scenario;
use crate::systems::gas::SealedTest;
use crate::systems::sealed;
use crate::systems::test_system::{Holding, TestSystem};
use chamber::effects::natural_convection::{REFERENCE_DIFFERENCE_K, SMALLEST_DIFFERENCE_K};
use chamber::effects::{EffectSet, NaturalConvection};
use chamber::real::Real;
use core::hint::black_box;
use pulp::Arch;
use start::Pushes;

/// The only effect on the gas that such tests have.
pub const EFFECTS: EffectSet = NaturalConvection::SET;

/// Tolerance of the factor, relative to its initial value, in units of the temperature's tolerance. The end of each step of the push
/// recomputes the factor, and in the hold it is smoother than the temperature, whose errors determine the steps.
const MAY_ERR: f64 = 100.0;

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct NaturalConvectionTest {
    gas: SealedTest,
    /// n.
    pub exponent: f64,
    /// Whether it starts at the wall's temperature.
    from_rest: bool,
    /// Transformed time at which the integration begins, s, and heat received and work until then, over m cv, K.
    begun: f64,
    energy: [f64; 2],
}

/// n.
fn exponent(scenario: &Scenario) -> f64 {
    scenario.chamber.effects.of(NaturalConvection::INDEX)[0]
}

/// Whether the heat flow is differentiable: with n below zero the gas reaches the wall's temperature in finite time.
pub fn is_smooth(scenario: &Scenario) -> bool {
    exponent(scenario) > 0.0
}

/// Whether the gas stays on one side of the wall's temperature: if it starts exactly there, or well away from it, and the push drives it
/// away. Very close to it, the difference would be dominated by rounding.
pub fn stays_on_a_side(s: &Scenario) -> bool {
    let above = s.initial_temperature_k - s.ambient_temperature_k;
    let widening = s.final_position_m - s.initial_position_m;
    if above == 0.0 { widening != 0.0 } else { above * widening < 0.0 && !starts_singular(EFFECTS, s) }
}

impl TestSystem<2> for NaturalConvectionTest {
    const HAS_ANOTHER_WAY: bool = true;
    const LONGEST: f64 = LONGEST;
    type Moving = Moving;
    type Held = Held;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let (mut gas, from_rest) = (SealedTest::new(s), s.initial_temperature_k == s.ambient_temperature_k);
        if from_rest {
            gas.transformation = gas.transformation.bent(s.push_time_s);
        }
        Self { gas, exponent: exponent(s), from_rest, begun: 0.0, energy: [0.0; 2] }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 2] {
        let [root] = self.gas.start(s);
        if self.from_rest {
            return [root, 0.0];
        }
        let difference = (s.initial_temperature_k - s.ambient_temperature_k).abs();
        [root, (difference * (1.0 / REFERENCE_DIFFERENCE_K)).powf(self.exponent)]
    }

    fn begin(arch: Arch, tests: &mut [Self], problems: &mut [Problem<2>], relative: f64) {
        for (tests, problems) in tests.chunks_mut(WIDTH).zip(problems.chunks_mut(WIDTH)) {
            let begun = arch.dispatch(Wide(&pushes(tests, problems)));
            for (lane, (test, problem)) in tests.iter_mut().zip(problems).enumerate() {
                if test.from_rest {
                    test.begun = begun.transformed_time[lane];
                    test.energy = begun.energy.map(|energy| energy[lane]);
                    problem.length -= test.begun;
                    problem.state = begun.state.map(|state| state[lane]);
                }
                problem.absolute[1] = relative * MAY_ERR * problem.state[1];
            }
        }
    }

    #[inline]
    fn energy_of_push(&self, integrated: [f64; 2]) -> [f64; 2] {
        [integrated[0] + self.energy[0], integrated[1] + self.energy[1]]
    }

    #[inline]
    fn gas(&self) -> &SealedTest {
        &self.gas
    }
}

/// The pushes of tests, one per lane.
fn pushes(tests: &[NaturalConvectionTest], problems: &[Problem<2>]) -> Pushes {
    let at = |lane: usize| lane.min(tests.len() - 1);
    let gas = |lane: usize| &tests[at(lane)].gas;
    let mut transformation = TimeTransformation::default();
    (0..WIDTH).for_each(|lane| transformation.load(lane, &gas(lane).transformation));
    Pushes {
        transformation,
        exponent: Lanes::from_fn(|lane| tests[at(lane)].exponent),
        expansion: Lanes::from_fn(|lane| gas(lane).closed.expansion),
        exchange: [0, 1].map(|of| Lanes::from_fn(|lane| gas(lane).closed.exchange[of])),
        wall: Lanes::from_fn(|lane| gas(lane).closed.ambient_temperature),
        length: Lanes::from_fn(|lane| problems[at(lane)].length),
    }
}

/// Tests, one per lane, while their pistons move.
#[derive(Clone, Default)]
pub struct Moving {
    gas: sealed::Moving,
    exponent: Lanes,
    /// Transformed time at the start, s.
    begun: Lanes,
}

/// |d/20 K|^n of temperature differences, K. Passes through memory: otherwise the compiler computes lane by lane.
#[inline(always)]
fn power(difference: Lanes, exponent: Lanes) -> Lanes {
    let difference = black_box(difference).abs().max(Lanes::from(SMALLEST_DIFFERENCE_K));
    black_box(math::power(difference * (1.0 / REFERENCE_DIFFERENCE_K), exponent))
}

impl LaneSystem<2> for Moving {
    type Row = NaturalConvectionTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &NaturalConvectionTest) {
        self.gas.load(lane, &test.gas);
        self.exponent[lane] = test.exponent;
        self.begun[lane] = test.begun;
    }

    #[inline(always)]
    fn restore(&self, [state, factor]: &mut [Lanes; 2]) {
        *factor = power(*state * *state - self.gas.wall, self.exponent);
    }

    #[inline(always)]
    fn rates(&self, r: Lanes, &[state, factor]: &[Lanes; 2]) -> Moment<2> {
        let [s, rate] = self.gas.transformation.unbent(self.begun + r);
        let root = self.gas.transformation.root(s);
        let temperature = state * state;
        let warmer = self.gas.wall - temperature;
        // Heat over m cv T (Tw − T), and work over m cv T.
        let exchange = self.gas.exchange_at([root, root * root]) * rate * factor;
        let work = self.gas.expansion_rate * (rate / root);
        let received = temperature * (exchange * warmer);
        let done = temperature * work;
        let slope = [
            state * 0.5 * (exchange * warmer - work),
            self.exponent * factor * (done / warmer - temperature * exchange),
        ];
        Moment { slope, view: View::NONE, power: [received, done] }
    }
}

/// Tests, one per lane, while their pistons rest.
#[derive(Clone, Default)]
pub struct Held {
    gas: sealed::Held,
    exponent: Lanes,
}

impl LaneSystem<2> for Held {
    type Row = NaturalConvectionTest;

    #[inline(always)]
    fn load(&mut self, lane: usize, test: &NaturalConvectionTest) {
        self.gas.load(lane, &test.gas);
        self.exponent[lane] = test.exponent;
    }

    #[inline(always)]
    fn rates(&self, _: Lanes, &[state, factor]: &[Lanes; 2]) -> Moment<2> {
        let (temperature, exchange) = (state * state, self.gas.exchange * factor);
        let (warmer, risen) = (self.gas.wall - temperature, temperature * exchange);
        let slope = [state * 0.5 * (exchange * warmer), -self.exponent * factor * risen];
        Moment { slope, view: View::NONE, power: [risen * warmer, Lanes::ZERO] }
    }
}

impl Holding<2> for Held {
    #[inline(always)]
    fn guess(&self, [state, _]: [&[Lanes; 2]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(state[0] * state[0], begin)
    }

    /// By recursion: each coefficient follows from those of lower powers.
    #[inline(always)]
    fn series(&self, &[state, factor]: &[Lanes; 2], length: Lanes) -> [Lanes; 4] {
        let (zero, exchange) = (Lanes::ZERO, self.gas.exchange * length);
        let (mut gas, mut factor) = ([state * state, zero, zero, zero], [factor, zero, zero]);
        let mut warmer = [self.gas.wall - gas[0], zero, zero];
        // Coefficients of T u.
        let mut driven = [zero; 3];
        for order in 0..3 {
            if order > 0 {
                warmer[order] = -gas[order];
            }
            let (mut heat, mut fall) = (zero, zero);
            for part in 0..=order {
                driven[order] += gas[part] * factor[order - part];
            }
            for part in 0..=order {
                heat += driven[part] * warmer[order - part];
                fall += driven[part] * factor[order - part];
            }
            let rate = exchange * (1.0 / (order + 1) as f64);
            gas[order + 1] = rate * heat;
            if order < 2 {
                factor[order + 1] = -self.exponent * rate * fall;
            }
        }
        gas
    }
}
