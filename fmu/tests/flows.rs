//! Compares charging, discharging, strokes and effects with independent integrations and conservation laws.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use chamber::balance::{Boundary, pressure_temperature_rates};
use chamber::effects::EffectValues;
use chamber::integrate::{Integrator, Tolerance};
use chamber::signals::Signals;
use chamber::simulate::{Start, simulate};
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use common::Host;
use fmu::table::effects::{effects_here, parameter_name};

fn reference() -> Chamber {
    Chamber::new(Gas::AIR, Geometry::new(0.02, 0.0, 2e-6, AreaLaw::Total), HeatTransfer::at_paper_reference(26.5))
}

/// A smooth experiment: stroke and flows as functions of time, piecewise linear over the steps.
fn stroke(t: f64) -> f64 {
    0.08 + 0.03 * (7.0 * t).sin()
}
fn inflow(t: f64) -> f64 {
    2e-4 * (1.0 + (5.0 * t).sin())
}
fn outflow(t: f64) -> f64 {
    1.5e-4 * (1.0 - (9.0 * t).cos())
}

/// Pressure and temperature after one interval of linear inputs, from the paper's equations (1) and (2) in P and T: other states
/// than the FMU's, at a far smaller tolerance.
fn paper_form(chamber: &Chamber, y: [f64; 2], t: f64, h: f64, linear: bool) -> [f64; 2] {
    let between = |f: fn(f64) -> f64, s: f64| if linear { f(t) + (f(t + h) - f(t)) / h * s } else { f(t) };
    let system = |s: f64, y: &[f64; 2]| {
        let boundary = Boundary {
            position: stroke(t) + (stroke(t + h) - stroke(t)) / h * s,
            velocity: (stroke(t + h) - stroke(t)) / h,
            mass_flow_in: between(inflow, s),
            temperature_in: 285.0,
            mass_flow_out: between(outflow, s),
            ambient_temperature: 293.15,
            ambient_pressure: 1e5,
        };
        pressure_temperature_rates(chamber, &boundary, y[0], y[1])
    };
    let mut run = Integrator::new(0.0, y, Tolerance { relative: 1e-13, absolute: [1e-9, 1e-12] });
    run.advance(&system, h, |_| ()).unwrap();
    run.state
}

fn drive(host: &Host, t: f64, h: f64, linear: bool) {
    host.set("position", stroke(t));
    host.set("velocity", (stroke(t + h) - stroke(t)) / h);
    for (name, flow) in [("massFlowIn", inflow as fn(f64) -> f64), ("massFlowOut", outflow)] {
        host.set(name, flow(t));
        if linear {
            host.set_derivative(name, 1, (flow(t + h) - flow(t)) / h);
        }
    }
    host.step(t, h);
}

#[test]
fn charging_and_discharging_agree_with_the_paper_s_form_at_any_communication_step() {
    let chamber = reference();
    for linear in [false, true] {
        for h in [1e-4, 1e-3, 1e-2, 0.1] {
            let host = Host::started(&[("position", stroke(0.0)), ("temperatureIn", 285.0)]);
            let mut y = [101_325.0, 293.15];
            let mut worst: f64 = 0.0;
            for k in 0..(0.8 / h) as u32 {
                let t = f64::from(k) * h;
                drive(&host, t, h, linear);
                y = paper_form(&chamber, y, t, h, linear);
                worst = worst.max((host.get("pressure") / y[0] - 1.0).abs());
                worst = worst.max((host.get("temperature") / y[1] - 1.0).abs());
            }
            assert!(worst < 1e-6, "h = {h}, linear {linear}: {worst:e}");
        }
    }
}

#[test]
fn mass_and_energy_close_to_rounding() {
    // Without heat transfer and with a held piston, dU = cp (ṁin Tin − ṁout T) dt with dm linear in time.
    let values = [("lambda0", 0.0), ("temperatureIn", 350.0), ("initialTemperature", 280.0)];
    let host = Host::new();
    host.start(&values, Some(1e-12));
    host.set("massFlowIn", 3e-4);
    let (m0, u0) = (host.get("mass"), host.get("internalEnergy"));
    for k in 0..100 {
        host.step(f64::from(k) * 1e-2, 1e-2);
    }
    let cp = 1.4 * 287.0 / 0.4;
    assert!((host.get("mass") / (m0 + 3e-4) - 1.0).abs() < 1e-10);
    assert!((host.get("internalEnergy") / (u0 + cp * 3e-4 * 350.0) - 1.0).abs() < 1e-10);
    // Outflow alone is isentropic in the remaining gas: U ∝ m^γ.
    let (m1, u1) = (host.get("mass"), host.get("internalEnergy"));
    host.set("massFlowIn", 0.0);
    host.set("massFlowOut", 2e-4);
    host.step(1.0, 1.0);
    let ratio = (m1 - 2e-4) / m1;
    assert!((host.get("mass") / (m1 - 2e-4) - 1.0).abs() < 1e-10);
    assert!((host.get("internalEnergy") / (u1 * ratio.powf(1.4)) - 1.0).abs() < 1e-10);
}

#[test]
fn heat_and_work_account_for_the_energy_of_a_stroke() {
    let host = Host::new();
    host.start(&[("initialPressure", 3e5)], Some(1e-12));
    let (u0, h) = (host.get("internalEnergy"), 1e-3);
    host.set("velocity", -0.2);
    let area = 0.02f64.powi(2) * std::f64::consts::PI / 4.0;
    let power = |host: &Host| host.get("heatFlow") - host.get("pressure") * area * -0.2;
    let mut points = vec![power(&host)];
    for k in 0..300 {
        host.set("position", 0.1 - 0.2 * f64::from(k) * h);
        host.step(f64::from(k) * h, h);
        points.push(power(&host));
    }
    // Boole's rule, of order h^6.
    let energy: f64 = points
        .windows(5)
        .step_by(4)
        .map(|p| 2.0 * h / 45.0 * (7.0 * p[0] + 32.0 * p[1] + 12.0 * p[2] + 32.0 * p[3] + 7.0 * p[4]))
        .sum();
    assert!((host.get("internalEnergy") / (u0 + energy) - 1.0).abs() < 1e-10);
}

#[test]
fn the_volume_at_a_communication_point_is_that_of_the_position_whatever_the_velocity() {
    let host = Host::started(&[("lambda0", 0.0)]);
    let invariant = |host: &Host| host.get("pressure") * host.get("volume").powf(1.4);
    let before = invariant(&host);
    let mut noise = 12345u32;
    for k in 0..200 {
        noise = noise.wrapping_mul(1664525).wrapping_add(1013904223);
        let position = 0.02 + 0.1 * f64::from(noise >> 16) / 65536.0;
        host.set("position", position);
        host.set("velocity", f64::from(noise & 0xff) / 255.0 - 0.5);
        assert!((host.get("volume") / reference().geometry.volume(position) - 1.0).abs() < 1e-15);
        host.step(f64::from(k) * 1e-3, 1e-3);
    }
    assert!((invariant(&host) / before - 1.0).abs() < 1e-6, "strokes taken up at once are adiabatic");
}

#[test]
fn every_effect_runs_in_the_fmu_as_in_a_simulation() {
    let motion = [(0.0, 0.1), (0.1, 0.1), (0.3, 0.05), (1.0, 0.05)];
    let times: Vec<f64> = (0..=100).map(|k| f64::from(k) * 0.01).collect();
    let signals = Signals::closed(&motion, 293.15, 101_325.0);
    for (index, card) in effects_here().filter(|(_, card)| card.parameters.iter().all(|p| p.is_variable())) {
        let mut chamber = reference();
        let mut values = EffectValues::NEUTRAL;
        for (value, parameter) in values.of_mut(index).iter_mut().zip(card.parameters) {
            *value = parameter.typical;
        }
        chamber.effects = values;
        let host = Host::started(&[]);
        drop(host);
        let host = Host::new();
        let mut starts = Vec::new();
        let names: Vec<String> = card.parameters.iter().map(|p| parameter_name(card, p)).collect();
        for (name, parameter) in names.iter().zip(card.parameters) {
            starts.push((name.as_str(), parameter.typical));
        }
        host.start(&starts, Some(1e-10));
        let start = Start { pressure: 101_325.0, temperature: 293.15 };
        let expected = simulate(&chamber, chamber.active(), start, &signals, &times, 1e-11).unwrap();
        for (k, sample) in expected.iter().enumerate() {
            let tolerance = 2e-7;
            for (name, value) in [
                ("pressure", sample.gas_pressure),
                ("measuredPressure", sample.measured_pressure),
                ("temperature", sample.temperature),
                ("mass", sample.mass),
            ] {
                let ours = host.get(name);
                assert!(
                    (ours / value - 1.0).abs() < tolerance,
                    "{}: {name} at {}: {ours} {value}",
                    card.name,
                    times[k]
                );
            }
            let t = times[k];
            let moving = (10..30).contains(&k);
            host.set(
                "position",
                if k < 10 {
                    0.1
                } else if k < 30 {
                    0.1 - 0.25 * (t - 0.1)
                } else {
                    0.05
                },
            );
            host.set("velocity", if moving { -0.25 } else { 0.0 });
            host.step(t, 0.01);
        }
    }
}

#[test]
fn an_effect_switched_on_between_steps_begins_in_equilibrium() {
    let host = Host::started(&[("initialPressure", 3e5), ("initialTemperature", 380.0)]);
    host.step(0.0, 0.05);
    let pressure = host.get("pressure");
    host.set("sensorLag.timeConstant", 0.02);
    assert_eq!(host.get("measuredPressure"), pressure, "the sensor begins where it stood");
    host.set("recordDelay.delay", 0.01);
    assert_eq!(host.get("measuredPressure"), pressure);
    host.set("ambientTemperature", 310.0);
    host.set("wallHeating.capacity", 5.0);
    assert_eq!(host.get("wallHeating.wallTemperature"), 310.0);
    host.set("gasZones.massFraction", 0.2);
    assert!((host.get("gasZones.coreTemperature") / host.get("temperature") - 1.0).abs() < 1e-14);
    host.step(0.05, 0.05);
    assert!(host.get("measuredPressure") > host.get("pressure"));
}

#[test]
fn a_flow_that_reverses_within_a_step_is_followed() {
    let run = |steps: u32| {
        let host = Host::started(&[("temperatureIn", 350.0)]);
        let h = 0.2 / f64::from(steps);
        for k in 0..steps {
            let t = f64::from(k) * h;
            host.set("massFlowIn", 3e-4 * (1.0 - t / 0.07));
            host.set_derivative("massFlowIn", 1, -3e-4 / 0.07);
            host.set("position", 0.1 + 0.3 * t - t * t);
            host.set_derivative("position", 1, 0.3 - 2.0 * t);
            host.set_derivative("position", 2, -2.0);
            host.step(t, h);
        }
        (host.get("pressure"), host.get("temperature"))
    };
    let (one, many) = (run(1), run(200));
    assert!((one.0 / many.0 - 1.0).abs() < 1e-6 && (one.1 / many.1 - 1.0).abs() < 1e-6, "{one:?} {many:?}");
}
