//! Work that Python waits for without stopping: other threads run, and Ctrl-C is heard.

use crate::Error;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

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
            Ok(Ok(result)) => return result.map_err(|error| Error::new_err(pneutherm::sentence(&error))),
            Ok(Err(_)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::new_err("a defect of pneutherm: please report what it wrote to standard error"));
            }
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
        }
    }
}
