//! `pneutherm._native`: the program and its results, for Python.
//!
//! | function | gives |
//! |---|---|
//! | `run` | the program's exit code |
//! | `identify`, `diagnose` | what `--json` writes, as text |
//! | `simulate`, `sweep` | a `Table` in the Arrow C stream interface: Python reads the memory that Rust filled |
//!
//! All of them let other Python threads run meanwhile. What is wrong is raised as `pneutherm.Error`, whose text is the
//! program's sentence. The package's own files, `pneutherm/*.py`, make dataclasses and pyarrow tables of it.

mod table;
mod work;

use anyhow::Context;
use pneutherm::evaluation;
use pneutherm::simulation::{self, Request};
use pyo3::prelude::*;
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use table::Table;
use work::interruptible;

pyo3::create_exception!(pneutherm, Error, pyo3::exceptions::PyException, "What is wrong, in the program's sentence.");

/// The extension module.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::{Error, diagnose, identify, run, simulate, sweep};
    #[pymodule_export]
    use crate::table::Table;
}

/// The program: does what the arguments say, its name first, and returns the exit code.
#[pyfunction]
fn run(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| {
        let code = pneutherm::run(arguments);
        // Rust flushes at the end of a Rust program only; when nobody reads there is nobody to tell.
        let _ = std::io::stdout().flush();
        code
    })
}

/// What was identified, as JSON.
#[pyfunction]
fn identify(py: Python<'_>, rig: PathBuf, method: String, model: Option<PathBuf>) -> PyResult<String> {
    interruptible(py, move || {
        let method = evaluation::method(&method)?;
        let found = evaluation::identify(&rig, method, model.as_deref())?;
        Ok(serde_json::to_string(&found)?)
    })
}

/// What was diagnosed, as JSON.
#[pyfunction]
fn diagnose(py: Python<'_>, rig: PathBuf, model: Option<PathBuf>, report: Option<PathBuf>) -> PyResult<String> {
    interruptible(py, move || {
        let (rig, found) = evaluation::diagnose(&rig, report.as_deref(), &|_, _| {})?;
        if let Some(path) = &model {
            evaluation::write_diagnosed(&rig, &found, path)?;
        }
        Ok(serde_json::to_string(&found.diagnosis)?)
    })
}

/// The chamber along a motion.
#[pyfunction]
fn simulate(
    py: Python<'_>,
    model: PathBuf,
    motion: PathBuf,
    rig: Option<PathBuf>,
    initial_pressure_pa: Option<f64>,
) -> PyResult<Table> {
    interruptible(py, move || {
        let samples = simulation::simulated(&Request { model, motion, rig, initial_pressure_pa })?.samples;
        Table::of_samples(&samples)
    })
}

/// All rows of a study.
#[pyfunction]
fn sweep(py: Python<'_>, study: PathBuf) -> PyResult<Table> {
    interruptible(py, move || {
        let study = ::sweep::Study::read(&study)?;
        let batches = ::sweep::run::run_in_memory(&study)?;
        Table::new(batches).with_context(|| format!("{}: no rows", study.path.display()))
    })
}
