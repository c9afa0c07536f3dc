//! Units that pressures may really be in, where the declared one is not theirs, and what speaks for another one.

use crate::policy::COMPRESSED_AIR_PA;
use records::units::{Quantity, Unit};
use records::{Layout, Rig};
use report::digits;

/// Units that pressures are recorded in. A rig's `atm` is nearly `bar`, its `hPa` is `mbar`.
const COMMON: [&str; 6] = ["Pa", "kPa", "MPa", "bar", "mbar", "psi"];

/// Units other than the declared one, each with how many times the pressure is declared if it is the right one.
pub fn others(declared: &Unit) -> impl Iterator<Item = (&'static str, f64)> {
    let (name, factor) = (declared.name, declared.factor);
    let common = Quantity::Pressure.units().iter().filter(|unit| COMMON.contains(&unit.name));
    common.filter(move |unit| unit.name != name && unit.factor != factor).map(move |u| (u.name, factor / u.factor))
}

/// What a rig says of its pressures.
#[derive(Clone, Copy, Debug)]
pub struct Declared {
    /// Their unit, where nothing scales it.
    pub unit: Option<&'static Unit>,
    /// What counts as zero, Pa: the pressure of the surroundings for gauge pressures.
    pub zero_pa: f64,
}

impl Declared {
    /// Of a rig.
    pub fn of(rig: &Rig) -> Self {
        let zero_pa = if rig.gauge_pressures { rig.ambient.pressure_pa } else { 0.0 };
        Self { unit: rig.pressure_unit, zero_pa }
    }

    /// Of a layout without its rig.
    pub fn of_layout(layout: &Layout) -> Self {
        let column = layout.column(Quantity::Pressure);
        Self {
            unit: column.plain_unit(Quantity::Pressure),
            // Without a scale or offset of its own, what is added to a gauge column is the pressure of the surroundings.
            zero_pa: if column.gauge { column.offset } else { 0.0 },
        }
    }

    /// Units that make pressures of which `is_plausible` holds; `pressure` gives one as read in a unit.
    fn plausible(&self, is_plausible: impl Fn(&dyn Fn(f64) -> f64) -> bool) -> Vec<&'static str> {
        let Some(declared) = self.unit else { return Vec::new() };
        let fits = |ratio: f64| is_plausible(&|pa| self.zero_pa + (pa - self.zero_pa) / ratio);
        others(declared).filter(|(_, ratio)| fits(*ratio)).map(|(unit, _)| unit).collect()
    }

    /// Units in which a pressure, Pa as declared, is one of compressed air.
    pub fn of_level(&self, pa: f64) -> Vec<&'static str> {
        self.plausible(|read| COMPRESSED_AIR_PA.contains(&read(pa)))
    }

    /// Units in which pressures, Pa as declared, answer volumes that change by this factor as a gas does that is closed in:
    /// P ∝ V⁻ⁿ, where n is between one and the adiabatic exponent, and less by a dead volume.
    pub fn of_answer(&self, (least, most): (f64, f64), factor: f64) -> Vec<&'static str> {
        self.plausible(|read| {
            read(least) > 0.0 && (0.6..1.5).contains(&((read(most) / read(least)).ln() / factor.ln()))
        })
    }
}

/// What speaks for another unit of absolute pressures.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The declared unit.
    pub declared: &'static str,
    /// The one that is more plausible.
    pub unit: &'static str,
    /// Pressure at which records rest, Pa, as declared and in the other unit.
    pub rest_pa: [f64; 2],
    /// Whether the latter is that of the surroundings.
    pub at_ambient: bool,
    /// λ0 by the paper's steps, W/(m² K), likewise.
    pub coefficient: Option<[f64; 2]>,
}

impl Doubt {
    /// In words.
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
