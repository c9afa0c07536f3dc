//! The geometry of a row: bore or strokes, solved for where the volume-to-area ratio is given.

use crate::quantity::Base;
use crate::quantity::point::Point;
use crate::result::status::Failure;
use chamber::{AreaLaw, Geometry};
use std::ops::{Range, RangeInclusive};

/// Smallest and largest bore considered when solving for a volume-to-area ratio, m.
const BORES_M: (f64, f64) = (1e-4, 10.0);

/// The chamber's shape, its bore solved for where the volume-to-area ratio is given.
pub fn of_point(point: &Point, area_law: AreaLaw) -> Result<Geometry, Failure> {
    let get = |base| point.get(base);
    let shape = |bore| Geometry::new(bore, get(Base::Rod), get(Base::DeadVolume), area_law);
    let wanted = get(Base::VolumeToArea);
    let bore = if wanted.is_nan() {
        get(Base::Bore)
    } else {
        let ratio = |bore| ratio(&shape(bore), get(Base::FinalStroke));
        bore_of(wanted, get(Base::Bore), get(Base::Rod), ratio).ok_or(Failure::NoBore)?
    };
    let geometry = shape(bore);
    if geometry.piston_area > 0.0 { Ok(geometry) } else { Err(Failure::RodFillsBore) }
}

/// Strokes before and after the push, m: where the volume-to-area ratio is given at a fixed bore, solved for with their ratio
/// kept. The area is linear in the volume, so that the volume follows from a linear equation.
pub fn strokes(geometry: &Geometry, point: &Point) -> Result<[f64; 2], Failure> {
    let (wanted, given) = (point.get(Base::VolumeToAreaByLength), [Base::InitialStroke, Base::FinalStroke]);
    let [initial, last] = given.map(|base| point.get(base));
    if wanted.is_nan() {
        return Ok([initial, last]);
    }
    let at_zero = geometry.heat_transfer_area(0.0);
    let slope = geometry.heat_transfer_area(1.0) - at_zero;
    let volume = wanted * at_zero / (1.0 - wanted * slope);
    let solved = (volume - geometry.dead_volume) / geometry.piston_area;
    if solved.is_finite() && solved > 0.0 { Ok([solved * (initial / last), solved]) } else { Err(Failure::NoLength) }
}

/// Gas volume over heat transfer area at a stroke, m.
fn ratio(geometry: &Geometry, stroke: f64) -> f64 {
    let volume = geometry.volume(stroke);
    volume / geometry.heat_transfer_area(volume)
}

/// The volume-to-area ratios, m, that some bore gives, for a rod, a dead volume and a stroke.
pub fn bores_give([rod, dead_volume, stroke]: [f64; 3], area_law: AreaLaw) -> RangeInclusive<f64> {
    /// Ratio of neighbouring bores: between them the volume-to-area ratio changes by less than 0.01 % near its maximum.
    const STEP: f64 = 1.01;
    /// Relative margin for a maximum between two bores.
    const SLACK: f64 = 1e-4;
    let least = least_bore(rod);
    let steps = ((BORES_M.1 / least).ln() / STEP.ln()).ceil().max(0.0) as i32;
    let bores = (0..=steps).map(|k| (least * STEP.powi(k)).min(BORES_M.1));
    let ratios = bores.map(|bore| ratio(&Geometry::new(bore, rod, dead_volume, area_law), stroke));
    let (low, high) = ratios.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), r| (low.min(r), high.max(r)));
    low * (1.0 - SLACK)..=high * (1.0 + SLACK)
}

/// The volume-to-area ratios, m, that some length gives, for bores, rods and dead volumes within these bounds: contains all of
/// them and, where the bounds are single values, no others. With increasing length the ratio goes from that of the dead volume to
/// that of an infinite column.
pub fn lengths_give([bores, rods, dead_volumes]: [&RangeInclusive<f64>; 3], area_law: AreaLaw) -> Range<f64> {
    if bores.start() <= rods.end() {
        // Some chambers have no gap between rod and barrel.
        return 0.0..f64::INFINITY;
    }
    let [[narrow, least_ends], [wide, most_ends]] = [(bores.start(), rods.end()), (bores.end(), rods.start())]
        .map(|(bore, rod)| Geometry::new(*bore, *rod, 0.0, area_law).area_constants());
    let dead_alone = |volume: f64, lateral: f64, ends: f64| match area_law {
        AreaLaw::Total => volume / (volume * lateral + ends),
        AreaLaw::Swept => volume / ends,
    };
    let least = dead_alone(*dead_volumes.start(), narrow, most_ends);
    let most = dead_alone(*dead_volumes.end(), wide, least_ends);
    least.min(1.0 / narrow)..most.max(1.0 / wide)
}

/// The smallest bore considered, for a rod.
fn least_bore(rod: f64) -> f64 {
    BORES_M.0.max(rod * (1.0 + 1e-12))
}

/// The bore that gives a volume-to-area ratio; if there are several, the one nearest to `near` on a logarithmic scale.
fn bore_of(target: f64, near: f64, rod: f64, ratio: impl Fn(f64) -> f64) -> Option<f64> {
    const STEP: f64 = 1.1;
    let miss = |bore: f64| ratio(bore) - target;
    let (least, most) = (least_bore(rod), BORES_M.1);
    let (mut low, mut high) = (near.clamp(least, most), near.clamp(least, most));
    let (mut at_low, mut at_high) = (miss(low), miss(high));
    while low > least || high < most {
        let (next_low, next_high) = ((low / STEP).max(least), (high * STEP).min(most));
        let (at_next_low, at_next_high) = (miss(next_low), miss(next_high));
        if at_next_low * at_low <= 0.0 {
            return Some(root(next_low, low, at_next_low, at_low, miss));
        }
        if at_next_high * at_high <= 0.0 {
            return Some(root(high, next_high, at_high, at_next_high, miss));
        }
        (low, high, at_low, at_high) = (next_low, next_high, at_next_low, at_next_high);
    }
    None
}

/// A root between two bores with opposite signs: regula falsi with the Illinois rule.
fn root(mut a: f64, mut b: f64, mut at_a: f64, mut at_b: f64, miss: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        if at_a == 0.0 || (b - a).abs() <= 1e-15 * b {
            return a;
        }
        let c = b - at_b * (b - a) / (at_b - at_a);
        let at_c = miss(c);
        if at_c * at_b <= 0.0 {
            (a, at_a) = (b, at_b);
        } else {
            at_a *= 0.5;
        }
        if (c - b).abs() <= 1e-15 * c {
            return c;
        }
        (b, at_b) = (c, at_c);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether some length gives that ratio in this chamber.
    fn is_given(wanted: f64, geometry: &Geometry) -> bool {
        let mut point = Point::EMPTY;
        point.set(Base::VolumeToAreaByLength, wanted);
        point.set(Base::InitialStroke, 0.1);
        point.set(Base::FinalStroke, 0.05);
        strokes(geometry, &point).is_ok()
    }

    #[test]
    fn lengths_give_the_ratios_between_that_of_the_dead_volume_and_that_of_an_endless_column() {
        for law in [AreaLaw::Total, AreaLaw::Swept] {
            // For the last of them, under the swept area law, the ratio falls with the length.
            for (bore, rod, dead) in [(0.02, 0.0, 0.0), (0.063, 0.02, 2e-5), (0.032, 0.012, 1e-3), (0.02, 0.0, 1e-4)] {
                let geometry = Geometry::new(bore, rod, dead, law);
                let Range { start, end } = lengths_give([&(bore..=bore), &(rod..=rod), &(dead..=dead)], law);
                for fraction in [1e-6, 0.1, 0.5, 0.9, 1.0 - 1e-6] {
                    assert!(is_given(start + fraction * (end - start), &geometry), "{law:?} {bore} {dead} {fraction}");
                }
                for beyond in [start * (1.0 - 1e-9), end * (1.0 + 1e-9)] {
                    assert!(beyond <= 0.0 || !is_given(beyond, &geometry), "{law:?} {bore} {dead} {beyond}");
                }
                // For a range of chambers, the ratios of each are included.
                let of_all = lengths_give([&(0.5 * bore..=2.0 * bore), &(0.0..=rod), &(0.0..=dead)], law);
                assert!(of_all.start <= start && end <= of_all.end, "{law:?} {bore} {dead}");
            }
        }
    }
}
