//! The sets of effects that rows are integrated with by code compiled for them, and which of these a row takes.

use super::course;
use super::equations::{ASKED, AT_RUN_TIME, TIGHT, states};
use super::kind::Kind;
use super::{relaxation, remembering};
use crate::batch::Batch;
use crate::instructions;
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::sets::{on_the_gas, on_the_gas_with};
use chamber::balance::STATES;
use chamber::effects::{
    self, EffectSet, Empirical, GasZones, LaminarLeakage, Leakage, SupplyLeakage, TubeVolume, WallHeating,
};

macro_rules! sets_with_code_of_their_own {
    ($($bits:expr),* $(,)?) => {
        /// Bits of those sets, in the order in which they are tried.
        const COMPILED: &[u32] = &[$($bits),*];

        /// Runs rows of one kind and area law, with effects of a set.
        pub fn course(
            batch: Batch,
            memory: &mut course::Memory,
            set: EffectSet,
            kind: Kind,
            rows: &[(u32, Plan)],
            out: &mut [Outcome],
        ) {
            // What the sensor does to a known pressure is no matter of the integration.
            let set = on_the_gas(set);
            let set = if kind.is_tight() { set.intersection(effects::KEEP_THE_MASS) } else { set };
            let set = if kind == Kind::Remembering { set.intersection(remembering::EFFECTS) } else { set };
            match compiled_for(set, kind.is_tight()) {
                $(Some(bits) if bits == const { $bits } && instructions::is_wide(batch.arch) => {
                    const BITS: u32 = $bits;
                    course::run::<{ states(BITS) }, BITS>(batch, memory, set, kind, rows, out)
                })*
                // Unit tests are of the parts. The kernel, the longest to compile, is tested as it is built: `tests/batches/`.
                #[cfg(test)]
                _ => unreachable!("the unit tests solve no batches"),
                #[cfg(not(test))]
                _ => course::run::<STATES, AT_RUN_TIME>(batch, memory, set, kind, rows, out),
            }
        }
    };
}

/// Whether there is code compiled for rows with these effects that no gas enters or leaves but by them. Rows with others
/// carry the states of all effects along and take longer.
pub fn has_code_of_its_own(set: EffectSet) -> bool {
    let set = on_the_gas(set);
    compiled_for(set, effects::KEEP_THE_MASS.contains(set)).is_some()
}

/// The bits of the first compiled set that has all effects of a set; one of tight rows only for such.
fn compiled_for(set: EffectSet, tight: bool) -> Option<u32> {
    let fits = |bits: &u32| (tight || bits & TIGHT == 0) && EffectSet::from_bits(*bits).contains(set);
    COMPILED.iter().copied().find(fits)
}

#[cfg(test)]
sets_with_code_of_their_own![];
#[cfg(not(test))]
sets_with_code_of_their_own![
    // Tight rows take the first that fits, the others the first that is not of tight ones.
    TIGHT | ASKED | WallHeating::SET.bits(),
    TIGHT | ASKED | relaxation::EFFECTS.bits(),
    TIGHT | GasZones::SET.bits(),
    TIGHT | ASKED | on_the_gas_with(effects::MANY).intersection(effects::KEEP_THE_MASS).bits(),
    TIGHT | ASKED | remembering::EFFECTS.bits(),
    Leakage::SET.bits() | SupplyLeakage::SET.bits() | LaminarLeakage::SET.bits() | ASKED,
    TubeVolume::SET.bits(),
    WallHeating::SET.bits() | ASKED,
    GasZones::SET.bits() | ASKED,
    on_the_gas_with(0).bits() | Empirical::SET.bits() | ASKED,
    on_the_gas_with(effects::MANY).bits() | ASKED,
];
