//! The geometry of a row: bore and strokes, solved for where the volume-to-area ratio is given.

use crate::quantity::Base;
use crate::quantity::point::Point;
use crate::result::status::Failure;
use chamber::{AreaLaw, Geometry};
use std::ops::RangeInclusive;

/// Largest and smallest bore that a volume-to-area ratio is solved for, m.
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

/// Strokes before and after the push, m: solved for in their proportion where the volume-to-area ratio is given at a
/// bore. The area grows in proportion to the volume, so that the volume follows from a linear equation.
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

/// Gas volume over heat transfer area at a stroke.
fn ratio(geometry: &Geometry, stroke: f64) -> f64 {
    let volume = geometry.volume(stroke);
    volume / geometry.heat_transfer_area(volume)
}

/// The volume-to-area ratios that bores give, at a rod, a dead volume and a stroke.
pub fn bores_give([rod, dead_volume, stroke]: [f64; 3], area_law: AreaLaw) -> RangeInclusive<f64> {
    /// Between bores so far apart the ratio changes by less than a hundredth of a per cent at its greatest.
    const STEP: f64 = 1.01;
    /// Of the ratio, for the greatest between two bores.
    const SLACK: f64 = 1e-4;
    let least = least_bore(rod);
    let steps = ((BORES_M.1 / least).ln() / STEP.ln()).ceil().max(0.0) as i32;
    let bores = (0..=steps).map(|k| (least * STEP.powi(k)).min(BORES_M.1));
    let ratios = bores.map(|bore| ratio(&Geometry::new(bore, rod, dead_volume, area_law), stroke));
    let (low, high) = ratios.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), r| (low.min(r), high.max(r)));
    low * (1.0 - SLACK)..=high * (1.0 + SLACK)
}

/// The smallest bore that is looked at, with that rod.
fn least_bore(rod: f64) -> f64 {
    BORES_M.0.max(rod * (1.0 + 1e-12))
}

/// The bore that gives a volume-to-area ratio: of several, the one nearest to `near` on a logarithmic scale.
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

/// A root between two bores at which the sign differs: regula falsi with the Illinois rule.
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
