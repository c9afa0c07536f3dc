//! Chambers side by side, one a lane.

use crate::lanes::{Lanes, WIDTH};
use chamber::balance::Balances;
use chamber::effects::EffectSet;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use pulp::{Arch, Simd, WithSimd};

/// Puts a chamber's numbers into a lane; those of its effects stay as they are.
#[inline(always)]
pub fn load_chamber(to: &mut Chamber<Lanes>, lane: usize, from: &Chamber) {
    to.gas.gas_constant[lane] = from.gas.gas_constant;
    to.gas.heat_capacity_ratio[lane] = from.gas.heat_capacity_ratio;
    to.geometry.bore[lane] = from.geometry.bore;
    to.geometry.rod_diameter[lane] = from.geometry.rod_diameter;
    to.geometry.piston_area[lane] = from.geometry.piston_area;
    to.geometry.dead_volume[lane] = from.geometry.dead_volume;
    to.heat_transfer.coefficient[lane] = from.heat_transfer.coefficient;
    to.heat_transfer.reference_pressure[lane] = from.heat_transfer.reference_pressure;
    to.heat_transfer.reference_temperature[lane] = from.heat_transfer.reference_temperature;
}

/// Balances of chambers, one a lane, of one area law: of their effects those that were asked for last.
pub struct Chambers(Balances<Lanes>);

impl Default for Chambers {
    fn default() -> Self {
        let geometry = Geometry::new(1.0, 0.0, 0.0, AreaLaw::Total);
        Self(Balances::of(Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(1.0)).lift()))
    }
}

impl Chambers {
    /// Puts a chamber into each lane, with the parameters of the effects in a set.
    pub fn gather<'a>(
        &mut self,
        arch: Arch,
        set: EffectSet,
        chamber: impl Fn(usize) -> &'a Chamber,
    ) -> &Balances<Lanes> {
        let all = &mut self.0.chamber;
        all.geometry.area_law = chamber(0).geometry.area_law;
        for lane in 0..WIDTH {
            let from = chamber(lane);
            load_chamber(all, lane, from);
            for effect in set.iter() {
                for (to, from) in all.effects.of_mut(effect).iter_mut().zip(from.effects.of(effect)) {
                    to[lane] = *from;
                }
            }
        }
        arch.dispatch(WorkOutBalances(&mut self.0));
        &self.0
    }
}

/// Works out what balances keep beside their chambers.
struct WorkOutBalances<'a>(&'a mut Balances<Lanes>);

impl WithSimd for WorkOutBalances<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        self.0.work_out();
    }
}
