//! Contradictions that only a fit shows: gauge pressure taken for absolute or absolute for gauge, a dead volume below zero by far.

use crate::error::Error;
use crate::fit::covariance::covariance;
use crate::fit::{self, Fit};
use crate::parameters::{Sizes, Slot};
use crate::policy;
use crate::record::prepare::Data;

/// Refuses a dead volume that is negative by more than its interval and a twentieth of the smallest swept volume.
pub fn dead_volume(data: &Data, fitted: &Fit) -> Result<(), Error> {
    let h = &fitted.hypothesis;
    let Some(i) = h.axes.iter().position(|a| a.slot == Slot::DeadVolume) else { return Ok(()) };
    let dead_volume_m3 = h.axes[i].value(fitted.rig[i]);
    let half_width_m3 = 1.96 * covariance(fitted, false)[(i, i)].sqrt() * h.axes[i].scale;
    let swept_m3 = data.cylinder.piston_area_m2 * data.smallest_position_m();
    if swept_m3 > 0.0
        && (dead_volume_m3 + half_width_m3 < -0.05 * swept_m3 || (fitted.at_bound[i] && dead_volume_m3 < 0.0))
    {
        return Err(Error::NegativeDeadVolume { dead_volume_m3, half_width_m3, swept_m3 });
    }
    Ok(())
}

/// Refuses a heat transfer coefficient that no gas in a cylinder has, in the model that is settled on: a lag or a delay that the
/// model does not have yet can make it anything.
pub fn coefficient(data: &Data, fitted: &Fit) -> Result<(), Error> {
    let chamber = fitted.chamber();
    let coefficient = chamber.heat_transfer.coefficient;
    if policy::PLAUSIBLE_COEFFICIENT.contains(&coefficient) {
        return Ok(());
    }
    let time_constant_s = Sizes::of(data, &chamber).relaxation;
    Err(Error::ImplausibleCoefficient { coefficient, time_constant_s })
}

/// Refuses gauge pressure that is declared absolute, and absolute pressure that is declared gauge: adding the ambient pressure to
/// every reading, or taking it away again, takes away nine tenths of the misfit, and the offset that fits best is the ambient
/// pressure within a seventh.
pub fn reference(data: &Data, fitted: &Fit) -> Result<(), Error> {
    const SHARE_LEFT: f64 = 0.1;
    const NEARLY: f64 = 0.15;
    let ambient_pa = data.ambient_pressure_pa;
    let offset_pa = if data.gauge_pressures { -ambient_pa } else { ambient_pa };
    // Readings that would be below vacuum are gauge.
    if data.lowest_pressure_pa() + offset_pa <= 0.0 {
        return Ok(());
    }
    let misfit = |share: f64| {
        let shifted = shifted(data, share * offset_pa);
        let h = &fitted.hypothesis;
        fit::fit(&shifted, h, fitted.rig.clone(), h.first_owns(&shifted), &fit::all_blocks(&shifted))
            .map_or(f64::INFINITY, |f| f.chi2)
    };
    let corrected = misfit(1.0);
    if corrected - fitted.blocks as f64 > SHARE_LEFT * (fitted.chi2 - fitted.blocks as f64) {
        return Ok(());
    }
    // The parabola of χ² through three offsets.
    let (low, high) = (misfit(0.9), misfit(1.1));
    let curvature = low + high - 2.0 * corrected;
    if curvature.is_finite() && curvature > 0.0 {
        let best = 1.0 + 0.05 * (low - high) / curvature;
        if (best - 1.0).abs() < NEARLY {
            let half_width_pa =
                1.96 * ambient_pa * (0.02 / curvature * (corrected / fitted.blocks as f64).max(1.0)).sqrt();
            let offset_pa = best * ambient_pa;
            return Err(if data.gauge_pressures {
                Error::NotGauge { offset_pa, half_width_pa, ambient_pa }
            } else {
                Error::Gauge { offset_pa, half_width_pa, ambient_pa }
            });
        }
    }
    Ok(())
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
