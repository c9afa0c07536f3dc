//! Arbitrary chambers and arbitrary inputs from their surroundings.

use chamber::balance::Boundary;
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use proptest::prelude::*;

prop_compose! {
    pub fn any_chamber()(bore in 0.01..0.2f64, dead_fraction in 0.0..0.5f64, lambda in 1.0..200.0f64, total in any::<bool>()) -> Chamber {
        let law = if total { AreaLaw::Total } else { AreaLaw::Swept };
        let dead_volume = dead_fraction * bore * bore * 0.05;
        Chamber::new(Gas::AIR, Geometry::new(bore, 0.0, dead_volume, law), HeatTransfer::at_paper_reference(lambda))
    }
}

prop_compose! {
    pub fn any_boundary()(position in 0.02..0.3f64, velocity in -1.0..1.0f64, mass_flow_in in 0.0..1e-4f64, temperature_in in 260.0..350.0f64,
        mass_flow_out in 0.0..1e-4f64, ambient_temperature in 260.0..320.0f64) -> Boundary {
        Boundary { position, velocity, mass_flow_in, temperature_in, mass_flow_out, ambient_temperature, ambient_pressure: 1.013e5 }
    }
}
