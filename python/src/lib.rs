//! `pneutherm._native`: the program and its results, for Python.
//!
//! | function | gives |
//! |---|---|
//! | `run` | the program's exit code |
//! | `identify`, `diagnose`, `validate` | what `--json` writes, as text |
//! | `simulate` | a `Table` in the Arrow C stream interface: Python reads the memory that Rust filled |
//! | `Study` | a study: its rows as a `Table`, as a stream of batches or in a folder, and its statistics |
//!
//! All of them let other Python threads run meanwhile. What is wrong is raised as `pneutherm.Error`, whose text is the
//! program's sentence. The package's own files, `pneutherm/*.py`, make dataclasses and pyarrow tables of it.

mod table;
mod work;

use ::sweep::study::plan::Plan;
use anyhow::Context;
use pneutherm::settings::Settings;
use pneutherm::simulation::band::Wanted;
use pneutherm::simulation::{self, Request};
use pneutherm::{evaluation, output};
use pneutherm::{stores, study_pictures};
use pyo3::prelude::*;
use records::{Document, Model, Rig};
use std::ffi::OsString;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use table::{Batches, Table};
use work::{Watch, interruptible, watched};

pyo3::create_exception!(pneutherm, Error, pyo3::exceptions::PyException, "What is wrong, in the program's sentence.");

/// The extension module.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::{Error, Study, diagnose, identify, run, simulate, validate};
    #[pymodule_export]
    use crate::table::{Batches, Table};
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

/// What a file says, as a path, as JSON or both: JSON replaces what the file says.
type Given = (Option<PathBuf>, Option<String>);

fn settings((path, json): Given) -> Settings {
    Settings { path, json }
}

fn read_rig(given: Given) -> anyhow::Result<Rig> {
    let document = settings(given).rig()?.context("rig: no rig file and no content of one is given")?;
    Ok(Rig::from_document(&document)?)
}

fn read_model(given: Given) -> anyhow::Result<Document> {
    settings(given).model()?.context("model: no model file and no content of one is given")
}

/// What was identified, as JSON.
#[pyfunction]
fn identify(py: Python<'_>, rig: Given, method: String, model: Option<PathBuf>) -> PyResult<String> {
    interruptible(py, move || {
        let method = evaluation::method(&method)?;
        let rig = read_rig(rig)?;
        output::check(&model, output::files(&rig))?;
        let found = evaluation::identify(&rig, method, model.as_deref())?;
        Ok(serde_json::to_string(&found)?)
    })
}

/// What was diagnosed, as JSON.
#[pyfunction]
fn diagnose(py: Python<'_>, rig: Given, model: Option<PathBuf>, report: Option<PathBuf>) -> PyResult<String> {
    interruptible(py, move || {
        let rig = read_rig(rig)?;
        output::check(model.iter().chain(&report), output::files(&rig))?;
        let found = evaluation::diagnose(&rig, report.as_deref(), &|_, _| {})?;
        if let Some(path) = &model {
            evaluation::write_diagnosed(&rig, &found, path)?;
        }
        Ok(serde_json::to_string(&found.diagnosis)?)
    })
}

/// How well a model predicts the records of a rig, as JSON.
#[pyfunction]
fn validate(py: Python<'_>, model: Given, rig: Given, whole_record: bool) -> PyResult<String> {
    interruptible(py, move || {
        let model = Model::from_document(&read_model(model)?)?;
        Ok(serde_json::to_string(&evaluation::validate(&model, &read_rig(rig)?, whole_record)?.validation)?)
    })
}

/// The chamber along a motion, with a band where `samples` asks for one.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python's keyword arguments, one each")]
fn simulate(
    py: Python<'_>,
    model: Given,
    motion: PathBuf,
    rig: Given,
    initial_pressure_pa: Option<f64>,
    raw_positions: bool,
    samples: Option<u32>,
    level: f64,
    seed: u64,
) -> PyResult<Table> {
    interruptible(py, move || {
        let band = samples.map(|samples| Wanted { samples, seed, level });
        let (model, rig) = (read_model(model)?, settings(rig).rig()?);
        let request = Request { model, motion, rig, initial_pressure_pa, raw_positions, band };
        Table::of_simulation(&simulation::simulated(&request)?)
    })
}

/// A study: its file, or its text with paths relative to the working folder.
#[pyclass(frozen, module = "pneutherm._native")]
struct Study(Arc<::sweep::Study>);

#[pymethods]
impl Study {
    /// From a file, or from JSON that says what the file would.
    #[new]
    fn new(py: Python<'_>, study: Given) -> PyResult<Self> {
        interruptible(py, move || {
            let document = settings(study).study()?.context("study: no study file and no content of one is given")?;
            Ok(Self(Arc::new(::sweep::Study::from_document(&document)?)))
        })
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.0.rows as usize
    }

    /// Solves all rows; they are one table in memory.
    fn table(&self, py: Python<'_>) -> PyResult<Table> {
        let study = self.0.clone();
        interruptible(py, move || {
            let batches = ::sweep::run_in_memory(&study)?;
            Table::new(batches).with_context(|| format!("{}: no rows", study.path.display()))
        })
    }

    /// The rows as they are computed.
    fn batches(&self) -> Batches {
        Batches(self.0.clone())
    }

    /// Statistics of the rows as JSON, without the rows.
    fn statistics(
        &self,
        py: Python<'_>,
        columns: Option<Vec<String>>,
        quantiles: Option<Vec<f64>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let (study, watch) = (self.0.clone(), Arc::new(Watch::default()));
        let teller = watch.clone();
        watched(py, &watch, progress, move || {
            let asked = columns.is_some() || quantiles.is_some();
            let plan = match &study.statistics {
                Some(plan) if !asked => plan.clone(),
                _ => Plan::picked(study.outputs(), columns.as_deref(), quantiles.as_deref())?,
            };
            Ok(serde_json::to_string(&::sweep::run::whole::statistics(&study, &plan, &*teller)?)?)
        })
    }

    /// The study, or a shard of it, into a folder: what was done, as JSON.
    fn write_folder(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        shard: String,
        rows: bool,
        extend: Option<PathBuf>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let shard = shard.parse().map_err(Error::new_err)?;
        let (study, watch) = (self.0.clone(), Arc::new(Watch::default()));
        let teller = watch.clone();
        watched(py, &watch, progress, move || {
            let store = stores::open(&folder)?;
            let smaller = extend.as_deref().map(stores::open).transpose()?;
            let earlier = smaller.as_deref().map(|store| ::sweep::Earlier::open(&study, store)).transpose()?;
            let options = ::sweep::Options { shard, rows, earlier: earlier.as_ref() };
            let done = ::sweep::run(&study, &*store, options, &*teller)?;
            study_pictures::write(&*store, &done.results)?;
            Ok(serde_json::json!({
                "rows_written": done.rows_written,
                "rows_taken": done.rows_taken,
                "parts_written": done.parts_written,
                "parts_found": done.parts_found,
                "statuses": done.statuses,
                "complete": done.complete,
            })
            .to_string())
        })
    }
}
