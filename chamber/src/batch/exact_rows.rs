//! Sealed tests by the closed forms of [`exact`](crate::exact), in lanes: no integration, no tolerance.

use super::finish::SETTLED;
use super::fit::{self, Exponential, GAUSS, Nodes, SAMPLE_RATE_HZ, Samples};
use super::outcome::{Failure, Outcome};
use super::scenario::{Options, Scenario};
use super::sealed::Ending;
use crate::exact::Closed;
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use core::hint::black_box;
use pulp::{Arch, Simd, WithSimd};

/// Ends of the regression's quadrature panels, in time constants; the last goes to the end of the record.
const PANELS: [f64; 8] = [0.0, 0.5, 1.0, 1.75, 2.75, 4.0, 6.0, 10.0];

/// Solves checked, sealed scenarios: numbers and durations, s. `nodes` is memory to use.
pub fn run(
    arch: Arch,
    nodes: &mut Nodes,
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
        for (lane, &(row, duration)) in rows.iter().enumerate() {
            let scenario = &scenarios[row as usize];
            out[row as usize] = outcome(arch, nodes, &tests, &ends, lane, scenario, duration, options.fit);
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
#[allow(clippy::too_many_arguments)]
fn outcome(
    arch: Arch,
    nodes: &mut Nodes,
    tests: &Tests,
    ends: &Ends,
    lane: usize,
    scenario: &Scenario,
    duration: f64,
    fit: bool,
) -> Outcome {
    let (peak, end, wall) = (ends.peak[lane], ends.end[lane], scenario.ambient_temperature_k);
    if !(peak > 0.0 && end > 0.0 && peak.is_finite() && end.is_finite()) {
        return Outcome::failed(Failure::StepTooSmall);
    }
    let settling = if ends.settling[lane] > 0.0 { ends.settling[lane] } else { 0.0 };
    let pressure_per_temperature = tests.closed.mass_gas_constant[lane] / tests.to[lane];
    let regression = fit.then(|| {
        arch.dispatch(Regression {
            nodes,
            push: scenario.push_time_s,
            duration,
            rate: ends.rate[lane],
            excess: 1.0 - wall / peak,
            pressure_at_rest: pressure_per_temperature * wall,
        })
    });
    Ending { scenario, duration, peak, end, pressure_per_temperature, settling, regression: regression.flatten() }
        .outcome()
}

/// Step 1 of the paper on the record from the end of the push on, P = Pf/(1 − ε e^(−k t)). Times in s.
struct Regression<'a> {
    nodes: &'a mut Nodes,
    push: f64,
    duration: f64,
    /// k, 1/s.
    rate: f64,
    /// ε, at the end of the push.
    excess: f64,
    /// Pf, Pa.
    pressure_at_rest: f64,
}

impl WithSimd for Regression<'_> {
    type Output = Option<[f64; 3]>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, simd: I) -> Self::Output {
        let first = (self.push * SAMPLE_RATE_HZ - 1e-9).ceil();
        let last = (self.duration * SAMPLE_RATE_HZ + 1e-9).floor();
        if last - first < 4.0 {
            return None;
        }
        let sum = Samples::new(last - first, 0);
        self.nodes.clear();
        for (number, weight) in sum.single() {
            self.nodes.push(number / SAMPLE_RATE_HZ, 0.0, *weight);
        }
        let tau = 1.0 / self.rate;
        if let Some(begin) = sum.integral() {
            let (from, to) = (begin / SAMPLE_RATE_HZ, (last - first) / SAMPLE_RATE_HZ);
            for (k, panel) in PANELS.iter().enumerate() {
                let a = from + panel * tau;
                let b = PANELS.get(k + 1).map_or(to, |next| (from + next * tau).min(to));
                if b <= a {
                    break;
                }
                for (node, weight) in GAUSS {
                    let t = 0.5 * (a + b) + 0.5 * (b - a) * node;
                    self.nodes.push(t, 0.0, 0.5 * (b - a) * weight * SAMPLE_RATE_HZ);
                }
            }
        }
        let origin = first / SAMPLE_RATE_HZ - self.push;
        self.nodes.set_pressures(|t| {
            let decayed = ((t + origin) * -self.rate).exp() * self.excess;
            Lanes::from(self.pressure_at_rest) / (Lanes::ONE - decayed)
        });
        let guess = fit::time_constant(self.rate, self.excess);
        Exponential { nodes: self.nodes, guess }.with_simd(simd)
    }
}
