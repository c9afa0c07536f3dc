//! Cost of a step: no allocation, and constant memory however many steps are made.

#![allow(unsafe_code, clippy::undocumented_unsafe_blocks, reason = "a host calls C functions")]

mod common;

use common::Host;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, counting this thread's allocations.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
    static BYTES: Cell<isize> = const { Cell::new(0) };
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        BYTES.set(BYTES.get() + layout.size() as isize);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        BYTES.set(BYTES.get() - layout.size() as isize);
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Makes steps of 1 ms with moving inputs; returns the time reached.
fn drive(host: &Host, from: u32, steps: u32) {
    for k in from..from + steps {
        let t = f64::from(k) * 1e-3;
        host.set("velocity", 0.1 * (20.0 * t).cos());
        host.set("massFlowIn", 1e-4 * (1.0 + (3.0 * t).sin()));
        host.set("massFlowOut", 1e-4 * (1.0 + (3.0 * t).sin()));
        host.set("position", 0.1 + 0.005 * (20.0 * t).sin());
        host.step(t, 1e-3);
        host.get("force");
    }
}

#[test]
fn a_step_allocates_nothing_and_memory_stays_flat() {
    let plain = Host::started(&[]);
    let effects = Host::started(&[("wallHeating.capacity", 2.0), ("sensorLag.timeConstant", 0.01)]);
    for host in [&plain, &effects] {
        drive(host, 0, 100);
        let before = ALLOCATIONS.get();
        drive(host, 100, 20_000);
        assert_eq!(ALLOCATIONS.get(), before);
    }
    let delayed = Host::started(&[("recordDelay.delay", 0.2)]);
    drive(&delayed, 0, 2_000);
    let before = BYTES.get();
    drive(&delayed, 2_000, 20_000);
    assert!(BYTES.get() - before < 100_000, "the delayed record has its size once the delay is over");
}
