//! Data that cannot be what it should be, found before anything is fitted.

use crate::error::Error;
use crate::record::lattice;
use crate::record::readout::Readout;
use crate::record::scatter::scatter;
use crate::record::stroke::{Motion, Phase, Segment};
use crate::record::unit::Declared;
use records::{Cylinder, Line, Trace, correlation, extremes, median, turned_back};
use std::iter;
use std::ops::Range;
use std::path::Path;

/// Fewest rows of a trace.
pub const FEWEST_ROWS: usize = 20;
/// A move of less than this share of the travel may leave a coarse sensor where it is.
const SHORT_MOVE: f64 = 0.05;
/// A run of equal extreme readings this long is a sensor at the end of its range...
const LONGEST_HONEST_RUN: usize = 5;
/// ...if the noise moves its readings: one of less than so many steps may leave them where they are.
const STEPS_OF_NOISE: f64 = 0.6;
/// Share of the changes from reading to reading that turn back from which on noise makes them: white noise turns
/// two of three back, and a gas none between two moves.
const TURNED_BACK: f64 = 0.05;

/// Pressures that a pneumatic chamber can have on the whole, Pa.
const PLAUSIBLE_PRESSURE_PA: std::ops::RangeInclusive<f64> = 1e3..=1e8;
/// A piston that goes so many bores away from the chamber's end is that of a rodless cylinder, whose stroke a rig states, or its
/// positions are in another unit.
const LONGEST_STROKE_IN_BORES: f64 = 100.0;
/// Units that positions are recorded in beside metres, m, ...
const POSITION_UNITS_M: [(&str, f64); 3] = [("mm", 1e-3), ("cm", 1e-2), ("in", 0.0254)];
/// ...and how far the piston of a usual cylinder goes, in bores.
const USUAL_STROKE_IN_BORES: std::ops::RangeInclusive<f64> = 0.3..=30.0;

/// Enough rows?
pub fn rows(trace: &Trace) -> Result<(), Error> {
    if trace.time_s.len() < FEWEST_ROWS {
        return Err(Error::TooFewSamples { trace: trace.path.clone(), rows: trace.time_s.len(), least: FEWEST_ROWS });
    }
    Ok(())
}

/// A move, a pressure that answers it the right way round, and a sensor within its range?
pub fn trace(
    trace: &Trace,
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    declared: Declared,
    cylinder: &Cylinder,
) -> Result<(), Error> {
    let path = || trace.path.clone();
    level(&trace.path, pressure_pa, declared)?;
    stroke(trace, cylinder)?;
    let (low, high) = extremes(&trace.position_m);
    if !motion.segments.iter().any(|s| s.phase == Phase::Move) || high - low < 20.0 * motion.noise_m {
        return Err(Error::NoMove { trace: path(), range_m: high - low, noise_m: motion.noise_m });
    }
    let (least, most) = extremes(pressure_pa);
    if most - least < 0.1 * (high - low) / high.abs().max(low.abs()) * least {
        let units = if low > 0.0 { declared.of_answer((least, most), high / low) } else { Vec::new() };
        return Err(Error::ConstantPressure { trace: path(), range_pa: most - least, stroke_m: high - low, units });
    }
    saturation(trace, pressure_pa, motion, readout, (least, most))?;
    closed(trace, pressure_pa, motion, readout)?;
    let correlation = correlation(&trace.position_m, pressure_pa);
    if correlation > 0.5 {
        return Err(Error::WrongSign { trace: path(), correlation });
    }
    Ok(())
}

/// Pressures of a trace that no cylinder on a bench has: the unit of their column is wrong.
///
/// # Errors
/// [`Error::ImplausiblePressure`] with the units that would make compressed air of them.
pub fn level(trace: &Path, pressure_pa: &[f64], declared: Declared) -> Result<(), Error> {
    if pressure_pa.is_empty() {
        return Ok(());
    }
    let median_pa = median(pressure_pa.to_vec());
    if !PLAUSIBLE_PRESSURE_PA.contains(&median_pa) {
        let units = declared.of_level(median_pa);
        return Err(Error::ImplausiblePressure { trace: trace.to_owned(), median_pa, units });
    }
    Ok(())
}

/// Positions that no cylinder of that bore has, where the rig does not state so long a stroke: their unit is wrong, or the bore's.
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

/// A run of readings equal to the record's extreme while the piston moves, or in a record whose noise moves every row. Where noise
/// does not move the readings, gas in equilibrium gives equal ones too, and those of a late sensor go on into the move: then such
/// a run lasts from the start of a move for longer than that.
fn saturation(
    trace: &Trace,
    pressure_pa: &[f64],
    motion: &Motion,
    readout: &Readout,
    (least, most): (f64, f64),
) -> Result<(), Error> {
    let rows: Vec<usize> = (0..pressure_pa.len()).filter(|&i| readout.is_data(i)).collect();
    let equal = rows.windows(2).filter(|w| pressure_pa[w[0]] == pressure_pa[w[1]]).count();
    let still = equal as f64 / (rows.len() - 1).max(1) as f64;
    let way = |rows: Range<usize>| {
        let (low, high) = extremes(&trace.position_m[rows]);
        high - low
    };
    let travel = way(0..trace.position_m.len());
    for (extreme, high) in [(most, true), (least, false)] {
        let run = longest_run(&rows, pressure_pa, extreme);
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else { continue };
        let noisy = !readings_stick(&rows, pressure_pa, first..last + 1)
            && turned_back(rows.iter().map(|&row| pressure_pa[row])) > TURNED_BACK;
        let moves = motion.segments.iter().any(|s| {
            let inside = first.max(s.first)..(last + 1).min(s.end);
            let stroke = way(s.first..s.end);
            s.phase == Phase::Move
                && stroke > SHORT_MOVE * travel
                && inside.len() >= LONGEST_HONEST_RUN * readout.period
                && way(inside) > 0.1 * stroke
                && (noisy || last + 1 > first.max(s.first) + (s.end - s.first))
        });
        if run.len() >= LONGEST_HONEST_RUN && (moves || (still < 0.2 && noisy && run.len() > 2 * LONGEST_HONEST_RUN)) {
            let from_s = trace.time_s[first];
            return Err(Error::Saturated {
                trace: trace.path.clone(),
                rows: run.len(),
                from_s,
                value_pa: extreme,
                high,
            });
        }
    }
    Ok(())
}

/// Where the piston comes back to a place, the pressure does too: a change by more than what the holds' own slopes make of it,
/// once the gas has settled, is gas that came or went.
fn closed(trace: &Trace, pressure_pa: &[f64], motion: &Motion, readout: &Readout) -> Result<(), Error> {
    /// Fewest readings of a rest or hold that is looked at.
    const FEWEST: usize = 10;
    /// Places within this share of the position are the same.
    const SAME_PLACE: f64 = 0.01;
    /// A change beyond this share, with nothing to be seen in between, is an open port.
    const OPENED: f64 = 0.05;
    let is_same = |a: f64, b: f64| (b / a - 1.0).abs() < SAME_PLACE;
    // Readings and position of each rest and hold. A stop shorter than the move before it, such as a point where the piston turns,
    // has no place: what the gas exchanged in the move has not settled in it. How fast it loses gas may show there all the same.
    let lasts = |s: &Segment| s.to_s - s.from_s;
    let before = iter::once(None).chain(motion.segments.iter().map(Some));
    let place = |s: &Segment| trace.position_m[s.first..s.end].iter().sum::<f64>() / (s.end - s.first) as f64;
    let still: Vec<(Vec<usize>, Option<f64>)> = before
        .zip(&motion.segments)
        .filter(|(_, s)| s.phase != Phase::Move)
        .map(|(before, s)| (s, before.is_none_or(|before| lasts(s) >= lasts(before))))
        .map(|(s, settles)| ((s.first..s.end).filter(|&row| readout.is_data(row)).collect(), settles.then(|| place(s))))
        .filter(|(rows, _): &(Vec<usize>, _)| rows.len() >= FEWEST)
        .collect();
    let are_same = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| is_same(a, b));
    if !still.iter().enumerate().any(|(i, (_, place))| still[i + 1..].iter().any(|(_, other)| are_same(*place, *other)))
    {
        return Ok(());
    }
    // In a short hold the readings of a coarse sensor may all be equal although the gas relaxes.
    let changes = pressure_pa.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|change| *change > 0.0);
    let step_pa = changes.fold(f64::INFINITY, f64::min);
    // End, position, and the line that the pressure tends to.
    let ends: Vec<(f64, Option<f64>, Line)> = still
        .into_iter()
        .map(|(rows, place)| {
            let of = |column: &[f64]| rows.iter().map(|&row| column[row]).collect::<Vec<f64>>();
            let time_s = of(&trace.time_s);
            let mut line = Line::towards(&time_s, &of(pressure_pa));
            let (begin_s, end_s) = extremes(&time_s);
            line.slope_error = line.slope_error.max(step_pa / (end_s - begin_s));
            (end_s, place, line)
        })
        .collect();
    let relative = |line: &Line| (line.slope.abs() + 2.0 * line.slope_error) / line.mean;
    for (i, (from_s, place, before)) in ends.iter().enumerate() {
        let mut drift = relative(before);
        for (to_s, other, after) in &ends[i + 1..] {
            drift = drift.max(relative(after));
            let change = after.at(*to_s) / before.at(*from_s) - 1.0;
            if are_same(*place, *other) && change.abs() > OPENED.max(drift * (to_s - from_s)) {
                return Err(Error::PortOpened { trace: trace.path.clone(), from_s: *from_s, to_s: *to_s, change });
            }
        }
    }
    Ok(())
}

/// Whether the noise is too small to move readings, but for those of a run, off the sensor's steps.
fn readings_stick(rows: &[usize], pressure_pa: &[f64], run: Range<usize>) -> bool {
    let beside: Vec<f64> = rows.iter().filter(|row| !run.contains(row)).map(|&row| pressure_pa[row]).collect();
    scatter(&beside) < STEPS_OF_NOISE * lattice::of_changes(&beside, 1e-9)
}

/// The longest run of that value.
fn longest_run<'a>(rows: &'a [usize], values: &[f64], of: f64) -> &'a [usize] {
    let (mut best, mut length) = (0..0, 0);
    for (k, &i) in rows.iter().enumerate() {
        length = if values[i] == of { length + 1 } else { 0 };
        if length > best.len() {
            best = k + 1 - length..k + 1;
        }
    }
    &rows[best]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn white_noise_turns_changes_back_and_a_gas_does_not() {
        let rows: Vec<usize> = (0..400).collect();
        let mut random = Random::new(33);
        let relaxing = |i: usize| if i < 100 { 1e5 } else { 1e5 + 2e5 * (-((i - 100) as f64) / 60.0).exp() };
        let noisy: Vec<f64> = rows.iter().map(|&i| relaxing(i) + 50.0 * random.normal()).collect();
        assert!(turned_back(noisy) > 3.0 * TURNED_BACK);
        let smooth: Vec<f64> = rows.iter().map(|&i| (relaxing(i) * 1e4).round() * 1e-4).collect();
        assert!(turned_back(smooth) < 0.2 * TURNED_BACK);
    }

    #[test]
    fn readings_stick_where_the_noise_is_small_against_the_steps() {
        let sticks = |noise_pa: f64| {
            let mut random = Random::new(31);
            let rows: Vec<usize> = (0..300).collect();
            let relaxing = |i: usize| 3e5 + 2e5 * (-(i as f64) / 60.0).exp();
            let rounded = |p: f64| (p / 390.6).round() * 390.6;
            let p: Vec<f64> = rows.iter().map(|&i| rounded(relaxing(i) + noise_pa * random.normal())).collect();
            readings_stick(&rows, &p, 290..300)
        };
        assert!(sticks(20.0) && sticks(80.0));
        assert!(!sticks(400.0));
        let mut random = Random::new(32);
        let unrounded: Vec<f64> = (0..300).map(|_| 3e5 + 80.0 * random.normal()).collect();
        assert!(!readings_stick(&(0..300).collect::<Vec<usize>>(), &unrounded, 0..0));
    }
}
