//! Saved states: copies behind handles, and their bytes.

use super::Instance;
use crate::protocol::refusal::Refusal;
use crate::protocol::snapshot::Snapshot;
use crate::protocol::state_bytes;

impl Instance {
    /// `fmi2GetFMUstate`: a handle to a copy; one that is already a handle is filled anew.
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

    /// Takes the instance back to the copy behind a handle (`fmi2SetFMUstate`).
    ///
    /// # Errors
    /// A handle that is none.
    pub fn restore(&mut self, handle: usize) -> Result<(), Refusal> {
        let Snapshot { phase, simulation } = self.saved(handle)?.clone();
        (self.phase, self.now) = (phase, simulation);
        self.outputs = None;
        self.warnings.lose_track();
        Ok(())
    }

    /// Drops the copy behind a handle (`fmi2FreeFMUstate`).
    ///
    /// # Errors
    /// A handle that is none.
    pub fn free(&mut self, handle: usize) -> Result<(), Refusal> {
        self.saved(handle)?;
        self.saved.remove(&handle);
        Ok(())
    }

    /// The copy behind a handle as bytes (`fmi2SerializeFMUstate`).
    ///
    /// # Errors
    /// A handle that is none.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, Refusal> {
        Ok(state_bytes::encode(self.saved(handle)?, &self.guid))
    }

    /// A handle to the copy that these bytes hold (`fmi2DeSerializeFMUstate`).
    ///
    /// # Errors
    /// Bytes that are no state of this FMU.
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
