//! Compares the FMU with the closed forms of the sealed chamber, at communication steps from 0.1 ms to 0.1 s.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use chamber::exact::Closed;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use common::Host;

const AMBIENT: f64 = 293.0;
const PRESSURE: f64 = 1.2e5;
const FROM: f64 = 0.1;
const TO: f64 = 0.05;

fn reference(area_law: AreaLaw) -> Chamber {
    Chamber::new(Gas::AIR, Geometry::new(0.025, 0.01, 2e-6, area_law), HeatTransfer::at_paper_reference(30.0))
}

fn host(area_law: AreaLaw, tolerance: Option<f64>) -> Host {
    let host = Host::new();
    let law = if area_law == AreaLaw::Total { 1.0 } else { 2.0 };
    let values = [
        ("bore", 0.025),
        ("rodDiameter", 0.01),
        ("deadVolume", 2e-6),
        ("areaLaw", law),
        ("lambda0", 30.0),
        ("initialPressure", PRESSURE),
        ("initialTemperature", AMBIENT),
        ("ambientTemperature", AMBIENT),
        ("position", FROM),
    ];
    host.start(&values, tolerance);
    host
}

/// Exact pressure at a time after the start of a ramp of `push` seconds, followed by a hold.
fn exact(chamber: &Chamber, push: f64, t: f64) -> f64 {
    let (v0, v1) = (chamber.geometry.volume(FROM), chamber.geometry.volume(TO));
    let closed = Closed::filled(chamber, PRESSURE, AMBIENT, v0, AMBIENT);
    if t < push {
        let v = v0 + (v1 - v0) * t / push;
        return closed.pressure(closed.ramp(AMBIENT, v0, v, t), v);
    }
    closed.pressure(closed.held(closed.ramp(AMBIENT, v0, v1, push), v1, t - push), v1)
}

/// Largest relative error of pressure and temperature over a push and a hold.
fn worst_error(host: &Host, chamber: &Chamber, push: f64, steps_of_push: i32, set: impl Fn(&Host, f64, f64)) -> f64 {
    let h = push / f64::from(steps_of_push);
    let mut worst: f64 = 0.0;
    for k in 0..4 * steps_of_push.max(3) {
        let t = push * f64::from(k) / f64::from(steps_of_push);
        let speed = if k < steps_of_push { (TO - FROM) / push } else { 0.0 };
        set(host, FROM + (TO - FROM) * (t / push).min(1.0), speed);
        host.step(t, h);
        let p = exact(chamber, push, t + h);
        let volume = host.get("volume");
        let temperature = p * volume / (host.get("mass") * 287.0);
        worst =
            worst.max((host.get("pressure") / p - 1.0).abs()).max((host.get("temperature") / temperature - 1.0).abs());
    }
    worst
}

#[test]
fn a_push_and_hold_agrees_with_the_exact_solution_at_any_communication_step() {
    for law in [AreaLaw::Total, AreaLaw::Swept] {
        for (push, steps) in [(0.1, 1000), (0.1, 100), (0.1, 10), (0.1, 1), (0.2, 2), (0.02, 1), (1.0, 10)] {
            let worst = worst_error(&host(law, None), &reference(law), push, steps, |host, position, velocity| {
                host.set("position", position);
                host.set("velocity", velocity);
            });
            assert!(worst < 1e-6, "{} s in {steps}: {worst:e}", push);
        }
    }
}

#[test]
fn the_position_s_derivative_serves_as_well_as_the_velocity() {
    let law = AreaLaw::Total;
    let worst = worst_error(&host(law, None), &reference(law), 0.1, 4, |host, position, velocity| {
        host.set("position", position);
        host.set("velocity", 77.0);
        host.set_derivative("position", 1, velocity);
    });
    assert!(worst < 1e-6, "{worst:e}");
}

#[test]
fn the_host_s_tolerance_is_obeyed() {
    let law = AreaLaw::Total;
    let error = |tolerance| {
        worst_error(&host(law, Some(tolerance)), &reference(law), 1.0, 1, |host, position, velocity| {
            host.set("position", position);
            host.set("velocity", velocity);
        })
    };
    let (coarse, fine) = (error(1e-3), error(1e-12));
    assert!(fine < 1e-10, "{fine:e}");
    assert!(coarse > 100.0 * fine && coarse < 1e-2, "{coarse:e}");
}

#[test]
fn a_hold_of_any_length_is_exact() {
    let host = host(AreaLaw::Total, None);
    host.set("position", TO);
    let chamber = reference(AreaLaw::Total);
    let (v0, v1) = (chamber.geometry.volume(FROM), chamber.geometry.volume(TO));
    let closed = Closed::filled(&chamber, PRESSURE, AMBIENT, v0, AMBIENT);
    let hot = AMBIENT * (v0 / v1).powf(0.4);
    let mut t = 0.0;
    for h in [1e-6, 1e-3, 0.3, 5.0, 1e6, 1e300] {
        host.step(t, h);
        t += h;
        let expected = closed.pressure(closed.held(hot, v1, t), v1);
        assert!((host.get("pressure") / expected - 1.0).abs() < 1e-13, "{t}");
    }
}
