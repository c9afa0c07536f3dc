//! A model on records that took no part: the error is the noise where the model is the truth, and tells where it is not.

use chamber::effects::{EffectSet, find};
use identify::Predictor;
use identify::synthetic::Recipe;
use records::OfEachRecord;

#[test]
fn the_true_model_predicts_other_records_to_their_noise() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    for whole_record in [true, false] {
        let found = identify::validate(&Predictor::of(recipe.chamber), &recipe.rig(), whole_record).unwrap().validation;
        assert!(found.rmse_pa < 1.15 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
        assert_eq!(found.records.len(), recipe.tests.len());
        assert!(found.records.iter().all(|r| (r.judged_from_s == 0.0) == whole_record && r.rows > 50));
    }
}

#[test]
fn a_model_with_another_coefficient_is_recognised_by_its_error() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(22) };
    let mut other = recipe.chamber;
    other.heat_transfer.coefficient *= 1.2;
    let found = identify::validate(&Predictor::of(other), &recipe.rig(), true).unwrap().validation;
    assert!(found.rmse_pa > 3.0 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
}

#[test]
fn a_wrong_coefficient_with_a_large_known_misfit_is_not_taken_for_a_gauge_offset() {
    let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(23) };
    for test in &mut recipe.tests {
        let (to, push_s, shape, hold_s) = test.moves[0];
        test.moves = vec![(to, 5.0 * push_s, shape, hold_s), (test.from_m, 5.0 * push_s, shape, hold_s)];
    }
    let mut other = recipe.chamber;
    other.heat_transfer.coefficient *= 1.3;
    let rig = recipe.rig();
    let known = identify::validate(&Predictor::of(other), &rig, true).unwrap().validation.rmse_pa;
    let largest_offset = |error_pa: f64| {
        let found =
            identify::validate(&Predictor { error_pa, ..Predictor::of(other) }, &rig, false).unwrap().validation;
        let own =
            found.records.iter().flat_map(|r| &r.parameters).filter(|(name, _)| name == "sensor_offset.offset_pa");
        own.map(|(_, offset)| offset.value.abs()).fold(0.0, f64::max)
    };
    let [imitating, told] = [0.0, known].map(largest_offset);
    assert!(imitating > 1e3 && told < 0.5 * imitating, "{told} {imitating}");
}

#[test]
fn a_per_record_delay_is_no_fault_of_the_model() {
    let mut late = Recipe { repeats: 1, ..Recipe::from_seed(23) };
    late.faults.pressure_delay_s = identify::synthetic::recording::Scattered { common: 0.03, between: 0.005 };
    let found = identify::validate(&Predictor::of(late.chamber), &late.rig(), true).unwrap().validation;
    assert!(found.rmse_pa < 1.5 * found.noise_pa, "{} against {}", found.rmse_pa, found.noise_pa);
}

#[test]
fn a_per_record_drift_is_refitted_to_the_whole_record() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(23) };
    let mut rig = recipe.rig();
    for (k, trace) in rig.experiments.iter_mut().flat_map(|e| &mut e.traces).enumerate() {
        let rate_pa_per_s = if k % 2 == 0 { 400.0 } else { -300.0 };
        let pressures = trace.pressure_pa.as_mut().unwrap().iter_mut();
        pressures.zip(&trace.time_s).for_each(|(pressure, time)| *pressure += rate_pa_per_s * (time - trace.time_s[0]));
    }
    let drift = find("sensor_drift").unwrap().0;
    let steady = Predictor::of(recipe.chamber);
    let of_each_record = OfEachRecord { effects: EffectSet::one(drift), ..OfEachRecord::default() };
    let drifting = Predictor { of_each_record, ..steady };
    let error_pa = |model, whole| identify::validate(model, &rig, whole).unwrap().validation.rmse_pa;
    let noise_pa = recipe.noise_rms_pa();
    assert!(error_pa(&steady, true) > 3.0 * noise_pa);
    assert!(error_pa(&drifting, true) < 1.2 * noise_pa);
    assert_eq!(error_pa(&drifting, false), error_pa(&steady, false), "a drift cannot be read off a record's start");
}

#[test]
fn initial_temperatures_are_refitted_where_they_were_per_record_in_the_model() {
    let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(23) }.with("wall_heating", &[8.0, 0.1]);
    (recipe.bench.start_warmer_k, recipe.bench.start_wall_warmer_k) = (8.0, 6.0);
    let rig = recipe.rig();
    let cold = Predictor::of(recipe.chamber);
    let of_each_record = OfEachRecord { initial_temperature: true, ..OfEachRecord::default() };
    let warm = Predictor { of_each_record, ..cold };
    let error_pa = |model, whole| identify::validate(model, &rig, whole).unwrap().validation.rmse_pa;
    let noise_pa = recipe.noise_rms_pa();
    for whole_record in [true, false] {
        let [cold, warm] = [&cold, &warm].map(|model| error_pa(model, whole_record));
        assert!(warm < 1.7 * noise_pa && cold > 2.5 * warm, "{cold} {warm} Pa, noise {noise_pa} Pa");
    }
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
    let found = identify::validate(&Predictor::of(recipe.chamber), &rig, false).unwrap().validation;
    assert_eq!((found.records[0].rmse_pa, found.records[0].rows), (None, 0));
    assert!(found.records[1..].iter().all(|r| r.rmse_pa.is_some()));
    rig.experiments.truncate(1);
    let refused = identify::validate(&Predictor::of(recipe.chamber), &rig, false).map(|_| ()).unwrap_err();
    assert!(refused.to_string().contains("ends with its first move"), "{refused}");
}

#[test]
fn a_first_reading_far_off_is_left_out_and_reported_and_does_not_change_the_result() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    let mut rig = recipe.rig();
    let of = |rig: &records::Rig| identify::validate(&Predictor::of(recipe.chamber), rig, false).unwrap().validation;
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

#[test]
fn an_averaging_window_that_fits_best_at_zero_has_the_interval_that_the_record_shows() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    let windows = |rig: &records::Rig| -> Vec<[f64; 2]> {
        let found = identify::validate(&Predictor::of(recipe.chamber), rig, true).unwrap().validation;
        let of_record = |r: identify::outcome::validation::RecordError| {
            let window = r.parameters.into_iter().find(|(name, _)| name == "position_averaging.window_s").unwrap().1;
            assert!(window.ci95[0] <= window.value && window.value <= window.ci95[1]);
            (window.value == 0.0).then_some(window.ci95)
        };
        found.records.into_iter().filter_map(of_record).collect()
    };
    let rig = recipe.rig();
    let found = windows(&rig);
    // Beforehand a window is within 1.96 times 0.06 s: the moves of 0.2 s show far less.
    assert!(
        !found.is_empty() && found.iter().all(|[low, high]| *low == 0.0 && (1e-3..0.06).contains(high)),
        "{found:?}"
    );
}
