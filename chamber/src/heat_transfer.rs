//! Heat transfer coefficient λ between gas and wall, W/(m² K). Equation (5), after Eichelberg (1939):
//! λ(P, T) = λ0 √(P T/(P0 T0)). Effects multiply it by further factors.

use crate::paper;
use crate::real::{Real, lift};

/// Eichelberg's law, fixed at one state of the gas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatTransfer<R = f64> {
    /// λ0, W/(m² K), at the reference state.
    pub coefficient: R,
    /// Reference pressure P0, Pa.
    pub reference_pressure: R,
    /// Reference temperature T0, K.
    pub reference_temperature: R,
}

impl HeatTransfer<f64> {
    /// λ0 at the paper's reference state, P0 = 5.65 bar and T0 = 293 K.
    pub fn at_paper_reference(coefficient: f64) -> Self {
        Self {
            coefficient,
            reference_pressure: paper::REFERENCE_PRESSURE_PA,
            reference_temperature: paper::REFERENCE_TEMPERATURE_K,
        }
    }
}

impl<R: Real> HeatTransfer<R> {
    /// λ at pressure P, Pa, and gas temperature T, K. Equation (5).
    #[inline(always)]
    pub fn coefficient_at(&self, pressure: R, temperature: R) -> R {
        self.coefficient / (self.reference_pressure * self.reference_temperature).sqrt()
            * (pressure * temperature).sqrt()
    }
}

lift!(HeatTransfer: coefficient, reference_pressure, reference_temperature);
