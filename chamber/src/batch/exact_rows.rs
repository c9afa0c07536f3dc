//! Sealed tests by the closed forms of [`exact`](crate::exact): no integration, no tolerance.

use super::fit::{self, GAUSS, Nodes, SAMPLE_RATE_HZ, Samples};
use super::outcome::{Failure, Fit, Outcome};
use super::scenario::Scenario;
use crate::exact::Closed;
use pulp::Arch;

/// Ends of the regression's quadrature panels, in time constants; the last goes to the end of the record.
const PANELS: [f64; 8] = [0.0, 0.5, 1.0, 1.75, 2.75, 4.0, 6.0, 10.0];

/// Solves a checked, sealed scenario of that duration, s.
pub fn run(arch: Arch, scenario: &Scenario, duration: f64, fit: bool) -> Outcome {
    let geometry = &scenario.chamber.geometry;
    let [from, to] = [scenario.initial_position_m, scenario.final_position_m].map(|x| geometry.volume(x));
    let (wall, start) = (scenario.ambient_temperature_k, scenario.initial_temperature_k);
    let closed = Closed::filled(&scenario.chamber, scenario.initial_pressure_pa, start, from, wall);
    let peak = closed.ramp(start, from, to, scenario.push_time_s);
    let hold = duration - scenario.push_time_s;
    let end = closed.held(peak, to, hold);
    if !(peak > 0.0 && end > 0.0 && peak.is_finite() && end.is_finite()) {
        return Outcome::failed(Failure::StepTooSmall);
    }
    let settled = (end - wall).abs() <= 0.01 * (peak - end).abs() || peak == end;
    Outcome {
        pressure_peak_pa: closed.pressure(peak, to),
        pressure_final_pa: closed.pressure(end, to),
        temperature_final_k: end,
        temperature_peak_k: peak,
        fit: if fit { regression(arch, scenario, &closed, peak, duration) } else { None },
        settling_time_s: settled.then(|| settling(&closed, peak, end, to)),
        energy_error: 0.0,
        duration_s: duration,
        exact: true,
        status: Ok(()),
    }
}

/// 1 − Tamb/T decays exponentially: when it reaches the edge of the band around the end, s.
fn settling(closed: &Closed, peak: f64, end: f64, volume: f64) -> f64 {
    let edge = end + 0.01 * (peak - end);
    let excess = |temperature: f64| 1.0 - closed.ambient_temperature / temperature;
    let ratio = excess(peak) / excess(edge);
    let time = ratio.ln() / closed.rate(volume);
    if time > 0.0 { time } else { 0.0 }
}

/// The paper's steps on the record from the end of the push on.
fn regression(arch: Arch, scenario: &Scenario, closed: &Closed, peak: f64, duration: f64) -> Option<Fit> {
    let volume = scenario.chamber.geometry.volume(scenario.final_position_m);
    let push = scenario.push_time_s;
    let first = (push * SAMPLE_RATE_HZ - 1e-9).ceil();
    let last = (duration * SAMPLE_RATE_HZ + 1e-9).floor();
    if last - first < 4.0 {
        return None;
    }
    let origin = first / SAMPLE_RATE_HZ;
    let pressure = |t: f64| closed.pressure(closed.held(peak, volume, origin - push + t), volume);
    let sum = Samples::new(last - first, 0);
    let mut nodes = Nodes::default();
    for (number, weight) in sum.single() {
        let t = number / SAMPLE_RATE_HZ;
        nodes.push(t, pressure(t), *weight);
    }
    let tau = 1.0 / closed.rate(volume);
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
                nodes.push(t, pressure(t), 0.5 * (b - a) * weight * SAMPLE_RATE_HZ);
            }
        }
    }
    let found = nodes.exponential(arch, tau)?;
    let positions = [scenario.initial_position_m, scenario.final_position_m];
    fit::steps(scenario, positions, scenario.initial_pressure_pa, found)
}
