//! A host in Rust that drives the FMU through its C functions, in the same process.

#![allow(dead_code, reason = "each test uses a part of it")]

use fmu::boundary::CEnum;
use fmu::fmi2::abi::*;
use fmu::fmi2::host::{Callbacks, Logger};
use fmu::start_values::REFERENCE_GUID;
use fmu::table::table;
use fmu::table::variable::Type;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

/// A message logged by the FMU.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub status: CEnum,
    pub category: String,
    pub text: String,
}

type Log = RefCell<Vec<Message>>;

/// Receives log messages of the form `"%s", text`. Declared without C's variable arguments, which Rust cannot define; on the
/// platforms of the tests the text arrives in the same register.
unsafe extern "C" fn receive(
    environment: *mut c_void,
    _name: *const c_char,
    status: CEnum,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    let owned = |text: *const c_char| unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned();
    assert_eq!(owned(format), "%s");
    let log = unsafe { &*environment.cast::<Log>() };
    log.borrow_mut().push(Message { status, category: owned(category), text: owned(text) });
}

/// As [`receive`], in the form required by Miri.
#[cfg(miri)]
unsafe extern "C" fn receive_any(
    environment: *mut c_void,
    name: *const c_char,
    status: CEnum,
    category: *const c_char,
    format: *const c_char,
    mut arguments: ...
) {
    unsafe { receive(environment, name, status, category, format, arguments.next_arg::<*const c_char>()) }
}

#[cfg(miri)]
pub fn logger() -> Logger {
    Some(receive_any)
}

#[cfg(not(miri))]
pub fn logger() -> Logger {
    type Fixed = unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, *const c_char);
    let fixed: Fixed = receive;
    Some(unsafe {
        std::mem::transmute::<
            Fixed,
            unsafe extern "C" fn(*mut c_void, *const c_char, CEnum, *const c_char, *const c_char, ...),
        >(fixed)
    })
}

/// One instance and its log.
pub struct Host {
    pub c: *mut c_void,
    log: *mut Log,
}

/// Value reference of a variable.
pub fn reference(name: &str) -> u32 {
    table().iter().position(|v| v.name == name).unwrap_or_else(|| panic!("{name}")) as u32
}

impl Host {
    /// A new instance for co-simulation.
    pub fn new() -> Self {
        Self::of(1)
    }

    /// A new instance for Model Exchange.
    pub fn exchange() -> Self {
        Self::of(0)
    }

    fn of(kind: CEnum) -> Self {
        let log: *mut Log = Box::into_raw(Box::default());
        let callbacks = Callbacks {
            logger: logger(),
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: log.cast(),
        };
        let (name, guid) = (c"test", CString::new(REFERENCE_GUID).unwrap());
        let c = unsafe { fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), null(), &callbacks, 0, 0) };
        assert!(!c.is_null(), "{:?}", unsafe { &*log }.borrow());
        Self { c, log }
    }

    /// An instance in step mode with these start values.
    pub fn started(values: &[(&str, f64)]) -> Self {
        let host = Self::new();
        host.start(values, None);
        host
    }

    /// From instantiated to step mode.
    pub fn start(&self, values: &[(&str, f64)], tolerance: Option<f64>) {
        let defined = c_int::from(tolerance.is_some());
        assert_eq!(unsafe { fmi2SetupExperiment(self.c, defined, tolerance.unwrap_or(0.0), 0.0, 0, 0.0) }, 0);
        for &(name, value) in values {
            self.set(name, value);
        }
        assert_eq!(unsafe { fmi2EnterInitializationMode(self.c) }, 0);
        assert_eq!(unsafe { fmi2ExitInitializationMode(self.c) }, 0, "{:?}", self.messages());
    }

    pub fn try_set(&self, name: &str, value: f64) -> CEnum {
        let reference = reference(name);
        match table()[reference as usize].is {
            Type::Enumeration(_) => return unsafe { fmi2SetInteger(self.c, &reference, 1, &(value as c_int)) },
            Type::Boolean => return unsafe { fmi2SetBoolean(self.c, &reference, 1, &(value as c_int)) },
            Type::Real => {}
        }
        unsafe { fmi2SetReal(self.c, &reference, 1, &value) }
    }

    pub fn set(&self, name: &str, value: f64) {
        assert_eq!(self.try_set(name, value), 0, "{:?}", self.messages());
    }

    pub fn set_derivative(&self, name: &str, order: c_int, value: f64) {
        let status = unsafe { fmi2SetRealInputDerivatives(self.c, &reference(name), 1, &order, &value) };
        assert_eq!(status, 0, "{:?}", self.messages());
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi2GetReal(self.c, &reference(name), 1, &mut value) }, 0, "{:?}", self.messages());
        value
    }

    pub fn output_derivative(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi2GetRealOutputDerivatives(self.c, &reference(name), 1, &1, &mut value) }, 0);
        value
    }

    pub fn try_step(&self, time: f64, h: f64) -> CEnum {
        unsafe { fmi2DoStep(self.c, time, h, 1) }
    }

    pub fn step(&self, time: f64, h: f64) {
        assert_eq!(self.try_step(time, h), 0, "{:?}", self.messages());
    }

    pub fn directional(&self, unknown: &str, known: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe {
            fmi2GetDirectionalDerivative(self.c, &reference(unknown), 1, &reference(known), 1, &1.0, &mut value)
        };
        assert_eq!(status, 0, "{:?}", self.messages());
        value
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        assert_eq!(unsafe { fmi2GetFMUstate(self.c, &mut state) }, 0);
        state
    }

    pub fn restore(&self, state: *mut c_void) {
        assert_eq!(unsafe { fmi2SetFMUstate(self.c, state) }, 0);
    }

    pub fn serialized(&self) -> Vec<u8> {
        let mut state = self.save();
        let mut size = 0;
        unsafe {
            assert_eq!(fmi2SerializedFMUstateSize(self.c, state, &mut size), 0);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr().cast(), size), 0);
            assert_eq!(fmi2FreeFMUstate(self.c, &mut state), 0);
            bytes
        }
    }

    /// Restores serialized bytes; returns the status.
    pub fn deserialize(&self, bytes: &[u8]) -> CEnum {
        let mut state = null_mut();
        let status = unsafe { fmi2DeSerializeFMUstate(self.c, bytes.as_ptr().cast(), bytes.len(), &mut state) };
        if status == 0 {
            self.restore(state);
            assert_eq!(unsafe { fmi2FreeFMUstate(self.c, &mut state) }, 0);
        }
        status
    }

    /// Messages logged since the last call.
    pub fn messages(&self) -> Vec<Message> {
        unsafe { &*self.log }.take()
    }

    /// The only message since the last call.
    pub fn message(&self) -> String {
        let messages = self.messages();
        assert_eq!(messages.len(), 1, "{messages:?}");
        messages[0].text.clone()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe {
            fmi2FreeInstance(self.c);
            drop(Box::from_raw(self.log));
        }
    }
}
