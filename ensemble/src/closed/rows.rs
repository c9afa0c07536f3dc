//! Solves tests by the closed forms of [`exact`](chamber::exact), in lanes: sealed ones, those with effects that keep the closed form
//! ([`with_effects`](crate::closed::with_effects)), and the sensor's readings of either ([`readings`]). No integration, no tolerance.

use crate::batch::Batch;
use crate::chambers::Chambers;
use crate::closed::readings::{self, Readings};
use crate::closed::test::{Ends, ExactTest, Tests};
use crate::closed::with_effects::{Exchange, Heat};
use crate::ending::HoldsEnded;
use crate::lanes::math::decay;
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::gauss::NODES;
use crate::numerics::root::Curve;
use crate::outcome::SETTLED;
use crate::outcome::{Failure, Outcome};
use crate::regression::relaxing::{self, ENDS, Relaxing, STEEP_ENDS};
use crate::regression::{Guess, Records, Regressions};
use crate::scenario::Scenario;
use crate::sensor::Sensor;
use chamber::balance::Balances;
use chamber::effects::EffectSet;
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Working memory, kept from one batch to the next.
#[derive(Default)]
pub struct Memory {
    chambers: Chambers,
    records: Records,
    readings: readings::Memory,
}

/// Solves checked scenarios, given by their indices. `set` are the effects that keep the closed form; if there are any, all rows have
/// the same area law. `shown` are the effects on the reading, if any; all sensors lag or none, and all records are delayed or none.
pub fn run(batch: Batch, memory: &mut Memory, set: EffectSet, shown: EffectSet, rows: &[u32], out: &mut [Outcome]) {
    let Batch { arch, scenarios, options } = batch;
    let Memory { chambers, records, readings } = memory;
    let mut all: Vec<ExactTest> = rows.iter().map(|&row| ExactTest::new(row, &scenarios[row as usize])).collect();
    if set.is_empty() {
        for test in &mut all {
            let [begin, end] = [test.from, test.to].map(|volume| test.closed.rate(volume));
            test.exchange(end, Closed::time_scales([begin, end], test.to / test.from, test.push));
        }
    } else {
        exchange(arch, chambers, set, &mut all, scenarios);
    }
    // Sorted by the number of parts of push and record, so that few lanes wait for one with more parts.
    let kind = |test: &ExactTest| {
        let relaxations = test.rate * test.hold;
        let of_record = if options.fit { ENDS.iter().filter(|end| **end < relaxations).count() } else { 0 };
        (test.is_bent, options.fit && test.is_steep(), test.parts as u32, of_record)
    };
    let kinds: Vec<_> = all.iter().map(kind).collect();
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    order.sort_unstable_by_key(|&test| kinds[test as usize]);
    let kind_of_code = |test: &u32| (kinds[*test as usize].0, kinds[*test as usize].1);
    let alike = order.chunk_by(|a, b| kind_of_code(a) == kind_of_code(b));
    for order in alike.flat_map(|tests| tests.chunks(WIDTH)) {
        let (is_bent, is_steep, ..) = kinds[order[0] as usize];
        let set = if is_bent { set } else { EffectSet::NONE };
        let tests = Tests::new(&all, order);
        let scenario = |lane: usize| &scenarios[all[order[lane.min(order.len() - 1)] as usize].row as usize];
        let effects = (!set.is_empty()).then(|| (set, chambers.gather(arch, set, |lane| &scenario(lane).chamber)));
        // Only a sensor with a lag or a delay needs the pressure during the push.
        let looks_back = Sensor::new(shown, &scenario(0).chamber.effects).looks_back();
        let nodes = looks_back.then_some(&mut readings.nodes);
        let ends = arch.dispatch(Solve { tests: &tests, effects, nodes });
        let solved = Solved { tests: &tests, ends: &ends };
        let outcomes = if shown.is_empty() {
            solved.outcomes(arch, records, options.fit.then_some(is_steep), scenario)
        } else {
            solved.readings(arch, (records, readings), shown, options.fit, scenario)
        };
        for (lane, &test) in order.iter().enumerate() {
            let row = all[test as usize].row as usize;
            let (pushed, end) = (ends.pushed[lane], ends.end[lane]);
            if pushed > 0.0 && end > 0.0 && pushed.is_finite() && end.is_finite() {
                out[row] = outcomes[lane];
            } else {
                out[row] = Outcome::failed(Failure::StepTooSmall);
            }
        }
    }
}

/// Sets the wall's temperature, the rates and, if it is linear, the heat exchange of tests with the effects of a set.
fn exchange(arch: Arch, chambers: &mut Chambers, set: EffectSet, all: &mut [ExactTest], scenarios: &[Scenario]) {
    for tests in all.chunks_mut(WIDTH) {
        let at = |lane: usize| lane.min(tests.len() - 1);
        let balance = chambers.gather(arch, set, |lane| &scenarios[tests[at(lane)].row as usize].chamber);
        let order: [u32; WIDTH] = core::array::from_fn(|lane| at(lane) as u32);
        let Changed { wall, held, time_scales, exchange, bend } =
            arch.dispatch(Change { set, balance, tests: &Tests::new(tests, &order) });
        for (lane, test) in tests.iter_mut().enumerate() {
            test.closed.ambient_temperature = wall[lane];
            test.is_bent = bend[lane] > 0.0;
            if !test.is_bent {
                test.closed.exchange = exchange.map(|all| all[lane]);
            }
            test.exchange(held[lane], time_scales[lane]);
        }
    }
}

/// What effects change in the closed form.
struct Changed {
    /// Temperatures of the walls, K.
    wall: Lanes,
    /// 1/τ_f of the hold, 1/s.
    held: Lanes,
    /// Duration of the push in time scales.
    time_scales: Lanes,
    /// Heat exchange during the push as a line over the volume; `bend` is positive if it is not linear.
    exchange: [Lanes; 2],
    bend: Lanes,
}

/// Computes [`Changed`].
struct Change<'a> {
    set: EffectSet,
    balance: &'a Balances<Lanes>,
    /// The tests without the effects.
    tests: &'a Tests,
}

impl WithSimd for Change<'_> {
    type Output = Changed;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Changed {
        let t = black_box(self.tests);
        let balance = black_box(self.balance);
        let mut heat = Exchange::new(self.set, balance, &t.closed, t.closed.ambient_temperature);
        let (wall, held) = (heat.wall(), heat.at(t.to));
        heat.move_at(t.velocity(&balance.chamber));
        let ends = [heat.at(t.from), heat.at(t.to)];
        let (exchange, bend) = heat.line([t.from, t.to], ends);
        let [per_begin, per_end] = [wall / t.from.sqrt(), wall / t.to.sqrt()];
        let time_scales = Closed::time_scales([ends[0] * per_begin, ends[1] * per_end], t.to / t.from, t.push);
        black_box(Changed { wall, held: held * per_end, time_scales, exchange, bend })
    }
}

/// Effects that keep the closed form, and the balances with their parameters.
type Effects<'a> = Option<(EffectSet, &'a Balances<Lanes>)>;

struct Solve<'a> {
    tests: &'a Tests,
    effects: Effects<'a>,
    /// Receives 1/T at the nodes of the push, if needed.
    nodes: Option<&'a mut Vec<[Lanes; NODES]>>,
}

impl WithSimd for Solve<'_> {
    type Output = Ends;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Ends {
        let t = black_box(self.tests);
        let wall = t.closed.ambient_temperature;
        let mut with_effects = None;
        if let Some((set, balance)) = black_box(self.effects) {
            let exchange = with_effects.insert(Exchange::new(set, balance, &t.closed, wall));
            exchange.move_at(t.velocity(&balance.chamber));
        }
        let pushed = match (&with_effects, self.nodes) {
            (None, None) => t.pushed(&t.closed),
            (Some(exchange), None) => t.pushed(exchange),
            (None, Some(nodes)) => t.nodes(&t.closed, nodes),
            (Some(exchange), Some(nodes)) => t.nodes(exchange, nodes),
        };
        let rate = t.rate;
        let end = wall / (Lanes::ONE - (Lanes::ONE - wall / pushed) * (-rate * t.hold).exp());
        // 1 − Tw/T decays exponentially: the time at which it reaches the edge of the band around the end.
        let edge = end + (pushed - end) * SETTLED;
        let settling = ((Lanes::ONE - wall / pushed) / (Lanes::ONE - wall / edge)).ln() / rate;
        black_box(Ends { pushed, end, rate, settling })
    }
}

/// A group of solved tests.
struct Solved<'a> {
    tests: &'a Tests,
    ends: &'a Ends,
}

impl Solved<'_> {
    /// The ends of the tests, for the gas.
    fn ended(&self, regressions: Option<Regressions>) -> HoldsEnded {
        let Self { tests, ends, .. } = self;
        HoldsEnded {
            wall: tests.closed.ambient_temperature,
            pushed: ends.pushed,
            end: ends.end,
            pressure_per_temperature: tests.closed.mass_gas_constant / tests.to,
            settling: ends.settling.where_positive(ends.settling, Lanes::ZERO),
            regressions,
        }
    }

    /// The outcomes without sensor effects; with the regression if `is_steep` is given, which says whether the records are steep.
    fn outcomes<'s>(
        &self,
        arch: Arch,
        records: &mut Records,
        is_steep: Option<bool>,
        scenario: impl Fn(usize) -> &'s Scenario,
    ) -> [Outcome; WIDTH] {
        let Self { tests, ends } = *self;
        let found = is_steep.map(|is_steep| {
            let guess = arch.dispatch(Record { tests, ends, records, is_steep });
            records.fit(arch, guess)
        });
        let ended = self.ended(found);
        core::array::from_fn(|lane| ended.ending(lane, scenario(lane)).outcome())
    }

    /// The outcomes with effects on the reading.
    fn readings<'s>(
        &self,
        arch: Arch,
        (records, readings): (&mut Records, &mut readings::Memory),
        set: EffectSet,
        fit: bool,
        scenario: impl Fn(usize) -> &'s Scenario,
    ) -> [Outcome; WIDTH] {
        let Self { tests, ends } = *self;
        let wall = tests.closed.ambient_temperature;
        let sensor = |lane: usize| Sensor::new(set, &scenario(lane).chamber.effects);
        let before = Lanes::from_fn(|lane| scenario(lane).initial_pressure_pa);
        let readings = Readings::new(arch, readings, tests, ends, sensor, before);
        let answers = readings.answers();
        let found = fit.then(|| {
            readings.lay_out(Lanes::from_fn(|lane| answers[lane].peak_time), records);
            let excess = Lanes::from_fn(|lane| 1.0 - wall[lane] / ends.pushed[lane]);
            records.fit(arch, Guess::Relaxation { rate: ends.rate, excess, from: tests.push })
        });
        let ended = self.ended(None);
        core::array::from_fn(|lane| {
            let scenario = scenario(lane);
            let regression = found.as_ref().and_then(|found| found.lane(lane));
            let gas = ended.ending(lane, scenario).outcome();
            answers[lane].outcome(scenario, regression, (wall[lane], &sensor(lane)), gas)
        })
    }
}

/// Pressure while the piston rests, P = Pf/(1 − ε e^(−k t)), Pa.
struct ExactHold<const FUSED: bool> {
    at_rest: Lanes,
    excess: Lanes,
    rate: Lanes,
    slowness: Lanes,
}

impl<const FUSED: bool> Relaxing for ExactHold<FUSED> {
    type Knot = Lanes;
    type Trajectory<'a> = &'a Self;

    #[inline(always)]
    fn knot(&self, relaxations: f64) -> Lanes {
        self.slowness * relaxations
    }

    #[inline(always)]
    fn time(knot: &Lanes) -> Lanes {
        *knot
    }

    #[inline(always)]
    fn trajectory(&self, _: [&Lanes; 2]) -> &Self {
        self
    }
}

impl<const FUSED: bool> Curve for &ExactHold<FUSED> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.at_rest / (Lanes::ONE - decay::<FUSED>(time * self.rate) * self.excess)
    }
}

/// Lays out the records; returns a guess of τ.
struct Record<'a> {
    tests: &'a Tests,
    ends: &'a Ends,
    records: &'a mut Records,
    is_steep: bool,
}

impl WithSimd for Record<'_> {
    type Output = Guess;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Guess {
        if I::IS_SCALAR { self.fill::<false>() } else { self.fill::<true>() }
    }
}

impl Record<'_> {
    #[inline(always)]
    fn fill<const FUSED: bool>(self) -> Guess {
        let Self { tests: t, ends, records, is_steep } = self;
        let wall = t.closed.ambient_temperature;
        let excess = black_box(Lanes::ONE - wall / ends.pushed);
        let hold = ExactHold::<FUSED> {
            at_rest: black_box(t.closed.mass_gas_constant * wall / t.to),
            excess,
            rate: ends.rate,
            slowness: black_box(ends.rate.recip()),
        };
        let parts = if is_steep { STEEP_ENDS } else { &ENDS };
        relaxing::lay_out(&hold, parts, t.push, black_box(t.push + t.hold), records);
        Guess::Relaxation { rate: ends.rate, excess, from: t.push }
    }
}
