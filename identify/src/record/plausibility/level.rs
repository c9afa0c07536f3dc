//! Absolute pressures in a unit other than the one that the rig declares.
//!
//! With r times the absolute pressure, a chamber has r times the mass and √r times λ0, and all else is the same: neither ratios
//! nor times show a wrong unit. The signs are the level at which the records rest, if it is the pressure of the surroundings in
//! another unit, or a level of compressed air in another unit only; and λ0, which for gases in cylinders is some 30 W/(m² K). Any
//! one of these may hold by chance: two give a note, all three a refusal.
//!
//! Gauge pressures in another unit contradict the volumes: see [`crate::judge::sanity`].

use crate::error::Error;
use crate::policy::{AT_AMBIENT, COMPRESSED_AIR_PA, FIRST_LAMBDA0};
use crate::record::data::{Data, Prepared};
use crate::record::papers_steps;
use crate::record::stroke::Phase;
use crate::record::unit::{Doubt, others};
use records::units::Unit;

/// Checks absolute pressures of a declared unit.
///
/// # Errors
/// If all signs favour another unit.
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
    // Records that rest at the pressure of the surroundings count; if none does, all do.
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

/// Mean pressure of a record's initial rest, Pa.
fn rest_pa(t: &Prepared) -> Option<f64> {
    let rest = t.course.motion.segments.first().filter(|s| s.phase == Phase::Rest)?;
    let rows: Vec<f64> = (rest.first..rest.end).filter(|&i| t.readout.is_data(i)).map(|i| t.pressure_pa[i]).collect();
    (!rows.is_empty()).then(|| rows.iter().sum::<f64>() / rows.len() as f64)
}

/// Median of λ0 by the paper's steps, W/(m² K).
fn coefficient(data: &Data, rests: &[(f64, &Prepared)]) -> Option<f64> {
    let of = |t: &Prepared| Some(papers_steps::of(data, t).ok()?.steps.coefficient_0_w_per_m2_k.value);
    let mut found: Vec<f64> = rests.iter().filter_map(|(_, t)| of(t)).filter(|c| *c > 0.0).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}
