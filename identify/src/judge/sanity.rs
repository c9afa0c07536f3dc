//! Contradictions that only a fit shows: an implausible heat transfer coefficient, a clearly negative dead volume, gauge pressure
//! declared absolute or the reverse, and gauge pressure in another unit than declared. Pressures in Pa, volumes in m³,
//! coefficients in W/(m² K).

use crate::error::Error;
use crate::fit::covariance::covariance;
use crate::fit::{self, Fit};
use crate::parameters::{Sizes, Slot};
use crate::policy;
use crate::record::data::Data;
use crate::record::unit;
use rayon::prelude::*;

/// Refuses a dead volume that is negative and at its bound, or below zero by more than its interval plus the larger of a
/// twentieth of the smallest swept volume and what three tolerances of the position zero make of it.
pub fn dead_volume(data: &Data, fitted: &Fit) -> Result<(), Error> {
    let h = &fitted.hypothesis;
    let Some(i) = h.axes.iter().position(|a| a.slot == Slot::DeadVolume) else { return Ok(()) };
    let dead_volume_m3 = h.axes[i].value(fitted.rig[i]);
    let half_width_m3 = 1.96 * covariance(fitted, false)[(i, i)].sqrt() * h.axes[i].scale;
    let area_m2 = data.cylinder.piston_area_m2;
    let swept_m3 = area_m2 * data.smallest_position_m();
    let open_m3 =
        half_width_m3 + (0.05 * swept_m3).max(policy::TOLERANCES * data.tolerance.position_offset_m * area_m2);
    if swept_m3 > 0.0 && dead_volume_m3 < 0.0 && (dead_volume_m3 < -open_m3 || fitted.at_bound[i]) {
        return Err(Error::NegativeDeadVolume { dead_volume_m3, half_width_m3, swept_m3 });
    }
    Ok(())
}

/// Refuses an implausible heat transfer coefficient in the final model: while a lag or delay is missing from the model, it can
/// take any value.
pub fn coefficient(data: &Data, fitted: &Fit) -> Result<(), Error> {
    if has_plausible_coefficient(fitted) {
        return Ok(());
    }
    let chamber = fitted.chamber();
    let time_constant_s = Sizes::of(data, &chamber).relaxation;
    Err(Error::ImplausibleCoefficient { coefficient: chamber.heat_transfer.coefficient, time_constant_s })
}

/// Whether a fit's heat transfer coefficient is plausible for a gas in a cylinder.
pub fn has_plausible_coefficient(fitted: &Fit) -> bool {
    policy::PLAUSIBLE_COEFFICIENT.contains(&fitted.chamber().heat_transfer.coefficient)
}

/// Refuses gauge pressure declared absolute, absolute pressure declared gauge, and gauge pressure in another unit than declared:
/// where adding the right offset to every reading removes nine tenths of the misfit, and the best-fitting offset agrees with it
/// within 15 %.
///
/// Gauge pressures that are r times too large, with r times the ambient pressure added, are r times the absolute pressures, which
/// a model fits just as well.
pub fn reference(data: &Data, fitted: &Fit) -> Result<(), Error> {
    const SHARE_LEFT: f64 = 0.1;
    const NEARLY: f64 = 0.15;
    let ambient_pa = data.ambient_pressure_pa;
    let misfit = |offset_pa: f64| {
        let shifted = shifted(data, offset_pa);
        let h = &fitted.hypothesis;
        fit::fit(&shifted, h, fitted.rig.clone(), h.record_guesses(&shifted), &fit::all_blocks(&shifted))
            .map_or(f64::INFINITY, |f| f.chi2)
    };
    let beyond_noise = fitted.chi2 - fitted.blocks as f64;
    let sign = if data.gauge_pressures { -1.0 } else { 1.0 };
    let tried = [Shift { offset_pa: sign * ambient_pa, unit: None }].into_iter().chain(other_units(data));
    // Readings cannot be below vacuum.
    let tried: Vec<Shift> = tried.filter(|shift| data.lowest_pressure_pa() + shift.offset_pa > 0.0).collect();
    let corrected = tried.into_par_iter().map(|shift| (misfit(shift.offset_pa), shift));
    let Some((corrected, shift)) = corrected.min_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    let left = corrected - fitted.blocks as f64;
    if left > SHARE_LEFT * beyond_noise {
        return Ok(());
    }
    // The parabola of χ² through three offsets.
    let (low, high) = (misfit(0.9 * shift.offset_pa), misfit(1.1 * shift.offset_pa));
    let curvature = low + high - 2.0 * corrected;
    if !(curvature.is_finite() && curvature > 0.0) {
        return Ok(());
    }
    let best = 1.0 + 0.05 * (low - high) / curvature;
    if (best - 1.0).abs() > NEARLY {
        return Ok(());
    }
    let half_width_pa =
        1.96 * shift.offset_pa.abs() * (0.02 / curvature * (corrected / fitted.blocks as f64).max(1.0)).sqrt();
    let offset_pa = best * ambient_pa;
    Err(match (shift.unit, data.gauge_pressures) {
        (Some((declared, unit)), _) => Error::GaugeUnit { unit, declared, share_left: (left / beyond_noise).max(0.0) },
        (None, true) => Error::NotGauge { offset_pa, half_width_pa, ambient_pa },
        (None, false) => Error::Gauge { offset_pa, half_width_pa, ambient_pa },
    })
}

/// Offset added to every reading, with the declared unit and the other one that it implies.
struct Shift {
    offset_pa: f64,
    unit: Option<(&'static str, &'static str)>,
}

/// Units in which the gauge pressures would be those of compressed air.
fn other_units(data: &Data) -> impl Iterator<Item = Shift> {
    /// Smallest ratio of highest to ambient pressure: a test below it hardly tells the unit.
    const LEAST_RISE: f64 = 1.2;
    /// Factor by which a compression may exceed the pressures of rests.
    const COMPRESSION: f64 = 2.0;
    let (ambient_pa, highest_pa) = (data.ambient_pressure_pa, data.highest_pressure_pa());
    let declared = data.pressure_unit.filter(|_| data.gauge_pressures);
    declared.into_iter().flat_map(move |declared| {
        let is_plausible = move |&(_, ratio): &(&str, f64)| {
            let highest_pa = ambient_pa + (highest_pa - ambient_pa) / ratio;
            highest_pa > LEAST_RISE * ambient_pa && highest_pa < COMPRESSION * policy::COMPRESSED_AIR_PA.end()
        };
        unit::others(declared).filter(is_plausible).map(move |(unit, ratio)| Shift {
            offset_pa: ambient_pa * (ratio - 1.0),
            unit: Some((declared.name, unit)),
        })
    })
}

fn shifted(data: &Data, by_pa: f64) -> Data {
    let mut data = data.clone();
    for t in &mut data.traces {
        t.initial_pressure_pa += by_pa;
        t.pressure_pa.iter_mut().for_each(|p| *p += by_pa);
        t.blocks.iter_mut().for_each(|b| b.mean_pa += by_pa);
    }
    data
}
