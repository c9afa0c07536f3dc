//! Records that are not like their repeats: a reading that stood still for a while, a clipped position, a port opened in between.
//!
//! Repeats of a test show the same gas in the same course, whatever a model lacks: what it leaves of one of them less what it leaves of the
//! others is free of that. There is noise in it, a zero and a drift of the gauge, and what makes tests differ, such as how warm the
//! wall was. A record that differs by many times as much, over the range of its pressures, has a fault that no other one has.

use super::data::{Data, Prepared};
use super::noise::polynomial_residual;
use super::repeats;
use super::stroke::Phase;
use records::extremes;

/// Repeats that tell which of them is unlike the others.
const FEWEST_REPEATS: usize = 3;
/// Records that tell how much repeats differ.
const FEWEST_OTHERS: usize = 4;
/// A record is unlike its repeats if it differs by so many times as much as others do...
const TIMES: f64 = 10.0;
/// ...all but this share of them, which may have faults too.
const ALL_BUT: f64 = 0.2;
/// Coefficients of a zero and a drift, which a record may have for itself.
const ZERO_AND_DRIFT: usize = 2;

/// The records that are unlike their repeats, by what a model leaves of the rows of all, Pa.
pub fn among(data: &Data, residuals: &[Vec<f64>]) -> Vec<usize> {
    let noise_pa = data.noise.total_pa();
    let differs = |k: usize, from: &[usize]| {
        let by_noise = noise_pa * (1.0 + 1.0 / from.len() as f64).sqrt();
        (differs_by(data, residuals, k, from).powi(2) - by_noise.powi(2)).max(0.0).sqrt() / range_pa(&data.traces[k])
    };
    let without = |of: &[usize], k: usize| of.iter().copied().filter(|other| *other != k).collect::<Vec<usize>>();
    // Of each test the record that differs most from the others, and how much these differ without it.
    let (mut suspects, mut usual) = (Vec::new(), Vec::new());
    for experiment in 0..data.experiments.len() {
        let own = repeats::of(data, experiment);
        let traces: Vec<&Prepared> = own.iter().map(|k| &data.traces[*k]).collect();
        if own.len() < FEWEST_REPEATS || !repeats::are_alike(&traces) {
            continue;
        }
        let each = own.iter().map(|k| (*k, differs(*k, &without(&own, *k))));
        let Some(suspect) = each.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let others = without(&own, suspect.0);
        usual.extend(others.iter().map(|k| differs(*k, &without(&others, *k))));
        suspects.push(suspect);
    }
    if usual.len() < FEWEST_OTHERS {
        return Vec::new();
    }
    usual.sort_by(f64::total_cmp);
    let usual = usual[((1.0 - ALL_BUT) * (usual.len() - 1) as f64) as usize];
    let is_unlike = |(k, differs): &(usize, f64)| *differs > TIMES * usual.max(noise_pa / range_pa(&data.traces[*k]));
    suspects.into_iter().filter(is_unlike).map(|(k, _)| k).collect()
}

fn range_pa(t: &Prepared) -> f64 {
    let (low, high) = extremes(&t.blocks.iter().map(|b| b.mean_pa).collect::<Vec<f64>>());
    high - low
}

/// Root mean square of what a model leaves of a record less the mean of what it leaves of others, in rests and holds, about a straight line
/// in time, Pa.
fn differs_by(data: &Data, residuals: &[Vec<f64>], record: usize, others: &[usize]) -> f64 {
    let all: Vec<usize> = [&[record], others].concat();
    let traces: Vec<&Prepared> = all.iter().map(|k| &data.traces[*k]).collect();
    let (mut times, mut differences) = (Vec::new(), Vec::new());
    for (segment, _) in traces[0].course.motion.segments.iter().enumerate().filter(|(_, s)| s.phase != Phase::Move) {
        let rows = repeats::data_beside_each_other(&traces, segment);
        let left = |k: usize, i: usize| residuals[all[k]][rows[k][i]];
        let of_others = |i: usize| (1..all.len()).map(|k| left(k, i)).sum::<f64>() / others.len() as f64;
        differences.extend((0..rows[0].len()).map(|i| left(0, i) - of_others(i)));
        times.extend(rows[0].iter().map(|row| traces[0].time_s[*row]));
    }
    let rest = polynomial_residual(&times, &differences, ZERO_AND_DRIFT);
    (rest.iter().map(|r| r * r).sum::<f64>() / rest.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::misfit;
    use crate::outcome::recording::left_out;
    use crate::search::baseline;
    use crate::synthetic::Recipe;
    use records::Rig;

    /// A rig with a leak, which the paper's model lacks, one record of which is changed row by row: time, s, pressure, Pa, and position, m.
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

    /// The records that are left out of the fit of the paper's model, and what the user is told.
    fn left_out_of(rig: &Rig) -> (Vec<usize>, Vec<String>) {
        let (data, _) = baseline::fitted(Data::prepare(rig).unwrap()).unwrap();
        let is_left_out = |k: &usize| data.traces[*k].readout.unlike_repeats.is_some();
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
    fn what_all_repeats_differ_by_leaves_none_of_them_out() {
        let data = Data::prepare(&rig(|_, _, _| ())).unwrap();
        let (data, fit) = baseline::fitted(data).unwrap();
        let mut residuals = misfit::residuals(&data, &fit);
        // Gas that begins as much warmer or colder, differently in each record.
        for (k, residual) in residuals.iter_mut().enumerate() {
            let warm_pa = 0.01 * range_pa(&data.traces[k]) * [1.0, 0.4, -1.2, 0.7, 1.9][k % 5];
            residual.iter_mut().zip(&data.traces[k].time_s).for_each(|(r, t)| *r += warm_pa * (-t / 0.7).exp());
        }
        assert!(among(&data, &residuals).is_empty());
        residuals[4].iter_mut().zip(&data.traces[4].time_s).for_each(|(r, t)| *r += 1e5 * (-t / 0.7).exp());
        assert_eq!(among(&data, &residuals), [4]);
    }

    #[test]
    fn a_single_test_of_three_repeats_tells_of_none_that_it_is_unlike_the_others() {
        let mut frozen = rig(|t, p, _| *p = if (1.0..2.5).contains(&t) { 4.5e5 } else { *p });
        frozen.experiments = vec![frozen.experiments.swap_remove(1)];
        assert!(left_out_of(&frozen).0.is_empty());
    }
}
