//! The dead volume that a fit begins with, where the rig file states none: small beside the volume that is swept or, where the
//! positions count from near the end of the travel, that which the pressures before and after the moves speak for.

use crate::record::data::{Prepared, smallest_position};
use records::extremes;

/// Of the smallest swept volume.
const SHARE: f64 = 0.05;
/// Positions that come nearer to zero than this share of their travel count from elsewhere than the chamber's end.
const NEAR_ZERO: f64 = 0.05;
/// So much of the travel is left at the smallest position, at the least.
const LEAST_LEFT: f64 = 0.02;

/// A first guess of the dead volume, m³, that leaves some volume at the smallest position.
pub fn first_guess(traces: &[Prepared], piston_area_m2: f64) -> f64 {
    let smallest = smallest_position(traces);
    let positions = traces.iter().map(|t| extremes(&t.position_m));
    let travel = positions.map(|(low, high)| high - low).fold(0.0, f64::max);
    if smallest >= NEAR_ZERO * travel {
        return SHARE * piston_area_m2 * smallest;
    }
    let mut lengths: Vec<f64> = traces.iter().filter_map(by_pressures).collect();
    lengths.sort_by(f64::total_cmp);
    let length = lengths.get(lengths.len() / 2).copied().unwrap_or(SHARE * travel - smallest);
    piston_area_m2 * length.max(LEAST_LEFT * travel - smallest)
}

/// The length of cylinder that the dead volume has if the gas is as warm at the end of a record as at its start:
/// P0 (x0 + l) = P1 (x1 + l), m.
fn by_pressures(trace: &Prepared) -> Option<f64> {
    /// A change of pressure below this share tells nothing of a volume.
    const LEAST_CHANGE: f64 = 0.1;
    let motion = &trace.course.motion;
    let (begin_s, end_s) = motion.extent();
    let [from, to] =
        [begin_s, end_s].map(|t| motion.segments[motion.segment_at(t)].stroke.at(t, &Default::default()).0);
    let rows = trace.pressure_pa.len();
    let end = &trace.pressure_pa[rows - rows.div_ceil(20)..];
    let (before, after) = (trace.initial_pressure_pa, end.iter().sum::<f64>() / end.len() as f64);
    ((after / before).ln().abs() > LEAST_CHANGE).then(|| (after * to - before * from) / (before - after))
}
