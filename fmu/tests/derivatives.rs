//! Compares directional and output derivatives with finite differences of the FMU itself.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use common::Host;
use fmu::table::table;
use fmu::table::variable::Role;

/// Whether a derivative agrees with a central difference over ±`d` of a value known to `relative`.
fn close(exact: f64, difference: f64, value: f64, relative: f64, d: f64) -> bool {
    (exact - difference).abs() <= 1e-5 * difference.abs() + relative * value.abs() / d
}

/// A running chamber with all effects on, out of equilibrium.
fn under_way() -> Host {
    let host = Host::started(&[
        ("initialPressure", 3e5),
        ("initialTemperature", 340.0),
        ("rodDiameter", 0.008),
        ("leakage.conductance", 1e-11),
        ("wallHeating.capacity", 3.0),
        ("wallHeating.outerConductance", 0.1),
        ("naturalConvection.exponent", 0.25),
        ("forcedConvection.coefficient", 0.7),
        ("gasColumnLength.exponent", -0.5),
        ("gasZones.massFraction", 0.2),
        ("gasZones.conductance", 0.03),
        ("tubeVolume.volume", 1e-6),
        ("sensorDrift.rate", 50.0),
    ]);
    host.set("velocity", -0.2);
    host.set("massFlowIn", 2e-4);
    host.set("massFlowOut", 1e-4);
    host.set("temperatureIn", 280.0);
    host.step(0.0, 0.05);
    // A jump of 1 mm is pending: without one, gas in the tube makes pushing different from pulling.
    host.set("position", host.get("position") - 0.2 * 0.05 - 1e-3);
    host
}

#[test]
fn derivatives_by_inputs_and_tunable_parameters_are_those_of_central_differences() {
    let host = under_way();
    let saved = host.save();
    let knowns = ["position", "velocity", "massFlowIn", "temperatureIn", "massFlowOut", "ambientTemperature"];
    let tunable =
        ["lambda0", "leakage.conductance", "forcedConvection.coefficient", "tubeVolume.volume", "ambientPressure"];
    for known in knowns.iter().chain(&tunable) {
        let at = host.get(known);
        let d = 1e-5 * if known.contains('.') { at.abs() } else { at.abs().max(1e-3) };
        for v in table().iter().filter(|v| matches!(v.role, Role::Output(_) | Role::Rate(_))) {
            let exact = host.directional(&v.name, known);
            let shifted = |delta: f64| {
                host.set(known, at + delta);
                let value = host.get(&v.name);
                host.restore(saved);
                value
            };
            let difference = (shifted(d) - shifted(-d)) / (2.0 * d);
            // The jump is computed to 1e-11 of the states, which rates and the difference over d magnify.
            let value = host.get(&v.name).abs().max(v.nominal);
            assert!(close(exact, difference, value, 1e-9, d), "d {} / d {known}: {exact} {difference}", v.name);
        }
    }
}

#[test]
fn derivatives_at_the_start_are_those_of_central_differences() {
    let host = Host::new();
    host.set("initialPressure", 3e5);
    host.set("initialTemperature", 340.0);
    host.set("leakage.conductance", 1e-11);
    host.set("velocity", 0.1);
    // Away from zero, where a flow's direction has a kink.
    host.set("massFlowIn", 1e-4);
    host.set("massFlowOut", 2e-4);
    assert_eq!(unsafe { fmu::fmi2::abi::fmi2EnterInitializationMode(host.c) }, 0);
    for known in table().iter().filter(|v| matches!(v.role, Role::Input(_) | Role::Parameter(_))) {
        let at = host.get(&known.name);
        let d = at.abs().max(1e-2 * known.nominal) * 1e-6;
        if at - d < known.min.unwrap_or(f64::MIN) || known.name == "naturalConvection.exponent" {
            continue;
        }
        for v in table().iter().filter(|v| matches!(v.role, Role::Output(_) | Role::Rate(_))) {
            let exact = host.directional(&v.name, &known.name);
            let shifted = |delta: f64| {
                host.set(&known.name, at + delta);
                let value = host.get(&v.name);
                host.set(&known.name, at);
                value
            };
            let difference = (shifted(d) - shifted(-d)) / (2.0 * d);
            let value = host.get(&v.name).abs().max(v.nominal);
            assert!(close(exact, difference, value, 1e-13, d), "d {} / d {}: {exact} {difference}", v.name, known.name);
        }
    }
}

#[test]
fn a_piston_held_by_the_far_end_follows_the_stroke() {
    let host = Host::new();
    host.set("position", 0.08);
    host.set("stroke", 0.05);
    assert_eq!(unsafe { fmu::fmi2::abi::fmi2EnterInitializationMode(host.c) }, 0);
    assert_eq!(host.get("pistonPosition"), 0.05);
    assert_eq!(host.directional("pistonPosition", "stroke"), 1.0);
    assert_eq!(host.directional("pistonPosition", "position"), 0.0);
}

#[test]
fn a_mass_flow_changes_the_mass_s_rate_by_itself_even_at_rest() {
    let host = Host::started(&[]);
    assert_eq!(host.directional("der(mass)", "massFlowIn"), 1.0);
    assert_eq!(host.directional("der(mass)", "massFlowOut"), -1.0);
    assert_eq!(host.directional("mass", "mass"), 1.0);
    let gamma_p_over_v = 1.4 * host.get("pressure") / host.get("volume");
    let area = 0.02f64.powi(2) * std::f64::consts::PI / 4.0;
    assert!((host.directional("pressure", "position") / (-gamma_p_over_v * area) - 1.0).abs() < 1e-12);
}

#[test]
fn output_derivatives_are_the_rates_at_which_outputs_change() {
    let host = under_way();
    host.set("sensorLag.timeConstant", 0.03);
    host.set("recordDelay.delay", 0.02);
    // First fill the delay's history and let the lag settle.
    host.step(0.05, 0.05);
    host.set("position", host.get("position") - 0.01);
    let d = 1e-5;
    let saved = host.save();
    for v in table().iter().filter(|v| matches!(v.role, Role::Output(_))) {
        let exact = host.output_derivative(&v.name);
        let begin = host.get(&v.name);
        host.step(0.1, d);
        let end_rate = host.output_derivative(&v.name);
        let difference = (host.get(&v.name) - begin) / d;
        host.restore(saved);
        assert!(
            (0.5 * (exact + end_rate) - difference).abs() <= 1e-4 * difference.abs() + 1e-6 * v.nominal / d * 1e-3,
            "{}: {exact} {difference}",
            v.name
        );
    }
}

#[test]
fn a_known_that_is_calculated_and_an_unknown_that_is_not_are_refused_by_name() {
    let host = Host::started(&[]);
    let (pressure, bore) = (common::reference("pressure"), common::reference("bore"));
    let mut value = 0.0;
    let status =
        unsafe { fmu::fmi2::abi::fmi2GetDirectionalDerivative(host.c, &pressure, 1, &pressure, 1, &1.0, &mut value) };
    assert_eq!(status, 3);
    assert!(host.message().contains("pressure cannot be a known of a directional derivative"));
    let status = unsafe { fmu::fmi2::abi::fmi2GetDirectionalDerivative(host.c, &bore, 1, &bore, 1, &1.0, &mut value) };
    assert_eq!(status, 3);
    assert!(host.message().contains("bore cannot be an unknown"));
}
