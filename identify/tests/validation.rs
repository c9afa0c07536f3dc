//! A model on records that took no part: the error is the noise where the model is the truth, and tells where it is not.

use identify::synthetic::Recipe;

#[test]
fn the_true_model_predicts_other_records_to_their_noise() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    for whole_record in [true, false] {
        let found = identify::validate(&recipe.chamber, 0.0, &recipe.rig(), whole_record).unwrap().validation;
        assert!(found.rmse_pa < 1.15 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
        assert_eq!(found.records.len(), recipe.tests.len());
        assert!(found.records.iter().all(|r| (r.judged_from_s == 0.0) == whole_record && r.rows > 50));
    }
}

#[test]
fn a_model_with_another_coefficient_is_told_by_its_error() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(22) };
    let mut other = recipe.chamber;
    other.heat_transfer.coefficient *= 1.2;
    let found = identify::validate(&other, 0.0, &recipe.rig(), true).unwrap().validation;
    assert!(found.rmse_pa > 3.0 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
}

#[test]
fn a_wrong_coefficient_that_is_known_to_leave_much_is_not_taken_for_an_offset_of_the_gauge() {
    let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(23) };
    for test in &mut recipe.tests {
        let (to, push_s, shape, hold_s) = test.moves[0];
        test.moves = vec![(to, 5.0 * push_s, shape, hold_s), (test.from_m, 5.0 * push_s, shape, hold_s)];
    }
    let mut other = recipe.chamber;
    other.heat_transfer.coefficient *= 1.3;
    let rig = recipe.rig();
    let known = identify::validate(&other, 0.0, &rig, true).unwrap().validation.rmse_pa;
    let largest_offset = |error_pa: f64| {
        let found = identify::validate(&other, error_pa, &rig, false).unwrap().validation;
        let own =
            found.records.iter().flat_map(|r| &r.parameters).filter(|(name, _)| name == "sensor_offset.offset_pa");
        own.map(|(_, offset)| offset.value.abs()).fold(0.0, f64::max)
    };
    let [imitating, told] = [0.0, known].map(largest_offset);
    assert!(imitating > 1e3 && told < 0.5 * imitating, "{told} {imitating}");
}

#[test]
fn a_delay_of_each_record_is_its_own_and_no_fault_of_the_model() {
    let mut late = Recipe { repeats: 1, ..Recipe::from_seed(23) };
    late.faults.pressure_delay_s = identify::synthetic::recording::Scattered { common: 0.03, between: 0.005 };
    let found = identify::validate(&late.chamber, 0.0, &late.rig(), true).unwrap().validation;
    assert!(found.rmse_pa < 1.5 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
}

#[test]
fn records_that_end_with_their_first_move_are_refused_and_one_among_others_has_no_error() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    let mut rig = recipe.rig();
    let first = &mut rig.experiments[0].traces[0];
    let moved = first.position_m.iter().position(|x| (x - first.position_m[0]).abs() > 0.01).unwrap();
    first.time_s.truncate(moved);
    first.position_m.truncate(moved);
    first.pressure_pa.as_mut().unwrap().truncate(moved);
    first.ambient_temperature_k = None;
    let found = identify::validate(&recipe.chamber, 0.0, &rig, false).unwrap().validation;
    assert_eq!((found.records[0].rmse_pa, found.records[0].rows), (None, 0));
    assert!(found.records[1..].iter().all(|r| r.rmse_pa.is_some()));
    rig.experiments.truncate(1);
    let refused = identify::validate(&recipe.chamber, 0.0, &rig, false).map(|_| ()).unwrap_err();
    assert!(refused.to_string().contains("ends with its first move"), "{refused}");
}

#[test]
fn a_first_reading_far_off_is_left_out_and_named_and_changes_nothing() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    let mut rig = recipe.rig();
    let of = |rig: &records::Rig| identify::validate(&recipe.chamber, 0.0, rig, false).unwrap().validation;
    let without = of(&rig);
    assert!(without.notes.is_empty(), "{:?}", without.notes);
    rig.experiments[0].traces[0].pressure_pa.as_mut().unwrap()[0] += 2e5;
    let with = of(&rig);
    assert!((with.rmse_pa / without.rmse_pa - 1.0).abs() < 0.02, "{} {}", with.rmse_pa, without.rmse_pa);
    assert!(
        with.notes[0].ends_with("one reading far off is left out (0.000 s after the first row)"),
        "{:?}",
        with.notes
    );
}
