//! Tests whose heat transfer follows a power of the temperature difference, in lanes: natural convection alone, the port
//! closed. The push is that of [`crate::sealed`] with one more factor,
//!
//! dT/ds = T (q |(T − Tw)/20 K|^n − 4 (γ − 1) w'/w),  q = c p (a1 w⁴ + a0) w (Tw − T)
//!
//! and from near T = Tw, where that has no power series, by the bent clock. The hold is a series ([`convective_hold`]), where
//! there is none that of [`crate::relaxation`], or, by the integrator, of the same equation with w' = 0.

use crate::Batch;
use crate::advance::{FIRST_OF_BENT, Loadable, Nobody, Problem, advance};
use crate::convective_hold::{self, Holds, Record, Solve};
use crate::instructions::Wide;
use crate::lanes::{Lanes, WIDTH};
use crate::math;
use crate::outcome::{Failure, Outcome};
use crate::plan::starts_singular;
use crate::regression::{Guess, Records};
use crate::relaxing_rows::{self, AfterPush};
use crate::scenario::Scenario;
use crate::sealed::{self, Ending, Holding, OwnTest, Test};
use crate::step::{LaneSystem, Moment, View};
use chamber::effects::EffectSet;
use chamber::effects::natural_convection::{REFERENCE_DIFFERENCE_K, SMALLEST_DIFFERENCE_K};
use chamber::real::Real;
use core::hint::black_box;

/// The effect on the gas, of those that there are, that such tests have.
pub const EFFECTS: EffectSet = EffectSet::from_bits(crate::bit(NAME));
const NAME: &str = "natural_convection";

/// What is kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    tests: Vec<ConvectiveTest>,
    problems: Vec<Problem<1>>,
    /// Those whose holds are series, with the numbers of their tests, and others.
    in_series: Vec<(usize, AfterPush)>,
    pushed: Vec<AfterPush>,
    records: Records,
    relaxing: relaxing_rows::Memory,
}

/// One test.
#[derive(Clone, Copy, Debug)]
pub struct ConvectiveTest {
    gas: Test,
    /// n.
    exponent: f64,
    is_bent: bool,
}

/// n.
fn exponent(scenario: &Scenario) -> f64 {
    scenario.chamber.effects.of(const { crate::place(NAME) })[0]
}

/// Whether the heat flow has a rate of change everywhere: with n below zero the gas comes to the wall's temperature at once.
pub fn is_smooth(scenario: &Scenario) -> bool {
    exponent(scenario) > 0.0
}

impl OwnTest<1> for ConvectiveTest {
    const HAS_ANOTHER_WAY: bool = true;
    type Moving<'a> = Moving<'a>;
    type Held<'a> = Held<'a>;

    #[inline]
    fn new(s: &Scenario) -> Self {
        let (mut gas, is_bent) = (Test::new(s), starts_singular(EFFECTS, s));
        if is_bent {
            gas.clock = gas.clock.bent(s.push_time_s);
        }
        Self { gas, exponent: exponent(s), is_bent }
    }

    #[inline]
    fn start(&self, s: &Scenario) -> [f64; 1] {
        self.gas.start(s)
    }

    #[inline]
    fn gas(&self) -> &Test {
        &self.gas
    }

    #[inline]
    fn first_step(&self) -> f64 {
        if self.is_bent { FIRST_OF_BENT } else { 0.0 }
    }

    #[inline]
    fn goes_one_way(&self, _: &[f64; 1]) -> bool {
        true
    }

    fn moving(tests: &[Self]) -> Moving<'_> {
        Moving { tests, gas: sealed::Moving::NONE, exponent: Lanes::ZERO }
    }

    fn held(tests: &[Self]) -> Held<'_> {
        Held { tests, gas: sealed::Held::NONE, exponent: Lanes::ZERO }
    }
}

/// Runs tests whose numbers are checked, all of one area law; with durations in s.
pub fn run(batch: Batch, memory: &mut Memory, rows: &[(u32, f64)], out: &mut [Outcome]) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { tests, problems, in_series, pushed, records, relaxing } = memory;
    tests.clear();
    problems.clear();
    for &(row, _) in rows {
        let s = &scenarios[row as usize];
        let test = ConvectiveTest::new(s);
        let mut push = test.push(s);
        if test.gas.clock.root_rate == 0.0 {
            push.longest = f64::INFINITY;
        }
        tests.push(test);
        problems.push(push);
    }
    advance(arch, &ConvectiveTest::moving(tests), problems, options.relative_tolerance, &mut Nobody);
    pushed.clear();
    in_series.clear();
    for (index, ((problem, test), &(row, duration))) in problems.iter().zip(&*tests).zip(rows).enumerate() {
        let Test { closed, rate, .. } = test.gas;
        let (s, temperature) = (&scenarios[row as usize], problem.state[0] * problem.state[0]);
        let capacity = closed.mass_gas_constant / closed.expansion;
        let [received, work] = problem.energy.map(|energy| capacity * energy);
        let is_gas = temperature > 0.0 && temperature < f64::INFINITY;
        let after = AfterPush {
            row,
            duration,
            relaxations: (duration - s.push_time_s) * rate,
            mass: closed.mass_gas_constant / s.chamber.gas.gas_constant,
            energy: [s.initial_temperature_k, temperature].map(|temperature| capacity * temperature),
            received: [received - work, work.abs()],
            failure: problem.failure.or((!is_gas).then_some(Failure::Empty)),
        };
        if is_gas && convective_hold::has_series(test.exponent, temperature, closed.ambient_temperature) {
            in_series.push((index, after));
        } else {
            pushed.push(after);
        }
    }
    relaxing_rows::run(batch, relaxing, EFFECTS, pushed, out);
    for group in in_series.chunks(WIDTH) {
        let at = |lane: usize| &group[lane.min(group.len() - 1)];
        let test = |lane: usize| &tests[at(lane).0];
        let scenario = |lane: usize| &scenarios[at(lane).1.row as usize];
        let per_temperature = Lanes::from_fn(|lane| test(lane).gas.pressure_per_temperature());
        let holds = Holds {
            exponent: Lanes::from_fn(|lane| test(lane).exponent),
            rate: Lanes::from_fn(|lane| test(lane).gas.rate),
            wall: Lanes::from_fn(|lane| test(lane).gas.closed.ambient_temperature),
            pushed: Lanes::from_fn(|lane| problems[at(lane).0].state[0] * problems[at(lane).0].state[0]),
            push: Lanes::from_fn(|lane| scenario(lane).push_time_s),
            hold: Lanes::from_fn(|lane| at(lane).1.duration - scenario(lane).push_time_s),
        };
        let ends = arch.dispatch(Wide(Solve(&holds)));
        let found = options.fit.then(|| {
            let guess = arch.dispatch(Wide(Record { holds: &holds, ends: &ends, per_temperature, records }));
            records.fit(arch, guess)
        });
        for (lane, (_, after)) in group.iter().enumerate() {
            out[after.row as usize] = after.outcome(&Ending {
                scenario: scenario(lane),
                duration: after.duration,
                wall: holds.wall[lane],
                pushed: holds.pushed[lane],
                end: ends.end[lane],
                pressure_per_temperature: per_temperature[lane],
                settling: ends.settling[lane],
                regression: found.as_ref().and_then(|found| found.lane(lane)),
            });
        }
    }
}

/// |d/20 K|^n of temperature differences, K. It passes through memory: else the compiler computes it lane by lane.
#[inline(always)]
fn power(difference: Lanes, exponent: Lanes) -> Lanes {
    let difference = black_box(difference).abs().max(Lanes::from(SMALLEST_DIFFERENCE_K));
    black_box(math::power(difference * (1.0 / REFERENCE_DIFFERENCE_K), exponent))
}

/// Tests, one a lane, while their pistons move.
#[derive(Clone)]
pub struct Moving<'a> {
    tests: &'a [ConvectiveTest],
    gas: sealed::Moving<'static>,
    exponent: Lanes,
}

impl Loadable for Moving<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.gas.load_test(lane, &test.gas);
        self.exponent[lane] = test.exponent;
    }
}

impl LaneSystem<1> for Moving<'_> {
    const CHEAP: bool = false;

    #[inline(always)]
    fn rates(&self, r: Lanes, &[state]: &[Lanes; 1]) -> Moment<1> {
        let [s, rate] = self.gas.clock.unbent(r);
        let root = self.gas.clock.root(s);
        let temperature = state * state;
        let warmer = self.gas.wall - temperature;
        let [heat, work] = self.gas.heat_and_work([root, root * root], warmer);
        let (heat, work) = (heat * power(warmer, self.exponent) * rate, work * rate);
        let power = [temperature * heat, temperature * work];
        Moment { slope: [state * 0.5 * (heat - work)], view: View::NONE, power }
    }
}

/// Tests, one a lane, while their pistons rest.
#[derive(Clone)]
pub struct Held<'a> {
    tests: &'a [ConvectiveTest],
    gas: sealed::Held<'static>,
    exponent: Lanes,
}

impl Loadable for Held<'_> {
    #[inline(always)]
    fn load(&mut self, lane: usize, index: usize) {
        let test = &self.tests[index];
        self.gas.load_test(lane, &test.gas);
        self.exponent[lane] = test.exponent;
    }
}

impl LaneSystem<1> for Held<'_> {
    const CHEAP: bool = false;

    #[inline(always)]
    fn rates(&self, _: Lanes, &[state]: &[Lanes; 1]) -> Moment<1> {
        let temperature = state * state;
        let warmer = self.gas.wall - temperature;
        let heat = self.gas.exchange * warmer * power(warmer, self.exponent);
        Moment { slope: [state * 0.5 * heat], view: View::NONE, power: [temperature * heat, Lanes::ZERO] }
    }
}

impl Holding<1> for Held<'_> {
    #[inline(always)]
    fn guess(&self, [state, _]: [&[Lanes; 1]; 2], begin: Lanes) -> Guess {
        self.gas.guess_from(state[0] * state[0], begin)
    }

    /// By the equation's recursion; that of f = |d|^n is k d f_k = Σ (n j − (k − j)) d_j f_(k−j) over j from 1 to k.
    #[inline(always)]
    fn series(&self, &[state]: &[Lanes; 1], length: Lanes) -> [Lanes; 4] {
        let zero = Lanes::ZERO;
        let (mut gas, exchange) = ([state * state, zero, zero, zero], self.gas.exchange * length);
        let mut warmer = [self.gas.wall - gas[0], zero, zero];
        let mut factor = [power(warmer[0], self.exponent), zero, zero];
        let least = Lanes::from(SMALLEST_DIFFERENCE_K);
        let per_warmer = (warmer[0].abs() - least).where_positive(warmer[0], least).recip();
        // Of T d.
        let mut driven = [zero; 3];
        for order in 0..3 {
            if order > 0 {
                warmer[order] = -gas[order];
                let mut sum = zero;
                for part in 1..=order {
                    let weight = self.exponent * part as f64 - (order - part) as f64;
                    sum += weight * warmer[part] * factor[order - part];
                }
                factor[order] = sum * per_warmer * (1.0 / order as f64);
            }
            for part in 0..=order {
                driven[order] += gas[part] * warmer[order - part];
            }
            let mut heat = zero;
            for part in 0..=order {
                heat += driven[part] * factor[order - part];
            }
            gas[order + 1] = exchange * heat * (1.0 / (order + 1) as f64);
        }
        gas
    }
}
