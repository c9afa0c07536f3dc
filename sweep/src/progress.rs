//! How far a run is, told while it goes on.

/// Told how a run goes on, from any thread.
pub trait Progress: Sync {
    /// Called with the number of rows solved since the last call.
    fn solved(&self, rows: u64);

    /// Called with the number of rows found in complete parts.
    fn found(&self, _rows: u64) {}
}

impl<F: Fn(u64) + Sync> Progress for F {
    fn solved(&self, rows: u64) {
        self(rows);
    }
}
