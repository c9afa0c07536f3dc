//! Tests by the closed forms of [`exact`](chamber::exact), in lanes: sealed ones, and those with effects that keep the
//! closed form ([`kept`](crate::kept)). No integration, no tolerance.

use crate::finish::SETTLED;
use crate::fit;
use crate::kept::Exchange;
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::outcome::{Failure, Outcome};
use crate::regression::{Found, Records, decay};
use crate::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use crate::scenario::{Options, Scenario};
use crate::sealed::Ending;
use chamber::Chamber;
use chamber::effects::EffectSet;
use chamber::exact::Closed;
use chamber::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Ends of the parts in which the regression's sums are taken, in 1/k after the push; the last ends with the record.
const ENDS: [f64; 10] = [0.3, 0.65, 1.1, 1.7, 2.5, 3.6, 5.3, 8.0, 13.0, f64::INFINITY];

/// Solves checked scenarios: numbers and durations, s. `set` are effects that keep the closed form; where there are any,
/// all rows have their area law in common. `records` is memory to use.
pub fn run(
    arch: Arch,
    records: &mut Records,
    set: EffectSet,
    rows: &[(u32, f64)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    let all: Vec<Test> =
        rows.iter().map(|&(row, duration)| Test::new(set, row, &scenarios[row as usize], duration)).collect();
    // Lanes that wait for one with more parts are few where neighbours have as many.
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    order.sort_unstable_by_key(|&test| all[test as usize].parts as u32);
    for order in order.chunks(WIDTH) {
        let tests = Tests::new(&all, order);
        let effects = (!set.is_empty()).then(|| {
            let row = |lane: usize| all[order[lane.min(order.len() - 1)] as usize].row;
            (set, gather(set, |lane| &scenarios[row(lane) as usize].chamber))
        });
        let ends = arch.dispatch(Solve { tests: &tests, effects });
        let found = options.fit.then(|| {
            let guess = arch.dispatch(Record { tests: &tests, ends: &ends, records });
            records.fit(arch, guess)
        });
        for (lane, &test) in order.iter().enumerate() {
            let Test { row, duration, .. } = all[test as usize];
            let scenario = &scenarios[row as usize];
            out[row as usize] = outcome(&tests, &ends, lane, scenario, duration, found.as_ref());
        }
    }
}

/// One test, reduced to the numbers its solution needs.
struct Test {
    row: u32,
    duration: f64,
    /// Without the effects; the wall's temperature is that with them.
    closed: Closed,
    /// 1/τ_f in the hold, 1/s.
    rate: f64,
    parts: f64,
    start: f64,
    from: f64,
    to: f64,
    push: f64,
}

impl Test {
    #[inline]
    fn new(set: EffectSet, row: u32, s: &Scenario, duration: f64) -> Self {
        let [from, to] = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
        let start = s.initial_temperature_k;
        let mut closed = Closed::filled(&s.chamber, s.initial_pressure_pa, start, from, s.ambient_temperature_k);
        let mut rates = [from, to].map(|volume| closed.rate(volume));
        if !set.is_empty() {
            let exchange = Exchange::new(set, &s.chamber, &closed, s.ambient_temperature_k);
            closed.ambient_temperature = exchange.wall();
            rates = [from, to].map(|volume| exchange.rate(volume));
        }
        let parts = Closed::parts(rates, to / from, s.push_time_s);
        Self { row, duration, closed, rate: rates[1], parts, start, from, to, push: s.push_time_s }
    }
}

/// As many tests as there are lanes.
struct Tests {
    closed: Closed<Lanes>,
    rate: Lanes,
    parts: Lanes,
    start: Lanes,
    from: Lanes,
    to: Lanes,
    push: Lanes,
    hold: Lanes,
}

/// What becomes of them.
struct Ends {
    pushed: Lanes,
    end: Lanes,
    rate: Lanes,
    settling: Lanes,
}

impl Tests {
    /// One of `all` in each lane, the last again in those that are left over.
    fn new(all: &[Test], order: &[u32]) -> Self {
        let zero = Lanes::ZERO;
        let mut tests = Self {
            closed: Closed { mass_gas_constant: zero, exchange: [zero; 2], expansion: zero, ambient_temperature: zero },
            rate: zero,
            parts: zero,
            start: zero,
            from: zero,
            to: zero,
            push: zero,
            hold: zero,
        };
        for lane in 0..WIDTH {
            let test = &all[order[lane.min(order.len() - 1)] as usize];
            let closed = &mut tests.closed;
            closed.mass_gas_constant[lane] = test.closed.mass_gas_constant;
            closed.exchange[0][lane] = test.closed.exchange[0];
            closed.exchange[1][lane] = test.closed.exchange[1];
            closed.expansion[lane] = test.closed.expansion;
            closed.ambient_temperature[lane] = test.closed.ambient_temperature;
            tests.rate[lane] = test.rate;
            tests.parts[lane] = test.parts;
            tests.start[lane] = test.start;
            tests.from[lane] = test.from;
            tests.to[lane] = test.to;
            tests.push[lane] = test.push;
            tests.hold[lane] = test.duration - test.push;
        }
        tests
    }

    /// Temperatures at the end of the push, K, each in its own number of parts; `part` solves one of them.
    #[inline(always)]
    fn pushed(&self, part: impl Fn(Lanes, Lanes, Lanes, Lanes) -> Lanes) -> Lanes {
        let (begin, end) = (self.from.sqrt(), self.to.sqrt());
        let (step, dwell) = ((end - begin) / self.parts, self.push * 2.0 / (begin + end) / self.parts);
        let mut inverse = self.start.recip();
        let most = self.parts.0.iter().fold(1.0, |a: f64, b| a.max(*b));
        for index in 0..most as usize {
            let next = part(inverse, begin + step * index as f64, step, dwell);
            inverse = (self.parts - index as f64).where_positive(next, inverse);
        }
        inverse.recip()
    }
}

/// Puts a chamber's numbers into a lane; those of its effects stay as they are.
#[inline(always)]
pub fn load_chamber(to: &mut Chamber<Lanes>, lane: usize, from: &Chamber) {
    to.gas.gas_constant[lane] = from.gas.gas_constant;
    to.gas.heat_capacity_ratio[lane] = from.gas.heat_capacity_ratio;
    to.geometry.bore[lane] = from.geometry.bore;
    to.geometry.rod_diameter[lane] = from.geometry.rod_diameter;
    to.geometry.piston_area[lane] = from.geometry.piston_area;
    to.geometry.dead_volume[lane] = from.geometry.dead_volume;
    to.heat_transfer.coefficient[lane] = from.heat_transfer.coefficient;
    to.heat_transfer.reference_pressure[lane] = from.heat_transfer.reference_pressure;
    to.heat_transfer.reference_temperature[lane] = from.heat_transfer.reference_temperature;
}

/// Chambers, one a lane, of one area law, with the parameters of the effects in a set.
fn gather<'a>(set: EffectSet, chamber: impl Fn(usize) -> &'a Chamber) -> Chamber<Lanes> {
    let mut all = chamber(0).lift::<Lanes>();
    for lane in 1..WIDTH {
        let from = chamber(lane);
        load_chamber(&mut all, lane, from);
        for effect in set.iter() {
            for (to, from) in all.effects.of_mut(effect).iter_mut().zip(from.effects.of(effect)) {
                to[lane] = *from;
            }
        }
    }
    all
}

struct Solve<'a> {
    tests: &'a Tests,
    /// Effects that keep the closed form, and the chambers with their parameters.
    effects: Option<(EffectSet, Chamber<Lanes>)>,
}

impl WithSimd for Solve<'_> {
    type Output = Ends;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Ends {
        let t = black_box(self.tests);
        let wall = t.closed.ambient_temperature;
        let pushed = match black_box(&self.effects) {
            None => t.pushed(|inverse, root, step, dwell| t.closed.ramp_part(inverse, root, step, dwell)),
            Some((set, chamber)) => {
                let exchange = Exchange::new(*set, chamber, &t.closed, wall);
                t.pushed(|inverse, root, step, dwell| exchange.ramp_part(wall, inverse, root, step, dwell))
            }
        };
        let rate = t.rate;
        let end = wall / (Lanes::ONE - (Lanes::ONE - wall / pushed) * (-rate * t.hold).exp());
        // 1 − Tamb/T decays exponentially: when it reaches the edge of the band around the end.
        let edge = end + (pushed - end) * SETTLED;
        let excess = |temperature: Lanes| Lanes::ONE - t.closed.ambient_temperature / temperature;
        let settling = (excess(pushed) / excess(edge)).ln() / rate;
        black_box(Ends { pushed, end, rate, settling })
    }
}

/// One lane's answers.
fn outcome(
    tests: &Tests,
    ends: &Ends,
    lane: usize,
    scenario: &Scenario,
    duration: f64,
    found: Option<&Found>,
) -> Outcome {
    let (pushed, end) = (ends.pushed[lane], ends.end[lane]);
    if !(pushed > 0.0 && end > 0.0 && pushed.is_finite() && end.is_finite()) {
        return Outcome::failed(Failure::StepTooSmall);
    }
    let settling = if ends.settling[lane] > 0.0 { ends.settling[lane] } else { 0.0 };
    let pressure_per_temperature = tests.closed.mass_gas_constant[lane] / tests.to[lane];
    let regression = found.and_then(|found| found.lane(lane));
    let wall = tests.closed.ambient_temperature[lane];
    Ending { scenario, duration, wall, pushed, end, pressure_per_temperature, settling, regression }.outcome()
}

/// The records from the end of the push on, P = Pf/(1 − ε e^(−k t)); the answer is a guess of τ, s.
struct Record<'a> {
    tests: &'a Tests,
    ends: &'a Ends,
    records: &'a mut Records,
}

impl WithSimd for Record<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Lanes {
        if I::IS_SCALAR { self.fill::<false>() } else { self.fill::<true>() }
    }
}

impl Record<'_> {
    #[inline(always)]
    fn fill<const FUSED: bool>(self) -> Lanes {
        let Self { tests: t, ends, records } = self;
        let wall = t.closed.ambient_temperature;
        let excess = black_box(Lanes::ONE - wall / ends.pushed);
        let at_rest = black_box(t.closed.mass_gas_constant * wall / t.to);
        let slowness = black_box(ends.rate.recip());
        let duration = black_box(t.push + t.hold);
        let mut first = black_box(each_lane!(i => samples::from(t.push.0[i])));
        records.clear();
        for end in black_box(&ENDS) {
            let end = black_box((t.push + slowness * *end).min(duration));
            let next = black_box(each_lane!(i => samples::after(end.0[i])));
            let count = black_box((next - first).max(Lanes::ZERO));
            let nodes = black_box(Samples { first, count }.nodes());
            let mut pressure = [Lanes::ZERO; POINTS];
            for k in 0..POINTS {
                let since = nodes.numbers[k] * (1.0 / SAMPLE_RATE_HZ) - t.push;
                let decayed = decay::<FUSED>(since * ends.rate) * excess;
                pressure[k] = black_box(at_rest / (Lanes::ONE - decayed));
            }
            records.push(first, &nodes, &pressure);
            first = black_box(first.max(next));
        }
        fit::time_constant(ends.rate, excess)
    }
}
