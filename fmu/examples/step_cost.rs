//! Measures the cost of `fmi2DoStep` at steps of 1 ms, called as from C, and whether memory stays constant.
//!
//! `cargo run --profile fmu -p pneutherm-fmu --example step_cost [MILLIONS]`: prints a Markdown table. The profile is the
//! library's; `--release` lacks its whole-program optimisation.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

use fmu::fmi2::abi::*;
use fmu::fmi2::host::Callbacks;
use fmu::start_values::REFERENCE_GUID;
use fmu::table::table;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};
use std::time::Instant;

fn reference(name: &str) -> u32 {
    table().iter().position(|v| v.name == name).expect("a variable of the table") as u32
}

/// An instance in step mode.
fn started(values: &[(&str, f64)]) -> *mut c_void {
    let callbacks = Callbacks {
        logger: None,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: null_mut(),
    };
    let guid = CString::new(REFERENCE_GUID).expect("no NUL in it");
    unsafe {
        let c = fmi2Instantiate(c"cost".as_ptr(), 1, guid.as_ptr(), null(), &callbacks, 0, 0);
        for &(name, value) in values {
            assert_eq!(fmi2SetReal(c, &reference(name), 1, &value), 0, "{name}");
        }
        assert_eq!(fmi2EnterInitializationMode(c), 0);
        assert_eq!(fmi2ExitInitializationMode(c), 0);
        c
    }
}

/// Seconds per step, the mean over `steps`; includes the call of `before` ahead of each.
fn seconds(c: *mut c_void, steps: u64, mut before: impl FnMut(u64)) -> f64 {
    let begin = Instant::now();
    for k in 0..steps {
        before(k);
        assert_eq!(unsafe { fmi2DoStep(c, k as f64 * 1e-3, 1e-3, 1) }, 0);
    }
    begin.elapsed().as_secs_f64() / steps as f64
}

/// Resident memory of the process, MB; `None` if not on Linux.
fn resident_mb() -> Option<f64> {
    let pages = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(pages.split(' ').nth(1)?.parse::<f64>().ok()? * 4096.0 / 1e6)
}

fn main() {
    let millions: u64 = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(10);
    println!("| what happens in a step of 1 ms | µs per fmi2DoStep |\n|---|---|");
    let hot = ("initialTemperature", 350.0);
    let row = |name: &str, seconds: f64| println!("| {name} | {:.3} |", seconds * 1e6);

    row("sealed, piston held (exact solution)", seconds(started(&[hot]), 1_000_000, |_| ()));

    let moving = started(&[hot]);
    let inputs = [reference("position"), reference("velocity")];
    let stroke = |k: u64| {
        let t = k as f64 * 1e-3;
        let values = [0.1 + 0.03 * (3.0 * t).sin(), 0.09 * (3.0 * t).cos()];
        unsafe { fmi2SetReal(moving, inputs.as_ptr(), 2, values.as_ptr()) };
    };
    row("sealed, moving piston (fmi2SetReal of position and velocity included)", seconds(moving, 1_000_000, stroke));

    let flow = started(&[hot, ("massFlowIn", 1e-4), ("massFlowOut", 1e-4)]);
    let memory = resident_mb();
    row(&format!("with flow in and out, {millions} million steps"), seconds(flow, millions * 1_000_000, |_| ()));
    let grown = memory.zip(resident_mb()).map(|(before, after)| after - before);

    let all = started(&[
        hot,
        ("wallHeating.capacity", 2.0),
        ("leakage.conductance", 1e-12),
        ("sensorLag.timeConstant", 0.01),
    ]);
    row("wall heating, leakage and sensor lag", seconds(all, 200_000, |_| ()));
    if let Some(grown) = grown {
        println!("\nMemory grew by {grown:.2} MB over {millions} million steps.");
    }
}
