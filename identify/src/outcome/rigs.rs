//! Records of two rigs under one rig file.
//!
//! Each record is fitted alone with the paper's model; where λ0 or the dead volume falls into two groups, each group is fitted. A
//! gas's behaviour depends on its state and stroke alone: where the tests of the groups overlap in both and yet need different
//! parameters, no effect of one rig is the cause.

use crate::judge::misfit;
use crate::policy::{APART, APART_FROM};
use crate::record::data::{Data, Prepared};
use crate::record::stroke::Phase;
use crate::search::baseline;
use chamber::Chamber;
use rayon::prelude::*;
use records::extremes;
use report::digits;

/// Minimum number of records in a group.
const FEWEST: usize = 2;

/// Quantities in which the tests of two groups must overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// Initial pressure and ratio of the first move's positions: effects were looked for, and none explains the difference.
    Levels,
    /// The positions themselves as well, on which an effect may depend.
    LevelsAndPositions,
}

/// The note on records that do not belong with the others; `rms_pa` is the error of the paper's model on all of them.
pub fn apart(data: &Data, rms_pa: f64, needed: Overlap) -> Option<String> {
    let floor_pa = data.noise.white_pa.max(data.noise.step_pa);
    if data.traces.len() < 2 * FEWEST || rms_pa < APART_FROM * floor_pa {
        return None;
    }
    let alone: Vec<Chamber> = (0..data.traces.len())
        .into_par_iter()
        .map(|k| fitted(data, &[k]).map(|(chamber, _)| chamber))
        .collect::<Option<_>>()?;
    let numbers: [fn(&Chamber) -> f64; 2] = [|c| c.heat_transfer.coefficient.ln(), |c| c.geometry.dead_volume];
    let mut splits: Vec<[Vec<usize>; 2]> =
        numbers.iter().map(|number| in_two(&alone.iter().map(number).collect::<Vec<_>>())).collect();
    splits.dedup();
    let apart = |split: [Vec<usize>; 2]| {
        let [one, other] = [fitted(data, &split[0])?, fitted(data, &split[1])?];
        let shares = [&split[0], &split[1]].map(|group| group.len() as f64 / data.traces.len() as f64);
        let square = shares[0] * one.1.powi(2) + shares[1] * other.1.powi(2);
        Some((square.sqrt(), split, [one.0, other.0]))
    };
    let (left_pa, split, [one, other]) = splits.into_iter().filter_map(apart).min_by(|a, b| a.0.total_cmp(&b.0))?;
    if !overlap(data, &split, needed) {
        return None;
    }
    let [few, many] = split;
    if left_pa.powi(2) - floor_pa.powi(2) > APART * (rms_pa.powi(2) - floor_pa.powi(2)) {
        return None;
    }
    let name = |k: &usize| data.traces[*k].path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let numbers = |c: &Chamber| {
        let geometry = &c.geometry;
        format!(
            "lambda0 = {} W/(m2 K) and a dead volume of {} cm3",
            digits(c.heat_transfer.coefficient, 3),
            digits(1e6 * geometry.dead_volume, 3)
        )
    };
    Some(format!(
        "{} do not fit the other {} records. Fitted separately, the paper's model errs by {} instead of {} Pa rms, with {} for these and {} for the others. Are they of another rig?",
        few.iter().map(name).collect::<Vec<_>>().join(", "),
        many.len(),
        digits(left_pa, 3),
        digits(rms_pa, 3),
        numbers(&one),
        numbers(&other),
    ))
}

/// The paper's model fitted to some records alone, and its error, Pa rms.
fn fitted(data: &Data, records: &[usize]) -> Option<(Chamber, f64)> {
    let (data, fit) = baseline::fitted(data.of_records(records)).ok()?;
    Some((fit.chamber(), misfit::rms(&data, &misfit::residuals(&data, &fit))))
}

/// Indices of the smaller and the larger group, split at the cut that leaves the least scatter within them.
fn in_two(numbers: &[f64]) -> [Vec<usize>; 2] {
    let mut order: Vec<usize> = (0..numbers.len()).collect();
    order.sort_by(|a, b| numbers[*a].total_cmp(&numbers[*b]));
    let scatter = |group: &[usize]| {
        let mean = group.iter().map(|k| numbers[*k]).sum::<f64>() / group.len() as f64;
        group.iter().map(|k| (numbers[*k] - mean).powi(2)).sum::<f64>()
    };
    let within = |cut: usize| scatter(&order[..cut]) + scatter(&order[cut..]);
    let cuts = FEWEST..=order.len() - FEWEST;
    let cut = cuts.min_by(|a, b| within(*a).total_cmp(&within(*b))).unwrap_or(FEWEST);
    let mut groups = [order[..cut].to_vec(), order[cut..].to_vec()];
    groups.iter_mut().for_each(|group| group.sort_unstable());
    groups.sort_by_key(Vec::len);
    groups
}

/// Whether the groups' tests overlap in everything on which an effect may depend: at least half of the smaller group's, and two
/// of either group's, lie within the other's range. Levels, directions or strokes of one group alone may be why it differs.
fn overlap(data: &Data, [few, many]: &[Vec<usize>; 2], needed: Overlap) -> bool {
    let tests = |group: &[usize]| group.iter().filter_map(|k| test(&data.traces[*k])).collect::<Vec<_>>();
    let [few, many] = [tests(few), tests(many)];
    let variables = if needed == Overlap::Levels { 2 } else { 3 };
    let inside = |these: &[[f64; 3]], others: &[[f64; 3]]| {
        let is_inside = |test: &&[f64; 3]| {
            (0..variables).all(|i| {
                let (low, high) = extremes(&others.iter().map(|other| other[i]).collect::<Vec<_>>());
                (low - NEARLY..=high + NEARLY).contains(&test[i])
            })
        };
        these.iter().filter(is_inside).count()
    };
    2 * inside(&few, &many) >= few.len() && inside(&few, &many) >= FEWEST && inside(&many, &few) >= FEWEST
}

/// Quantities whose logarithms differ by less are alike.
const NEARLY: f64 = 0.05;

/// Logarithms of a test's initial pressure, of the ratio of its first move's end and start positions, and of the end position.
fn test(t: &Prepared) -> Option<[f64; 3]> {
    let first = t.course.motion.segments.iter().find(|s| s.phase == Phase::Move)?;
    // For a move whose rows were lost, those on either side.
    let rows = if first.lost {
        [first.first - 1, first.end.min(t.position_m.len() - 1)]
    } else {
        [first.first, first.end - 1]
    };
    let [from, to] = rows.map(|row| t.position_m[row]);
    let test = [t.initial_pressure_pa, to / from, to].map(f64::ln);
    test.iter().all(|x| x.is_finite()).then_some(test)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Recipe;
    use records::Rig;

    /// Two rigs under one rig file: the records of the second as further experiments, or as further repeats.
    fn two_rigs(one: u64, other: u64, as_repeats: bool) -> Rig {
        let of = |seed| Recipe { repeats: 2, ..Recipe::from_seed(seed) }.rig();
        let (mut rig, others) = (of(one), of(other));
        for mut experiment in others.experiments {
            experiment.traces.iter_mut().for_each(|t| t.path = format!("other-{}", t.path.display()).into());
            match rig.experiments.iter_mut().find(|e| as_repeats && e.name == experiment.name) {
                Some(own) => own.traces.append(&mut experiment.traces),
                None => rig.experiments.push(experiment),
            }
        }
        rig
    }

    fn note(rig: &Rig) -> Option<String> {
        let (data, fit) = baseline::fitted(Data::prepare(rig).unwrap()).unwrap();
        apart(&data, misfit::rms(&data, &misfit::residuals(&data, &fit)), Overlap::Levels)
    }

    #[test]
    fn records_of_another_rig_are_named() {
        for as_repeats in [false, true] {
            let note = note(&two_rigs(1, 2, as_repeats)).expect("two rigs");
            let named = note.split(" do not fit the other").next().unwrap();
            let others = named.split(", ").filter(|name| name.starts_with("other-")).count();
            assert!(others == 0 || others == named.split(", ").count(), "{note}");
            assert_eq!(named.split(", ").count(), 10, "{note}");
        }
    }

    #[test]
    fn the_records_of_one_rig_are_one_group_whatever_effect_it_has() {
        for seed in 0..8 {
            let rig = Recipe { repeats: 2, ..Recipe::from_seed(seed) }.rig();
            assert_eq!(note(&rig), None, "{seed}");
        }
    }

    #[test]
    fn numbers_are_split_where_the_groups_scatter_least() {
        assert_eq!(in_two(&[5.0, 1.0, 5.2, 1.1, 0.9]), [vec![0, 2], vec![1, 3, 4]]);
    }
}
