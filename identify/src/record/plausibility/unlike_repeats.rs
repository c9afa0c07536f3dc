//! Records unlike their repeats: a reading that stood still for a while, a clipped position, a port opened in between.
//!
//! Repeats of a test show the same gas in the same course, whatever a model lacks: its residual in one of them less that in the
//! others is free of that. It contains noise, a zero and a drift of the gauge, and what makes tests differ, such as how warm the
//! wall was. A record that differs by many times as much, over the range of its pressures, has a fault that no other one has.
//! Which of two repeats is faulty is decided by a model fitted without both.

use crate::record::data::{Data, Prepared};
use crate::record::noise::polynomial_residual;
use crate::record::repeats;
use crate::record::stroke::Phase;
use records::extremes;

/// Fewest other records that show how much repeats usually differ.
const FEWEST_OTHERS: usize = 4;
/// A record is unlike its repeats if it differs by this multiple of what others do...
const TIMES: f64 = 10.0;
/// ...except for this fraction of the others, which may have faults too.
const ALL_BUT: f64 = 0.2;
/// A model fitted without two repeats shows which of them is faulty if its error in that one is this multiple of its error in the
/// other one.
const FAULTY: f64 = 2.0;
/// Number of coefficients of a zero and a drift, which each record may have.
const ZERO_AND_DRIFT: usize = 2;

/// Differences between the records of a test.
struct Test {
    /// The record that differs most from the others, or both of two.
    suspects: Vec<usize>,
    /// That difference, over the range of its pressures.
    difference: f64,
    /// Difference of each of the others from the rest of them, or of each of two from the other one.
    other_differences: Vec<f64>,
}

/// The records that are unlike their repeats, by a model's residuals in all rows, Pa; both of two that are unlike each other.
pub fn among(data: &Data, residuals: &[Vec<f64>]) -> Vec<usize> {
    let compared = (0..data.experiments.len()).filter_map(|experiment| compared(data, residuals, experiment));
    let tests: Vec<Test> = compared.collect();
    let is_unlike = |(number, test): &(usize, &Test)| {
        let is_pair = test.suspects.len() > 1;
        let tell = tests.iter().enumerate().filter(|(other, _)| !is_pair || other != number);
        let mut other_differences: Vec<f64> =
            tell.flat_map(|(_, test)| test.other_differences.iter().copied()).collect();
        if other_differences.len() < FEWEST_OTHERS {
            return false;
        }
        other_differences.sort_by(f64::total_cmp);
        let usual = other_differences[((1.0 - ALL_BUT) * (other_differences.len() - 1) as f64) as usize];
        test.difference > TIMES * usual.max(data.noise.total_pa() / range_pa(&data.traces[test.suspects[0]]))
    };
    tests.iter().enumerate().filter(is_unlike).flat_map(|(_, test)| test.suspects.iter().copied()).collect()
}

/// Compares the records of a test, if there are repeats with the same course.
fn compared(data: &Data, residuals: &[Vec<f64>], experiment: usize) -> Option<Test> {
    let noise_pa = data.noise.total_pa();
    let difference_of = |k: usize, from: &[usize]| {
        let by_noise = noise_pa * (1.0 + 1.0 / from.len() as f64).sqrt();
        (rms_difference(data, residuals, k, from).powi(2) - by_noise.powi(2)).max(0.0).sqrt()
            / range_pa(&data.traces[k])
    };
    let without = |of: &[usize], k: usize| of.iter().copied().filter(|other| *other != k).collect::<Vec<usize>>();
    let own = repeats::of(data, experiment);
    if !repeats::are_alike(&own.iter().map(|k| &data.traces[*k]).collect::<Vec<_>>()) {
        return None;
    }
    if let [one, other] = own[..] {
        let difference = difference_of(one, &[other]);
        return Some(Test { suspects: own, difference, other_differences: vec![difference; 2] });
    }
    let all = own.iter().map(|k| (*k, difference_of(*k, &without(&own, *k))));
    let (suspect, difference) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let others = without(&own, suspect);
    let other_differences = others.iter().map(|k| difference_of(*k, &without(&others, *k))).collect();
    Some(Test { suspects: vec![suspect], difference, other_differences })
}

/// Of two repeats that were left out, the one that a model fitted without them describes much better than the other one.
pub fn better_of_pairs(data: &Data, residuals: &[Vec<f64>], unlike: &[usize]) -> Vec<usize> {
    let of_test = |k: usize| data.traces[k].experiment;
    let is_pair = |pair: &&[usize]| of_test(pair[0]) == of_test(pair[1]);
    let pairs = unlike.windows(2).filter(is_pair);
    let better = pairs.filter_map(|pair| {
        let [one, other] = [pair[0], pair[1]].map(|k| at_rest_rms(&data.traces[k], &residuals[k]));
        match () {
            () if other > FAULTY * one => Some(pair[0]),
            () if one > FAULTY * other => Some(pair[1]),
            () => None,
        }
    });
    better.collect()
}

/// Root mean square of a model's residuals in the rests and holds of a record, left out or not, Pa.
fn at_rest_rms(t: &Prepared, residual: &[f64]) -> f64 {
    let held = t.course.motion.segments.iter().filter(|s| s.phase != Phase::Move);
    root_mean_square(&held.flat_map(|s| residual[s.first..s.end].iter().copied()).collect::<Vec<f64>>())
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|r| r * r).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn range_pa(t: &Prepared) -> f64 {
    let (low, high) = extremes(&t.blocks.iter().map(|b| b.mean_pa).collect::<Vec<f64>>());
    high - low
}

/// Root mean square, about a straight line in time, of a model's residual in a record less its mean residual in others, in rests
/// and holds, Pa.
fn rms_difference(data: &Data, residuals: &[Vec<f64>], record: usize, others: &[usize]) -> f64 {
    let all: Vec<usize> = [&[record], others].concat();
    let traces: Vec<&Prepared> = all.iter().map(|k| &data.traces[*k]).collect();
    let (mut times, mut differences) = (Vec::new(), Vec::new());
    for (segment, _) in traces[0].course.motion.segments.iter().enumerate().filter(|(_, s)| s.phase != Phase::Move) {
        let rows = repeats::aligned_data_rows(&traces, segment);
        let left = |k: usize, i: usize| residuals[all[k]][rows[k][i]];
        let of_others = |i: usize| (1..all.len()).map(|k| left(k, i)).sum::<f64>() / others.len() as f64;
        // Behind rows that one of them lacks, the alignment pairs rows of different times.
        let since_begin = |k: usize, i: usize| traces[k].time_s[rows[k][i]] - traces[k].time_s[rows[k][0]];
        let is_beside = |i: &usize| {
            (1..all.len()).all(|k| (since_begin(k, *i) - since_begin(0, *i)).abs() < 0.5 * traces[0].row_s())
        };
        let beside: Vec<usize> = (0..rows[0].len()).filter(is_beside).collect();
        differences.extend(beside.iter().map(|&i| left(0, i) - of_others(i)));
        times.extend(beside.iter().map(|&i| traces[0].time_s[rows[0][i]]));
    }
    root_mean_square(&polynomial_residual(&times, &differences, ZERO_AND_DRIFT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::misfit;
    use crate::outcome::recording::left_out;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use records::Rig;

    /// A rig with a leak, which the paper's model lacks, with one record changed row by row: time, s, pressure, Pa, and position,
    /// m.
    fn rig(change: impl Fn(f64, &mut f64, &mut f64)) -> Rig {
        let recipe = Recipe::from_seed(5);
        let mut rig = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]).rig();
        let trace = &mut rig.experiments[1].traces[0];
        let pressure_pa = trace.pressure_pa.as_mut().unwrap();
        for ((t, p), x) in trace.time_s.iter().zip(pressure_pa).zip(&mut trace.position_m) {
            change(*t, p, x);
        }
        rig
    }

    /// The records left out of the fit of the paper's model, and what the user is told.
    fn left_out_of(rig: &Rig) -> (Vec<usize>, Vec<String>) {
        let (data, _) = baseline::fitted(Data::prepare(rig).unwrap()).unwrap();
        let is_left_out = |k: &usize| data.traces[*k].readout.unlike_others.is_some();
        ((0..data.traces.len()).filter(is_left_out).collect(), left_out(&data))
    }

    #[test]
    fn a_record_whose_reading_stands_still_is_left_out_and_named_and_the_fit_is_that_without_it() {
        let frozen = rig(|t, p, _| *p = if (1.0..2.5).contains(&t) { 4.5e5 } else { *p });
        let (records, notes) = left_out_of(&frozen);
        assert_eq!(records, [3]);
        assert!(notes.iter().any(|note| note.contains("differs from that of the other repeats")), "{notes:?}");
        let (_, fit) = baseline::fitted(Data::prepare(&frozen).unwrap()).unwrap();
        let mut two = rig(|_, _, _| ());
        two.experiments[1].traces.remove(0);
        let (_, right) = baseline::fitted(Data::prepare(&two).unwrap()).unwrap();
        let lambda0 = |fit: &crate::fit::Fit| fit.chamber().heat_transfer.coefficient;
        assert!((lambda0(&fit) / lambda0(&right) - 1.0).abs() < 1e-3, "{} {}", lambda0(&fit), lambda0(&right));
    }

    #[test]
    fn of_two_repeats_the_one_whose_reading_stands_still_is_left_out() {
        for faulty in 0..2 {
            let mut two = rig(|t, p, _| *p = if (1.0..2.5).contains(&t) { 4.5e5 } else { *p });
            two.experiments.iter_mut().for_each(|test| test.traces.truncate(2));
            two.experiments[1].traces.swap(0, faulty);
            assert_eq!(left_out_of(&two).0, [2 + faulty]);
        }
        let mut two = rig(|_, _, _| ());
        two.experiments.iter_mut().for_each(|test| test.traces.truncate(2));
        assert!(left_out_of(&two).0.is_empty());
    }

    #[test]
    fn a_record_whose_position_is_clipped_is_left_out() {
        let ends = rig(|_, _, _| ());
        let position_m = &ends.experiments[1].traces[0].position_m;
        let (low, high) = extremes(position_m);
        let clipped_m = low + 0.2 * (high - low);
        assert_eq!(left_out_of(&rig(|_, _, x| *x = x.max(clipped_m))).0, [3]);
    }

    #[test]
    fn zeros_drifts_and_small_differences_of_records_leave_none_out() {
        assert!(left_out_of(&rig(|_, _, _| ())).0.is_empty());
        assert!(left_out_of(&rig(|t, p, _| *p += 3000.0 + 500.0 * t)).0.is_empty());
        assert!(left_out_of(&rig(|t, p, _| *p += 300.0 * (2.0 * t).sin())).0.is_empty());
    }

    #[test]
    fn a_difference_between_all_repeats_leaves_none_of_them_out() {
        let data = Data::prepare(&rig(|_, _, _| ())).unwrap();
        let (data, fit) = baseline::fitted(data).unwrap();
        let mut residuals = misfit::residuals(&data, &fit);
        // Gas that begins somewhat warmer or colder, differently in each record.
        for (k, residual) in residuals.iter_mut().enumerate() {
            let warm_pa = 0.01 * range_pa(&data.traces[k]) * [1.0, 0.4, -1.2, 0.7, 1.9][k % 5];
            residual.iter_mut().zip(&data.traces[k].time_s).for_each(|(r, t)| *r += warm_pa * (-t / 0.7).exp());
        }
        assert!(among(&data, &residuals).is_empty());
        residuals[4].iter_mut().zip(&data.traces[4].time_s).for_each(|(r, t)| *r += 1e5 * (-t / 0.7).exp());
        assert_eq!(among(&data, &residuals), [4]);
    }

    #[test]
    fn a_single_test_of_three_repeats_does_not_show_that_one_is_unlike_the_others() {
        let mut frozen = rig(|t, p, _| *p = if (1.0..2.5).contains(&t) { 4.5e5 } else { *p });
        frozen.experiments = vec![frozen.experiments.swap_remove(1)];
        assert!(left_out_of(&frozen).0.is_empty());
    }
}
