//! Reports the progress of a run.

/// Receives the progress of a run, from any thread.
pub trait Progress: Sync {
    /// Called with the number of rows solved since the last call.
    fn solved(&self, rows: u64);

    /// Called with the number of rows in complete parts found.
    fn found(&self, _rows: u64) {}
}

impl<F: Fn(u64) + Sync> Progress for F {
    fn solved(&self, rows: u64) {
        self(rows);
    }
}
