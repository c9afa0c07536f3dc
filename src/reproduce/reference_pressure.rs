//! Appendix 2 of the paper, the reference pressure of λ0, as a section of the report.

use chamber::{Gas, paper};
use report::{Section, digits};

/// Supply pressure of the paper's servovalve, Pa.
const SUPPLY_PA: f64 = 7e5;
/// The ratio as printed in the paper.
const PRINTED_RATIO: f64 = 0.8077;

/// The section of the report.
pub fn section() -> Section {
    let ratio = paper::equilibrium_pressure_ratio(Gas::AIR.heat_capacity_ratio);
    let mut section = Section::new("Appendix 2: the reference pressure");
    section.text(format!(
        "λ0 refers to the chamber pressure at which the subsonic inlet and the sonic exhaust of a servovalve pass the same flow. \
         The exact ratio to the supply pressure is {} (the paper prints {PRINTED_RATIO}), that is {} bar of {} bar. We keep the paper's \
         P0 = {} bar as the reference.",
        digits(ratio, 5),
        digits(ratio * SUPPLY_PA * 1e-5, 4),
        digits(SUPPLY_PA * 1e-5, 2),
        digits(paper::REFERENCE_PRESSURE_PA * 1e-5, 3),
    ));
    section
}
