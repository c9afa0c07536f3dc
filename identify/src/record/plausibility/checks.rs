//! Implausible data, found before anything is fitted.

use super::saturation::{self, End};
use crate::error::Error;
use crate::record::sampling::readout::Readout;
use crate::record::series::scatter::smallest_change;
use crate::record::stroke::{Motion, Phase, Segment};
use crate::record::unit::Declared;
use records::{Cylinder, Line, Trace, correlation, extremes, median};
use std::iter;
use std::path::Path;

/// Fewest rows of a trace.
pub const FEWEST_ROWS: usize = 20;

/// Plausible median pressures of a pneumatic chamber, Pa.
const PLAUSIBLE_PRESSURE_PA: std::ops::RangeInclusive<f64> = 1e3..=1e8;
/// A piston this many bores from the chamber's end belongs to a rodless cylinder, whose stroke the rig states, or its positions
/// are in another unit.
const LONGEST_STROKE_IN_BORES: f64 = 100.0;
/// Units other than metres that positions are recorded in, m, ...
const POSITION_UNITS_M: [(&str, f64); 3] = [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254)];
/// ...and how far the piston of a usual cylinder travels, in bores.
const USUAL_STROKE_IN_BORES: std::ops::RangeInclusive<f64> = 0.3..=30.0;

/// Checks that the trace has enough rows.
pub fn rows(trace: &Trace) -> Result<(), Error> {
    if trace.time_s.len() < FEWEST_ROWS {
        return Err(Error::TooFewSamples { trace: trace.path.clone(), rows: trace.time_s.len(), least: FEWEST_ROWS });
    }
    Ok(())
}

/// Checks that there is a move and that the pressure responds to it with the right sign. Returns the ends of the sensor's range
/// that the trace shows.
pub fn trace(
    trace: &Trace,
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    declared: Declared,
    cylinder: &Cylinder,
) -> Result<Vec<End>, Error> {
    let path = || trace.path.clone();
    level(&trace.path, pressure_pa, declared)?;
    stroke(trace, cylinder)?;
    let (low, high) = extremes(&trace.position_m);
    if !motion.segments.iter().any(|s| s.phase == Phase::Move) || high - low < 20.0 * motion.noise_m {
        return Err(Error::NoMove { trace: path(), range_m: high - low, noise_m: motion.noise_m });
    }
    let (least, most) = extremes(pressure_pa);
    if most - least < 0.1 * (high - low) / high.abs().max(low.abs()) * least {
        let units = if low > 0.0 { declared.units_by_response((least, most), high / low) } else { Vec::new() };
        return Err(Error::ConstantPressure { trace: path(), range_pa: most - least, stroke_m: high - low, units });
    }
    let ends = saturation::ends(trace, pressure_pa, motion, readout);
    let ends_pa: Vec<f64> = ends.iter().map(|end| end.value_pa).collect();
    let saturated = saturation::rows_at(&ends_pa, pressure_pa);
    closed(trace, pressure_pa, motion, &Readout { saturated, ..readout.clone() })?;
    let correlation = correlation(&trace.position_m, pressure_pa);
    if correlation > 0.5 {
        return Err(Error::WrongSign { trace: path(), correlation });
    }
    Ok(ends)
}

/// Rejects pressures that no cylinder on a bench has: the unit of their column is wrong.
///
/// # Errors
/// [`Error::ImplausiblePressure`] with the units in which they would be those of compressed air.
pub fn level(trace: &Path, pressure_pa: &[f64], declared: Declared) -> Result<(), Error> {
    if pressure_pa.is_empty() {
        return Ok(());
    }
    let median_pa = median(pressure_pa.to_vec());
    if !PLAUSIBLE_PRESSURE_PA.contains(&median_pa) {
        let units = declared.units_by_level(median_pa);
        return Err(Error::ImplausiblePressure { trace: trace.to_owned(), median_pa, units });
    }
    Ok(())
}

/// Rejects positions that no cylinder of this bore reaches, unless the rig states the stroke: their unit or the bore's is wrong.
fn stroke(trace: &Trace, cylinder: &Cylinder) -> Result<(), Error> {
    let (low, high) = extremes(&trace.position_m);
    let (reach_m, bore_m) = (high.max(-low), cylinder.bore_m);
    if cylinder.stroke_m.is_some() || reach_m <= LONGEST_STROKE_IN_BORES * bore_m {
        return Ok(());
    }
    let is_usual = |unit_m: f64| USUAL_STROKE_IN_BORES.contains(&(reach_m * unit_m / bore_m));
    let units = POSITION_UNITS_M.iter().filter(|(_, unit_m)| is_usual(*unit_m)).map(|(unit, _)| *unit).collect();
    Err(Error::ImplausibleStroke { trace: trace.path.clone(), reach_m, bore_m, units })
}

/// Rejects a trace in which the piston returns to a place but the pressure does not: once the gas has settled, a change beyond
/// what the holds' own slopes account for is gas that entered or left.
fn closed(trace: &Trace, pressure_pa: &[f64], motion: &Motion, readout: &Readout) -> Result<(), Error> {
    /// Fewest readings of a rest or hold that is compared.
    const FEWEST: usize = 10;
    /// Positions within this fraction of each other are the same place.
    const SAME_PLACE: f64 = 0.01;
    /// A change beyond this fraction that the drift of the holds does not account for is an open port.
    const OPENED: f64 = 0.05;
    let is_same = |a: f64, b: f64| (b / a - 1.0).abs() < SAME_PLACE;
    // Readings and position of each rest and hold. A stop shorter than the move before it, such as a turning point, gets no
    // position: what the gas exchanged in the move has not settled in it. It may still show how fast gas is lost.
    let lasts = |s: &Segment| s.to_s - s.from_s;
    let before = iter::once(None).chain(motion.segments.iter().map(Some));
    let position = |s: &Segment| trace.position_m[s.first..s.end].iter().sum::<f64>() / (s.end - s.first) as f64;
    let still: Vec<(Vec<usize>, Option<f64>)> = before
        .zip(&motion.segments)
        .filter(|(_, s)| s.phase != Phase::Move)
        .map(|(before, s)| (s, before.is_none_or(|before| lasts(s) >= lasts(before))))
        .map(|(s, settles)| {
            ((s.first..s.end).filter(|&row| readout.is_data(row)).collect(), settles.then(|| position(s)))
        })
        .filter(|(rows, _): &(Vec<usize>, _)| rows.len() >= FEWEST)
        .collect();
    let are_same = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| is_same(a, b));
    if !still
        .iter()
        .enumerate()
        .any(|(i, (_, position))| still[i + 1..].iter().any(|(_, other)| are_same(*position, *other)))
    {
        return Ok(());
    }
    // In a short hold the readings of a coarse sensor may all be equal although the gas relaxes.
    let step_pa = smallest_change(pressure_pa);
    // End time, position, and the line to which the pressure tends.
    let ends: Vec<(f64, Option<f64>, Line)> = still
        .into_iter()
        .map(|(rows, position)| {
            let of = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
            let time_s = of(&trace.time_s);
            let mut line = Line::towards(&time_s, &of(pressure_pa));
            let (begin_s, end_s) = extremes(&time_s);
            line.slope_error = line.slope_error.max(step_pa / (end_s - begin_s));
            (end_s, position, line)
        })
        .collect();
    // Two parts of one hold are not a return.
    let leaves = |position: Option<f64>, from_s: f64, to_s: f64| {
        let between = trace.time_s.partition_point(|t| *t <= from_s)..trace.time_s.partition_point(|t| *t < to_s);
        position.is_some_and(|position| trace.position_m[between].iter().any(|x| !is_same(position, *x)))
    };
    let relative = |line: &Line| (line.slope.abs() + 2.0 * line.slope_error) / line.mean;
    for (i, (from_s, position, before)) in ends.iter().enumerate() {
        let mut drift = relative(before);
        for (to_s, other, after) in &ends[i + 1..] {
            drift = drift.max(relative(after));
            let change = after.at(*to_s) / before.at(*from_s) - 1.0;
            let is_open = change.abs() > OPENED.max(drift * (to_s - from_s));
            if is_open && are_same(*position, *other) && leaves(*position, *from_s, *to_s) {
                return Err(Error::PortOpened { trace: trace.path.clone(), from_s: *from_s, to_s: *to_s, change });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;

    /// Whether a port seems to be open if the piston is pushed from 0.1 m to 0.05 m and, from 1.0 s on, goes `away` m from there
    /// for 0.2 s, while the pressure falls by the fraction `rate` per second in the holds and by `change` between them.
    fn seems_open(away: f64, rate: f64, change: f64) -> bool {
        let goes = |t: f64, from_s: f64, to_s: f64| ((t - from_s) / (to_s - from_s)).clamp(0.0, 1.0);
        let time_s: Vec<f64> = (0..2000).map(|row| 0.001 * f64::from(row)).collect();
        let position_m: Vec<f64> = time_s
            .iter()
            .map(|t| 0.1 - 0.05 * goes(*t, 0.1, 0.2) + away * (goes(*t, 1.0, 1.05) - goes(*t, 1.15, 1.2)))
            .collect();
        let held = |t: f64| 1.0 - rate * (t.min(1.0) - 0.2 + (t - 1.2).max(0.0)) - change * goes(t, 1.0, 1.04);
        let pressure_pa: Vec<f64> =
            time_s.iter().zip(&position_m).map(|(t, x)| if *t < 0.2 { 1e4 / x } else { 1e4 / x * held(*t) }).collect();
        let trace = Trace { time_s, position_m, ..Recipe::from_seed(5).rig().experiments[0].traces[0].clone() };
        let motion = Motion::detect(&trace.time_s, &trace.position_m);
        assert!(motion.segments.iter().filter(|s| s.phase == Phase::Hold).count() > 1);
        closed(&trace, &pressure_pa, &motion, &Readout::default()).is_err()
    }

    #[test]
    fn pressure_that_is_lost_during_an_excursion_of_the_piston_shows_an_open_port() {
        assert!(seems_open(0.03, 0.0, 0.1));
        assert!(!seems_open(0.03, 0.0, 0.02));
    }

    #[test]
    fn two_parts_of_one_hold_show_no_open_port_whatever_the_pressure_does_in_between() {
        assert!(!seems_open(0.0003, 0.0, 0.1));
    }

    #[test]
    fn a_leak_that_the_holds_show_is_no_open_port_and_one_three_times_as_large_between_them_is() {
        let while_away = |times: f64| seems_open(0.03, 0.05, 0.05 * (times - 0.8));
        assert!(!while_away(1.0));
        assert!(while_away(3.0));
    }
}
