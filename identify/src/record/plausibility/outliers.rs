//! Readings that are far off: spikes, left out and counted.
//!
//! Before a fit, a reading that stands out from both its neighbours; after it, a residual far from the median of those around it,
//! in units of their scatter (Hampel's identifier, J. Am. Stat. Assoc. 69 (1974) 383). Residuals are judged again whenever a
//! model with more terms changes them.

use crate::policy;
use crate::record::data::{Data, Prepared};
use crate::record::sampling::readout::Readout;
use crate::record::series::hampel::{accidental, middle_and_scatter};
use crate::record::series::scatter::{scatter, smallest_change};
use crate::record::stroke::{Phase, Segment};
use records::{DEVIATION_OF_MEDIAN, median};
use statrs::distribution::{Binomial, DiscreteCDF};
use std::borrow::Cow;
use std::cell::Cell;
use std::ops::Range;

/// A reading this many standard deviations from both its neighbours stands out.
const FROM_NEIGHBOURS: f64 = 9.0;
/// A residual this many standard deviations from the median around it is an outlier.
const FROM_MEDIAN: f64 = 6.5;
/// Steps of a sensor are smaller than this fraction of its reading.
const COARSEST_STEP: f64 = 0.02;
/// Most successive spikes at a move.
const TOGETHER: usize = 2;
/// Rows on each side that a residual is compared with.
const REACH: usize = 8;

/// No compression of a gas makes a reading this multiple of the median.
const IMPOSSIBLE: f64 = 100.0;

/// A record's pressures, Pa, with those that no gas can have replaced by the reading before them, and the rows of these. So large
/// a value would outweigh all else before it is left out.
pub fn without_impossible(pressure_pa: &[f64]) -> (Cow<'_, [f64]>, Vec<usize>) {
    let usual_pa = median(pressure_pa.to_vec());
    let most_pa = IMPOSSIBLE * usual_pa.abs();
    let rows: Vec<usize> = (0..pressure_pa.len()).filter(|row| pressure_pa[*row].abs() > most_pa).collect();
    if rows.is_empty() {
        return (Cow::Borrowed(pressure_pa), rows);
    }
    let mut filled = pressure_pa.to_vec();
    for &row in &rows {
        filled[row] = row.checked_sub(1).map_or(usual_pa, |before| filled[before]);
    }
    (Cow::Owned(filled), rows)
}

/// Rows whose pressure stands out from both neighbours by much more than these differ and than the noise, Pa.
pub fn spikes(pressure_pa: &[f64], readout: &Readout, noise_pa: f64) -> Vec<usize> {
    let rows: Vec<usize> = (0..pressure_pa.len()).filter(|&i| readout.is_data(i)).collect();
    let found: Vec<usize> = rows
        .windows(3)
        .filter(|w| stands_out([pressure_pa[w[0]], pressure_pa[w[1]], pressure_pa[w[2]]], noise_pa))
        .map(|w| w[1])
        .collect();
    accidental(found, rows.len())
}

/// Rows of a rest, the first `rest` of a record, whose pressure is far from the median of those around it, in units of their
/// scatter or of the smallest change between readings, which may be the sensor's step.
pub fn of_rest(pressure_pa: &[f64], rest: usize) -> Vec<usize> {
    let smallest_pa = smallest_change(pressure_pa);
    let own = &pressure_pa[..rest];
    let level_pa = own.iter().sum::<f64>() / rest.max(1) as f64;
    let step_pa = if smallest_pa < COARSEST_STEP * level_pa { smallest_pa } else { 0.0 };
    let rows: Vec<usize> = (0..rest).collect();
    accidental(far_from_median(&rows, own, scatter(own).max(step_pa)), rest)
}

/// Rows of each record whose residual (measured − model, Pa) is far from those around it.
///
/// At a move the model errs too, in the few rows of a fast one, if it still lacks a delay, a low-pass or an average. Rows in
/// reach of a move are outliers only if they stand out from both neighbours, alone or two together, and if the moves have no more
/// of them than the rest of the records: spikes are independent of the piston.
pub fn in_residuals(data: &Data, residuals: &[Vec<f64>]) -> Vec<Vec<usize>> {
    let noise_pa = data.noise.white_pa.max(data.noise.step_pa);
    let records: Vec<Far> = data.traces.iter().zip(residuals).map(|(t, r)| Far::of(t, r, noise_pa)).collect();
    let sum = |of: fn(&Far) -> usize| records.iter().map(of).sum::<usize>();
    let [at_moves, elsewhere] = [sum(|far| far.at_moves.len()), sum(|far| far.elsewhere.len())];
    let [known_at_moves, known_elsewhere] = [sum(|far| far.known[0]), sum(|far| far.known[1])];
    let [rows_at_moves, rows_elsewhere] = [sum(|far| far.rows[0]), sum(|far| far.rows[1])];
    let by_chance = more_at_moves(
        [at_moves + known_at_moves, elsewhere + known_elsewhere],
        rows_at_moves as f64 / (rows_at_moves + rows_elsewhere).max(1) as f64,
    );
    let of_moves_too = by_chance > policy::AT_MOVES_PROBABILITY;
    records
        .into_iter()
        .map(|far| {
            let rows = far.rows[0] + far.rows[1];
            let mut found = far.elsewhere;
            found.extend(far.at_moves.iter().filter(|_| of_moves_too));
            found.sort_unstable();
            accidental(found, rows)
        })
        .collect()
}

/// Probability of at least this many of the outliers lying at moves, which have this fraction of the rows.
fn more_at_moves([at_moves, elsewhere]: [usize; 2], share: f64) -> f64 {
    let Some(fewer) = at_moves.checked_sub(1) else { return 1.0 };
    Binomial::new(share, (at_moves + elsewhere) as u64).map_or(1.0, |binomial| binomial.sf(fewer as u64))
}

/// Readings of a record that are far from those around them.
struct Far {
    /// Those in reach of a move, alone or in pairs, ...
    at_moves: Vec<usize>,
    /// ... and those elsewhere.
    elsewhere: Vec<usize>,
    /// Numbers of spikes that were known before, at moves and elsewhere.
    known: [usize; 2],
    /// Numbers of rows examined, at moves and elsewhere.
    rows: [usize; 2],
}

impl Far {
    fn of(t: &Prepared, residual: &[f64], noise_pa: f64) -> Self {
        let is_no_data = |i: usize| t.readout.is_early(i) || t.readout.is_open(i);
        let is_looked_at =
            |i: usize| t.readout.readings.are_at(i) && !is_no_data(i) && t.spikes.binary_search(&i).is_err();
        let rows: Vec<usize> = (0..residual.len()).filter(|&i| is_looked_at(i)).collect();
        let at_moves = reach_of_moves(t, &rows);
        let far = far_from_median(&rows, residual, noise_pa);
        let is_far = |k: usize| far.binary_search(&k).is_ok();
        // Between the rows before and behind it, or the pair if the row beside it is far off too.
        let is_between_others = |k: usize| {
            let first = if k > 0 && is_far(k - 1) { k - 1 } else { k };
            let last = if is_far(k + 1) { k + 1 } else { k };
            let (Some(before), Some(after)) = (first.checked_sub(1), rows.get(last + 1)) else { return false };
            let [a, b, c] = [residual[rows[before]], residual[rows[k]], residual[*after]];
            last - first < TOGETHER && !is_far(before) && !is_far(last + 1) && stands_out([a, b, c], noise_pa)
        };
        let known_at_moves = t
            .spikes
            .iter()
            .filter(|spike| at_moves.get(rows.partition_point(|row| row < spike)).copied().unwrap_or(false))
            .count();
        let rows_at_moves = at_moves.iter().filter(|at| **at).count();
        let row = |k: &usize| rows[*k];
        Self {
            at_moves: far.iter().filter(|&&k| at_moves[k] && is_between_others(k)).map(row).collect(),
            elsewhere: far.iter().filter(|&&k| !at_moves[k]).map(row).collect(),
            known: [known_at_moves, t.spikes.len() - known_at_moves],
            rows: [rows_at_moves, rows.len() - rows_at_moves],
        }
    }
}

/// Which of these rows can be reached by an error of the model at a move that is too short for the median of [`REACH`] rows on
/// each side: it begins at most that many rows before the move, where the position is late, and ends at most twice as many after
/// it. What counts as a move may begin and end with many rows in which the piston stands: an error is no farther from the rows in
/// which it is seen to move than these are long.
fn reach_of_moves(t: &Prepared, rows: &[usize]) -> Vec<bool> {
    let mut out = vec![false; rows.len()];
    for s in t.course.motion.segments.iter().filter(|s| s.phase == Phase::Move) {
        let seen = seen_to_move(t, s);
        let first = s.first.max(seen.start.saturating_sub(seen.len()));
        let end = s.end.min(seen.end + seen.len());
        let [first, end] = [first, end].map(|of| rows.partition_point(|row| *row < of));
        out[first.saturating_sub(REACH)..(end + 2 * REACH).min(rows.len())].fill(true);
    }
    out
}

/// The rows of a move from the first that differs from its start to the last that differs from its end.
fn seen_to_move(t: &Prepared, s: &Segment) -> Range<usize> {
    /// In standard deviations of the position noise.
    const DEVIATIONS: f64 = 5.0;
    let [begin_m, end_m] = [s.from_s, s.to_s].map(|time_s| s.stroke.at(time_s, &Cell::new(0)).0);
    let least_m = DEVIATIONS * t.course.motion.noise_m;
    let differs = |row: usize, place_m: f64| (t.position_m[row] - place_m).abs() > least_m;
    let first = (s.first..s.end).find(|row| differs(*row, begin_m)).unwrap_or(s.end);
    let end = (first..s.end).rfind(|row| differs(*row, end_m)).map_or(first, |last| last + 1);
    first..end
}

/// Indices among these rows whose residual is far from the median of those around it.
fn far_from_median(rows: &[usize], residual: &[f64], noise_pa: f64) -> Vec<usize> {
    let mut around = Vec::with_capacity(2 * REACH + 1);
    let mut found = Vec::new();
    for k in 0..rows.len() {
        let near = &rows[k.saturating_sub(REACH)..(k + REACH + 1).min(rows.len())];
        let off = residual[rows[k]];
        // A cheap test first: most readings lie near their neighbours' level.
        let mean = near.iter().map(|&i| residual[i]).sum::<f64>() / near.len() as f64;
        if (off - mean).abs() < 0.8 * FROM_MEDIAN * noise_pa {
            continue;
        }
        around.clear();
        around.extend(near.iter().map(|&i| residual[i]));
        let [middle, scatter] = middle_and_scatter(&mut around);
        let scatter = (DEVIATION_OF_MEDIAN * scatter).max(noise_pa);
        if (off - middle).abs() > FROM_MEDIAN * scatter {
            found.push(k);
        }
    }
    found
}

/// Whether the middle one of three stands out from both neighbours by much more than these differ and than the noise.
fn stands_out([a, b, c]: [f64; 3], noise_pa: f64) -> bool {
    (b - a) * (b - c) > 0.0 && (b - a).abs().min((b - c).abs()) > FROM_NEIGHBOURS * noise_pa + 3.0 * (c - a).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Random, Recipe};

    /// A rig, residuals that are pure noise, and the first row of each record's first move.
    fn noise_of_a_rig() -> (Data, Vec<Vec<f64>>, Vec<usize>) {
        let data = Data::prepare(&Recipe { repeats: 2, ..Recipe::from_seed(5) }.rig()).unwrap();
        let mut random = Random::new(6);
        let noise = |t: &Prepared| t.time_s.iter().map(|_| data.noise.white_pa * random.normal()).collect();
        let residuals = data.traces.iter().map(noise).collect();
        let first_move = |t: &Prepared| t.course.motion.segments.iter().find(|s| s.phase == Phase::Move).unwrap().first;
        let moves = data.traces.iter().map(first_move).collect();
        (data, residuals, moves)
    }

    #[test]
    fn rows_in_which_a_model_misses_the_move_are_no_outliers_and_lone_spikes_there_and_elsewhere_are() {
        let (data, mut residuals, moves) = noise_of_a_rig();
        let sd_pa = data.noise.white_pa;
        for (residual, first) in residuals.iter_mut().zip(&moves) {
            residual[first + 2..first + 6].iter_mut().for_each(|r| *r += 40.0 * sd_pa);
        }
        let (at_move, at_rest) = (moves[0] + 12, residuals[1].len() - 30);
        residuals[0][at_move] -= 30.0 * sd_pa;
        residuals[1][at_rest] += 30.0 * sd_pa;
        let found = in_residuals(&data, &residuals);
        assert_eq!(found[..2], [vec![at_move], vec![at_rest]]);
        assert!(found[2..].iter().all(Vec::is_empty), "{found:?}");
    }

    #[test]
    fn two_spikes_together_are_left_out_also_in_the_quiet_end_of_what_counts_as_a_move() {
        let (mut data, mut residuals, _) = noise_of_a_rig();
        let sd_pa = data.noise.white_pa;
        let (index, quiet) = {
            let motion = &mut data.traces[0].course.motion;
            let index = motion.segments.iter().position(|s| s.phase == Phase::Move).unwrap();
            let end = motion.segments[index].end + 60;
            (motion.segments[index].end, motion.segments[index + 1].first) = (end, end);
            (index, end - 20)
        };
        assert!(data.traces[0].course.motion.segments[index].end > quiet);
        residuals[0][quiet] += 40.0 * sd_pa;
        residuals[0][quiet + 1] += 20.0 * sd_pa;
        assert_eq!(in_residuals(&data, &residuals)[0], [quiet, quiet + 1]);
    }

    #[test]
    fn two_spikes_together_at_a_move_are_left_out_and_three_rows_are_none() {
        let (data, mut residuals, moves) = noise_of_a_rig();
        let sd_pa = data.noise.white_pa;
        let at = [moves[0] + 12, moves[1] + 12];
        let spikes = [(0, 0, -300.0), (0, 1, -130.0), (1, 0, 300.0), (1, 1, 130.0), (1, 2, 60.0)];
        spikes.iter().for_each(|&(record, row, size)| residuals[record][at[record] + row] += size * sd_pa);
        // As many as elsewhere; otherwise they would depend on the moves.
        let elsewhere: Vec<usize> = (1..4).map(|k| residuals[2].len() - 20 * k).collect();
        elsewhere.iter().for_each(|row| residuals[2][*row] += 40.0 * sd_pa);
        let found = in_residuals(&data, &residuals);
        assert_eq!(found[..2], [vec![at[0], at[0] + 1], vec![]]);
        assert_eq!(found[2].len(), elsewhere.len());
    }

    #[test]
    fn lone_rows_that_are_far_off_at_move_after_move_are_no_outliers() {
        let (data, mut residuals, moves) = noise_of_a_rig();
        for (residual, first) in residuals.iter_mut().zip(&moves) {
            residual[first + 4] += 40.0 * data.noise.white_pa;
        }
        assert!(in_residuals(&data, &residuals).iter().all(Vec::is_empty));
    }

    #[test]
    fn a_reading_far_off_in_a_rest_is_found_also_where_it_is_the_first() {
        let mut random = Random::new(8);
        let mut p: Vec<f64> = (0..60).map(|_| 3e5 + 150.0 * random.normal()).collect();
        assert!(of_rest(&p, 50).is_empty());
        (p[0], p[20]) = (p[0] + 2e5, p[20] - 5e3);
        assert_eq!(of_rest(&p, 50), [0, 20]);
        // Steps of a sensor that noise reaches now and then are only steps.
        let mut steps = vec![3e5; 60];
        (steps[7], steps[30]) = (3.004e5, 3.004e5);
        assert!(of_rest(&steps, 50).is_empty());
        assert!(of_rest(&[3e5, 5e5], 1).is_empty());
        let planned = [&[5e5][..], &[3e5; 30]].concat();
        assert_eq!(of_rest(&planned, 31), [0]);
    }

    #[test]
    fn an_impossible_pressure_is_replaced_by_the_reading_before_it_and_left_out() {
        let p = [9.9e37, 2e5, 2.1e5, 3e7, -1e300, 2.2e5];
        let (filled, rows) = without_impossible(&p);
        assert_eq!((filled.as_ref(), rows), (&[2.2e5, 2e5, 2.1e5, 2.1e5, 2.1e5, 2.2e5][..], vec![0, 3, 4]));
        assert!(matches!(without_impossible(&p[1..3]), (Cow::Borrowed(_), rows) if rows.is_empty()));
    }

    #[test]
    fn lone_spikes_are_found_and_a_fast_rise_is_none() {
        let mut random = Random::new(4);
        let mut p: Vec<f64> =
            (0..400).map(|i| 1e5 + 4e3 * f64::from((i - 100).clamp(0, 20)) + 50.0 * random.normal()).collect();
        (p[60], p[300]) = (p[60] + 5e3, p[300] - 4e3);
        assert_eq!(spikes(&p, &Readout::default(), 50.0), [60, 300]);
    }
}
