//! Gaps: rows that a logger lost while the piston moved.
//!
//! A time step far longer than those around it hides what the piston did in it: a smooth curve through the rows on either side
//! may be off by metres per second. Behind the gap the volume is known again, and so is the gas's mass, which a closed chamber
//! keeps; only the heat exchanged in the gap is not. The stroke in a gap is therefore any that the piston may have made, and the
//! gas's temperature at its end is a per-record parameter ([`crate::parameters::RecordSlot::BehindGap`]). A few rows on either
//! side are not data either: there a sensor that is late, or lags, shows what happened in the gap.
//! Position in m, time in s.

use crate::policy;
use crate::record::far_off::from_to;
use crate::record::stroke::position_noise::position_noise;
use crate::record::stroke::positions::Positions;
use crate::record::stroke::smoothed::Held;
use crate::record::stroke::{Motion, Phase, Segment, Spline};
use records::{LineNumbers, extremes, median};
use std::cell::Cell;
use std::ops::Range;
use std::path::Path;

/// Most gaps of a record: what follows a further one is left out.
pub const MOST: usize = 4;
/// A part with fewer rows between two gaps, or behind the last one, belongs to them.
const FEWEST_ROWS: usize = 20;
/// A part with fewer readings of the position shows no stroke.
const FEWEST_READINGS: usize = 12;
/// Rows before and behind a gap that are not data: a model that lacks a delay or a lag errs there.
const AROUND: [usize; 2] = [8, 16];
/// Time steps on either side that a longer one is compared with.
const STEPS_BESIDE: usize = 15;
/// Rows that show the piston's speed before a gap and behind it.
const ROWS_OF_SPEED: usize = 4;
/// A displacement of this many standard deviations of the position noise is real.
const DEVIATIONS: f64 = 5.0;

/// The stroke of a record, determined separately on either side of its gaps.
pub fn motion(time_s: &[f64], position_m: &[f64], positions: &Positions) -> Motion {
    let parts = parts(time_s, position_m, positions);
    // A record whose first part shows no stroke is not divided.
    if parts.first().is_none_or(|first| first.start > 0 || first.end == time_s.len()) {
        return Motion::through(time_s, position_m, positions);
    }
    // A part may have too few rows at rest to show the noise.
    let noise_m = position_noise(&positions.readings(position_m));
    let travel = extremes(position_m);
    let mut whole: Option<Motion> = None;
    for rows in parts {
        let of_part = positions.of_rows(&rows);
        let mut part = Motion::through_in(&time_s[rows.clone()], &position_m[rows.clone()], &of_part, noise_m);
        for segment in &mut part.segments {
            (segment.first, segment.end) = (segment.first + rows.start, segment.end + rows.start);
        }
        let Some(before) = &mut whole else {
            whole = Some(part);
            continue;
        };
        if part.segments[0].phase == Phase::Rest {
            part.segments[0].phase = Phase::Hold;
        }
        let gap = before.rows()..rows.start;
        before.segments.push(lost(gap, course([at_end(before), at_begin(&part)], travel)));
        before.segments.append(&mut part.segments);
    }
    let mut whole = whole.unwrap_or_else(|| Motion::through(time_s, position_m, positions));
    let (rows, last) = (whole.rows(), time_s.len() - 1);
    if rows <= last {
        let from = at_end(&whole);
        let stroke = Spline::line([from.time_s, time_s[last]], [from.position_m, position_m[last]]);
        whole.segments.push(lost(rows..time_s.len(), stroke));
    }
    whole
}

/// A lost part of a record, with the stroke assumed for it.
fn lost(rows: Range<usize>, stroke: Spline) -> Segment {
    let (from_s, to_s) = stroke.ends();
    Segment { phase: Phase::Move, lost: true, first: rows.start, end: rows.end, from_s, to_s, stroke, shift_s: 0.0 }
}

/// The stroke assumed in a gap: a cubic that joins the speeds on both sides, which are halved until it stays within the range of
/// the record's positions; else a straight line.
fn course([from, to]: [Held; 2], (low, high): (f64, f64)) -> Spline {
    /// Distance by which the piston may leave that range, as a fraction of it.
    const OUT: f64 = 0.02;
    const HALVINGS: i32 = 8;
    const LOOKED_AT: u32 = 32;
    let (times, positions) = ([from.time_s, to.time_s], [from.position_m, to.position_m]);
    let out_m = OUT * (high - low);
    let stays = |curve: &Spline| {
        let near = Cell::new(0);
        let moments = (1..LOOKED_AT).map(|k| times[0] + (times[1] - times[0]) * f64::from(k) / f64::from(LOOKED_AT));
        moments.map(|t| curve.at(t, &near).0).all(|x| (low - out_m..high + out_m).contains(&x))
    };
    let curves = (0..HALVINGS).map(|k| {
        let part = 0.5f64.powi(k);
        Spline::through(times.to_vec(), positions.to_vec(), [Some(part * from.speed), Some(part * to.speed)])
    });
    { curves }.find(stays).unwrap_or_else(|| Spline::line(times, positions))
}

fn at_end(part: &Motion) -> Held {
    held(&part.segments[part.segments.len() - 1], part.extent().1)
}

fn at_begin(part: &Motion) -> Held {
    held(&part.segments[0], part.extent().0)
}

fn held(segment: &Segment, time_s: f64) -> Held {
    let (position_m, speed) = segment.stroke.at(time_s, &Cell::new(0));
    Held { time_s, position_m, speed, at_once: false }
}

/// The gaps that have rows behind them.
pub fn of(motion: &Motion) -> impl Iterator<Item = &Segment> {
    let all_but_last = &motion.segments[..motion.segments.len() - 1];
    all_but_last.iter().filter(|s| s.lost)
}

/// Rows that are not data because of a motion's gaps.
pub fn rows(motion: &Motion) -> Vec<Range<usize>> {
    let [before, behind] = AROUND;
    let lost = motion.segments.iter().filter(|s| s.lost);
    lost.map(|s| s.first.saturating_sub(before)..s.end + behind).collect()
}

/// States the gaps of a record in a sentence that gives the lines around them and the seconds; `None` without any.
pub fn sentence(path: &Path, motion: &Motion, lines: &LineNumbers, time_s: &[f64]) -> Option<String> {
    let gap = |s: &Segment| from_to([s.first - 1, s.end.min(time_s.len() - 1)], lines, time_s);
    let gaps: Vec<String> = motion.segments.iter().filter(|s| s.lost).map(gap).collect();
    (!gaps.is_empty()).then(|| {
        format!(
            "{}: rows are missing while the piston moves ({} after the first row). Its course in such a gap is not known: the gas's temperature at the end of the gap is fitted, and the rows next to the gap are left out",
            path.display(),
            gaps.join("; ")
        )
    })
}

/// The parts of a record between its gaps that have enough rows.
fn parts(time_s: &[f64], position_m: &[f64], positions: &Positions) -> Vec<Range<usize>> {
    let cuts = cuts(time_s, position_m);
    let begins = std::iter::once(0).chain(cuts.iter().copied());
    let ends = cuts.iter().copied().chain([time_s.len()]);
    let is_enough = |rows: &Range<usize>| rows.len() >= FEWEST_ROWS && positions.in_rows(rows).len() >= FEWEST_READINGS;
    let parts = begins.zip(ends).map(|(begin, end)| begin..end);
    parts.filter(is_enough).take(MOST + 1).collect()
}

/// Rows before which others were lost while the piston moved.
fn cuts(time_s: &[f64], position_m: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = median(steps.clone());
    // Most steps are no longer than that, and are not examined further.
    let is_long = |k: &usize| {
        steps[*k] > policy::GAP_STEPS * usual && {
            let beside = [k.saturating_sub(STEPS_BESIDE)..*k, k + 1..(k + 1 + STEPS_BESIDE).min(steps.len())];
            beside.into_iter().all(|steps_beside| steps[*k] > policy::GAP_STEPS * median(steps[steps_beside].to_vec()))
        }
    };
    let long: Vec<usize> = (FEWEST_ROWS - 1..steps.len()).filter(is_long).collect();
    if long.is_empty() {
        return long;
    }
    let (low, high) = extremes(position_m);
    let least_m = DEVIATIONS * std::f64::consts::SQRT_2 * position_noise(position_m);
    let moves = |k: &usize| {
        let travel_m = |from: usize, to: usize| {
            let travel_m = (position_m[to] - position_m[from]).abs();
            if travel_m > least_m { travel_m } else { 0.0 }
        };
        // The displacement in the gap, or the one that the speed on either side would make there.
        let extrapolated_m = |from: usize, to: usize| travel_m(from, to) * steps[*k] / (time_s[to] - time_s[from]);
        let before = extrapolated_m(k - ROWS_OF_SPEED, *k);
        let to = (k + 1 + ROWS_OF_SPEED).min(time_s.len() - 1);
        let behind = if to > k + 1 { extrapolated_m(k + 1, to) } else { 0.0 };
        travel_m(*k, k + 1).max(before).max(behind) > policy::GAP_TRAVEL * (high - low)
    };
    long.into_iter().filter(moves).map(|k| k + 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    /// 0.1 m to 0.05 m from 1 s on in 0.4 s, and back from 3 s on.
    fn stroke(time: f64) -> f64 {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let travel = |begin: f64| smooth(((time - begin) / 0.4).clamp(0.0, 1.0));
        0.1 - 0.05 * (travel(1.0) - travel(3.0))
    }

    /// Five seconds at 100 Hz without the rows in these stretches, s.
    fn recorded(without: &[Range<f64>]) -> (Vec<f64>, Vec<f64>) {
        let mut random = Random::new(2);
        let rows = (0..500).map(|i| 0.01 * f64::from(i)).map(|t| (t, stroke(t) + 4e-6 * random.normal()));
        rows.filter(|(t, _)| !without.iter().any(|gap| gap.contains(t))).unzip()
    }

    fn motion_of(without: &[Range<f64>]) -> (Vec<f64>, Motion) {
        let (time_s, position_m) = recorded(without);
        let motion = motion(&time_s, &position_m, &Positions::of(&position_m));
        (time_s, motion)
    }

    #[test]
    fn a_gap_over_a_move_is_a_separate_segment_and_the_rows_around_it_are_no_data() {
        let (time_s, motion) = motion_of(&[0.905..1.555]);
        let gaps: Vec<&Segment> = of(&motion).collect();
        let [gap] = gaps[..] else { panic!("{} gaps", gaps.len()) };
        assert_eq!((gap.from_s, gap.to_s), (time_s[90], time_s[91]));
        assert_eq!((gap.first, gap.end), (91, 91));
        assert_eq!(rows(&motion).first(), Some(&(83..107)));
        let phases: Vec<(Phase, bool)> = motion.segments.iter().map(|s| (s.phase, s.lost)).collect();
        let [rest, hold] = [Phase::Rest, Phase::Hold].map(|phase| (phase, false));
        assert_eq!(phases, [rest, (Phase::Move, true), hold, (Phase::Move, false), hold]);
        assert_eq!(motion.rows(), time_s.len());
        let near = Cell::new(0);
        assert!((gap.stroke.at(gap.to_s, &near).0 - 0.05).abs() < 4e-6);
    }

    #[test]
    fn the_stroke_on_either_side_of_a_gap_is_followed_as_far_as_there_are_rows() {
        let (_, motion) = motion_of(&[1.155..1.305]);
        let near = Cell::new(0);
        for t in [1.05, 1.1, 1.15, 1.31, 1.35] {
            let at = motion.segments[motion.segment_at(t)].stroke.at(t, &near).0;
            assert!((at - stroke(t)).abs() < 2e-5, "{t}: {at} {}", stroke(t));
        }
        assert_eq!(of(&motion).count(), 1);
    }

    #[test]
    fn the_begin_of_a_move_is_found_though_a_gap_leaves_few_uneven_rows_before_it() {
        // 0.25 s at rest, then accelerating for 0.2 s.
        let stroke = |t: f64| {
            let u = (t - 0.25).max(0.0);
            0.36 - if u < 0.2 { 0.9 * u * u } else { 0.36 * (u - 0.1) }
        };
        let stroke = |t: f64| if t < 1.2 { stroke(t) } else { stroke(1.2) };
        let mut random = Random::new(4);
        let rows = (0..300).map(|i| 0.02 * f64::from(i) + 0.006 * random.normal()).collect::<Vec<f64>>();
        let rows = rows.into_iter().filter(|t| !(0.67..1.05).contains(t));
        let (time_s, position_m): (Vec<f64>, Vec<f64>) = rows.map(|t| (t, stroke(t) + 8e-6 * random.normal())).unzip();
        let motion = motion(&time_s, &position_m, &Positions::of(&position_m));
        assert_eq!(of(&motion).count(), 1);
        let near = Cell::new(0);
        for t in time_s.into_iter().filter(|t| (0.1..0.67).contains(t)) {
            let at = motion.segments[motion.segment_at(t)].stroke.at(t, &near).0;
            assert!((at - stroke(t)).abs() < 4e-5, "{t}: {at} {}", stroke(t));
        }
    }

    #[test]
    fn the_stroke_assumed_in_a_gap_joins_smoothly_and_stays_within_the_travel() {
        let sine = |t: f64| 0.1 + 0.03 * (2.0 * t).sin();
        let rows = (0..600).map(|i| 0.01 * f64::from(i)).filter(|t| !(1.505..1.905).contains(t));
        let (time_s, position_m): (Vec<f64>, Vec<f64>) = rows.map(|t| (t, sine(t))).unzip();
        let near = Cell::new(0);
        let whole = motion(&time_s, &position_m, &Positions::of(&position_m));
        let [gap] = of(&whole).collect::<Vec<_>>()[..] else { panic!("no gap") };
        for t in [1.55, 1.7, 1.85] {
            assert!((gap.stroke.at(t, &near).0 - sine(t)).abs() < 3e-4, "{t}");
        }
        // From the speed of a move to rest: without a limit it would go far beyond the rest position.
        let (_, motion) = motion_of(&[1.205..1.9]);
        let [gap] = of(&motion).collect::<Vec<_>>()[..] else { panic!("no gap") };
        let farthest = (0..70).map(|k| gap.stroke.at(1.2 + 0.01 * f64::from(k), &near).0).fold(f64::INFINITY, f64::min);
        assert!(farthest > 0.05 - 0.0011, "{farthest}");
    }

    #[test]
    fn a_gap_while_the_piston_rests_and_a_few_lost_rows_of_a_move_change_nothing() {
        for without in [vec![2.0..2.5], vec![1.195..1.225], vec![1.095..1.105, 1.155..1.175, 3.095..3.125]] {
            let (time_s, position_m) = recorded(&without);
            let positions = Positions::of(&position_m);
            assert_eq!(motion(&time_s, &position_m, &positions), Motion::through(&time_s, &position_m, &positions));
        }
    }

    #[test]
    fn a_piston_that_moves_and_returns_within_a_gap_counts_as_moving() {
        let (time_s, position_m): (Vec<f64>, Vec<f64>) =
            (0..600).map(|i| 0.01 * f64::from(i)).map(|t| (t, 0.1 + 0.03 * (4.0 * t).sin())).unzip();
        // Around a turning point.
        let (turn, lost) = (std::f64::consts::PI * 1.125, 0.2);
        let (time_s, position_m): (Vec<f64>, Vec<f64>) =
            time_s.into_iter().zip(position_m).filter(|(t, _)| (t - turn).abs() > lost).unzip();
        assert_eq!(cuts(&time_s, &position_m).len(), 1);
    }

    #[test]
    fn few_rows_between_two_gaps_or_behind_the_last_one_belong_to_them() {
        let (time_s, motion) = motion_of(&[0.905..1.205, 1.285..1.605, 3.205..4.915]);
        let lost: Vec<Range<usize>> = motion.segments.iter().filter(|s| s.lost).map(|s| s.first..s.end).collect();
        assert_eq!(lost.len(), 2);
        assert_eq!((lost[0].len(), lost[1].end), (8, time_s.len()));
        assert_eq!(of(&motion).count(), 1);
        assert_eq!(motion.rows(), time_s.len());
    }

    #[test]
    fn sparse_rows_while_the_piston_rests_are_no_gap() {
        let rows = |t: &f64| !(1.5..2.9).contains(t) || ((t * 100.0).round() as usize).is_multiple_of(20);
        let (time_s, position_m): (Vec<f64>, Vec<f64>) =
            (0..500).map(|i| 0.01 * f64::from(i)).filter(rows).map(|t| (t, stroke(t))).unzip();
        assert!(cuts(&time_s, &position_m).is_empty());
    }

    #[test]
    fn a_gap_is_named_by_the_lines_and_seconds_around_it() {
        let (time_s, motion) = motion_of(&[0.905..1.555]);
        let lines: LineNumbers = (0..time_s.len()).map(|row| row + 2).collect();
        let said = sentence(Path::new("a.csv"), &motion, &lines, &time_s).unwrap();
        assert!(said.starts_with("a.csv: rows are missing while the piston moves (lines 92 to 93, 0.900 s to 1.560 s"));
        let said = sentence(Path::new("a.csv"), &motion, &LineNumbers::default(), &time_s).unwrap();
        assert!(said.contains("(0.900 s to 1.560 s after the first row)"));
        assert_eq!(sentence(Path::new("a.csv"), &motion_of(&[]).1, &lines, &time_s), None);
    }
}
