//! The chamber: gas, geometry, heat transfer law and the effects' parameters, as plain numbers.

use crate::effects::{EffectSet, EffectValues};
use crate::gas::Gas;
use crate::geometry::Geometry;
use crate::heat_transfer::HeatTransfer;
use crate::real::Real;

/// All constants of one chamber.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chamber<R = f64> {
    /// Specific gas constant and heat capacity ratio.
    pub gas: Gas<R>,
    /// Bore, rod and dead volume.
    pub geometry: Geometry<R>,
    /// Heat transfer between gas and wall.
    pub heat_transfer: HeatTransfer<R>,
    /// Parameters of every effect; neutral ones change nothing.
    pub effects: EffectValues<R>,
}

impl Chamber<f64> {
    /// The paper's model: no effect.
    pub fn new(gas: Gas, geometry: Geometry, heat_transfer: HeatTransfer) -> Self {
        Self { gas, geometry, heat_transfer, effects: EffectValues::NEUTRAL }
    }

    /// This chamber with the first parameters of the effect at that index in the list replaced.
    pub fn with(self, index: usize, first: &[f64]) -> Self {
        Self { effects: self.effects.with(index, first), ..self }
    }

    /// This chamber with the effects in `set` at their typical values.
    pub fn with_typical(self, set: EffectSet) -> Self {
        Self { effects: self.effects.with_typical(set), ..self }
    }

    /// The effects whose parameters are not all neutral.
    pub fn active(&self) -> EffectSet {
        self.effects.active()
    }
}

impl<R: Real> Chamber<R> {
    /// The same chamber in another number type.
    pub fn lift<S: Real + From<R>>(self) -> Chamber<S> {
        Chamber {
            gas: self.gas.lift(),
            geometry: self.geometry.lift(),
            heat_transfer: self.heat_transfer.lift(),
            effects: self.effects.lift(),
        }
    }
}
