//! What to measure next: the test on which two explanations differ most.
//!
//! A number of push-and-hold tests within the rig's stroke are simulated with both fitted models from the same initial pressure;
//! their rms difference over the record, in units of the noise, shows how well each test separates them.

use crate::forward::{Correction, Run};
use crate::record::course::Course;
use crate::record::data::{Data, Prepared};
use crate::record::stroke::{Motion, Phase};
use crate::search::{Candidate, Found, Verdict};
use chamber::simulate::Start;
use records::extremes;
use report::digits;
use serde::Serialize;

/// A test and the explanations that it would separate.
#[derive(Clone, Debug, Serialize)]
pub struct NextExperiment {
    /// The two explanations.
    pub separates: [String; 2],
    /// The test, in words.
    pub test: String,
    /// Difference of the two models' readings, rms, in units of the noise.
    pub difference_over_noise: f64,
}

/// A difference below this multiple of the noise, rms, is useless.
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

/// Tests that separate the chosen model from those that the data cannot tell from it.
pub fn next(data: &Data, found: &Found) -> Vec<NextExperiment> {
    if matches!(found.verdict, Verdict::Adequate | Verdict::Unexplained) {
        return Vec::new();
    }
    let tests = tests(data);
    let alike = found.tried.iter().filter(|c| found.alike.contains(&c.model));
    alike.filter_map(|c| separating(data, &tests, &found.chosen, c)).collect()
}

fn separating(data: &Data, tests: &[Test], a: &Candidate, b: &Candidate) -> Option<NextExperiment> {
    let best = tests
        .iter()
        .filter_map(|test| Some((test, difference(test, a, b)? / data.noise.total_pa())))
        .max_by(|x, y| x.1.total_cmp(&y.1))?;
    let test = if best.1 < TOO_SMALL {
        "no push and hold within the strokes, speeds and pressures of these records separates them; try a faster push, \
         sampled faster. Until then either of them describes these data"
            .to_owned()
    } else {
        best.0.words.clone()
    };
    Some(NextExperiment { separates: [a.model.words(), b.model.words()], test, difference_over_noise: best.1 })
}

/// Root mean square of the difference of two models' readings, Pa.
fn difference(test: &Test, a: &Candidate, b: &Candidate) -> Option<f64> {
    let run = |c: &Candidate| {
        let chamber = c.fit.chamber_of_rig();
        let temperature = test.course.ambient_temperature.at(0.0, &Default::default()).0;
        let start = Start::at_rest(&chamber, test.pressure_pa, temperature);
        Run {
            chamber: &chamber,
            set: chamber.active(),
            start,
            correction: Correction::NONE,
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

/// Tests of which the rig has shown to be capable: over its stroke, from its initial pressures, as fast as its fastest move and
/// more slowly, as long as its longest record and longer.
fn tests(data: &Data) -> Vec<Test> {
    let segments = || data.traces.iter().flat_map(|t| &t.course.motion.segments);
    let of_traces = |value: fn(&Prepared) -> f64| extremes(&data.traces.iter().map(value).collect::<Vec<f64>>());
    let ends: Vec<f64> = segments().map(|s| s.stroke.range()).flat_map(|(low, high)| [low, high]).collect();
    let (low, high) = extremes(&ends);
    let (lowest_pa, highest_pa) = of_traces(|t| t.initial_pressure_pa);
    let (_, longest_s) = of_traces(|t| t.time_s.last().copied().unwrap_or(0.0));
    let moves = segments().filter(|s| s.phase == Phase::Move && s.to_s > s.from_s);
    let speeds = moves.map(|s| {
        let (from, to) = s.stroke.range();
        (to - from) / (s.to_s - s.from_s)
    });
    let fastest_s = (high - low) / speeds.fold(f64::MIN_POSITIVE, f64::max);
    let mut pressures = vec![lowest_pa, highest_pa];
    pressures.dedup_by(|a, b| (*a / *b - 1.0).abs() < 0.1);
    let mut out = Vec::new();
    for (from, to, verb) in [(high, low, "compress"), (low, high, "expand")] {
        for &pressure_pa in &pressures {
            for push_s in [1.0, 4.0, 16.0].map(|slower| slower * fastest_s) {
                for hold_s in [longest_s, 6.0 * longest_s] {
                    let words = format!(
                        "{verb} from {:.0} mm to {:.0} mm in {} s, beginning at {:.2} bar absolute, and hold for {hold_s:.0} s",
                        from * 1e3,
                        to * 1e3,
                        digits(push_s, 2),
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
    // 50 rows in the rest, 100 in the push, `ROWS` in the hold.
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
