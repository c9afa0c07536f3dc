//! Rows that a logger lost while the piston moved: what it did there is not known, and what is known of the gas behind it is.

use chamber::effects;
use identify::Predictor;
use identify::outcome::diagnosis::Diagnosis;
use identify::outcome::validation;
use identify::parameters::Model;
use identify::record::data::Data;
use identify::record::reconstruction::gaps;
use identify::search::baseline;
use identify::synthetic::{Recipe, Shape};
use records::{Rig, Trace, Verdict};
use std::ops::Range;

/// Every test goes there and back, so that each gap has records of the same move whole.
fn there_and_back(seed: u64) -> Recipe {
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(seed) };
    for test in &mut recipe.tests {
        let (_, _, _, hold_s) = test.moves[0];
        test.moves.push((test.from_m, 0.3, Shape::Quintic, hold_s));
    }
    recipe
}

/// The trace without the rows of this stretch, s from its first row.
fn lose(trace: &mut Trace, stretch: Range<f64>) {
    let kept: Vec<bool> = trace.time_s.iter().map(|t| !stretch.contains(&(t - trace.time_s[0]))).collect();
    let of = |column: &mut Vec<f64>| {
        let mut kept = kept.iter();
        column.retain(|_| *kept.next().unwrap());
    };
    of(&mut trace.time_s);
    of(&mut trace.position_m);
    trace.pressure_pa.iter_mut().for_each(of);
    trace.ambient_temperature_k.iter_mut().for_each(of);
    trace.lines.retain(&kept);
}

/// When the second move of a test begins and ends, s.
fn second_move(recipe: &Recipe, test: usize) -> [f64; 2] {
    let moves = &recipe.tests[test].moves;
    let begin = recipe.rest_s + moves[0].1 + moves[0].3;
    [begin, begin + moves[1].1]
}

/// The rig where the first repeat of each test lost rows: all of its second move, its start, its middle or its end.
fn with_gaps(recipe: &Recipe) -> Rig {
    let mut rig = recipe.rig();
    for (k, experiment) in rig.experiments.iter_mut().enumerate() {
        let [begin, end] = second_move(recipe, k);
        let stretch =
            [begin - 0.2..end + 0.2, begin - 0.3..begin + 0.15, begin + 0.1..end - 0.1, end - 0.12..end + 0.4];
        lose(&mut experiment.traces[0], stretch[k % 4].clone());
    }
    rig
}

fn diagnosis(rig: &Rig) -> Diagnosis {
    identify::diagnose(rig, &|_, _| ()).unwrap().diagnosis
}

fn holds(d: &Diagnosis, recipe: &Recipe) -> bool {
    let (name, lambda0) = &d.after.parameters[0];
    assert_eq!(name, "lambda0_w_per_m2_k");
    (lambda0.ci95[0]..lambda0.ci95[1]).contains(&recipe.chamber.heat_transfer.coefficient)
}

#[test]
fn clean_rigs_with_gaps_over_moves_are_adequate_and_their_coefficient_is_right() {
    for seed in [5, 6] {
        let recipe = there_and_back(seed);
        let found = diagnosis(&with_gaps(&recipe));
        assert_eq!(found.verdict, Verdict::Adequate, "{seed}: {:?}", found.effects);
        assert!(holds(&found, &recipe), "{seed}: {:?}", found.after.parameters[0]);
        let told = found.assumptions.iter().filter(|note| note.contains("rows are missing while the piston moves"));
        assert_eq!(told.count(), 5);
        assert!(!found.assumptions.iter().any(|note| note.contains("check it")), "{:?}", found.assumptions);
    }
}

#[test]
fn an_effect_gets_its_name_beside_gaps() {
    for (seed, effect) in [(7, "leakage"), (8, "wall_heating"), (9, "record_delay")] {
        let (e, _) = effects::find(effect).unwrap();
        let found = diagnosis(&with_gaps(&there_and_back(seed).with_strength(e, 1.0)));
        assert_eq!((found.verdict, found.effects), (Verdict::Explained, vec![effect]));
    }
}

#[test]
fn one_record_alone_with_a_gap_over_a_move_is_adequate() {
    let mut recipe = Recipe { repeats: 1, ..there_and_back(11) };
    recipe.tests.truncate(1);
    let found = diagnosis(&with_gaps(&recipe));
    assert_eq!(found.verdict, Verdict::Adequate, "{:?}", found.effects);
    assert!(holds(&found, &recipe), "{:?}", found.after.parameters[0]);
}

#[test]
fn a_row_or_two_lost_in_a_move_and_a_gap_in_a_hold_change_next_to_nothing() {
    let recipe = there_and_back(5);
    let whole = diagnosis(&recipe.rig());
    let mut rig = recipe.rig();
    for (k, experiment) in rig.experiments.iter_mut().enumerate() {
        let [begin, end] = second_move(&recipe, k);
        lose(&mut experiment.traces[0], begin + 0.095..begin + 0.115);
        lose(&mut experiment.traces[1], end + 0.6..end + 0.9);
    }
    let found = diagnosis(&rig);
    assert_eq!((found.verdict, whole.verdict), (Verdict::Adequate, Verdict::Adequate));
    assert!(holds(&found, &recipe));
    assert!(!found.assumptions.iter().any(|note| note.contains("rows are missing")));
    let [found, whole] = [&found, &whole].map(|d| d.after.parameters[0].1.value);
    assert!((found / whole - 1.0).abs() < 2e-3, "{found} {whole}");
}

#[test]
fn a_validation_compares_the_rows_before_a_gap_or_fits_the_temperature_behind_it() {
    let mut recipe = there_and_back(5);
    recipe.tests.truncate(2);
    let (whole, rig) = (recipe.rig(), with_gaps(&recipe));
    let validated = |rig: &Rig, all| validation::validate(&Predictor::of(recipe.chamber), rig, all).unwrap().validation;
    let noise = recipe.noise_rms_pa();
    for all in [false, true] {
        let [with, without] = [&rig, &whole].map(|rig| validated(rig, all));
        assert!(with.rmse_pa < 1.1 * noise && without.rmse_pa < 1.1 * noise, "{} {}", with.rmse_pa, without.rmse_pa);
        let [gapped, as_it_was] = [&with, &without].map(|v| v.records[0].rows);
        assert_eq!(gapped < as_it_was / 2 + 100, !all, "{gapped} {as_it_was}");
        assert_eq!(with.notes.iter().filter(|note| note.contains("are not compared")).count(), usize::from(!all));
    }
}

#[test]
fn the_gas_keeps_its_mass_through_a_gap() {
    let recipe = there_and_back(5);
    let (data, fit) = baseline::fitted(Data::prepare(&with_gaps(&recipe)).unwrap()).unwrap();
    assert_eq!(fit.hypothesis.model, Model::PAPER);
    let of_first_test = [&data.traces[0], &data.traces[1]];
    assert_eq!(of_first_test.map(|t| gaps::of(&t.course.motion).count()), [1, 0]);
    let [with, without] = of_first_test.map(|t| fit.hypothesis.record_axes(t).len());
    assert_eq!(with, without + 1);
    let t = of_first_test[0];
    let mut mass = Vec::new();
    let setting = fit.setting(t, &fit.records[0]);
    let run = identify::fit::run(t, &setting, fit.hypothesis.model.effects);
    run.disturbed(&t.time_s, &identify::forward::Undisturbed, |_, kg| mass.push(kg)).unwrap();
    assert!(mass.iter().all(|kg| (kg / mass[0] - 1.0).abs() < 1e-9));
}
