//! Work that Python waits for without stopping: other threads run, and Ctrl-C is heard.

use crate::Error;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use sweep::progress::Progress;

/// How long an interrupt may go unheard.
const PAUSE: Duration = Duration::from_millis(50);

/// Does the work in a thread of its own. An interrupt returns at once; the thread then ends when its work is done.
///
/// # Errors
/// What is wrong as `Error`; `KeyboardInterrupt` or whatever else a signal's handler raises.
pub fn interruptible<T, F>(py: Python<'_>, work: F) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce() -> anyhow::Result<T> + Send + 'static,
{
    wait(py, work, |_| Ok(()))
}

/// The same for work that tells `watch` how far it has come: `progress`, if any, is called with the number of rows done.
/// An interrupt, or whatever `progress` raises, ends the work.
///
/// # Errors
/// As [`interruptible`], and what `progress` raises.
pub fn watched<T, F>(py: Python<'_>, watch: &Arc<Watch>, progress: Option<Py<PyAny>>, work: F) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce() -> anyhow::Result<T> + Send + 'static,
{
    let mut reported = None;
    let mut report = |py: Python<'_>| {
        let done = watch.done.load(Relaxed);
        if reported != Some(done)
            && let Some(progress) = &progress
        {
            progress.call1(py, (done,))?;
            reported = Some(done);
        }
        Ok(())
    };
    let result = wait(py, work, &mut report).and_then(|result| report(py).map(|()| result));
    if result.is_err() {
        watch.stop.store(true, Relaxed);
    }
    result
}

/// How far a study has come, and whether it is to stop.
#[derive(Default)]
pub struct Watch {
    done: AtomicU64,
    stop: AtomicBool,
}

impl Progress for Watch {
    fn solved(&self, rows: u64) {
        if self.stop.load(Relaxed) {
            // Unlike a panic it is silent; the thread that began the work catches it.
            resume_unwind(Box::new("stopped"));
        }
        self.done.fetch_add(rows, Relaxed);
    }

    fn found(&self, rows: u64) {
        self.done.fetch_add(rows, Relaxed);
    }
}

/// Waits for work in a thread of its own; `meanwhile` is called every now and then.
fn wait<T, F>(py: Python<'_>, work: F, mut meanwhile: impl FnMut(Python<'_>) -> PyResult<()>) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce() -> anyhow::Result<T> + Send + 'static,
{
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(work));
        // Nobody listens after an interrupt.
        let _ = sender.send(result);
    });
    // A receiver cannot be shared between threads, an exclusive reference can go to the one that waits.
    let mut receiver = receiver;
    loop {
        let exclusive = &mut receiver;
        match py.detach(move || exclusive.recv_timeout(PAUSE)) {
            Ok(Ok(result)) => return result.map_err(|error| Error::new_err(pneutherm::error_message(&error))),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::new_err("a defect of pneutherm: please report what it wrote to standard error"));
            }
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals()?;
                meanwhile(py)?;
            }
        }
    }
}
