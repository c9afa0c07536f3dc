//! Units that pressures may really be in if the declared one is wrong, and the evidence for another one.

use crate::policy::COMPRESSED_AIR_PA;
use records::units::{Quantity, Unit};
use records::{Layout, Rig};
use report::digits;

/// Units that pressures are recorded in. A rig's `atm` is nearly `bar`, its `hPa` is `mbar`.
const COMMON: [&str; 6] = ["Pa", "kPa", "MPa", "bar", "mbar", "psi"];

/// Units other than the declared one, each with the ratio of the declared pressure to the true one if that unit is right.
pub fn others(declared: &Unit) -> impl Iterator<Item = (&'static str, f64)> {
    let (name, factor) = (declared.name, declared.factor);
    let common = Quantity::Pressure.units().iter().filter(|unit| COMMON.contains(&unit.name));
    common.filter(move |unit| unit.name != name && unit.factor != factor).map(move |u| (u.name, factor / u.factor))
}

/// What a rig declares about its pressures.
#[derive(Clone, Copy, Debug)]
pub struct Declared {
    /// Their unit, unless the column is scaled.
    pub unit: Option<&'static Unit>,
    /// Zero of the pressures, Pa: the pressure of the surroundings for gauge pressures.
    pub zero_pa: f64,
}

impl Declared {
    /// From a rig.
    pub fn of(rig: &Rig) -> Self {
        let zero_pa = if rig.gauge_pressures { rig.ambient.pressure_pa } else { 0.0 };
        Self { unit: rig.pressure_unit, zero_pa }
    }

    /// From a layout without its rig.
    pub fn of_layout(layout: &Layout) -> Self {
        let column = layout.column(Quantity::Pressure);
        Self {
            unit: column.plain_unit(Quantity::Pressure),
            // In a gauge column without its own scale or offset, the offset is the pressure of the surroundings.
            zero_pa: if column.gauge { column.offset } else { 0.0 },
        }
    }

    /// Units for which `is_plausible` holds; its argument converts a declared pressure, Pa, to the same reading in that unit.
    fn plausible(&self, is_plausible: impl Fn(&dyn Fn(f64) -> f64) -> bool) -> Vec<&'static str> {
        let Some(declared) = self.unit else { return Vec::new() };
        let fits = |ratio: f64| is_plausible(&|pa| self.zero_pa + (pa - self.zero_pa) / ratio);
        others(declared).filter(|(_, ratio)| fits(*ratio)).map(|(unit, _)| unit).collect()
    }

    /// Units in which a pressure, Pa as declared, is that of compressed air.
    pub fn units_by_level(&self, pa: f64) -> Vec<&'static str> {
        self.plausible(|read| COMPRESSED_AIR_PA.contains(&read(pa)))
    }

    /// Units in which pressures, Pa as declared, respond to volumes that change by `factor` as an enclosed gas does: P ∝ V⁻ⁿ,
    /// with n between one and the adiabatic exponent, and less with a dead volume.
    pub fn units_by_response(&self, (least, most): (f64, f64), factor: f64) -> Vec<&'static str> {
        self.plausible(|read| {
            read(least) > 0.0 && (0.6..1.5).contains(&((read(most) / read(least)).ln() / factor.ln()))
        })
    }
}

/// Evidence for another unit of absolute pressures.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The declared unit.
    pub declared: &'static str,
    /// The more plausible one.
    pub unit: &'static str,
    /// Rest pressure of the records, Pa, as declared and in the other unit.
    pub rest_pa: [f64; 2],
    /// Whether the latter is that of the surroundings.
    pub at_ambient: bool,
    /// λ0 by the paper's steps, W/(m² K), likewise.
    pub coefficient: Option<[f64; 2]>,
}

impl Doubt {
    /// States the doubt in words.
    pub fn sentence(&self) -> String {
        let bar = |pa: f64| format!("{} bar", digits(1e-5 * pa, 4));
        let [rest, other] = self.rest_pa;
        let what = if self.at_ambient { "the pressure of the surroundings" } else { "usual for compressed air" };
        let lambda0 = self.coefficient.map_or(String::new(), |[declared, other]| {
            format!(", with lambda0 some {} rather than {} W/(m2 K)", digits(other, 2), digits(declared, 2))
        });
        format!(
            "the pressures, declared in {}, rest at {}; read in {unit} that is {}, {what}{lambda0}: check the unit of the pressure column (unit = \"{unit}\")",
            self.declared,
            bar(rest),
            bar(other),
            unit = self.unit
        )
    }
}
