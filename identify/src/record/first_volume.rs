//! First guess of the dead volume, where the rig file states none: small compared with the swept volume or, where positions near
//! the end of the travel count from about zero, from the pressures before and after the moves.

use crate::record::data::{Prepared, smallest_position};
use records::extremes;

/// First guess, over the smallest swept volume or the travel.
const SHARE: f64 = 0.05;
/// Positions nearer to zero than this fraction of their travel are not counted from the chamber's end.
const NEAR_ZERO: f64 = 0.05;
/// Least length of gas at the smallest position, as a fraction of the travel.
const LEAST_LEFT: f64 = 0.02;

/// First guess of the dead volume, m³, which leaves some volume at the smallest position.
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

/// Dead volume as a length of cylinder, m, if the gas is as warm at the end of a record as at its start:
/// P0 (x0 + l) = P1 (x1 + l).
fn by_pressures(trace: &Prepared) -> Option<f64> {
    /// A smaller relative change of pressure does not determine a volume.
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
