//! Batches against closed forms, against the plain integrator, and against themselves in another order. One program, so that the kernel
//! is linked once.

mod closed_forms;
mod common;
mod energy;
mod independence;
mod integrated_rows;
#[path = "../common/numbers.rs"]
mod numbers;
mod paths;
mod plain;
mod sealed_rows;
mod sensors;
