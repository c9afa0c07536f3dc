//! Pressures in another unit than the rig declares.
//!
//! With r times the absolute pressure a chamber has r times the mass and √r times λ0, and all else is as it was: neither ratios
//! nor times tell a wrong unit. What tells it is the level at which the records rest, where that is the pressure of the
//! surroundings in another unit, or no level of compressed air but in another unit; and λ0, which in gases in cylinders is some
//! 30 W/(m² K). Each of these may be so for once, so that it takes two for a note, and all for a refusal.
//!
//! Gauge pressures in another unit contradict the volumes: see [`crate::judge::sanity`].

use crate::error::Error;
use crate::parameters::FIRST_LAMBDA0;
use crate::policy::{AT_AMBIENT, COMPRESSED_AIR_PA};
use crate::record::prepare::{Data, Prepared};
use crate::record::stroke::Phase;
use paper::{Recording, Setup, time_constant};
use records::Rig;
use records::units::{Quantity, Unit};
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

/// Looks at absolute pressures of a declared unit.
///
/// # Errors
/// Where everything speaks for another unit.
pub fn check(data: &Data, declared: Option<&'static Unit>) -> Result<Option<Doubt>, Error> {
    let Some(declared) = declared.filter(|_| !data.gauge_pressures) else { return Ok(None) };
    let rests: Vec<(f64, &Prepared)> = data.traces.iter().filter_map(|t| Some((rest_pa(t)?, t))).collect();
    let usual = |pa: f64| COMPRESSED_AIR_PA.contains(&pa);
    let at_ambient = |pa: f64| (pa / data.ambient_pressure_pa - 1.0).abs() < AT_AMBIENT;
    if rests.is_empty() || rests.iter().any(|(pa, _)| at_ambient(*pa)) {
        return Ok(None);
    }
    let lowest = rests.iter().map(|(pa, _)| *pa).fold(f64::INFINITY, f64::min);
    let is_all_unusual =
        !rests.iter().any(|(pa, _)| usual(*pa)) || data.highest_pressure_pa() < data.ambient_pressure_pa;
    // Those at rest at the pressure of the surroundings count; where none is, all do.
    let signs = |(unit, ratio): (&'static str, f64)| {
        let open: Vec<_> = rests.iter().filter(|(pa, _)| at_ambient(pa / ratio)).collect();
        let all_usual = rests.iter().all(|(pa, _)| usual(pa / ratio));
        let rest_pa = open.first().map_or(lowest, |(pa, _)| *pa);
        let at_ambient = !open.is_empty();
        let is_unusual = if at_ambient { !usual(rest_pa) } else { is_all_unusual };
        if !all_usual || !(at_ambient || is_unusual) {
            return None;
        }
        let coefficient = coefficient(data, &rests).map(|declared| [declared, declared / ratio.sqrt()]);
        let far = |coefficient: f64| (coefficient / FIRST_LAMBDA0).ln().abs();
        let is_nearer = coefficient.is_some_and(|[declared, other]| far(other) < far(declared));
        let count = usize::from(at_ambient) + usize::from(is_unusual) + usize::from(is_nearer);
        let doubt =
            Doubt { declared: declared.name, unit, rest_pa: [rest_pa, rest_pa / ratio], at_ambient, coefficient };
        (count > 1).then_some((count, doubt))
    };
    match others(declared).filter_map(signs).max_by_key(|(count, doubt)| (doubt.at_ambient, *count)) {
        Some((3, doubt)) => Err(Error::OtherPressureUnit { doubt }),
        found => Ok(found.map(|(_, doubt)| doubt)),
    }
}

/// Mean pressure of a record's rest, Pa.
fn rest_pa(t: &Prepared) -> Option<f64> {
    let rest = t.course.motion.segments.first().filter(|s| s.phase == Phase::Rest)?;
    let rows: Vec<f64> = (rest.first..rest.end).filter(|&i| t.readout.is_data(i)).map(|i| t.pressure_pa[i]).collect();
    (!rows.is_empty()).then(|| rows.iter().sum::<f64>() / rows.len() as f64)
}

/// Median of λ0 by the paper's steps, W/(m² K).
fn coefficient(data: &Data, rests: &[(f64, &Prepared)]) -> Option<f64> {
    let of = |t: &Prepared| {
        let setup = Setup {
            gas: data.gas,
            geometry: data.cylinder.geometry(0.0),
            ambient_temperature_k: t.initial_temperature_k,
            reference_pressure_pa: chamber::paper::REFERENCE_PRESSURE_PA,
            reference_temperature_k: chamber::paper::REFERENCE_TEMPERATURE_K,
        };
        let recording = Recording { time_s: &t.time_s, pressure_pa: &t.pressure_pa, position_m: &t.position_m };
        Some(time_constant::evaluate(&setup, &recording).ok()?.steps.coefficient_0_w_per_m2_k.value)
    };
    let mut found: Vec<f64> = rests.iter().filter_map(|(_, t)| of(t)).filter(|c| *c > 0.0).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}
