//! Rows with specialised equations, which are fewer and shorter than the general ones: at most one effect on the gas, and no sensor
//! effects. [`Own`] has one list for each kind; rows that turn out not to be solvable this way are left to the general integrator.

mod adaptive;
mod convective;
mod finish;
mod flows;
mod gas;
mod heated;
mod list;
mod remembering;
mod sealed;
mod stirred;
mod test;
mod turns;
mod walled;

use crate::batch::Features;
use chamber::effects::EffectSet;
use flows::{FlowTest, Gap, Orifice};
use list::{List, Way};

/// A chunk's rows with specialised equations, one list for each kind.
#[derive(Default)]
pub struct Own {
    /// The paper's model, if the integrator is requested.
    sealed: List<adaptive::Memory<1, gas::SealedTest>>,
    /// The same with a wall that warms.
    walled: List<adaptive::Memory<2, walled::WalledTest>>,
    /// The same with decaying turbulence.
    stirred: List<adaptive::Memory<2, stirred::StirredTest>>,
    /// The same with a heat flow as a function of pressure.
    heated: List<adaptive::Memory<1, heated::HeatedTest>>,
    /// The same with natural convection: with holds as integrals or series, and if the integrator is requested.
    convective: List<convective::rows::Memory>,
    integrated: List<adaptive::Memory<2, convective::ConvectiveTest>>,
    /// Gas leaves or enters through an orifice; through a gap or at constant rates.
    orifices: List<adaptive::Memory<2, FlowTest<Orifice>>>,
    gaps: List<adaptive::Memory<2, FlowTest<Gap>>>,
    /// The same with a conducting wall.
    remembering: List<remembering::Memory>,
}

impl Own {
    /// The list for a row, if there is one.
    #[inline]
    pub fn rows_like(&mut self, row: &Features) -> Option<&mut Vec<u32>> {
        let &Features { scenario: s, of_gas, is_sealed, integrates, is_wide, .. } = row;
        if !is_wide || row.sensor.is_some() {
            return None;
        }
        Some(match of_gas {
            EffectSet::NONE if is_sealed && integrates => &mut self.sealed.rows,
            walled::EFFECTS if is_sealed && walled::has_wall(s) => &mut self.walled.rows,
            stirred::EFFECTS if is_sealed && stirred::is_stirred(s) => &mut self.stirred.rows,
            heated::EFFECTS if is_sealed && heated::is_heated(s) => &mut self.heated.rows,
            remembering::EFFECT if is_sealed && !integrates => &mut self.remembering.rows,
            convective::EFFECTS if !is_sealed || !convective::stays_on_a_side(s) => return None,
            convective::EFFECTS if !integrates => &mut self.convective.rows,
            convective::EFFECTS if convective::is_smooth(s) => &mut self.integrated.rows,
            of_gas if flows::ORIFICES.contains(&of_gas) => &mut self.orifices.rows,
            flows::GAP => &mut self.gaps.rows,
            EffectSet::NONE if !is_sealed => &mut self.gaps.rows,
            _ => return None,
        })
    }

    /// The lists in the order of solution.
    pub fn lists(&mut self) -> [&mut List<dyn Way>; 9] {
        [
            &mut self.sealed, &mut self.walled, &mut self.stirred, &mut self.heated, &mut self.convective,
            &mut self.integrated, &mut self.orifices, &mut self.gaps, &mut self.remembering,
        ]
    }
}
