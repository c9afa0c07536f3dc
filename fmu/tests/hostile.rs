//! Hosts that make arbitrary calls with arbitrary arguments, and many instances at once.
//!
//! Random call sequences of co-simulation and Model Exchange, different in every run: 5,000 and 20,000, or the number in
//! `PNEUTHERM_FUZZ_CASES`. Those of FMI 3.0 are in `hostile_fmi3.rs`.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;
#[path = "common/draws.rs"]
mod draws;

use common::Host;
use draws::{cases, change_of_state, equipment, length, number, orderly, step};
use fmu::boundary::CEnum;
use fmu::fmi2::abi::*;
use fmu::fmi2::host::EventInfo;
use fmu::plant::event_indicators::EVENT_INDICATORS;
use fmu::plant::states::ALL;
use proptest::prelude::*;
use std::ffi::{c_int, c_void};
use std::ptr::{null, null_mut};

#[derive(Clone, Debug)]
enum Call {
    Start,
    Setup { tolerance: Option<f64>, start: f64, stop: Option<f64> },
    Enter,
    Exit,
    Terminate,
    Reset,
    SetReal(Vec<(u32, f64)>, bool),
    SetInteger(u32, i32),
    SetOther(u32),
    GetReal(Vec<u32>, bool),
    GetInteger(u32),
    Derivative(u32, i32, f64),
    OutputDerivative(u32, i32),
    Directional(u32, u32, f64),
    Step { offset: f64, h: f64 },
    Save,
    Restore(usize),
    Free(usize),
    Bytes { cut: usize, flip: usize },
    Status(u32),
    Logging(i32),
    Begin,
    EnterEvent,
    NewDiscrete(bool),
    EnterContinuous,
    Completed(bool),
    Time(f64),
    States { shift: usize, by: f64, length: usize },
    Rates { length: usize, null: bool },
    Indicators(usize),
}

/// Calls of a host that integrates.
fn exchange() -> impl Strategy<Value = Call> {
    prop_oneof![
        1 => Just(Call::Begin),
        2 => Just(Call::EnterEvent),
        3 => draws::null().prop_map(Call::NewDiscrete),
        3 => Just(Call::EnterContinuous),
        4 => draws::null().prop_map(Call::Completed),
        4 => prop_oneof![5 => 0.0..2.0f64, 1 => number()].prop_map(Call::Time),
        5 => (change_of_state(), length(ALL))
            .prop_map(|((shift, by), length)| Call::States { shift, by, length }),
        4 => (length(ALL), draws::null()).prop_map(|(length, null)| Call::Rates { length, null }),
        3 => length(EVENT_INDICATORS).prop_map(Call::Indicators),
    ]
}

fn call() -> impl Strategy<Value = Call> {
    let option = |s: BoxedStrategy<f64>| prop::option::of(s);
    prop_oneof![
        2 => Just(Call::Start),
        1 => (option(number().boxed()), number(), option(number().boxed())).prop_map(|(tolerance, start, stop)| Call::Setup { tolerance, start, stop }),
        1 => Just(Call::Enter),
        1 => Just(Call::Exit),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        8 => (prop::collection::vec((draws::reference(0), number()), 0..4), draws::null()).prop_map(|(b, n)| Call::SetReal(b, n)),
        1 => (draws::reference(0), any::<i32>()).prop_map(|(r, v)| Call::SetInteger(r, v)),
        1 => draws::reference(0).prop_map(Call::SetOther),
        4 => (prop::collection::vec(draws::reference(0), 0..5), draws::null()).prop_map(|(b, n)| Call::GetReal(b, n)),
        1 => draws::reference(0).prop_map(Call::GetInteger),
        3 => (draws::reference(0), -1..5, number()).prop_map(|(r, o, v)| Call::Derivative(r, o, v)),
        2 => (draws::reference(0), 0..3).prop_map(|(r, o)| Call::OutputDerivative(r, o)),
        2 => (draws::reference(0), draws::reference(0), number()).prop_map(|(u, k, v)| Call::Directional(u, k, v)),
        10 => (prop_oneof![9 => Just(0.0), 1 => number()], step()).prop_map(|(offset, h)| Call::Step { offset, h }),
        2 => Just(Call::Save),
        2 => (0..4usize).prop_map(Call::Restore),
        1 => (0..4usize).prop_map(Call::Free),
        1 => (0..2000usize, 0..20_000usize).prop_map(|(cut, flip)| Call::Bytes { cut, flip }),
        1 => prop_oneof![0..6u32, Just(u32::MAX)].prop_map(Call::Status),
        1 => (-1..2).prop_map(Call::Logging),
    ]
}

/// What a host holds besides the instance.
#[derive(Default)]
struct Held {
    states: Vec<*mut c_void>,
}

impl Held {
    fn get(&self, index: usize) -> *mut c_void {
        self.states.get(index).copied().unwrap_or(null_mut())
    }
}

fn reached(host: &Host) -> f64 {
    let mut time = 0.0;
    unsafe { fmi2GetRealStatus(host.c, 2, &mut time) };
    time
}

/// Makes the call; returns its worst status.
unsafe fn make(host: &Host, held: &mut Held, call: &Call) -> CEnum {
    let c = host.c;
    unsafe {
        match call {
            Call::Start => {
                if fmi2EnterInitializationMode(c) != 0 {
                    return 3;
                }
                fmi2ExitInitializationMode(c)
            }
            Call::Setup { tolerance, start, stop } => fmi2SetupExperiment(
                c,
                c_int::from(tolerance.is_some()),
                tolerance.unwrap_or(0.0),
                *start,
                c_int::from(stop.is_some()),
                stop.unwrap_or(0.0),
            ),
            Call::Enter => fmi2EnterInitializationMode(c),
            Call::Exit => fmi2ExitInitializationMode(c),
            Call::Terminate => fmi2Terminate(c),
            Call::Reset => fmi2Reset(c),
            Call::SetReal(batch, null_value) => {
                let (references, values): (Vec<u32>, Vec<f64>) = batch.iter().copied().unzip();
                let values = if *null_value { null() } else { values.as_ptr() };
                fmi2SetReal(c, references.as_ptr(), references.len(), values)
            }
            Call::SetInteger(reference, value) => fmi2SetInteger(c, reference, 1, value),
            Call::SetOther(reference) => {
                fmi2SetBoolean(c, reference, 1, &1).max(fmi2GetString(c, reference, 1, null_mut()))
            }
            Call::GetReal(references, null_references) => {
                let mut values = vec![0.0; references.len()];
                let pointer = if *null_references { null() } else { references.as_ptr() };
                fmi2GetReal(c, pointer, references.len(), values.as_mut_ptr())
            }
            Call::GetInteger(reference) => fmi2GetInteger(c, reference, 1, &mut 0),
            Call::Derivative(reference, order, value) => fmi2SetRealInputDerivatives(c, reference, 1, order, value),
            Call::OutputDerivative(reference, order) => fmi2GetRealOutputDerivatives(c, reference, 1, order, &mut 0.0),
            Call::Directional(unknown, known, value) => {
                fmi2GetDirectionalDerivative(c, unknown, 1, known, 1, value, &mut 0.0)
            }
            Call::Step { offset, h } => fmi2DoStep(c, reached(host) + offset, *h, 1),
            Call::Save => {
                let mut state = held.get(0);
                if held.states.len() < 4 {
                    state = null_mut();
                }
                let status = fmi2GetFMUstate(c, &mut state);
                if !held.states.contains(&state) {
                    held.states.push(state);
                }
                status
            }
            Call::Restore(index) => fmi2SetFMUstate(c, held.get(*index)),
            Call::Free(index) => {
                let mut state = held.get(*index);
                let status = fmi2FreeFMUstate(c, &mut state);
                let freed = held.get(*index);
                held.states.retain(|s| *s != freed);
                status
            }
            Call::Bytes { cut, flip } => {
                let mut bytes = host.serialized();
                bytes.truncate(*cut);
                if let Some(byte) = bytes.get_mut(flip / 8) {
                    *byte ^= 1 << (flip % 8);
                }
                host.deserialize(&bytes)
            }
            Call::Status(kind) => fmi2GetRealStatus(c, *kind, &mut 0.0).max(fmi2GetBooleanStatus(c, *kind, &mut 0)),
            Call::Begin => fmi2NewDiscreteStates(c, &mut EventInfo::default()).max(fmi2EnterContinuousTimeMode(c)),
            Call::EnterEvent => fmi2EnterEventMode(c),
            Call::NewDiscrete(null) => {
                let mut info = EventInfo::default();
                fmi2NewDiscreteStates(c, if *null { null_mut() } else { &mut info })
            }
            Call::EnterContinuous => fmi2EnterContinuousTimeMode(c),
            Call::Completed(null) => {
                let (mut enter, mut end) = (0, 0);
                fmi2CompletedIntegratorStep(c, 0, if *null { null_mut() } else { &mut enter }, &mut end)
            }
            Call::Time(time) => fmi2SetTime(c, *time),
            Call::States { shift, by, length } => {
                let mut states = vec![0.0; (*length).max(ALL)];
                if fmi2GetContinuousStates(c, states.as_mut_ptr(), ALL) != 0 {
                    return 3;
                }
                states[*shift] *= by;
                fmi2SetContinuousStates(c, states.as_ptr(), *length)
            }
            Call::Rates { length, null } => {
                let mut rates = vec![0.0; *length];
                let pointer = if *null { null_mut() } else { rates.as_mut_ptr() };
                fmi2GetDerivatives(c, pointer, *length).max(fmi2GetNominalsOfContinuousStates(
                    c,
                    rates.as_mut_ptr(),
                    *length,
                ))
            }
            Call::Indicators(length) => fmi2GetEventIndicators(c, vec![0.0; *length].as_mut_ptr(), *length),
            Call::Logging(count) => fmi2SetDebugLogging(c, 0, *count as usize, null()),
        }
    }
}

#[test]
fn a_state_after_the_shortest_step_there_is_can_be_read() {
    let host = Host::new();
    host.start(&[("recordDelay.delay", 0.02)], None);
    survives(&host, &Host::new(), &[Call::Step { offset: 0.0, h: 5e-324 }]).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(5_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_sequence_of_calls_crashes_and_every_refusal_is_explained(equipment in equipment(), orderly in orderly(), calls in prop::collection::vec(call(), 1..25)) {
        let host = Host::new();
        if orderly {
            host.start(&equipment, None);
        }
        survives(&host, &Host::new(), &calls)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(20_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_sequence_of_a_host_that_integrates_crashes(equipment in equipment(), orderly in orderly(), calls in prop::collection::vec(prop_oneof![2 => exchange(), 1 => call()], 1..40)) {
        let host = Host::exchange();
        if orderly {
            host.start(&equipment, None);
            unsafe { make(&host, &mut Held::default(), &Call::Begin) };
        }
        survives(&host, &Host::exchange(), &calls)?;
    }
}

/// Whether a refusal of the call leaves everything unchanged. A pair of calls may be half done.
fn is_one_call(call: &Call) -> bool {
    use Call::*;
    !matches!(call, Start | SetOther(_) | Begin | Bytes { .. } | Save | Free(_))
}

/// Makes the calls: each is answered, each refusal explained, and a refused call changes nothing. The final state can be saved
/// and restored, and a reset makes the instance as new.
fn survives(host: &Host, fresh: &Host, calls: &[Call]) -> Result<(), TestCaseError> {
    let mut held = Held::default();
    for call in calls {
        let before = is_one_call(call).then(|| host.serialized());
        host.messages();
        let status = unsafe { make(host, &mut held, call) };
        let messages = host.messages();
        prop_assert!((0..=3).contains(&status), "{:?}: {}", call, status);
        prop_assert_eq!(status >= 2, messages.iter().any(|m| m.status >= 2), "{:?}: {} {:?}", call, status, messages);
        prop_assert!(
            messages.iter().all(|m| m.text.len() > 20 && !m.text.contains("broke down")),
            "{:?}: {:?}",
            call,
            messages
        );
        if let Some(before) = before.filter(|_| status >= 2) {
            prop_assert_eq!(before, host.serialized(), "{:?} was refused and changed something", call);
        }
    }
    let last = host.serialized();
    prop_assert_eq!(host.deserialize(&last), 0, "a state that was saved cannot be read: {:?}", host.messages());
    prop_assert_eq!(host.serialized(), last);
    prop_assert_eq!(unsafe { fmi2Reset(host.c) }, 0);
    prop_assert_eq!(host.serialized(), fresh.serialized(), "a reset instance is not as a fresh one");
    Ok(())
}

/// Pressures of a run whose inputs depend on `seed`, as bits.
fn run(seed: u32) -> Vec<u64> {
    let host = Host::started(&[("initialPressure", 2e5 + f64::from(seed)), ("wallHeating.capacity", 1.0)]);
    (0..300)
        .map(|k| {
            host.set("velocity", 0.1 * (f64::from(k + seed) * 0.1).sin());
            host.set("position", host.get("position"));
            host.step(f64::from(k) * 1e-3, 1e-3);
            host.get("pressure").to_bits()
        })
        .collect()
}

#[test]
fn sixty_four_instances_in_eight_threads_run_as_if_alone() {
    let alone: Vec<_> = (0..64).map(run).collect();
    let threads: Vec<_> = (0..8)
        .map(|t| {
            std::thread::spawn(move || {
                // Eight instances at once, stepped in turn.
                let hosts: Vec<_> = (0..8)
                    .map(|i| {
                        let pressure = 2e5 + f64::from(8 * t + i);
                        (8 * t + i, Host::started(&[("initialPressure", pressure), ("wallHeating.capacity", 1.0)]))
                    })
                    .collect();
                let mut bits = vec![Vec::new(); 8];
                for k in 0..300 {
                    for (i, (seed, host)) in hosts.iter().enumerate() {
                        host.set("velocity", 0.1 * (f64::from(k + seed) * 0.1).sin());
                        host.set("position", host.get("position"));
                        host.step(f64::from(k) * 1e-3, 1e-3);
                        bits[i].push(host.get("pressure").to_bits());
                    }
                }
                bits
            })
        })
        .collect();
    let together: Vec<_> = threads.into_iter().flat_map(|t| t.join().unwrap()).collect();
    assert_eq!(alone, together);
}
