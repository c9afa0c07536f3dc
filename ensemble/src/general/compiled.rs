//! The sets of effects that the integrator is compiled for, and the choice of one for a row.

use super::equations::{ASKED, AT_RUN_TIME, TIGHT, states};
use super::integration;
use super::kind::Kind;
use super::{relaxation, wall_conduction};
use crate::batch::Batch;
use crate::instructions;
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::sets::{on_the_gas, on_the_gas_with};
use chamber::balance::STATES;
use chamber::effects::{
    self, EffectSet, Empirical, GasZones, LaminarLeakage, Leakage, SupplyLeakage, TubeVolume, WallHeating,
};

macro_rules! compiled_sets {
    ($($bits:expr),* $(,)?) => {
        /// Bits of these sets, in the order in which they are tried.
        const COMPILED: &[u32] = &[$($bits),*];

        /// Integrates rows of one kind and area law, with the effects of a set.
        pub fn integrate(
            batch: Batch,
            memory: &mut integration::Memory,
            set: EffectSet,
            kind: Kind,
            rows: &[(u32, Plan)],
            out: &mut [Outcome],
        ) {
            // The sensor is a filter of the pressure and takes no part in the integration.
            let set = on_the_gas(set);
            let set = if kind.is_tight() { set.intersection(effects::KEEP_THE_MASS) } else { set };
            let set = if kind == Kind::WallConduction { set.intersection(wall_conduction::EFFECTS) } else { set };
            match compiled_for(set, kind.is_tight()) {
                $(Some(bits) if bits == const { $bits } && instructions::is_wide(batch.arch) => {
                    const BITS: u32 = $bits;
                    integration::run::<{ states(BITS) }, BITS>(batch, memory, set, kind, rows, out)
                })*
                // Unit tests cover the parts. The kernel takes longest to compile and is tested as built: `tests/batches/`.
                #[cfg(test)]
                _ => unreachable!("the unit tests solve no batches"),
                #[cfg(not(test))]
                _ => integration::run::<STATES, AT_RUN_TIME>(batch, memory, set, kind, rows, out),
            }
        }
    };
}

/// Whether the integrator is compiled for rows with these effects and no constant flows. Other rows carry the states of all effects
/// and take longer.
pub fn has_code_of_its_own(set: EffectSet) -> bool {
    let set = on_the_gas(set);
    compiled_for(set, effects::KEEP_THE_MASS.contains(set)).is_some()
}

/// The bits of the first compiled set that contains a set; sets for tight rows only if `tight`.
fn compiled_for(set: EffectSet, tight: bool) -> Option<u32> {
    let fits = |bits: &u32| (tight || bits & TIGHT == 0) && EffectSet::from_bits(*bits).contains(set);
    COMPILED.iter().copied().find(fits)
}

#[cfg(test)]
compiled_sets![];
#[cfg(not(test))]
compiled_sets![
    // Tight rows take the first set that fits, others the first without `TIGHT`.
    TIGHT | ASKED | WallHeating::SET.bits(),
    TIGHT | ASKED | relaxation::EFFECTS.bits(),
    TIGHT | GasZones::SET.bits(),
    TIGHT | ASKED | on_the_gas_with(effects::MANY).intersection(effects::KEEP_THE_MASS).bits(),
    TIGHT | ASKED | wall_conduction::EFFECTS.bits(),
    Leakage::SET.bits() | SupplyLeakage::SET.bits() | LaminarLeakage::SET.bits() | ASKED,
    TubeVolume::SET.bits(),
    WallHeating::SET.bits() | ASKED,
    GasZones::SET.bits() | ASKED,
    on_the_gas_with(0).bits() | Empirical::SET.bits() | ASKED,
    on_the_gas_with(effects::MANY).bits() | ASKED,
];
