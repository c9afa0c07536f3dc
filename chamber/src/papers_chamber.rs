//! The chamber that Carneiro and Gomes de Almeida (2006) simulate.

use crate::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};

/// The chamber of the paper's section 3.1; the paper uses [`AreaLaw::Swept`].
pub fn section_31(area_law: AreaLaw) -> Chamber {
    Chamber::new(Gas::AIR, Geometry::new(0.02, 0.0, 1.57e-6, area_law), HeatTransfer::at_paper_reference(26.5))
}
