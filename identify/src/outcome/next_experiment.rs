//! What to measure next: the test on which two explanations differ most.
//!
//! Each of a handful of push-and-hold tests within the rig's stroke is simulated with both fitted models from the same
//! initial pressure; their difference, rms over the record in units of the noise, says how well that test separates them.

use crate::forward::{Course, Run};
use crate::outcome::diagnosis::terms;
use crate::record::prepare::Data;
use crate::record::stroke::{Motion, extent};
use crate::search::{Candidate, Found, Verdict};
use chamber::simulate::Start;
use serde::Serialize;

/// A test and what it would separate.
#[derive(Clone, Debug, Serialize)]
pub struct NextExperiment {
    /// The two explanations.
    pub separates: [String; 2],
    /// The test, in words.
    pub test: String,
    /// Difference of the two models' readings, rms, in units of the noise; `None` where the advice is a general one.
    pub difference_over_noise: Option<f64>,
}

/// A difference of less than this many times the noise, rms, is no use.
const TOO_SMALL: f64 = 0.1;
/// Integration error relative to the states.
const RELATIVE_TOLERANCE: f64 = 3e-8;

/// A push-and-hold test.
struct Test {
    words: String,
    course: Course,
    times: Vec<f64>,
    pressure_pa: f64,
}

/// Advice for a finished tracing: tests that separate the winner from what is alike or nearest.
pub fn next(data: &Data, found: &Found) -> Vec<NextExperiment> {
    match found.verdict {
        Verdict::Adequate => Vec::new(),
        Verdict::Unexplained | Verdict::Improved => {
            let general = NextExperiment {
                separates: ["unknown".to_owned(), "noise".to_owned()],
                test: "no known effect fits: record the gas temperature or the wall's beside the pressure, repeat one \
                       test at another speed and one with a hold five times as long, and see which balance the \
                       difference follows"
                    .to_owned(),
                difference_over_noise: None,
            };
            let alike = found.tried.iter().filter(|c| found.alike.contains(&c.model)).take(1);
            let tests = tests(data);
            let between = alike.filter_map(|c| separating(data, &tests, &found.chosen, c));
            std::iter::once(general).chain(between).collect()
        }
        Verdict::Explained => {
            let same_size = found.chosen.model.terms();
            let alike = found.tried.iter().filter(|c| found.alike.contains(&c.model));
            let runner_up =
                found.tried.iter().filter(|c| c.model != found.chosen.model && c.model.terms() == same_size).take(1);
            let others: Vec<&Candidate> = if found.alike.is_empty() { runner_up.collect() } else { alike.collect() };
            let tests = tests(data);
            others.into_iter().filter_map(|c| separating(data, &tests, &found.chosen, c)).collect()
        }
    }
}

fn separating(data: &Data, tests: &[Test], a: &Candidate, b: &Candidate) -> Option<NextExperiment> {
    let best = tests
        .iter()
        .filter_map(|test| Some((test, difference(test, a, b)? / data.noise.total_pa())))
        .max_by(|x, y| x.1.total_cmp(&y.1))?;
    let test = if best.1 < TOO_SMALL {
        "no push and hold within this stroke shows a difference; a push as fast as the bench allows, sampled as fast as the \
         logger allows, is the best there is, and until then either of them describes these data"
            .to_owned()
    } else {
        best.0.words.clone()
    };
    Some(NextExperiment { separates: [terms(&a.model), terms(&b.model)], test, difference_over_noise: Some(best.1) })
}

/// Root mean square of the difference of two models' readings, Pa.
fn difference(test: &Test, a: &Candidate, b: &Candidate) -> Option<f64> {
    let run = |c: &Candidate| {
        let chamber = c.fit.chamber();
        let temperature = test.course.ambient_temperature.at(0.0, &Default::default()).0;
        let start = Start::at_rest(&chamber, test.pressure_pa, temperature);
        Run {
            chamber: &chamber,
            set: chamber.active(),
            start,
            warmer: 0.0,
            course: &test.course,
            relative_tolerance: RELATIVE_TOLERANCE,
        }
        .pressures(&test.times)
        .ok()
    };
    let (one, other) = (run(a)?, run(b)?);
    let squares: f64 = one.iter().zip(&other).map(|(x, y)| (x - y).powi(2)).sum();
    Some((squares / one.len() as f64).sqrt())
}

fn tests(data: &Data) -> Vec<Test> {
    let stroke = data.traces.iter().flat_map(|t| t.course.motion.segments.iter().map(|s| s.stroke.range()));
    let (low, high) = stroke.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
    let longest = data.traces.iter().filter_map(|t| t.time_s.last()).fold(0.0f64, |a, b| a.max(*b));
    let (_, largest) =
        data.traces.iter().map(|t| extent(&t.pressure_pa)).fold((0.0, 0.0f64), |a, b| (a.0, a.1.max(b.1)));
    let ambient = data.ambient_pressure_pa;
    let mut out = Vec::new();
    for (from, to, way) in [(high, low, "compress"), (low, high, "expand")] {
        for pressure_pa in [0.5 * ambient, ambient, (0.6 * largest).max(2.0 * ambient)] {
            for push_s in [0.03, 0.1, 2.0] {
                for hold_s in [longest, 6.0 * longest] {
                    let words = format!(
                        "{way} from {:.0} mm to {:.0} mm in {push_s} s, beginning at {:.2} bar absolute, and hold for {hold_s:.0} s",
                        from * 1e3,
                        to * 1e3,
                        pressure_pa / 1e5
                    );
                    out.push(test(data, words, [from, to], push_s, hold_s, pressure_pa));
                }
            }
        }
    }
    out
}

fn test(data: &Data, words: String, [from, to]: [f64; 2], push_s: f64, hold_s: f64, pressure_pa: f64) -> Test {
    const REST_S: f64 = 0.5;
    const ROWS: usize = 400;
    let end = REST_S + push_s + hold_s;
    // Rows of a hundredth of the push while it lasts, then few.
    let mut times: Vec<f64> = (0..=50).map(|k| REST_S * f64::from(k) / 50.0).collect();
    times.extend((1..=100).map(|k| REST_S + push_s * f64::from(k) / 100.0));
    times.extend((1..=ROWS).map(|k| REST_S + push_s + hold_s * k as f64 / ROWS as f64));
    let position = |t: f64| {
        let u = ((t - REST_S) / push_s).clamp(0.0, 1.0);
        from + (to - from) * u * u * (3.0 - 2.0 * u)
    };
    let stroke: Vec<f64> = times.iter().map(|t| position(*t)).collect();
    let motion = Motion::detect(&times, &stroke);
    let rows: Vec<f64> = (0..=ROWS).map(|k| end * k as f64 / ROWS as f64).collect();
    let ambient_temperature =
        crate::record::stroke::Spline::through(vec![0.0], vec![data.ambient_temperature_k], [None, None]);
    let course = Course { motion, ambient_temperature, ambient_pressure: data.ambient_pressure_pa, mass_flow: None };
    Test { words, course, times: rows, pressure_pa }
}
