//! Behaviour of an FMU whose host sets nothing: a push and hold, until the host sets something.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use common::Host;
use fmu::fmi2::abi::*;
use fmu::fmi2::host::EventInfo;

#[test]
fn a_host_that_sets_nothing_sees_a_push_and_hold() {
    let host = Host::started(&[]);
    let begin = host.get("pressure");
    host.step(0.0, 0.07);
    assert!((host.get("pistonPosition") - 0.065).abs() < 1e-15 && host.get("velocity") == -0.5);
    // The change at 0.1 s lies within this step.
    host.step(0.07, 0.13);
    let pushed = host.get("pressure");
    assert!((host.get("pistonPosition") - 0.05).abs() < 1e-15 && host.get("velocity") == 0.0 && pushed > 1.9 * begin);
    host.step(0.2, 1.8);
    assert!(host.get("pressure") < 0.9 * pushed);
    assert!(host.messages().is_empty());
}

#[test]
fn the_push_does_not_depend_on_the_step() {
    let ends = [0.03, 0.1, 0.5].map(|h| {
        let host = Host::started(&[]);
        for k in 0..(0.9 / h) as u32 {
            host.step(f64::from(k) * h, h);
        }
        let rest = 1.0 - (0.9 / h).floor() * h;
        host.step(1.0 - rest, rest);
        host.get("pressure")
    });
    assert!(ends.iter().all(|end| (end / ends[0] - 1.0).abs() < 1e-8), "{ends:?}");
}

#[test]
fn start_values_set_again_change_nothing_and_another_value_hands_the_piston_over() {
    for (parameter, value, is_pushed) in [("position", 0.1, true), ("velocity", 0.0, true), ("deadVolume", 1e-5, false)]
    {
        let host = Host::started(&[(parameter, value)]);
        host.step(0.0, 0.1);
        assert_eq!(host.get("pistonPosition") < 0.06, is_pushed, "{parameter}");
    }
    let host = Host::started(&[]);
    host.set("position", 0.1);
    host.step(0.0, 0.1);
    assert_eq!((host.get("pistonPosition"), host.get("velocity")), (0.1, 0.0));
}

#[test]
fn a_piston_taken_over_by_the_host_during_its_push_rests_where_it_is() {
    let host = Host::started(&[]);
    host.step(0.0, 0.04);
    host.set("massFlowIn", 0.0);
    host.step(0.04, 0.1);
    assert!((host.get("pistonPosition") - 0.08).abs() < 1e-15);
}

#[test]
fn a_saved_state_remembers_who_moves_the_piston() {
    let host = Host::started(&[]);
    host.step(0.0, 0.04);
    let bytes = host.serialized();
    host.set("velocity", 0.0);
    host.deserialize(&bytes);
    host.step(0.04, 0.06);
    assert!((host.get("pistonPosition") - 0.05).abs() < 1e-15);
}

#[test]
fn a_host_that_integrates_gets_the_time_at_which_the_push_ends() {
    let host = Host::exchange();
    host.start(&[], None);
    let mut info = EventInfo::default();
    unsafe {
        assert_eq!(fmi2NewDiscreteStates(host.c, &mut info), 0);
        assert_eq!((info.next_event_time_defined, info.next_event_time), (1, 0.1));
        assert_eq!(fmi2EnterContinuousTimeMode(host.c), 0);
        assert_eq!(fmi2SetTime(host.c, 0.1), 0);
        assert_eq!((host.get("position"), host.get("velocity")), (0.05, -0.5));
        assert_eq!(fmi2EnterEventMode(host.c), 0);
        assert_eq!(fmi2NewDiscreteStates(host.c, &mut info), 0);
    }
    // It must restart the integration, because the speed jumps.
    assert_eq!((info.next_event_time_defined, info.values_of_continuous_states_changed), (0, 1));
    assert_eq!((host.get("position"), host.get("velocity")), (0.05, 0.0));
}
