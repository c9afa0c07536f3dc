//! FMI 3.0 hosts that make arbitrary calls with arbitrary arguments: random call sequences of Model Exchange and of
//! co-simulation, with and without event mode and early return, different in every run: 20,000 and 2,000, or the number in
//! `PNEUTHERM_FUZZ_CASES`.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

#[path = "common/draws.rs"]
mod draws;

use draws::{cases, change_of_state, equipment, length, number, orderly, step};
use fmu::boundary::CEnum;
use fmu::fmi3::abi::*;
use fmu::plant::event_indicators::EVENT_INDICATORS;
use fmu::plant::states::ALL;
use fmu::start_values::REFERENCE_GUID;
use fmu::table::table;
use fmu::table::variable::Type;
use proptest::prelude::*;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::LazyLock;

/// The standard's functions, as implemented in this library.
static FUNCTIONS: LazyLock<BTreeSet<&str>> = LazyLock::new(|| {
    let sources = [
        include_str!("../src/fmi3/abi/absent.rs"),
        include_str!("../src/fmi3/abi/life_cycle.rs"),
        include_str!("../src/fmi3/abi/running.rs"),
        include_str!("../src/fmi3/abi/saved.rs"),
        include_str!("../src/fmi3/abi/values.rs"),
    ];
    let functions = sources.iter().flat_map(|source| source.split("extern \"C\" fn ").skip(1));
    functions.filter_map(|rest| rest.split('(').next()).filter(|name| name.starts_with("fmi3")).collect()
});

type Log = RefCell<Vec<(CEnum, String)>>;

unsafe extern "C" fn receive(environment: *mut c_void, status: CEnum, category: *const c_char, text: *const c_char) {
    let owned = |text: *const c_char| unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned();
    assert!(owned(category).starts_with("log"));
    unsafe { &*environment.cast::<Log>() }.borrow_mut().push((status, owned(text)));
}

/// Kind of an instance.
#[derive(Clone, Copy, Debug)]
enum Kind {
    CoSimulation { event_mode: bool, early_return: bool },
    ModelExchange,
}

/// One instance, its log, and its saved states.
struct Host {
    c: *mut c_void,
    log: *mut Log,
    states: Vec<*mut c_void>,
}

impl Host {
    fn new(kind: Kind) -> Self {
        let log: *mut Log = Box::into_raw(Box::default());
        let (name, token, environment) = (c"test", CString::new(REFERENCE_GUID).unwrap(), log.cast());
        let (name, token) = (name.as_ptr(), token.as_ptr());
        let c = unsafe {
            match kind {
                Kind::CoSimulation { event_mode, early_return } => {
                    let (event, early) = (u8::from(event_mode), u8::from(early_return));
                    let none = (null(), 0, null());
                    fmi3InstantiateCoSimulation(
                        name,
                        token,
                        null(),
                        0,
                        0,
                        event,
                        early,
                        none.0,
                        none.1,
                        environment,
                        Some(receive),
                        none.2,
                    )
                }
                Kind::ModelExchange => {
                    fmi3InstantiateModelExchange(name, token, null(), 0, 0, environment, Some(receive))
                }
            }
        };
        assert!(!c.is_null(), "{:?}", unsafe { &*log }.borrow());
        Self { c, log, states: Vec::new() }
    }

    /// Initializes the instance with these parameters, up to the mode in which time advances.
    fn start(&self, kind: Kind, parameters: &[(&str, f64)]) {
        for &(name, value) in parameters {
            let reference = table().iter().position(|v| v.name == name).unwrap() as u32;
            let status = unsafe {
                match table()[reference as usize].is {
                    Type::Real => fmi3SetFloat64(self.c, &reference, 1, &value, 1),
                    Type::Enumeration(_) => fmi3SetInt64(self.c, &reference, 1, &(value as i64), 1),
                    Type::Boolean => fmi3SetBoolean(self.c, &reference, 1, &(value as u8), 1),
                }
            };
            assert_eq!(status, 0, "{name}: {:?}", self.messages());
        }
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.c, 0, 0.0, 0.0, 0, 0.0), 0);
            assert_eq!(fmi3ExitInitializationMode(self.c), 0, "{:?}", self.messages());
            match kind {
                Kind::CoSimulation { event_mode: false, .. } => {}
                Kind::CoSimulation { .. } => assert_eq!(fmi3EnterStepMode(self.c), 0),
                Kind::ModelExchange => assert_eq!(self.begin(), 0),
            }
        }
    }

    /// Goes from event mode to continuous-time mode.
    unsafe fn begin(&self) -> CEnum {
        unsafe { self.update(false).max(fmi3EnterContinuousTimeMode(self.c)) }
    }

    unsafe fn update(&self, without_destination: bool) -> CEnum {
        let ([mut a, mut b, mut c, mut d, mut e], mut time) = ([0; 5], 0.0);
        let time = if without_destination { null_mut() } else { &raw mut time };
        unsafe { fmi3UpdateDiscreteStates(self.c, &mut a, &mut b, &mut c, &mut d, &mut e, time) }
    }

    fn state(&self, index: usize) -> *mut c_void {
        self.states.get(index).copied().unwrap_or(null_mut())
    }

    fn time(&self) -> f64 {
        let (reference, mut time) = (fmu::fmi3::time_reference(), 0.0);
        assert_eq!(unsafe { fmi3GetFloat64(self.c, &reference, 1, &mut time, 1) }, 0, "{:?}", self.messages());
        time
    }

    fn serialized(&self) -> Vec<u8> {
        let (mut state, mut size) = (null_mut(), 0);
        unsafe {
            assert_eq!(fmi3GetFMUState(self.c, &mut state), 0);
            assert_eq!(fmi3SerializedFMUStateSize(self.c, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(fmi3SerializeFMUState(self.c, state, bytes.as_mut_ptr(), size), 0);
            assert_eq!(fmi3FreeFMUState(self.c, &mut state), 0);
            bytes
        }
    }

    fn messages(&self) -> Vec<(CEnum, String)> {
        unsafe { &*self.log }.take()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe {
            fmi3FreeInstance(self.c);
            drop(Box::from_raw(self.log));
        }
    }
}

/// Functions for variable types that this FMU does not have.
#[derive(Clone, Copy, Debug)]
enum Foreign {
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    UInt64,
    String,
    Binary,
    Clock,
    Interval,
    Shift,
}

#[derive(Clone, Debug)]
enum Call {
    Enter { tolerance: Option<f64>, start: f64, stop: Option<f64> },
    Exit,
    EnterEvent,
    EnterStep,
    EnterContinuous,
    Begin,
    Terminate,
    Reset,
    Set { batch: Vec<(u32, f64)>, null: bool, more: usize },
    Get { references: Vec<u32>, null: bool, more: usize },
    SetInt64(u32, i64),
    GetInt64(u32),
    SetBoolean(u32, u8),
    GetBoolean(u32),
    Foreign(Foreign, u32),
    OutputDerivative(u32, i32),
    Directional { unknown: u32, known: u32, seed: f64, more: usize },
    Adjoint,
    Step { offset: f64, h: f64, null: bool },
    Save,
    Restore(usize),
    Free(usize),
    Bytes { cut: usize, flip: usize },
    Logging(usize),
    Update { null: bool },
    Completed { null: bool },
    Time(f64),
    States { shift: usize, by: f64, length: usize },
    Rates { length: usize, null: bool },
    Indicators(usize),
    Numbers { null: bool },
    Dependencies(u32),
    Configuration,
    Evaluate,
    Partition(u32, f64),
}

fn reference() -> impl Strategy<Value = u32> {
    draws::reference(1 + EVENT_INDICATORS as u32)
}

/// One value more than references, in one case of twenty.
fn more() -> impl Strategy<Value = usize> {
    draws::null().prop_map(usize::from)
}

fn foreign() -> impl Strategy<Value = Foreign> {
    use Foreign::*;
    prop::sample::select(vec![
        Float32, Int8, UInt8, Int16, UInt16, Int32, UInt32, UInt64, String, Binary, Clock, Interval, Shift,
    ])
}

fn life() -> impl Strategy<Value = Call> {
    prop_oneof![
        2 => Just(Call::Enter { tolerance: None, start: 0.0, stop: None }),
        1 => (prop::option::of(number()), number(), prop::option::of(number())).prop_map(|(tolerance, start, stop)| Call::Enter { tolerance, start, stop }),
        3 => Just(Call::Exit),
        2 => Just(Call::EnterEvent),
        2 => Just(Call::EnterStep),
        2 => Just(Call::EnterContinuous),
        2 => Just(Call::Begin),
        3 => draws::null().prop_map(|null| Call::Update { null }),
        1 => Just(Call::Terminate),
        1 => Just(Call::Reset),
        1 => (0..3usize).prop_map(Call::Logging),
    ]
}

fn values() -> impl Strategy<Value = Call> {
    prop_oneof![
        8 => (prop::collection::vec((reference(), number()), 0..4), draws::null(), more()).prop_map(|(batch, null, more)| Call::Set { batch, null, more }),
        5 => (prop::collection::vec(reference(), 0..5), draws::null(), more()).prop_map(|(references, null, more)| Call::Get { references, null, more }),
        1 => (reference(), prop_oneof![-1..4i64, any::<i64>()]).prop_map(|(r, v)| Call::SetInt64(r, v)),
        1 => reference().prop_map(Call::GetInt64),
        1 => (reference(), any::<u8>()).prop_map(|(r, v)| Call::SetBoolean(r, v)),
        1 => reference().prop_map(Call::GetBoolean),
        2 => (foreign(), reference()).prop_map(|(f, r)| Call::Foreign(f, r)),
        2 => (reference(), 0..3).prop_map(|(r, o)| Call::OutputDerivative(r, o)),
        2 => (reference(), reference(), number(), more()).prop_map(|(unknown, known, seed, more)| Call::Directional { unknown, known, seed, more }),
        1 => prop::sample::select(vec![Call::Adjoint, Call::Configuration, Call::Evaluate]),
        1 => reference().prop_map(Call::Dependencies),
        1 => (reference(), number()).prop_map(|(r, t)| Call::Partition(r, t)),
        2 => Just(Call::Save),
        2 => (0..4usize).prop_map(Call::Restore),
        1 => (0..4usize).prop_map(Call::Free),
        1 => (0..2000usize, 0..20_000usize).prop_map(|(cut, flip)| Call::Bytes { cut, flip }),
    ]
}

/// Calls of a host that lets the FMU integrate.
fn stepping() -> impl Strategy<Value = Call> {
    (prop_oneof![9 => Just(0.0), 1 => number()], step(), draws::null()).prop_map(|(offset, h, null)| Call::Step {
        offset,
        h,
        null,
    })
}

/// Calls of a host that integrates.
fn exchange() -> impl Strategy<Value = Call> {
    prop_oneof![
        4 => draws::null().prop_map(|null| Call::Completed { null }),
        4 => prop_oneof![5 => 0.0..2.0f64, 1 => number()].prop_map(Call::Time),
        5 => (change_of_state(), length(ALL)).prop_map(|((shift, by), length)| Call::States { shift, by, length }),
        4 => (length(ALL), draws::null()).prop_map(|(length, null)| Call::Rates { length, null }),
        3 => length(EVENT_INDICATORS).prop_map(Call::Indicators),
        1 => draws::null().prop_map(|null| Call::Numbers { null }),
    ]
}

/// Makes the call; returns its worst status.
unsafe fn make(host: &mut Host, call: &Call) -> CEnum {
    let c = host.c;
    unsafe {
        match call {
            Call::Enter { tolerance, start, stop } => fmi3EnterInitializationMode(
                c,
                u8::from(tolerance.is_some()),
                tolerance.unwrap_or(0.0),
                *start,
                u8::from(stop.is_some()),
                stop.unwrap_or(0.0),
            ),
            Call::Exit => fmi3ExitInitializationMode(c),
            Call::EnterEvent => fmi3EnterEventMode(c),
            Call::EnterStep => fmi3EnterStepMode(c),
            Call::EnterContinuous => fmi3EnterContinuousTimeMode(c),
            Call::Begin => host.begin(),
            Call::Terminate => fmi3Terminate(c),
            Call::Reset => fmi3Reset(c),
            Call::Set { batch, null: without, more } => {
                let (references, mut values): (Vec<u32>, Vec<f64>) = batch.iter().copied().unzip();
                values.extend(vec![0.0; *more]);
                let pointer = if *without { null() } else { values.as_ptr() };
                fmi3SetFloat64(c, references.as_ptr(), references.len(), pointer, values.len())
            }
            Call::Get { references, null: without, more } => {
                let mut values = vec![0.0; references.len() + more];
                let pointer = if *without { null() } else { references.as_ptr() };
                fmi3GetFloat64(c, pointer, references.len(), values.as_mut_ptr(), values.len())
            }
            Call::SetInt64(reference, value) => fmi3SetInt64(c, reference, 1, value, 1),
            Call::GetInt64(reference) => fmi3GetInt64(c, reference, 1, &mut 0, 1),
            Call::SetBoolean(reference, value) => fmi3SetBoolean(c, reference, 1, value, 1),
            Call::GetBoolean(reference) => fmi3GetBoolean(c, reference, 1, &mut 0, 1),
            Call::Foreign(of, reference) => foreign_type(c, *of, reference),
            Call::OutputDerivative(reference, order) => fmi3GetOutputDerivatives(c, reference, 1, order, &mut 0.0, 1),
            Call::Directional { unknown, known, seed, more } => {
                let seeds = [*seed; 2];
                fmi3GetDirectionalDerivative(c, unknown, 1, known, 1, seeds.as_ptr(), 1 + more, &mut 0.0, 1)
            }
            Call::Adjoint => fmi3GetAdjointDerivative(c, null(), 0, null(), 0, null(), 0, null_mut(), 0),
            Call::Step { offset, h, null: without } => {
                let ([mut event, mut end, mut early], mut last) = ([7; 3], f64::NAN);
                let last_destination = if *without { null_mut() } else { &raw mut last };
                let before = host.time();
                let status = fmi3DoStep(c, before + offset, *h, 1, &mut event, &mut end, &mut early, last_destination);
                if status < 2 {
                    assert_eq!((last, end, event), (host.time(), 0, early));
                    assert!(
                        early == 1 || (last - (before + offset + h)).abs() <= 1e-12 * last.abs(),
                        "{last} {before}"
                    );
                }
                status
            }
            Call::Save => {
                let mut state = if host.states.len() < 4 { null_mut() } else { host.state(0) };
                let status = fmi3GetFMUState(c, &mut state);
                if !host.states.contains(&state) {
                    host.states.push(state);
                }
                status
            }
            Call::Restore(index) => fmi3SetFMUState(c, host.state(*index)),
            Call::Free(index) => {
                let freed = host.state(*index);
                let mut state = freed;
                let status = fmi3FreeFMUState(c, &mut state);
                host.states.retain(|state| *state != freed);
                status
            }
            Call::Bytes { cut, flip } => {
                let mut bytes = host.serialized();
                bytes.truncate(*cut);
                if let Some(byte) = bytes.get_mut(flip / 8) {
                    *byte ^= 1 << (flip % 8);
                }
                let mut state = null_mut();
                let status = fmi3DeserializeFMUState(c, bytes.as_ptr(), bytes.len(), &mut state);
                if status != 0 {
                    return status;
                }
                fmi3SetFMUState(c, state).max(fmi3FreeFMUState(c, &mut state))
            }
            Call::Logging(count) => {
                let categories = [c"logStatusError".as_ptr(), c"logNothing".as_ptr()];
                let status = fmi3SetDebugLogging(c, 0, *count, categories.as_ptr());
                fmi3SetDebugLogging(c, 0, 0, null()).max(status)
            }
            Call::Update { null } => host.update(*null),
            Call::Completed { null } => {
                let (mut enter, mut end) = (0, 0);
                fmi3CompletedIntegratorStep(c, 0, if *null { null_mut() } else { &mut enter }, &mut end)
            }
            Call::Time(time) => fmi3SetTime(c, *time),
            Call::States { shift, by, length } => {
                let mut states = vec![0.0; (*length).max(ALL)];
                let status = fmi3GetContinuousStates(c, states.as_mut_ptr(), ALL);
                states[*shift] *= by;
                if status == 0 { fmi3SetContinuousStates(c, states.as_ptr(), *length) } else { status }
            }
            Call::Rates { length, null } => {
                let mut rates = vec![0.0; *length];
                let pointer = if *null { null_mut() } else { rates.as_mut_ptr() };
                let nominals = fmi3GetNominalsOfContinuousStates(c, rates.as_mut_ptr(), *length);
                fmi3GetContinuousStateDerivatives(c, pointer, *length).max(nominals)
            }
            Call::Indicators(length) => fmi3GetEventIndicators(c, vec![0.0; *length].as_mut_ptr(), *length),
            Call::Numbers { null } => {
                let mut n = 0;
                let destination = if *null { null_mut() } else { &raw mut n };
                fmi3GetNumberOfEventIndicators(c, destination).max(fmi3GetNumberOfContinuousStates(c, destination))
            }
            Call::Dependencies(of) => fmi3GetNumberOfVariableDependencies(c, *of, &mut 0)
                .max(fmi3GetVariableDependencies(c, *of, null_mut(), null_mut(), null_mut(), null_mut(), 0)),
            Call::Configuration => fmi3EnterConfigurationMode(c).max(fmi3ExitConfigurationMode(c)),
            Call::Evaluate => fmi3EvaluateDiscreteStates(c),
            Call::Partition(clock, time) => fmi3ActivateModelPartition(c, *clock, *time),
        }
    }
}

/// Gets and sets a variable with a type that does not occur.
unsafe fn foreign_type(c: *mut c_void, of: Foreign, vr: &u32) -> CEnum {
    unsafe {
        match of {
            Foreign::Float32 => fmi3GetFloat32(c, vr, 1, &mut 0.0, 1).max(fmi3SetFloat32(c, vr, 1, &0.0, 1)),
            Foreign::Int8 => fmi3GetInt8(c, vr, 1, &mut 0, 1).max(fmi3SetInt8(c, vr, 1, &0, 1)),
            Foreign::UInt8 => fmi3GetUInt8(c, vr, 1, &mut 0, 1).max(fmi3SetUInt8(c, vr, 1, &0, 1)),
            Foreign::Int16 => fmi3GetInt16(c, vr, 1, &mut 0, 1).max(fmi3SetInt16(c, vr, 1, &0, 1)),
            Foreign::UInt16 => fmi3GetUInt16(c, vr, 1, &mut 0, 1).max(fmi3SetUInt16(c, vr, 1, &0, 1)),
            Foreign::Int32 => fmi3GetInt32(c, vr, 1, &mut 0, 1).max(fmi3SetInt32(c, vr, 1, &0, 1)),
            Foreign::UInt32 => fmi3GetUInt32(c, vr, 1, &mut 0, 1).max(fmi3SetUInt32(c, vr, 1, &0, 1)),
            Foreign::UInt64 => fmi3GetUInt64(c, vr, 1, &mut 0, 1).max(fmi3SetUInt64(c, vr, 1, &0, 1)),
            Foreign::String => fmi3GetString(c, vr, 1, &mut null(), 1).max(fmi3SetString(c, vr, 1, &null(), 1)),
            Foreign::Binary => {
                fmi3GetBinary(c, vr, 1, &mut 0, &mut null(), 1).max(fmi3SetBinary(c, vr, 1, &0, &null(), 1))
            }
            Foreign::Clock => fmi3GetClock(c, vr, 1, &mut 0).max(fmi3SetClock(c, vr, 1, &0)),
            Foreign::Interval => fmi3GetIntervalDecimal(c, vr, 1, &mut 0.0, &mut 0)
                .max(fmi3SetIntervalDecimal(c, vr, 1, &0.0))
                .max(fmi3GetIntervalFraction(c, vr, 1, &mut 0, &mut 0, &mut 0))
                .max(fmi3SetIntervalFraction(c, vr, 1, &0, &0)),
            Foreign::Shift => fmi3GetShiftDecimal(c, vr, 1, &mut 0.0)
                .max(fmi3SetShiftDecimal(c, vr, 1, &0.0))
                .max(fmi3GetShiftFraction(c, vr, 1, &mut 0, &mut 0))
                .max(fmi3SetShiftFraction(c, vr, 1, &0, &0)),
        }
    }
}

/// Whether a refusal of the call leaves everything unchanged. A pair of calls may be half done.
fn is_one_call(call: &Call) -> bool {
    !matches!(call, Call::Begin | Call::Bytes { .. } | Call::Save | Call::Free(_) | Call::Enter { .. })
}

/// Makes the calls: each is answered, each refusal is explained in the terms of FMI 3.0, and a refused call changes nothing. The
/// final state can be saved and restored, and a reset makes the instance as new.
fn survives(kind: Kind, equipment: &[(&str, f64)], orderly: bool, calls: &[Call]) -> Result<(), TestCaseError> {
    let mut host = Host::new(kind);
    let fresh = host.serialized();
    if orderly {
        host.start(kind, equipment);
    }
    for call in calls {
        let before = is_one_call(call).then(|| host.serialized());
        host.messages();
        let status = unsafe { make(&mut host, call) };
        let messages = host.messages();
        prop_assert!((0..=3).contains(&status), "{:?}: {}", call, status);
        prop_assert_eq!(status >= 2, messages.iter().any(|m| m.0 >= 2), "{:?}: {} {:?}", call, status, messages);
        for (_, text) in &messages {
            prop_assert!(text.len() > 20 && !text.contains("broke down"), "{:?}: {}", call, text);
            prop_assert!(!text.contains("type Real") && !text.contains("Integer"), "types of FMI 2.0: {}", text);
            for name in text.split(|c: char| !c.is_alphanumeric()).filter(|word| word.starts_with("fmi")) {
                prop_assert!(
                    FUNCTIONS.contains(name),
                    "{:?} speaks of {}, which is not in FMI 3.0: {}",
                    call,
                    name,
                    text
                );
            }
        }
        if let Some(before) = before.filter(|_| status >= 2) {
            prop_assert_eq!(before, host.serialized(), "{:?} was refused and changed something", call);
        }
    }
    let (last, whole) = (host.serialized(), Call::Bytes { cut: usize::MAX, flip: usize::MAX });
    prop_assert_eq!(unsafe { make(&mut host, &whole) }, 0, "a saved state cannot be read: {:?}", host.messages());
    prop_assert_eq!(host.serialized(), last);
    prop_assert_eq!(unsafe { fmi3Reset(host.c) }, 0);
    prop_assert_eq!(host.serialized(), fresh, "a reset instance is not as a fresh one");
    Ok(())
}

#[test]
fn a_co_simulation_in_event_mode_takes_no_time_from_the_host() {
    let kind = Kind::CoSimulation { event_mode: true, early_return: false };
    let calls = [Call::Step { offset: 0.0, h: 1.0, null: false }, Call::EnterEvent, Call::Time(0.0)];
    survives(kind, &[("recordDelay.delay", 0.02)], true, &calls).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(2_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_sequence_of_co_simulation_crashes_and_every_refusal_is_explained(
        event_mode in any::<bool>(),
        early_return in any::<bool>(),
        equipment in equipment(),
        orderly in orderly(),
        calls in prop::collection::vec(prop_oneof![2 => stepping(), 1 => life(), 3 => values(), 1 => exchange()], 1..25),
    ) {
        survives(Kind::CoSimulation { event_mode, early_return }, &equipment, orderly, &calls)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(20_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_sequence_of_a_host_that_integrates_crashes(
        equipment in equipment(),
        orderly in orderly(),
        calls in prop::collection::vec(prop_oneof![4 => exchange(), 2 => life(), 3 => values(), 1 => stepping()], 1..40),
    ) {
        survives(Kind::ModelExchange, &equipment, orderly, &calls)?;
    }
}
