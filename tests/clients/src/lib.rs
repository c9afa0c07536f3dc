//! Shared by the clients' tests: the FMU under test and FMPy's results for it.
//!
//! `CHAMBER_FMU` is the FMU, `CHAMBER_DIGITS` a text file: one line per step with time, position and velocity set before it, and
//! pressure, temperature and heat flow after it; numbers as hexadecimal bits.

use std::path::PathBuf;

/// Length of a step, s.
pub const STEP: f64 = 0.01;

/// One step of FMPy.
pub struct Row {
    /// Time at the start of the step, s.
    pub time: f64,
    /// Position and velocity.
    pub inputs: [f64; 2],
    /// Pressure, temperature, heat flow.
    pub outputs: [f64; 3],
}

fn from_environment(name: &str) -> PathBuf {
    std::env::var_os(name)
        .unwrap_or_else(|| panic!("{name} is not set: run tests/python/test_fmu_rust_clients.py"))
        .into()
}

/// The FMU under test.
pub fn fmu() -> PathBuf {
    from_environment("CHAMBER_FMU")
}

/// FMPy's results.
pub fn digits() -> Vec<Row> {
    let text = std::fs::read_to_string(from_environment("CHAMBER_DIGITS")).expect("FMPy's digits can be read");
    let rows: Vec<Row> = text
        .lines()
        .map(|line| {
            let bits = line.split(' ').map(|word| f64::from_bits(u64::from_str_radix(word, 16).expect("bits")));
            let numbers: Vec<f64> = bits.collect();
            let [time, x, v, p, t, q] = numbers[..] else { panic!("six numbers in {line}") };
            Row { time, inputs: [x, v], outputs: [p, t, q] }
        })
        .collect();
    assert!(rows.len() > 50 && rows.iter().any(|row| row.outputs[2] < -1.0), "a run with heat flow");
    rows
}
