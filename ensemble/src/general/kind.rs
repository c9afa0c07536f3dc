//! Kinds of integrated rows, which are solved separately.

use super::{relaxation, wall_conduction};
use crate::batch::Features;
use chamber::effects;

/// The kind of an integrated row.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Gas may enter or leave, at constant rates or by effects.
    Open,
    /// No gas enters or leaves.
    Tight,
    /// Tight, and temperature is the only state of the hold: see [`relaxation`].
    Relaxing,
    /// Tight, and temperature and the modes of a conducting wall are the only states of the hold: see [`wall_conduction`].
    WallConduction,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Open, Self::Tight, Self::Relaxing, Self::WallConduction];

    /// The kind of a row.
    pub fn of(row: &Features) -> Self {
        let of_gas = row.of_gas;
        let by_integrals = row.is_wide && !row.integrates;
        if !row.is_sealed || !effects::KEEP_THE_MASS.contains(of_gas) {
            Self::Open
        } else if by_integrals && row.sensor.is_none() && relaxation::EFFECTS.contains(of_gas) {
            Self::Relaxing
        } else if by_integrals
            && wall_conduction::EFFECTS.contains(of_gas)
            && !of_gas.intersection(effects::REMEMBERING).is_empty()
        {
            Self::WallConduction
        } else {
            Self::Tight
        }
    }

    /// Whether no gas enters or leaves.
    pub fn is_tight(self) -> bool {
        matches!(self, Self::Tight | Self::Relaxing | Self::WallConduction)
    }
}
