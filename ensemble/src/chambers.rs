//! Chambers, one per lane.

use crate::lanes::{Lanes, WIDTH, put};
use chamber::balance::Balances;
use chamber::effects::EffectSet;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use pulp::{Arch, Simd, WithSimd};

/// Loads a chamber into a lane, without the parameters of its effects.
#[inline(always)]
pub fn load_chamber(to: &mut Chamber<Lanes>, lane: usize, from: &Chamber) {
    put!(to.gas, lane, from.gas; gas_constant, heat_capacity_ratio);
    put!(to.geometry, lane, from.geometry; bore, rod_diameter, piston_area, dead_volume);
    put!(to.heat_transfer, lane, from.heat_transfer; coefficient, reference_pressure, reference_temperature);
}

/// Balances of chambers with the same area law, one per lane, with the effects of the last set requested.
pub struct Chambers(Balances<Lanes>);

impl Default for Chambers {
    fn default() -> Self {
        let geometry = Geometry::new(1.0, 0.0, 0.0, AreaLaw::Total);
        Self(Balances::of(Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(1.0)).lift()))
    }
}

impl Chambers {
    /// Loads a chamber into each lane, with the parameters of the effects in a set.
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

/// Computes the derived constants of the balances.
struct WorkOutBalances<'a>(&'a mut Balances<Lanes>);

impl WithSimd for WorkOutBalances<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) {
        self.0.recompute_constants();
    }
}
