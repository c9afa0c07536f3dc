//! The chamber in a system: internally solved ports, ends of the stroke, external wall, sums that close, one-time warnings.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use common::Host;
use fmu::boundary::CEnum;
use std::f64::consts::PI;

const CP: f64 = 1.4 * 287.0 / 0.4;

fn warnings(host: &Host) -> Vec<String> {
    let all = host.messages().into_iter().filter(|m| m.category == "logStatusWarning");
    all.inspect(|m| assert_eq!(m.status, 1 as CEnum)).map(|m| m.text).collect()
}

#[test]
fn sums_close_the_balances_whatever_the_step() {
    for h in [1e-4, 1e-3, 1e-2, 0.1] {
        let host = Host::started(&[
            ("initialPressure", 3e5),
            ("supplyPortConductance", 3e-9),
            ("supplyPortPressure", 6e5),
            ("exhaustPortConductance", 2e-9),
            ("temperatureIn", 320.0),
        ]);
        let (u0, m0) = (host.get("internalEnergy"), host.get("mass"));
        // Contributions of ports and flow, from the means seen by the host; the gas loses nothing else.
        let (mut mass, mut enthalpy) = (0.0, 0.0);
        for k in 0..(0.4f64 / h).round() as u32 {
            let t = f64::from(k) * h;
            host.set("position", 0.08 + 0.03 * (7.0 * t).sin());
            host.set("velocity", 0.21 * (7.0 * t).cos());
            host.set("massFlowIn", 1e-4);
            host.step(t, h);
            for port in ["supply", "exhaust"] {
                mass += h * host.get(&format!("{port}PortMassFlow"));
                enthalpy += h * host.get(&format!("{port}PortEnthalpyFlow"));
            }
            mass += h * 1e-4;
            enthalpy += h * 1e-4 * CP * 320.0;
        }
        let gained = host.get("internalEnergy") - u0;
        let (heat, work) = (host.get("heatReceived"), host.get("workDone"));
        assert!((gained - (heat + enthalpy - work)).abs() < 1e-8 * u0, "h = {h}: {gained} {heat} {enthalpy} {work}");
        assert!((gained - (heat + host.get("enthalpyReceived") - work)).abs() < 1e-8 * u0, "h = {h}");
        assert!((host.get("mass") - m0 - mass).abs() < 1e-8 * m0, "h = {h}: {mass}");
        assert!((host.get("mass") - m0 - host.get("massReceived")).abs() < 1e-14 * m0, "h = {h}");
    }
}

#[test]
fn instantaneous_strokes_count_as_work_and_the_exact_hold_as_heat() {
    let host = Host::started(&[("initialPressure", 3e5)]);
    let u0 = host.get("internalEnergy");
    for k in 0..20 {
        host.set("position", 0.1 - 0.002 * f64::from(k % 5));
        host.step(f64::from(k) * 0.01, 0.01);
        let sum = host.get("heatReceived") - host.get("workDone");
        assert!((host.get("internalEnergy") - u0 - sum).abs() < 1e-12 * u0);
    }
    assert_eq!(host.get("massReceived"), 0.0);
    assert!(host.get("enthalpyReceived").abs() < 1e-12 * u0);
}

#[test]
fn a_port_fills_a_small_volume_at_a_coarse_step_as_at_a_fine_one() {
    // 4 l/(s bar) into 3 cm³.
    let area = PI * 0.02f64.powi(2) / 4.0;
    let fill = |h: f64| {
        let host = Host::started(&[
            ("deadVolume", 1e-6),
            ("position", 2e-6 / area),
            ("supplyPortConductance", 4e-8),
            ("supplyPortPressure", 7e5),
        ]);
        (0..(0.05 / h).round() as u32).for_each(|k| host.step(f64::from(k) * h, h));
        (host.get("pressure"), host.get("temperature"))
    };
    let (fine, coarse) = (fill(1e-4), fill(1e-2));
    assert!((fine.0 - coarse.0).abs() < 1.0 && (fine.1 - coarse.1).abs() < 1e-3, "{fine:?} {coarse:?}");
    assert!((fine.0 / 7e5 - 1.0).abs() < 1e-4, "{fine:?}");
}

#[test]
fn a_frictionless_mass_on_the_gas_conserves_energy() {
    let host = Host::new();
    host.start(&[("lambda0", 0.0), ("strokeInput", 2.0), ("initialPressure", 2e5)], None);
    let area = PI * 0.02f64.powi(2) / 4.0;
    let (mass, h) = (2.0, 1e-3);
    let mut v = 0.0;
    let energy = |host: &Host, v: f64| {
        host.get("internalEnergy") + 101_325.0 * area * host.get("pistonPosition") + 0.5 * mass * v * v
    };
    let (before, mut worst): (f64, f64) = (energy(&host, v), 0.0);
    // Velocity at half steps, as in an energy-conserving integrator.
    v += 0.5 * h * host.get("force") / mass;
    for k in 0..1000 {
        host.set("velocity", v);
        host.step(f64::from(k) * h, h);
        let push = h * host.get("force") / mass;
        worst = worst.max((energy(&host, v + 0.5 * push) / before - 1.0).abs());
        v += push;
    }
    assert!(worst < 1e-5, "{worst:e}");
    assert!(host.get("pistonPosition") > 0.05, "it swings");
}

#[test]
fn a_position_beyond_the_stroke_is_limited_and_reported_once() {
    let host = Host::started(&[("stroke", 0.15)]);
    host.set("velocity", 1.0);
    for k in 0..10 {
        let t = f64::from(k) * 0.01;
        host.set("position", 0.1 + t);
        host.step(t, 0.01);
        assert!((host.get("pistonPosition") - (0.11 + t).min(0.15)).abs() < 1e-15, "{t}");
    }
    host.set("position", -0.01);
    host.step(0.1, 0.01);
    assert_eq!(host.get("pistonPosition"), 0.0);
    let texts = warnings(&host);
    let limited: Vec<_> = texts.iter().filter(|text| text.contains("beyond its stroke of 0.15 m")).collect();
    assert_eq!(limited.len(), 1, "{texts:?}");
}

#[test]
fn within_a_step_the_piston_stops_where_the_stroke_ends() {
    let run = |steps: u32| {
        let host = Host::started(&[("stroke", 0.12), ("strokeInput", 2.0), ("wallHeating.capacity", 1.0)]);
        host.set("velocity", 1.0);
        let h = 0.08 / f64::from(steps);
        (0..steps).for_each(|k| host.step(f64::from(k) * h, h));
        (host.get("pistonPosition"), host.get("pressure"), host.get("workDone"))
    };
    let (one, many) = (run(1), run(80));
    assert!((one.0 - 0.12).abs() < 1e-14 && (many.0 - 0.12).abs() < 1e-14);
    assert!((one.1 / many.1 - 1.0).abs() < 1e-8 && (one.2 / many.2 - 1.0).abs() < 1e-7, "{one:?} {many:?}");
}

#[test]
fn the_velocity_alone_moves_the_piston_and_the_position_is_of_no_influence() {
    let run = |position: f64| {
        let host = Host::started(&[("strokeInput", 2.0)]);
        host.set("velocity", -0.2);
        for k in 0..50 {
            host.set("position", position);
            host.step(f64::from(k) * 1e-3, 1e-3);
        }
        assert_eq!(host.directional("force", "velocity"), 0.0);
        assert_eq!(host.directional("force", "position"), 0.0);
        assert!(warnings(&host).is_empty());
        (host.get("pistonPosition"), host.get("pressure"))
    };
    let (one, other) = (run(0.1), run(7.0));
    assert_eq!(one, other);
    assert!((one.0 - 0.09).abs() < 1e-14);
}

#[test]
fn position_and_velocity_that_disagree_are_reported_once_and_noise_is_not() {
    let host = Host::started(&[]);
    for k in 0..20 {
        let t = f64::from(k) * 1e-3;
        host.set("velocity", 0.5);
        host.set("position", 0.1 + 0.5 * t + 1e-6 * f64::from(k % 3));
        host.step(t, 1e-3);
    }
    assert!(warnings(&host).is_empty());
    host.set("velocity", 0.0);
    for k in 20..30 {
        host.set("position", 0.11 + 0.003 * f64::from(k - 20));
        host.step(f64::from(k) * 1e-3, 1e-3);
    }
    let texts = warnings(&host);
    assert_eq!(texts.len(), 1, "{texts:?}");
    assert!(texts[0].contains("position has moved by") && texts[0].contains("strokeInput = velocity"), "{texts:?}");
}

#[test]
fn states_where_the_model_is_not_valid_are_reported_once_each() {
    let host = Host::started(&[("position", 0.1), ("deadVolume", 1e-9)]);
    for k in 0..20 {
        host.set("position", 1e-4);
        host.set("velocity", if k == 3 { 30.0 } else { 0.0 });
        host.step(f64::from(k) * 1e-5, 1e-5);
    }
    let texts = warnings(&host);
    for words in ["is beyond 1e7 Pa", "is outside 150 to 700 K", "is faster than 20 m/s"] {
        assert_eq!(texts.iter().filter(|text| text.contains(words)).count(), 1, "{words}: {texts:?}");
    }
    unsafe { fmu::fmi2::abi::fmi2Reset(host.c) };
    host.start(&[("position", 0.1), ("deadVolume", 1e-9)], None);
    host.set("position", 1e-4);
    host.step(0.0, 1e-5);
    assert!(!warnings(&host).is_empty(), "a reset instance gives them again");
}

#[test]
fn an_external_wall_replaces_the_effects_of_the_wall_which_keep_their_states_and_are_reported_once() {
    for effect in [0.0, 2.0] {
        let host = Host::started(&[
            ("externalWall", 1.0),
            ("wallTemperature", 350.0),
            ("wallHeating.capacity", effect),
            ("wallConduction.inverseEffusivity", 1e-3 * effect),
            ("initialPressure", 2e5),
        ]);
        let texts = warnings(&host);
        assert_eq!(texts.len(), usize::from(effect > 0.0), "{texts:?}");
        assert!(
            texts.iter().all(|text| text.contains("wallHeating and wallConduction have no influence")),
            "{texts:?}"
        );
        host.step(0.0, 30.0);
        assert!((host.get("temperature") - 350.0).abs() < 1e-6, "{}", host.get("temperature"));
        assert_eq!((host.get("wallHeating.wallTemperature"), host.get("wallConduction.mode7")), (293.15, 0.0));
        host.set("warmWall.temperatureDifference", 5.0);
        assert_eq!(warnings(&host).len(), usize::from(effect == 0.0));
        host.set("wallTemperature", 300.0);
        assert_eq!(host.get("der(wallHeating.wallTemperature)"), 0.0);
        let expected = -host.get("heatTransferCoefficient") * 50.0;
        let area = host.get("heatFlow") / expected;
        assert!((area - (4.0 * host.get("volume") / 0.02 + PI * 2e-4)).abs() < 1e-8, "{area}");
    }
}
