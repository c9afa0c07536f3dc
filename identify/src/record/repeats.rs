//! Repeats of one experiment, aligned row by row.
//!
//! Rests are aligned at their ends. Holds are aligned by the time since the piston had completed half of its travel: where the
//! piston or its sensor creeps to its place, the number of rows that count as the end of a move depends on the positions' noise,
//! and a relaxation compared with a later part of itself would look like pressure noise.

use crate::record::data::{Data, Prepared};
use crate::record::stroke::Phase;

/// Indices of an experiment's records among all records, without those unlike the others.
pub fn of(data: &Data, experiment: usize) -> Vec<usize> {
    let is_one = |t: &Prepared| t.experiment == experiment && t.readout.unlike_others.is_none();
    (0..data.traces.len()).filter(|&k| is_one(&data.traces[k])).collect()
}

/// Whether these records, at least two, have the same sequence of segments.
pub fn are_alike(traces: &[&Prepared]) -> bool {
    let phases = |t: &Prepared| t.course.motion.segments.iter().map(|s| s.phase).collect::<Vec<_>>();
    traces.len() > 1 && traces.iter().all(|t| phases(t) == phases(traces[0]))
}

/// The data rows of a segment of alike records, aligned, the same number of each.
pub fn aligned_data_rows(traces: &[&Prepared], segment: usize) -> Vec<Vec<usize>> {
    let rows = |t: &&Prepared| -> Vec<usize> {
        let own = &t.course.motion.segments[segment];
        (own.first..own.end).filter(|row| t.readout.is_data(*row)).collect()
    };
    aligned_rows(traces, segment, &traces.iter().map(rows).collect::<Vec<_>>())
}

/// The aligned rows of a segment of alike records, the same number of each, chosen from `rows`, those of each record in order.
pub fn aligned_rows(traces: &[&Prepared], segment: usize, rows: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let is_rest = traces[0].course.motion.segments[segment].phase == Phase::Rest;
    let shortest = |rows: &[Vec<usize>]| rows.iter().map(Vec::len).min().unwrap_or(0);
    let length = shortest(rows);
    if is_rest {
        return rows.iter().map(|own| own[own.len() - length..].to_vec()).collect();
    }
    let halves: Option<Vec<usize>> = traces.iter().map(|t| half_of_the_move_before(t, segment)).collect();
    let latest = halves.and_then(|halves| {
        let after = |(half, own): (&usize, &Vec<usize>)| own.first().map(|first| first.saturating_sub(*half));
        let begin = halves.iter().zip(rows).filter_map(after).max()?;
        let from = |(half, own): (usize, &Vec<usize>)| own.iter().copied().filter(|i| *i >= half + begin).collect();
        Some(halves.into_iter().zip(rows).map(from).collect::<Vec<Vec<usize>>>())
    });
    // A hold of which another repeat counts most as a move is compared from its start.
    let kept = latest.filter(|kept| 2 * shortest(kept) >= length).unwrap_or_else(|| rows.to_vec());
    let length = shortest(&kept);
    kept.into_iter().map(|own| own[..length].to_vec()).collect()
}

/// The row at which half of the travel is completed in the move before a segment, if there is one.
fn half_of_the_move_before(t: &Prepared, segment: usize) -> Option<usize> {
    let before = &t.course.motion.segments[segment.checked_sub(1)?];
    if before.phase != Phase::Move {
        return None;
    }
    let x = &t.position_m[before.first..before.end];
    let steps = || x.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let half = 0.5 * steps().sum::<f64>();
    let mut gone = 0.0;
    let rows = steps().take_while(|step| {
        gone += step;
        gone < half
    });
    Some(before.first + rows.count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;

    #[test]
    fn holds_are_aligned_by_travel_where_a_move_of_one_repeat_seems_to_last_longer() {
        let data = Data::prepare(&Recipe { repeats: 2, ..Recipe::from_seed(5) }.rig()).unwrap();
        let mut traces: Vec<Prepared> = of(&data, 0).into_iter().map(|k| data.traces[k].clone()).collect();
        assert_eq!(traces.len(), 2);
        let [half, other] = [0, 1].map(|k| half_of_the_move_before(&traces[k], 2).unwrap());
        let segments = &mut traces[1].course.motion.segments;
        segments[1].end += 40;
        segments[2].first += 40;
        let traces: Vec<&Prepared> = traces.iter().collect();
        let hold = |k: usize| (traces[k].course.motion.segments[2].first..traces[k].time_s.len()).collect::<Vec<_>>();
        let beside = aligned_rows(&traces, 2, &[hold(0), hold(1)]);
        assert_eq!([beside[0].len(), beside[1].len()], [hold(1).len(); 2]);
        assert!(beside[0].iter().zip(&beside[1]).all(|(a, b)| a - half == b - other));
        // Of a hold that ends before the other begins, nothing would be left.
        let short = hold(0)[..30].to_vec();
        assert_eq!(aligned_rows(&traces, 2, &[short.clone(), hold(1)]), [short, hold(1)[..30].to_vec()]);
    }
}
