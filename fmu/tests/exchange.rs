//! Model Exchange: a host that integrates gets the results of co-simulation, meets every kink as an event, and is refused any
//! call out of order.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use chamber::effects;
use chamber::integrate::{Integrator, Tolerance};
use common::{Host, reference};
use fmu::fmi2::abi::*;
use fmu::fmi2::host::EventInfo;
use fmu::plant::event_indicators::EVENT_INDICATORS;
use fmu::plant::states::ALL;
use fmu::table::effects::{effects_here, parameter_name};
use fmu::table::index_of_state;

/// A host that integrates: Dormand and Prince's pair, with inputs as functions of time.
struct Exchange<F> {
    host: Host,
    time: f64,
    inputs: F,
}

impl<F: Fn(&Host, f64)> Exchange<F> {
    fn started(values: &[(&str, f64)], tolerance: f64, inputs: F) -> Self {
        let host = Host::exchange();
        inputs(&host, 0.0);
        host.start(values, Some(tolerance));
        let new = Self { host, time: 0.0, inputs };
        new.handle_event();
        new
    }

    /// Goes from event mode to continuous time; returns whether states changed.
    fn handle_event(&self) -> bool {
        let mut info = EventInfo::default();
        unsafe {
            assert_eq!(fmi2NewDiscreteStates(self.host.c, &mut info), 0, "{:?}", self.host.messages());
            assert_eq!(fmi2EnterContinuousTimeMode(self.host.c), 0);
        }
        assert_eq!((info.new_discrete_states_needed, info.next_event_time_defined), (0, 0));
        info.values_of_continuous_states_changed != 0
    }

    fn states(&self) -> [f64; ALL] {
        let mut x = [0.0; ALL];
        assert_eq!(unsafe { fmi2GetContinuousStates(self.host.c, x.as_mut_ptr(), ALL) }, 0);
        x
    }

    fn at(&self, t: f64, x: &[f64; ALL]) {
        unsafe {
            assert_eq!(fmi2SetTime(self.host.c, t), 0);
            assert_eq!(fmi2SetContinuousStates(self.host.c, x.as_ptr(), ALL), 0);
        }
        (self.inputs)(&self.host, t);
    }

    fn rates(&self, t: f64, x: &[f64; ALL]) -> [f64; ALL] {
        self.at(t, x);
        let mut rates = [f64::NAN; ALL];
        unsafe { fmi2GetDerivatives(self.host.c, rates.as_mut_ptr(), ALL) };
        rates
    }

    fn indicators(&self) -> [f64; EVENT_INDICATORS] {
        let mut z = [f64::NAN; EVENT_INDICATORS];
        assert_eq!(unsafe { fmi2GetEventIndicators(self.host.c, z.as_mut_ptr(), EVENT_INDICATORS) }, 0);
        z
    }

    /// Integrates to `until` over an interval with smooth inputs, completing each step for the record.
    fn advance(&mut self, until: f64) {
        let mut nominals = [0.0; ALL];
        assert_eq!(unsafe { fmi2GetNominalsOfContinuousStates(self.host.c, nominals.as_mut_ptr(), ALL) }, 0);
        let tolerance = Tolerance { relative: 1e-11, absolute: nominals.map(|n| 1e-13 * n) };
        let mut run = Integrator::new(self.time, self.states(), tolerance);
        let steps = ((until - self.time) / 2e-3).ceil();
        let (from, length) = (self.time, (until - self.time) / steps);
        for k in 1..=steps as u32 {
            let end = if f64::from(k) == steps { until } else { from + f64::from(k) * length };
            run.advance(&|t: f64, x: &[f64; ALL]| self.rates(t, x), end, |_| ()).unwrap();
            self.at(end, &run.state);
            let (mut event, mut end) = (7, 7);
            assert_eq!(unsafe { fmi2CompletedIntegratorStep(self.host.c, 1, &mut event, &mut end) }, 0);
            assert_eq!((event, end), (0, 0));
        }
        self.time = until;
    }

    /// Integrates in steps of `h` until an indicator changes sign, and halves the last step until the event is located to 1e-12
    /// s; returns the indicator's index.
    fn next_event(&mut self, h: f64, latest: f64) -> Option<usize> {
        let z = self.indicators();
        while self.time < latest {
            let (t, x) = (self.time, self.states());
            let changed = |z1: &[f64; EVENT_INDICATORS]| (0..EVENT_INDICATORS).find(|&i| z[i] * z1[i] <= 0.0);
            let mut step = h;
            loop {
                self.advance(t + step);
                match changed(&self.indicators()) {
                    Some(i) if step < 1e-12 => {
                        unsafe { assert_eq!(fmi2EnterEventMode(self.host.c), 0) };
                        return Some(i);
                    }
                    Some(_) => {
                        self.time = t;
                        self.at(t, &x);
                        step *= 0.5;
                    }
                    None => break,
                }
            }
        }
        None
    }
}

/// A push from 0.1 m to 0.05 m between 0.1 s and 0.3 s.
fn push(t: f64) -> (f64, f64) {
    if t < 0.1 {
        (0.1, 0.0)
    } else if t < 0.3 {
        (0.1 - 0.25 * (t - 0.1), -0.25)
    } else {
        (0.05, 0.0)
    }
}

#[test]
fn a_host_that_integrates_finds_what_co_simulation_finds_with_every_effect() {
    let all: Vec<usize> = effects_here().map(|(index, _)| index).collect();
    let sets = all.iter().map(|i| vec![*i]).chain([Vec::new(), all.clone()]);
    for set in sets {
        let mut starts = vec![("initialPressure".to_owned(), 3e5), ("initialTemperature".to_owned(), 300.0)];
        for &index in &set {
            let card = &effects::CARDS[index];
            for p in card.parameters.iter().filter(|p| p.is_variable()) {
                starts.push((parameter_name(card, p), p.typical));
            }
        }
        let starts: Vec<(&str, f64)> = starts.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let together = Host::new();
        together.start(&starts, Some(1e-11));
        // At a kink in time, the value after it applies.
        let speed = std::cell::Cell::new(0.0);
        let mut apart = Exchange::started(&starts, 1e-11, |host, t| {
            host.set("position", push(t).0);
            host.set("velocity", speed.get());
        });
        for k in 0..50 {
            let t = f64::from(k) * 0.01;
            let (position, velocity) = push(t + 1e-9);
            together.set("position", push(t).0);
            together.set("velocity", velocity);
            together.step(t, 0.01);
            speed.set(velocity);
            assert!((position - push(t).0).abs() < 1e-8);
            apart.advance(t + 0.01);
            for (name, allowed) in [
                ("pressure", 1e-8),
                ("temperature", 1e-8),
                ("mass", 1e-8),
                ("heatReceived", 1e-6),
                ("workDone", 1e-6),
                ("measuredPressure", 1e-6),
            ] {
                let (one, other) = (together.get(name), apart.host.get(name));
                assert!((one - other).abs() <= allowed * one.abs().max(1e-3), "{set:?} {name} at {t}: {one} {other}");
            }
        }
    }
}

#[test]
fn a_discharge_passes_its_kinks_one_after_the_other() {
    let mut leaking = Exchange::started(
        &[("initialPressure", 5e5), ("leakage.conductance", 3e-9), ("leakage.criticalPressureRatio", 0.4)],
        1e-8,
        |_, _| (),
    );
    let mut ratios = Vec::new();
    while leaking.next_event(1e-3, 3.0).is_some() {
        ratios.push(leaking.host.get("ambientPressure") / leaking.host.get("pressure"));
        assert!(!leaking.handle_event());
    }
    assert_eq!(ratios.len(), 2, "{ratios:?}");
    assert!((ratios[0] - 0.4).abs() < 1e-7 && (ratios[1] - 0.999).abs() < 1e-7, "{ratios:?}");
}

#[test]
fn flows_and_ports_that_turn_round_are_events() {
    let mut turning = Exchange::started(&[], 1e-8, |host, t| host.set("massFlowIn", 1e-4 * (1.0 - t / 0.05)));
    assert!(turning.next_event(7e-3, 0.2).is_some());
    assert!((turning.time - 0.05).abs() < 1e-6, "{}", turning.time);
    let values = [("supplyPortConductance", 2e-9), ("supplyPortPressure", 3e5)];
    let mut filling = Exchange::started(&values, 1e-8, |_, _| ());
    let mut seen = Vec::new();
    while filling.next_event(2e-3, 1.0).is_some() {
        seen.push(filling.host.get("pressure") / 3e5);
        filling.handle_event();
    }
    assert_eq!(seen.len(), 1, "{seen:?}");
    assert!((seen[0] - 0.999).abs() < 1e-7, "the flow begins subsonic and turns linear: {seen:?}");
}

#[test]
fn a_piston_that_its_velocity_moves_rests_at_the_end_of_its_stroke_and_leaves_it() {
    let values = [("stroke", 0.12), ("strokeInput", 2.0), ("position", 0.1)];
    let mut pushed = Exchange::started(&values, 1e-8, |host, t| host.set("velocity", (10.0 * t).cos()));
    assert!(pushed.next_event(1e-3, 0.1).is_some());
    assert!((pushed.host.get("pistonPosition") - 0.12).abs() < 1e-9);
    assert!((pushed.time - 0.1 * 0.2f64.asin()).abs() < 1e-8);
    pushed.handle_event();
    assert_eq!(pushed.host.get("der(travel)"), 0.0);
    assert!(pushed.next_event(1e-3, 1.0).is_some());
    assert!((pushed.time - 0.1 * std::f64::consts::FRAC_PI_2).abs() < 1e-8, "{}", pushed.time);
    pushed.handle_event();
    pushed.advance(0.3);
    let back = 0.12 + 0.1 * (3f64.sin() - 1.0);
    assert!((pushed.host.get("pistonPosition") - back).abs() < 1e-8);
    assert_eq!(pushed.host.messages().iter().filter(|m| m.category == "logStatusWarning").count(), 1);
}

#[test]
fn a_position_that_jumps_in_an_event_compresses_the_gas_adiabatically() {
    let position = std::cell::Cell::new(0.1);
    let jumping = Exchange::started(&[("lambda0", 0.0)], 1e-8, |host, _| host.set("position", position.get()));
    let (pressure, volume) = (jumping.host.get("pressure"), jumping.host.get("volume"));
    unsafe { assert_eq!(fmi2EnterEventMode(jumping.host.c), 0) };
    jumping.host.set("position", 0.05);
    assert!(jumping.handle_event(), "states have changed");
    let expected = pressure * (volume / jumping.host.get("volume")).powf(1.4);
    assert!((jumping.host.get("pressure") / expected - 1.0).abs() < 1e-12);
    let gained = jumping.host.get("internalEnergy") + jumping.host.get("workDone");
    assert!((gained * 0.4 / (pressure * volume) - 1.0).abs() < 1e-12);
}

#[test]
fn rates_and_outputs_have_the_derivatives_of_their_differences_by_states_and_inputs() {
    let values = [
        ("initialPressure", 3e5),
        ("initialTemperature", 340.0),
        ("leakage.conductance", 1e-11),
        ("wallHeating.capacity", 3.0),
        ("naturalConvection.exponent", 0.25),
        ("forcedConvection.coefficient", 0.7),
        ("gasZones.massFraction", 0.2),
        ("gasZones.conductance", 0.03),
        ("tubeVolume.volume", 1e-6),
        ("supplyPortConductance", 1e-9),
        ("supplyPortPressure", 6e5),
        ("velocity", -0.2),
    ];
    let mut running = Exchange::started(&values, 1e-8, |_, _| ());
    running.advance(0.02);
    let host = &running.host;
    let base = running.states();
    let names: Vec<String> = fmu::table::table().iter().map(|v| v.name.clone()).collect();
    let unknowns = ["der(internalEnergy)", "der(mass)", "pressure", "temperature", "heatFlow", "force", "workDone"];
    for state in 0..ALL {
        let known = &names[index_of_state(state).unwrap()];
        let d = 1e-6 * base[state].abs().max(1e-6);
        for unknown in unknowns {
            let exact = host.directional(unknown, known);
            let shifted = |delta: f64| {
                let mut x = base;
                x[state] += delta;
                running.at(0.02, &x);
                let value = host.get(unknown);
                running.at(0.02, &base);
                value
            };
            let difference = (shifted(d) - shifted(-d)) / (2.0 * d);
            let scale = host.get(unknown).abs().max(1e-3);
            assert!(
                (exact - difference).abs() <= 1e-5 * difference.abs() + 1e-12 * scale / d,
                "d {unknown} / d {known}: {exact} {difference}"
            );
        }
    }
    assert!(
        host.directional("temperature", "position").abs() < 1e-9,
        "the energy is a state: the host's work changes it"
    );
}

#[test]
fn what_belongs_to_one_kind_or_mode_is_refused_in_another() {
    let host = Host::exchange();
    let mut x = [0.0; ALL];
    let mut info = EventInfo::default();
    unsafe {
        assert_eq!(fmi2SetTime(host.c, 0.0), 3);
        assert_eq!(fmi2NewDiscreteStates(host.c, &mut info), 3);
        host.start(&[], None);
        assert_eq!(fmi2DoStep(host.c, 0.0, 0.1, 1), 3);
        assert_eq!(fmi2EnterContinuousTimeMode(host.c), 0);
        assert_eq!(fmi2GetContinuousStates(host.c, x.as_mut_ptr(), ALL), 0);
        assert_eq!(fmi2SetContinuousStates(host.c, x.as_ptr(), ALL - 1), 3);
        host.messages();
        x[1] = f64::NAN;
        assert_eq!(fmi2SetContinuousStates(host.c, x.as_ptr(), ALL), 2);
        assert!(host.message().contains("internalEnergy = NaN J is not a finite number"));
        x[1] = -1.0;
        assert_eq!(fmi2SetContinuousStates(host.c, x.as_ptr(), ALL), 0);
        assert_eq!(fmi2GetDerivatives(host.c, x.as_mut_ptr(), ALL), 2, "the solver takes a smaller step");
        assert!(host.message().contains("make no gas"));
        assert_eq!(fmi2SetReal(host.c, &reference("lambda0"), 1, &30.0), 3);
        assert!(host.message().contains("parameters change in event mode"));
        assert_eq!(fmi2NewDiscreteStates(host.c, &mut info), 3);
        host.messages();
        let stepping = Host::started(&[]);
        assert_eq!(fmi2GetContinuousStates(stepping.c, x.as_mut_ptr(), ALL), 2);
        assert!(stepping.message().contains("this instance is for co-simulation"));
        assert_eq!(fmi2EnterEventMode(stepping.c), 3);
    }
}

#[test]
fn a_saved_state_of_a_host_that_integrates_continues_bit_by_bit() {
    let values = [("initialPressure", 3e5), ("recordDelay.delay", 0.01), ("sensorLag.timeConstant", 0.01)];
    let mut running = Exchange::started(&values, 1e-8, |host, t| {
        host.set("position", 0.1 - 0.1 * t);
        host.set("velocity", -0.1);
    });
    running.advance(0.05);
    let bytes = running.host.serialized();
    running.advance(0.1);
    let first = ["pressure", "measuredPressure", "heatReceived"].map(|name| running.host.get(name).to_bits());
    assert_eq!(running.host.deserialize(&bytes), 0);
    running.time = 0.05;
    running.advance(0.1);
    let again = ["pressure", "measuredPressure", "heatReceived"].map(|name| running.host.get(name).to_bits());
    assert_eq!(again, first);
    let other = Host::started(&[]);
    assert_eq!(other.deserialize(&bytes), 3, "of the other kind");
    assert!(other.message().contains("of the other kind"));
}

#[test]
fn states_beyond_all_numbers_complete_no_step_and_start_no_record_so_that_what_is_saved_can_be_read() {
    let host = Host::exchange();
    host.start(&[], None);
    let mut x = [0.0; ALL];
    unsafe {
        assert_eq!(fmi2GetContinuousStates(host.c, x.as_mut_ptr(), ALL), 0);
        let gas = x;
        x[1] = 1e305;
        assert_eq!(fmi2SetContinuousStates(host.c, x.as_ptr(), ALL), 0);
        let (delay, both) = (reference("recordDelay.delay"), [reference("recordDelay.delay"), reference("velocity")]);
        assert_eq!(fmi2SetReal(host.c, both.as_ptr(), 2, [0.01, 0.3].as_ptr()), 2);
        assert!(host.message().contains("the outputs of this state are too large for a number"));
        let mut values = [f64::NAN; 2];
        assert_eq!(fmi2GetReal(host.c, both.as_ptr(), 2, values.as_mut_ptr()), 0);
        assert_eq!(values, [0.0, 0.0], "a refused batch changes nothing");
        assert_eq!(fmi2EnterContinuousTimeMode(host.c), 0);
        let (mut event, mut end) = (7, 7);
        assert_eq!(fmi2CompletedIntegratorStep(host.c, 1, &mut event, &mut end), 2);
        assert!(host.message().contains("the outputs of this state are too large for a number"));
        assert_eq!(fmi2EnterEventMode(host.c), 2);
        assert_eq!(host.deserialize(&host.serialized()), 0, "{:?}", host.messages());
        // The solver goes back, and the simulation continues.
        assert_eq!(fmi2SetContinuousStates(host.c, gas.as_ptr(), ALL), 0);
        assert_eq!(fmi2CompletedIntegratorStep(host.c, 1, &mut event, &mut end), 0);
        assert_eq!(fmi2EnterEventMode(host.c), 0);
        assert_eq!(fmi2SetReal(host.c, &delay, 1, &0.01), 0);
        assert_eq!(host.deserialize(&host.serialized()), 0, "{:?}", host.messages());
    }
}

#[test]
fn an_initialization_that_makes_no_gas_is_refused_and_can_be_mended() {
    let host = Host::exchange();
    unsafe { assert_eq!(fmi2EnterInitializationMode(host.c), 0) };
    // So small that the reciprocal of the volume is not finite.
    host.set("deadVolume", 0.0);
    host.set("position", f64::MIN_POSITIVE);
    let before = host.serialized();
    unsafe { assert_eq!(fmi2ExitInitializationMode(host.c), 2) };
    assert!(host.message().contains("too large for a number"));
    assert_eq!(host.serialized(), before, "a refused call changes nothing");
    host.set("position", 0.1);
    unsafe { assert_eq!(fmi2ExitInitializationMode(host.c), 0) };
}
