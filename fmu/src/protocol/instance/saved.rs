//! Saved states: copies with handles, and their bytes.

use super::Instance;
use crate::protocol::refusal::Refusal;
use crate::protocol::snapshot::Snapshot;
use crate::protocol::state_bytes;

impl Instance {
    /// `fmi2GetFMUstate`: saves a copy and returns its handle; an existing handle is reused.
    pub fn save(&mut self, handle: usize) -> usize {
        if let Some(existing) = self.saved.get_mut(&handle) {
            existing.phase = self.phase;
            existing.simulation.clone_from(&self.now);
            return handle;
        }
        self.keep(Snapshot { phase: self.phase, simulation: self.now.clone() })
    }

    fn keep(&mut self, snapshot: Snapshot) -> usize {
        let boxed = Box::new(snapshot);
        let handle = std::ptr::from_ref(&*boxed) as usize;
        self.saved.insert(handle, boxed);
        handle
    }

    fn saved(&self, handle: usize) -> Result<&Snapshot, Refusal> {
        let why = "there is no state that this handle stands for: it was never saved by this instance, or it was freed";
        self.saved.get(&handle).map(|boxed| &**boxed).ok_or(Refusal::BadState { why })
    }

    /// Restores the instance from the copy with a handle (`fmi2SetFMUstate`).
    ///
    /// # Errors
    /// For an invalid handle.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        let Snapshot { phase, simulation } = self.saved(handle)?.clone();
        (self.phase, self.now) = (phase, simulation);
        self.outputs = None;
        self.warnings.forget_position();
        Ok(())
    }

    /// Drops the copy with a handle (`fmi2FreeFMUstate`).
    ///
    /// # Errors
    /// For an invalid handle.
    pub fn free(&mut self, handle: usize) -> Result<(), Refusal> {
        self.saved(handle)?;
        self.saved.remove(&handle);
        Ok(())
    }

    /// The copy with a handle as bytes (`fmi2SerializeFMUstate`).
    ///
    /// # Errors
    /// For an invalid handle.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(state_bytes::encode(self.saved(handle)?, &self.guid))
    }

    /// Stores the copy encoded by these bytes and returns its handle (`fmi2DeSerializeFMUstate`).
    ///
    /// # Errors
    /// For bytes that are no state of this FMU.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<usize, Refusal> {
        let snapshot = state_bytes::decode(bytes, &self.guid)?;
        if snapshot.simulation.kind != self.now.kind {
            return Err(Refusal::BadBytes {
                why: "it is of an instance of the other kind, Model Exchange or co-simulation",
            });
        }
        Ok(self.keep(snapshot))
    }
}
