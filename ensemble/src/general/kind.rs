//! Kinds of rows that are integrated, by what lanes must have in common.

use super::{relaxation, remembering};
use crate::batch::Features;
use chamber::effects;

/// What rows that are integrated have in common.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Gas may enter or leave, at constant rates and by effects.
    Open,
    /// No gas enters or leaves.
    Tight,
    /// Nor has the hold a state but the temperature: see [`relaxation`].
    Relaxing,
    /// Nor has the hold states but the temperature and those of a wall that remembers: see [`remembering`].
    Remembering,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Open, Self::Tight, Self::Relaxing, Self::Remembering];

    /// That of a row.
    pub fn of(row: &Features) -> Self {
        let of_gas = row.of_gas;
        let by_integrals = row.is_wide && !row.integrates;
        if !row.is_sealed || !effects::KEEP_THE_MASS.contains(of_gas) {
            Self::Open
        } else if by_integrals && row.behind.is_none() && relaxation::EFFECTS.contains(of_gas) {
            Self::Relaxing
        } else if by_integrals
            && remembering::EFFECTS.contains(of_gas)
            && !of_gas.intersection(effects::REMEMBERING).is_empty()
        {
            Self::Remembering
        } else {
            Self::Tight
        }
    }

    /// Whether no gas enters or leaves.
    pub fn is_tight(self) -> bool {
        matches!(self, Self::Tight | Self::Relaxing | Self::Remembering)
    }
}
