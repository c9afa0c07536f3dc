//! Progress of a run on standard error: a bar on a terminal, or one line of JSON per second for programs.
//!
//! The rate counts only rows solved by this run; rows that already existed count only as done.

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use serde_json::json;
use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// How progress is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ProgressFormat {
    /// A progress bar, if standard error is a terminal
    Bar,
    /// One line of JSON per second, for programs
    Json,
    /// No progress
    None,
}

impl ProgressFormat {
    fn pause(self) -> Duration {
        Duration::from_millis(if self == ProgressFormat::Bar { 250 } else { 1000 })
    }
}

/// Progress in rows.
pub struct Progress {
    format: ProgressFormat,
    rows: u64,
    solved: AtomicU64,
    found: AtomicU64,
    begun: Instant,
}

impl sweep::progress::Progress for Progress {
    fn solved(&self, rows: u64) {
        self.solved.fetch_add(rows, Relaxed);
    }

    fn found(&self, rows: u64) {
        self.found.fetch_add(rows, Relaxed);
    }
}

/// The present progress.
struct Standing {
    done: u64,
    found: u64,
    rate: f64,
    /// `None` before the first row.
    seconds_left: Option<f64>,
}

impl Progress {
    /// Starts now, for this many rows.
    pub fn new(format: ProgressFormat, rows: u64) -> Self {
        let zero = || AtomicU64::new(0);
        Self { format, rows, solved: zero(), found: zero(), begun: Instant::now() }
    }

    fn standing(&self) -> Standing {
        let (solved, found) = (self.solved.load(Relaxed), self.found.load(Relaxed));
        let rate = solved as f64 / self.begun.elapsed().as_secs_f64().max(1e-9);
        let left = self.rows.saturating_sub(solved + found) as f64;
        Standing { done: solved + found, found, rate, seconds_left: (solved > 0).then(|| left / rate) }
    }

    /// Runs `work` and reports its progress.
    pub fn during<T>(&self, work: impl FnOnce(&Self) -> T) -> T {
        std::thread::scope(|scope| {
            let (end, ended) = channel::<()>();
            scope.spawn(move || {
                let template = "{bar:30} {human_pos} of {human_len} rows, {msg}";
                let bar = (self.format == ProgressFormat::Bar).then(|| bar(self.rows, template));
                while ended.recv_timeout(self.format.pause()) == Err(RecvTimeoutError::Timeout) {
                    self.report(bar.as_ref());
                }
                self.report(bar.as_ref());
                if let Some(bar) = bar {
                    bar.finish_and_clear();
                }
            });
            let result = work(self);
            drop(end);
            result
        })
    }

    fn report(&self, bar: Option<&ProgressBar>) {
        let now = self.standing();
        if let Some(bar) = bar {
            let left = now.seconds_left.map(|left| HumanDuration(Duration::from_secs_f64(left.min(1e12))));
            let left = left.map_or(String::new(), |left| format!(", {left} left"));
            bar.set_message(format!("{:.0} rows/s{left}", now.rate));
            bar.set_position(now.done);
        }
        if self.format == ProgressFormat::Json {
            let line = json!({
                "rows_done": now.done,
                "rows": self.rows,
                "rows_found": now.found,
                "rows_per_second": now.rate,
                "seconds_elapsed": self.begun.elapsed().as_secs_f64(),
                "seconds_left": now.seconds_left,
            });
            // A closed standard error is ignored.
            let _ = writeln!(io::stderr(), "{line}");
        }
    }
}

/// A progress bar with this template on standard error; hidden if that is not a terminal.
pub fn bar(length: u64, template: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Runs work of unknown progress, with a spinner on a terminal.
pub fn with_spinner<T>(what: &'static str, work: impl FnOnce() -> T) -> T {
    let spinner = ProgressBar::new_spinner().with_message(what);
    spinner.enable_steady_tick(Duration::from_millis(100));
    let result = work();
    spinner.finish_and_clear();
    result
}
