//! The gas of a test without effects and the transformation of time over its push.

use crate::ending::AfterPush;
use crate::integrator::time_transformation::TimeTransformation;
use crate::outcome::Failure;
use crate::scenario::Scenario;
use chamber::exact::Closed;

/// One test, reduced to the numbers its equation needs.
#[derive(Clone, Copy, Debug)]
pub struct SealedTest {
    /// c a1, c a0, γ − 1, Tw and m R.
    pub closed: Closed,
    /// The transformation of time over the push.
    pub transformation: TimeTransformation,
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

    /// The end of its push at a temperature, K, given the heat received and the work done over m cv, K.
    pub fn after_push(&self, row: u32, s: &Scenario, pushed: f64, energy: [f64; 2]) -> AfterPush {
        let capacity = self.capacity();
        let [received, work] = energy.map(|energy| capacity * energy);
        let is_gas = pushed > 0.0 && pushed < f64::INFINITY;
        AfterPush {
            row,
            relaxations: s.hold_s() * self.rate,
            mass: self.closed.mass_gas_constant / s.chamber.gas.gas_constant,
            energy: [s.initial_temperature_k, pushed].map(|temperature| capacity * temperature),
            received: [received - work, work.abs()],
            failure: (!is_gas).then_some(Failure::Empty),
        }
    }
}
