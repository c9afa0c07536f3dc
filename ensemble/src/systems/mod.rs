//! Rows with specialised equations, which are fewer and shorter than the general ones: at most one effect on the gas, and no sensor
//! effects. [`Systems`] has one list for each kind; rows that turn out not to be solvable this way are left to the general integrator.

mod adaptive;
mod decaying_turbulence;
mod empirical_heat_flow;
mod flows;
mod gas;
mod list;
mod natural_convection;
mod sealed;
mod settling;
mod test_system;
mod turns;
mod wall_conduction;
mod wall_heating;

use crate::batch::Features;
use chamber::effects::EffectSet;
use flows::{FlowTest, Gap, Orifice};
use list::{List, Method};

/// A chunk's rows with specialised equations, one list for each kind.
#[derive(Default)]
pub struct Systems {
    /// The paper's model, if the integrator is requested.
    sealed: List<adaptive::Memory<1, gas::SealedTest>>,
    /// The same with a wall that warms.
    wall_heating: List<adaptive::Memory<2, wall_heating::WallHeatingTest>>,
    /// The same with decaying turbulence.
    decaying_turbulence: List<adaptive::Memory<2, decaying_turbulence::TurbulenceTest>>,
    /// The same with a heat flow as a function of pressure.
    empirical_heat_flow: List<adaptive::Memory<1, empirical_heat_flow::HeatFlowTest>>,
    /// The same with natural convection: with holds as integrals or series, and if the integrator is requested.
    natural_convection: List<natural_convection::rows::Memory>,
    integrated_convection: List<adaptive::Memory<2, natural_convection::NaturalConvectionTest>>,
    /// Gas leaves or enters through an orifice; through a gap or at constant rates.
    orifices: List<adaptive::Memory<2, FlowTest<Orifice>>>,
    gaps: List<adaptive::Memory<2, FlowTest<Gap>>>,
    /// The same with a conducting wall.
    wall_conduction: List<wall_conduction::Memory>,
}

impl Systems {
    /// The list for a row, if there is one.
    #[inline]
    pub fn rows_like(&mut self, row: &Features) -> Option<&mut Vec<u32>> {
        let &Features { scenario: s, of_gas, is_sealed, integrates, is_wide, .. } = row;
        if !is_wide || row.sensor.is_some() {
            return None;
        }
        Some(match of_gas {
            EffectSet::NONE if is_sealed && integrates => &mut self.sealed.rows,
            wall_heating::EFFECTS if is_sealed && wall_heating::has_wall(s) => &mut self.wall_heating.rows,
            decaying_turbulence::EFFECTS if is_sealed && decaying_turbulence::has_turbulence(s) => {
                &mut self.decaying_turbulence.rows
            }
            empirical_heat_flow::EFFECTS if is_sealed && empirical_heat_flow::has_heat_flow(s) => {
                &mut self.empirical_heat_flow.rows
            }
            wall_conduction::EFFECT if is_sealed && !integrates => &mut self.wall_conduction.rows,
            natural_convection::EFFECTS if !is_sealed || !natural_convection::stays_on_a_side(s) => return None,
            natural_convection::EFFECTS if !integrates => &mut self.natural_convection.rows,
            natural_convection::EFFECTS if natural_convection::is_smooth(s) => &mut self.integrated_convection.rows,
            of_gas if flows::ORIFICES.contains(&of_gas) => &mut self.orifices.rows,
            flows::GAP => &mut self.gaps.rows,
            EffectSet::NONE if !is_sealed => &mut self.gaps.rows,
            _ => return None,
        })
    }

    /// The lists in the order of solution.
    pub fn lists(&mut self) -> [&mut List<dyn Method>; 9] {
        [
            &mut self.sealed, &mut self.wall_heating, &mut self.decaying_turbulence, &mut self.empirical_heat_flow,
            &mut self.natural_convection, &mut self.integrated_convection, &mut self.orifices, &mut self.gaps,
            &mut self.wall_conduction,
        ]
    }
}
