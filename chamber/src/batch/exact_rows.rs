//! Sealed tests by the closed forms of [`exact`](crate::exact), in lanes: no integration, no tolerance.

use super::finish::SETTLED;
use super::fit;
use super::outcome::{Failure, Outcome};
use super::regression::{Found, Part, Records};
use super::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use super::scenario::{Options, Scenario};
use super::sealed::Ending;
use crate::exact::Closed;
use crate::lanes::{Lanes, WIDTH, each_lane};
use crate::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Ends of the parts in which the regression's sums are taken, in 1/k after the push; the last ends with the record.
const ENDS: [f64; 10] = [0.3, 0.65, 1.1, 1.7, 2.5, 3.6, 5.3, 8.0, 13.0, f64::INFINITY];

/// Solves checked, sealed scenarios: numbers and durations, s. `records` is memory to use.
pub fn run(
    arch: Arch,
    records: &mut Records,
    rows: &[(u32, f64)],
    scenarios: &[Scenario],
    options: &Options,
    out: &mut [Outcome],
) {
    for rows in rows.chunks(WIDTH) {
        let mut tests = Tests::first(&scenarios[rows[0].0 as usize], rows[0].1);
        for (lane, &(row, duration)) in rows.iter().enumerate().skip(1) {
            tests.load(lane, &scenarios[row as usize], duration);
        }
        let ends = arch.dispatch(Solve(&tests));
        let found = options.fit.then(|| {
            let guess = arch.dispatch(Record { tests: &tests, ends: &ends, records });
            records.fit(arch, guess)
        });
        for (lane, &(row, duration)) in rows.iter().enumerate() {
            let scenario = &scenarios[row as usize];
            out[row as usize] = outcome(&tests, &ends, lane, scenario, duration, found.as_ref());
        }
    }
}

/// As many tests as there are lanes.
struct Tests {
    closed: Closed<Lanes>,
    parts: Lanes,
    start: Lanes,
    from: Lanes,
    to: Lanes,
    push: Lanes,
    hold: Lanes,
}

/// What becomes of them.
struct Ends {
    peak: Lanes,
    end: Lanes,
    rate: Lanes,
    settling: Lanes,
}

impl Tests {
    /// The same test in every lane.
    fn first(scenario: &Scenario, duration: f64) -> Self {
        let zero = Lanes::ZERO;
        let mut tests = Self {
            closed: Closed { mass_gas_constant: zero, exchange: [zero; 2], expansion: zero, ambient_temperature: zero },
            parts: zero,
            start: zero,
            from: zero,
            to: zero,
            push: zero,
            hold: zero,
        };
        for lane in 0..WIDTH {
            tests.load(lane, scenario, duration);
        }
        tests
    }

    #[inline]
    fn load(&mut self, lane: usize, s: &Scenario, duration: f64) {
        let [from, to] = [s.initial_position_m, s.final_position_m].map(|x| s.chamber.geometry.volume(x));
        let (start, wall) = (s.initial_temperature_k, s.ambient_temperature_k);
        let closed = Closed::filled(&s.chamber, s.initial_pressure_pa, start, from, wall);
        let all = &mut self.closed;
        all.mass_gas_constant[lane] = closed.mass_gas_constant;
        all.exchange[0][lane] = closed.exchange[0];
        all.exchange[1][lane] = closed.exchange[1];
        all.expansion[lane] = closed.expansion;
        all.ambient_temperature[lane] = closed.ambient_temperature;
        self.parts[lane] = closed.parts(from, to, s.push_time_s);
        self.start[lane] = start;
        self.from[lane] = from;
        self.to[lane] = to;
        self.push[lane] = s.push_time_s;
        self.hold[lane] = duration - s.push_time_s;
    }
}

struct Solve<'a>(&'a Tests);

impl WithSimd for Solve<'_> {
    type Output = Ends;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Ends {
        let t = black_box(self.0);
        let peak = t.closed.ramp_in(t.parts, t.start, t.from, t.to, t.push);
        let end = t.closed.held(peak, t.to, t.hold);
        let rate = t.closed.rate(t.to);
        // 1 − Tamb/T decays exponentially: when it reaches the edge of the band around the end.
        let edge = end + (peak - end) * SETTLED;
        let excess = |temperature: Lanes| Lanes::ONE - t.closed.ambient_temperature / temperature;
        let settling = (excess(peak) / excess(edge)).ln() / rate;
        black_box(Ends { peak, end, rate, settling })
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
    let (peak, end) = (ends.peak[lane], ends.end[lane]);
    if !(peak > 0.0 && end > 0.0 && peak.is_finite() && end.is_finite()) {
        return Outcome::failed(Failure::StepTooSmall);
    }
    let settling = if ends.settling[lane] > 0.0 { ends.settling[lane] } else { 0.0 };
    let pressure_per_temperature = tests.closed.mass_gas_constant[lane] / tests.to[lane];
    let regression = found.and_then(|found| found.lane(lane));
    Ending { scenario, duration, peak, end, pressure_per_temperature, settling, regression }.outcome()
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
        let Self { tests: t, ends, records } = self;
        let wall = t.closed.ambient_temperature;
        let excess = Lanes::ONE - wall / ends.peak;
        let at_rest = t.closed.mass_gas_constant * wall / t.to;
        let slowness = ends.rate.recip();
        let duration = t.push + t.hold;
        let mut first = each_lane!(i => samples::from(t.push.0[i]));
        records.clear();
        for end in black_box(&ENDS) {
            let end = (t.push + slowness * *end).min(duration);
            let next = each_lane!(i => samples::after(end.0[i]));
            let samples = Samples { first, count: (next - first).max(Lanes::ZERO) };
            let (numbers, _) = samples.nodes();
            let mut pressure = [Lanes::ZERO; POINTS];
            for k in 0..POINTS {
                let since = numbers[k] * (1.0 / SAMPLE_RATE_HZ) - t.push;
                let decayed = (since * -ends.rate).exp() * excess;
                pressure[k] = at_rest / (Lanes::ONE - decayed);
            }
            records.push(Part { samples, pressure });
            first = first.max(next);
        }
        fit::time_constant(ends.rate, excess)
    }
}
