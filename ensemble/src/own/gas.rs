//! The gas of a test without effects, reduced to the numbers that its equation needs, and the clock of its push.

use crate::integrator::clock::Clock;
use chamber::exact::Closed;

/// One test, reduced to the numbers its equation needs.
#[derive(Clone, Copy, Debug)]
pub struct SealedTest {
    /// c a1, c a0, γ − 1, Tw and m R.
    pub closed: Closed,
    /// The clock of the push.
    pub clock: Clock,
    /// Volume of the hold, m³.
    pub held_volume: f64,
    /// 1/τ_f, 1/s: c Aq/√V Tw in the hold.
    pub rate: f64,
}

impl SealedTest {
    /// P/T in the hold, Pa/K.
    #[inline]
    pub fn pressure_per_temperature(&self) -> f64 {
        self.closed.mass_gas_constant / self.held_volume
    }

    /// m cv, J/K.
    #[inline]
    pub fn capacity(&self) -> f64 {
        self.closed.mass_gas_constant / self.closed.expansion
    }
}
