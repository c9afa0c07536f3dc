//! A point of a study: a value for every quantity.

use super::{BASE, Base, COUNT};
use chamber::{Chamber, Gas, Geometry, HeatTransfer};
use records::Model;

/// A value for every quantity, which defines one row of a study. NaN where a quantity is not given.
#[derive(Clone, Copy, Debug)]
pub struct Point(pub [f64; COUNT]);

impl Point {
    /// A point without values: all are NaN.
    pub const EMPTY: Point = Point([f64::NAN; COUNT]);

    /// The numbers of a model; those of the test are left out.
    pub fn of_model(model: &Model) -> Point {
        let (c, mut point) = (&model.chamber, Point::EMPTY);
        point.set(Base::GasConstant, c.gas.gas_constant);
        point.set(Base::HeatCapacityRatio, c.gas.heat_capacity_ratio);
        point.set(Base::Bore, c.geometry.bore);
        point.set(Base::Rod, c.geometry.rod_diameter);
        point.set(Base::DeadVolume, c.geometry.dead_volume);
        point.set(Base::Coefficient, c.heat_transfer.coefficient);
        point.set(Base::ReferencePressure, c.heat_transfer.reference_pressure);
        point.set(Base::ReferenceTemperature, c.heat_transfer.reference_temperature);
        point.set(Base::AmbientTemperature, model.ambient_temperature_k);
        point.set(Base::AmbientPressure, model.ambient_pressure_pa);
        point.effects_mut().copy_from_slice(&c.effects.0);
        point
    }

    /// A model with these numbers in place of its own.
    pub fn applied_to(&self, model: &Model) -> Model {
        let get = |base| self.get(base);
        let mut model = model.clone();
        let chamber = &mut model.chamber;
        self.set_gas(chamber);
        chamber.effects.0.copy_from_slice(self.effects());
        chamber.geometry =
            Geometry::new(get(Base::Bore), get(Base::Rod), get(Base::DeadVolume), chamber.geometry.area_law);
        model.ambient_temperature_k = get(Base::AmbientTemperature);
        model.ambient_pressure_pa = get(Base::AmbientPressure);
        model
    }

    /// Sets the gas and heat transfer of a chamber; its geometry may have to be solved for.
    pub fn set_gas(&self, chamber: &mut Chamber) {
        let get = |base| self.get(base);
        chamber.gas = Gas { gas_constant: get(Base::GasConstant), heat_capacity_ratio: get(Base::HeatCapacityRatio) };
        chamber.heat_transfer = HeatTransfer {
            coefficient: get(Base::Coefficient),
            reference_pressure: get(Base::ReferencePressure),
            reference_temperature: get(Base::ReferenceTemperature),
        };
    }

    /// The value of a base quantity.
    pub fn get(&self, base: Base) -> f64 {
        self.0[base as usize]
    }

    /// Sets the value of a base quantity.
    pub fn set(&mut self, base: Base, value: f64) {
        self.0[base as usize] = value;
    }

    /// Parameters of all effects, in the order of their cards.
    pub fn effects(&self) -> &[f64] {
        &self.0[BASE..]
    }

    /// Parameters of all effects, mutable, in the order of their cards.
    fn effects_mut(&mut self) -> &mut [f64] {
        &mut self.0[BASE..]
    }
}
