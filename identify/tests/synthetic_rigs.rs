//! The tracing on rigs that do not exist: other geometries and strengths than the labelled cases have.

use chamber::card::{ActsOn, Tried};
use chamber::effects::{self, WallHeating};
use chamber::simulate::Start;
use identify::fit::covariance;
use identify::forward::{Correction, Run, Undisturbed};
use identify::parameters::{RecordStart, names};
use identify::record::data::Data;
use identify::search::{self, Found, Verdict, baseline};
use identify::synthetic::recording::{self, Disturbance, Scattered};
use identify::synthetic::{Outside, Recipe, Shape};

fn traced(recipe: &Recipe) -> Found {
    search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap().1
}

/// Whether this effect alone is named, or said to be indistinguishable from what is.
fn is_told(found: &Found, effect: &str) -> bool {
    found.alike.iter().chain([&found.chosen.model]).any(|model| names(model.effects) == [effect])
}

#[test]
fn each_effect_of_the_list_is_named_on_a_rig_of_its_own() {
    let by_themselves = effects::all().filter(|(_, card)| card.tried == Tried::Always);
    for (seed, (e, card)) in (100..).zip(by_themselves) {
        let plain = Recipe { repeats: 2, ..Recipe::from_seed(seed) };
        // What a record does to the stroke, or adds to the pressure, is no matter of the chamber.
        let mut recipe = if card.acts_on == ActsOn::RecordedStroke { plain } else { plain.with_strength(e, 1.0) };
        match card.name {
            "sensor_offset" => recipe.faults.offset_pa = Scattered::common(2e3),
            "position_delay" => recipe.faults.position_delay_s = 0.02,
            "position_averaging" => recipe.faults.position_window_s = 0.04,
            _ => {}
        }
        let found = traced(&recipe);
        if card.name == "warm_wall" && found.verdict == Verdict::Adequate {
            // Gas at rest has the wall's temperature: alone that is an ambient temperature within its tolerance.
            continue;
        }
        assert!(found.verdict == Verdict::Explained, "{}: {:?}", card.name, found.verdict);
        assert!(is_told(&found, card.name), "{}", card.name);
        if names(found.chosen.model.effects) != [card.name] {
            // Said to be indistinguishable from what was named: a bench with two end volumes cannot tell them apart.
            continue;
        }
        let lambda0 = found.chosen.fit.chamber().heat_transfer.coefficient;
        assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.03, "{}: {lambda0}", card.name);
    }
}

#[test]
fn records_without_noise_are_adequate_without_an_effect_and_name_the_one_they_have() {
    let none = [None; 3];
    let some = ["leakage", "wall_heating", "sensor_lag"].map(|name| effects::find(name).map(|(e, _)| e));
    for (k, effect) in none.into_iter().chain(some).enumerate() {
        // From 100 to 5000 Hz.
        let rate_hz = [100.0, 1000.0, 5000.0][k % 3];
        let plain = Recipe { repeats: 1, rate_hz, ..Recipe::from_seed(70 + k as u64) }.without_noise();
        let recipe = if let Some(e) = effect { plain.with_strength(e, 1.0) } else { plain };
        let found = traced(&recipe);
        let verdict = if effect.is_some() { Verdict::Explained } else { Verdict::Adequate };
        let named: Vec<&str> = effect.map(|e| effects::CARDS[e].name).into_iter().collect();
        assert_eq!((found.verdict, names(found.chosen.model.effects)), (verdict, named), "{k}");
        let lambda0 = found.chosen.fit.chamber().heat_transfer.coefficient;
        assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 1e-3, "{k}: {lambda0}");
    }
}

#[test]
fn two_effects_at_once_are_both_named() {
    let (leak, _) = effects::find("leakage").unwrap();
    let (lag, _) = effects::find("sensor_lag").unwrap();
    let found =
        traced(&Recipe { repeats: 2, ..Recipe::from_seed(31) }.with_strength(leak, 0.5).with_strength(lag, 0.5));
    assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Explained, vec!["leakage", "sensor_lag"]));
}

#[test]
fn three_effects_are_named_where_records_with_drifts_of_their_own_would_fit_most_of_them() {
    let three = Recipe { repeats: 2, ..Recipe::from_seed(31) };
    let place = |name: &str| effects::find(name).unwrap().0;
    let three = ["laminar_leakage", "wall_heating", "sensor_drift"]
        .into_iter()
        .fold(three, |recipe, name| recipe.with_strength(place(name), 0.5));
    let found = traced(&three);
    let named = names(found.chosen.model.of_rig());
    assert_eq!((found.verdict, named), (Verdict::Explained, vec!["wall_heating", "sensor_drift", "laminar_leakage"]));
}

#[test]
fn a_lag_is_explained_in_moves_of_few_rows_although_the_stroke_between_rows_is_uncertain() {
    let (lag, _) = effects::find("sensor_lag").unwrap();
    for (seed, shape) in [(41, Shape::Trapezoid), (43, Shape::Cubic)] {
        let mut recipe = Recipe { repeats: 2, rate_hz: 50.0, ..Recipe::from_seed(seed) };
        recipe.chamber.effects.of_mut(lag)[0] = 0.03;
        for (_, length_s, kind, _) in recipe.tests.iter_mut().flat_map(|t| &mut t.moves) {
            (*length_s, *kind) = (0.1, shape);
        }
        let found = traced(&recipe);
        let named = names(found.chosen.model.effects);
        assert_eq!((found.verdict, named), (Verdict::Explained, vec!["sensor_lag"]), "{seed}");
    }
}

#[test]
fn a_drift_beside_a_leak_is_named_where_all_records_have_the_same() {
    let place = |name: &str| effects::find(name).unwrap().0;
    for leak in ["leakage", "supply_leakage"] {
        let recipe = Recipe { repeats: 2, ..Recipe::from_seed(44) }.with_strength(place(leak), 4.0);
        let found = traced(&recipe.with_strength(place("sensor_drift"), 3.0));
        let mut named = names(found.chosen.model.of_rig());
        named.sort_unstable();
        let mut both = vec!["sensor_drift", leak];
        both.sort_unstable();
        assert_eq!((found.verdict, named), (Verdict::Explained, both));
    }
}

#[test]
fn a_delay_is_named_that_drives_the_paper_s_coefficient_out_of_bounds() {
    let (delay, _) = effects::find("record_delay").unwrap();
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(36) };
    recipe.chamber.effects.of_mut(delay)[0] = 0.1;
    let (_, paper) = baseline::fitted(Data::prepare(&recipe.rig()).unwrap()).unwrap();
    assert!(paper.chamber().heat_transfer.coefficient < 0.1);
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Explained, vec!["record_delay"]));
}

#[test]
fn a_leak_of_another_critical_ratio_is_still_a_leak() {
    let (leak, _) = effects::find("leakage").unwrap();
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(33) }.with_strength(leak, 1.0);
    recipe.chamber.effects.of_mut(leak)[1] = 0.05;
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Explained, vec!["leakage"]));
    assert!((found.chosen.fit.chamber().effects.of(leak)[1] - 0.05).abs() < 0.05);
}

#[test]
fn a_leak_of_another_critical_ratio_is_a_leak_beside_another_effect_too() {
    let (leak, _) = effects::find("leakage").unwrap();
    let (drift, _) = effects::find("sensor_drift").unwrap();
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(34) }.with_strength(leak, 1.0).with_strength(drift, 1.0);
    recipe.chamber.effects.of_mut(leak)[1] = 0.5;
    let found = traced(&recipe);
    assert_eq!(
        (found.verdict, names(found.chosen.model.effects)),
        (Verdict::Explained, vec!["leakage", "sensor_drift"])
    );
}

#[test]
fn a_push_of_six_rows_is_no_effect() {
    // Between the rows of so fast a move its course is open: what that does to the hold after it must not get a name.
    for shape in [Shape::Cosine, Shape::Quintic, Shape::Ramp] {
        let mut recipe = Recipe::from_seed(51);
        recipe.noise_pa = 20.0;
        recipe.tests.iter_mut().flat_map(|t| &mut t.moves).for_each(|m| (m.1, m.2) = (0.06, shape));
        let found = traced(&recipe);
        assert_eq!(found.verdict, Verdict::Adequate, "{shape:?}: {:?}", names(found.chosen.model.effects));
    }
}

#[test]
fn a_piston_that_never_rests_is_followed_through_all_its_cycles() {
    // Sines of thirty cycles and triangles of five: however many ways a move has, means of its rows are those of a short part of one.
    for (shape, cycles) in [(Shape::Cosine, 30), (Shape::Ramp, 5)] {
        let mut recipe = Recipe { repeats: 1, noise_pa: 100.0, ..Recipe::from_seed(52) };
        for test in &mut recipe.tests {
            let (to, ..) = test.moves[0];
            test.moves = [(to, 0.5, shape, 0.0), (test.from_m, 0.5, shape, 0.0)].repeat(cycles);
            test.moves.last_mut().unwrap().3 = 3.0;
        }
        let data = Data::prepare(&recipe.rig()).unwrap();
        assert!(data.traces.iter().all(|t| t.spikes.is_empty()), "{shape:?}: a peak at a turn is no spike");
        let (_, found) = search::search(data, &|_, _| ()).unwrap();
        assert_eq!(found.verdict, Verdict::Adequate, "{shape:?}: {:?}", names(found.chosen.model.effects));
        let lambda0 = found.chosen.fit.chamber().heat_transfer.coefficient;
        assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.01, "{shape:?}: {lambda0}");
    }
}

#[test]
fn records_with_delays_of_either_sign_and_zeros_of_their_own_are_adequate() {
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(71) };
    recipe.faults.pressure_delay_s.between = 0.01;
    recipe.faults.offset_pa.between = 500.0;
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.of_rig())), (Verdict::Adequate, vec![]));
    assert!(!found.chosen.model.per_record.is_empty());
    let chamber = found.chosen.fit.chamber_of_rig();
    assert_eq!(names(chamber.active()), Vec::<&str>::new(), "what a record has for itself is none of the rig's model");
    let lambda0 = chamber.heat_transfer.coefficient;
    assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.01, "{lambda0}");
}

#[test]
fn a_wall_that_tests_shortly_before_have_warmed_is_no_other_effect() {
    let wall = WallHeating::INDEX;
    let mut recipe = Recipe { repeats: 1, noise_pa: 100.0, ..Recipe::from_seed(72) }.with_strength(wall, 1.0);
    (recipe.bench.start_warmer_k, recipe.bench.start_wall_warmer_k) = (7.0, 5.0);
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.of_rig())), (Verdict::Explained, vec!["wall_heating"]));
    let fit = &found.chosen.fit;
    let lambda0 = fit.chamber().heat_transfer.coefficient;
    assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.02, "{lambda0}");
}

#[test]
fn a_delay_of_few_rows_of_a_slow_logger_is_named() {
    // All that a delay changes are the few rows of a fast move, which look like outliers of the paper's model.
    for seed in [61, 62] {
        let mut recipe = Recipe { repeats: 2, rate_hz: 50.0, ..Recipe::from_seed(seed) };
        recipe.tests.iter_mut().flat_map(|t| &mut t.moves).for_each(|m| (m.1, m.2) = (0.1, Shape::Ramp));
        recipe.faults.pressure_delay_s = Scattered::common(0.025);
        let found = traced(&recipe);
        assert_eq!(found.verdict, Verdict::Explained, "{seed}");
        assert!(is_told(&found, "record_delay"), "{seed}: {:?}", names(found.chosen.model.effects));
    }
}

#[test]
fn an_effect_is_named_beside_per_record_delays_in_coloured_noise() {
    // Noise of 3 s and more: parts of a record that long would leave its move in one half alone.
    let (conduction, _) = effects::find("wall_conduction").unwrap();
    let mut recipe = Recipe { repeats: 2, noise_pa: 60.0, ..Recipe::from_seed(64) }.with_strength(conduction, 1.0);
    recipe.faults.pressure_delay_s.between = 0.01;
    recipe.faults.disturbances.push(Disturbance::OneOverF { sd_pa: 100.0 });
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.of_rig())), (Verdict::Explained, vec!["wall_conduction"]));
}

#[test]
fn delays_of_each_record_are_no_colour_of_the_noise() {
    // Repeats that are read at other times differ by more than noise until their delays are in the model.
    let (zones, _) = effects::find("gas_zones").unwrap();
    let mut recipe = Recipe { repeats: 3, noise_pa: 150.0, ..Recipe::from_seed(66) }.with_strength(zones, 1.0);
    recipe.faults.pressure_delay_s.between = 0.01;
    let (data, found) = search::search(Data::prepare(&recipe.rig()).unwrap(), &|_, _| ()).unwrap();
    assert_eq!((found.verdict, names(found.chosen.model.of_rig())), (Verdict::Explained, vec!["gas_zones"]));
    assert!((data.noise.total_pa() / 150.0 - 1.0).abs() < 0.1, "{:?}", data.noise);
}

#[test]
fn a_delay_in_which_the_records_agree_is_one_of_the_rig() {
    let (leak, _) = effects::find("leakage").unwrap();
    let mut recipe = Recipe { repeats: 3, rate_hz: 500.0, ..Recipe::from_seed(67) }.with_strength(leak, 1.0);
    recipe.faults.position_delay_s = 0.015;
    let found = traced(&recipe);
    let named = names(found.chosen.model.of_rig());
    assert_eq!((found.verdict, named), (Verdict::Explained, vec!["leakage", "position_delay"]));
}

#[test]
fn a_random_walk_of_the_readings_is_no_drift() {
    for seed in 81..84 {
        let mut recipe = Recipe::from_seed(seed);
        recipe.faults.disturbances.push(Disturbance::Walk { after_a_second_pa: 150.0 });
        recipe.noise_pa = 60.0;
        let found = traced(&recipe);
        assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Adequate, vec![]), "{seed}");
    }
}

#[test]
fn readings_of_eight_bits_are_those_of_a_clean_rig() {
    // What is read of a level is as far off in all records that come to it.
    for seed in 91..95 {
        let recipe = Recipe { noise_pa: 50.0, quantisation_pa: 1e6 / 256.0, ..Recipe::from_seed(seed) };
        let found = traced(&recipe);
        assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Adequate, vec![]), "{seed}");
    }
}

#[test]
fn the_interval_holds_the_truth_also_where_the_accuracy_does_not_require_the_effect() {
    let (convection, _) = effects::find("natural_convection").unwrap();
    let recipe = Recipe { repeats: 2, ..Recipe::from_seed(5) }.with_strength(convection, 1.0);
    let mut rig = recipe.rig();
    let asked_pa = |accuracy_pa: Option<f64>, rig: &mut records::Rig| {
        rig.accuracy_pa = accuracy_pa;
        identify::diagnose(rig, &|_, _| ()).unwrap().diagnosis
    };
    let named = asked_pa(None, &mut rig);
    assert_eq!((named.verdict, &named.effects[..]), (Verdict::Explained, &["natural_convection"][..]));
    let makes_do = asked_pa(Some(2.0 * named.before.rmse_pa.fit), &mut rig);
    assert_eq!((makes_do.verdict, makes_do.effects.len()), (Verdict::Adequate, 0));
    let [interval, of_named] = [&makes_do, &named].map(|d| d.after.parameters[0].1.ci95);
    let truth = recipe.chamber.heat_transfer.coefficient;
    assert!(interval[0] < truth && truth < interval[1], "{interval:?}, {truth}");
    assert!(interval[1] - interval[0] > of_named[1] - of_named[0]);
    assert!(makes_do.lambda0_budget.iter().any(|b| b.source == "effects_within_accuracy" && b.share > 0.0));
    let asks = |d: &identify::Diagnosis| d.assumptions.iter().any(|note| note.contains("the records ask for"));
    assert!(!asks(&makes_do), "{:?}", makes_do.assumptions);
}

#[test]
fn a_slow_hum_of_records_without_repeats_is_noise() {
    for seed in [3, 60] {
        let mut recipe = Recipe { repeats: 1, noise_pa: 60.0, ..Recipe::from_seed(seed) };
        recipe.faults.disturbances.push(Disturbance::Hum { amplitude_pa: 200.0, frequency_hz: 0.45 });
        let found = traced(&recipe);
        assert_eq!(found.verdict, Verdict::Adequate, "seed {seed}: {:?}", names(found.chosen.model.effects));
    }
}

#[test]
fn a_filtered_record_of_a_fast_stroke_has_no_lagging_sensor() {
    // As much noise as what the interpolation between its rows leaves.
    let filtered = recording::ALL.iter().find(|r| r.name == "position-filtered").unwrap();
    let found = traced(&filtered.apply(Recipe::wide(3)));
    assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Explained, vec!["position_delay"]));
}

#[test]
fn an_effect_is_named_although_a_low_pass_of_the_positions_imitated_it() {
    let filtered = recording::ALL.iter().find(|r| r.name == "position-filtered").unwrap();
    for (seed, name, strength) in [(19002, "tube_volume", 2.0), (19004, "dead_volume_surface", 1.0)] {
        let (effect, _) = effects::find(name).unwrap();
        let found = traced(&filtered.apply(Recipe::from_seed(seed)).with_strength(effect, strength));
        assert_eq!(found.verdict, Verdict::Explained, "{name}");
        let mut told = found.alike.iter().chain([&found.chosen.model]).map(|model| names(model.effects));
        assert!(told.any(|named| named == [name, "position_delay"]), "{:?}", names(found.chosen.model.effects));
        let delay = effects::find("position_delay").unwrap().0;
        let time_constant_s = found.chosen.fit.chamber().effects.of(delay)[1];
        assert!((time_constant_s / 0.05 - 1.0).abs() < 0.01, "{name}: {time_constant_s} s");
    }
}

#[test]
fn a_record_averaged_over_nearly_a_whole_push_has_no_lagging_sensor() {
    // Pushes of 50 to 80 ms, averaged over 40 ms: what cannot be found again of them must not get a name.
    let averaged = recording::ALL.iter().find(|r| r.name == "position-averaged").unwrap();
    let recipe = averaged.apply(Recipe::wide(3));
    let found = traced(&recipe);
    assert_eq!(found.verdict, Verdict::Explained);
    assert!(is_told(&found, "position_averaging"), "{:?}", names(found.chosen.model.effects));
    let lambda0 = found.chosen.fit.chamber().heat_transfer.coefficient;
    assert!((lambda0 / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 0.01, "{lambda0}");
}

#[test]
fn an_interval_holds_the_truth_where_effects_cannot_be_told_apart() {
    // So faint a surface of the dead volume looks like a longer gas column, which asks for a coefficient 25 % larger.
    let (surface, _) = effects::find("dead_volume_surface").unwrap();
    let coarse = recording::ALL.iter().find(|r| r.name == "12-bit-60").unwrap();
    let recipe = coarse.apply(Recipe::from_seed(952).with_strength(surface, 4.0));
    let found = identify::diagnose(&recipe.rig(), &|_, _| ()).unwrap();
    let (name, lambda0) = &found.diagnosis.after.parameters[0];
    let truth = recipe.chamber.heat_transfer.coefficient;
    assert!(lambda0.ci95[0] < truth && truth < lambda0.ci95[1], "{name}: {lambda0:?}, {truth}");
    assert!(found.found.alike.is_empty() || lambda0.ci95[1] > 1.15 * lambda0.ci95[0], "{lambda0:?}");
    let kept = found.uncertainty();
    assert_eq!((&kept.parameters[0], kept.ci95[0]), (name, lambda0.ci95));
    let shares: f64 = found.diagnosis.lambda0_budget.iter().map(|b| b.share).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
}

#[test]
fn next_to_a_supply_leak_of_another_critical_ratio_the_surface_of_the_dead_volume_is_not_the_gas_column() {
    let (surface, _) = effects::find("dead_volume_surface").unwrap();
    let leaking = recording::ALL.iter().find(|r| r.name == "supply-leak").unwrap();
    let found = traced(&leaking.apply(Recipe::from_seed(104)).with_strength(surface, 1.0));
    let named = names(found.chosen.model.effects);
    assert_eq!((found.verdict, named), (Verdict::Explained, vec!["dead_volume_surface", "supply_leakage"]));
}

#[test]
fn a_warm_wall_is_warm_for_every_law_of_heat_transfer() {
    let (column, _) = effects::find("gas_column_length").unwrap();
    let mut recipe = Recipe { repeats: 2, outside: Some(Outside::WarmWall(10.0)), ..Recipe::from_seed(2) };
    recipe.bench.start_warmer_k = 10.0;
    let found = traced(&recipe.with_strength(column, 1.0));
    assert_eq!(found.verdict, Verdict::Explained);
    // A bench with two end volumes cannot tell the gas's column from a surface of the dead volume.
    let mut told = found.alike.iter().chain([&found.chosen.model]).map(|model| names(model.effects));
    assert!(told.all(|named| !named.contains(&"warm_wall")) && is_told(&found, "gas_column_length"));
}

#[test]
fn gas_that_is_warm_at_the_start_of_every_record_is_no_warm_wall() {
    let warm = recording::ALL.iter().find(|r| r.name == "warm-start").unwrap();
    let mut recipe = warm.apply(Recipe::from_seed(5));
    recipe.faults.stated.ambient_offset_k = -3.0;
    let found = traced(&recipe);
    assert_eq!((found.verdict, names(found.chosen.model.effects)), (Verdict::Adequate, vec![]));
    assert!(found.chosen.model.record_start == RecordStart::Gas);
}

#[test]
fn an_interval_holds_the_truth_where_records_tell_the_ambient_temperature_better_than_its_thermometer() {
    let rises = recording::ALL.iter().find(|r| r.name == "ambient-rises").unwrap();
    let mut recipe = rises.apply(Recipe::from_seed(1));
    recipe.faults.stated.ambient_offset_k = 2.0;
    let found = traced(&recipe).chosen.fit;
    let estimates = covariance::estimates(&found, &covariance::covariance(&found, true));
    let (name, lambda0) = &estimates[0];
    let truth = recipe.chamber.heat_transfer.coefficient;
    assert!(lambda0.ci95[0] < truth && truth < lambda0.ci95[1], "{name}: {lambda0:?}, {truth}");
    assert!((lambda0.value / truth - 1.0).abs() > 0.005 && lambda0.ci95[1] < 1.05 * truth, "{lambda0:?}, {truth}");
}

#[test]
fn the_interval_of_a_leak_holds_the_truth_where_records_do_not_tell_its_critical_pressure_ratio() {
    let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(31) };
    recipe.tests.truncate(2);
    recipe.tests.iter_mut().for_each(|test| test.pressure_pa = 1.6e5);
    let conductance = recipe.leak_of(0.1);
    for ratio in [0.1, 0.3, 0.55] {
        let found = traced(&recipe.clone().with("leakage", &[conductance, ratio])).chosen.fit;
        let names: Vec<String> = found.hypothesis.axes.iter().map(|axis| axis.slot.name()).collect();
        assert_eq!(names, ["lambda0_w_per_m2_k", "dead_volume_m3", "leakage.conductance_m3_per_s_pa"]);
        let leak = &covariance::estimates(&found, &covariance::covariance(&found, true))[2].1;
        assert!(leak.ci95[0] < conductance && conductance < leak.ci95[1], "{ratio}: {leak:?}, {conductance}");
        let by_ratio = covariance::budget(&found, 2, true).pop().unwrap();
        assert!(by_ratio.0 == "leakage.critical_pressure_ratio" && by_ratio.1 > 0.5, "{by_ratio:?}");
    }
}

#[test]
fn turbulence_that_decays_is_found_behind_the_effects_that_imitate_it_and_beside_others() {
    let plain = Recipe { repeats: 2, ..Recipe::from_seed(43) }.with("decaying_turbulence", &[3.0, 0.3]);
    let leak = plain.leak_of(1.0);
    let (turbulence, _) = effects::find("decaying_turbulence").unwrap();
    for (recipe, expected) in [
        (plain.clone(), vec!["decaying_turbulence"]),
        (plain.with("leakage", &[leak, 0.3]), vec!["leakage", "decaying_turbulence"]),
    ] {
        let found = traced(&recipe);
        assert_eq!(found.verdict, Verdict::Explained);
        assert_eq!(names(found.chosen.model.effects), expected);
        let [coefficient, decay_s] = [0, 1].map(|k| found.chosen.fit.chamber().effects.of(turbulence)[k]);
        assert!((coefficient / 3.0 - 1.0).abs() < 0.2 && (decay_s / 0.3 - 1.0).abs() < 0.2, "{coefficient} {decay_s}");
    }
}

#[test]
fn an_effect_without_a_card_is_never_called_explained() {
    for outside in [Outside::FrictionHeat(0.05), Outside::Compliance(0.004), Outside::Hysteresis(600.0)] {
        let found = traced(&Recipe { repeats: 2, ..Recipe::from_seed(41) }.with_outside(outside));
        assert_ne!(found.verdict, Verdict::Explained, "{}: {:?}", outside.name(), names(found.chosen.model.effects));
    }
}

#[test]
fn effects_that_leave_less_than_the_accuracy_but_with_a_shape_improve_and_do_not_explain() {
    // A law of the coefficient stands for half of what a warm diaphragm adds.
    let found = traced(&Recipe::from_seed(4_000_018).with_outside(Outside::HotGauge(9.0, 0.5)));
    assert!(found.chosen_adequacy.is_adequate() && !found.chosen_adequacy.is_noise);
    assert_eq!(found.verdict, Verdict::Improved, "{:?}", names(found.chosen.model.effects));
}

#[test]
fn a_fitted_offset_stays_within_the_range_of_gauges() {
    let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(41) };
    recipe.faults.offset_pa = Scattered::common(4e4);
    let (offset, _) = effects::find("sensor_offset").unwrap();
    let found = traced(&recipe).chosen.fit.chamber();
    assert!(found.effects.of(offset)[0] <= 25e3, "{}", found.effects.of(offset)[0]);
}

#[test]
fn the_same_rig_gives_the_same_bits_on_one_thread() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
    let data = Data::prepare(&recipe.rig()).unwrap();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (_, one) = alone.install(|| baseline::fitted(data.clone()).unwrap());
    assert_eq!(baseline::fitted(data).unwrap().1.rig, one.rig);
}

/// A rig's chamber along its second record, at rest at 3.2 bar before it.
fn from_rest<'a>(recipe: &'a Recipe, data: &'a Data, relative_tolerance: f64) -> Run<'a, f64> {
    Run {
        chamber: &recipe.chamber,
        set: recipe.chamber.active(),
        start: Start { pressure: 3.2e5, temperature: data.ambient_temperature_k },
        correction: Correction::NONE,
        course: &data.traces[1].course,
        relative_tolerance,
    }
}

#[test]
fn the_fit_s_forward_model_is_the_simulator_s() {
    for (e, card) in effects::all().filter(|(_, card)| card.is_candidate()) {
        let recipe = Recipe { repeats: 1, ..Recipe::from_seed(61) }.with_strength(e, 1.0);
        let data = Data::prepare(&recipe.rig()).unwrap();
        let t = &data.traces[1];
        let run = from_rest(&recipe, &data, 1e-9);
        let ours = run.pressures(&t.time_s).unwrap();
        // The simulator's stroke is straight between knots: give it the same one, in steps of a twentieth of a row.
        let near = Default::default();
        let end = *t.time_s.last().unwrap();
        let motion: Vec<(f64, f64)> = (0..(end * 4000.0) as usize)
            .map(|k| {
                let time = k as f64 / 4000.0;
                let part = t.course.motion.segments.iter().find(|s| time <= s.to_s).unwrap();
                (time, part.stroke.at(time, &near).0)
            })
            .collect();
        let signals = chamber::signals::Signals::closed(&motion, data.ambient_temperature_k, data.ambient_pressure_pa)
            .with_true_stroke(run.set, &recipe.chamber.effects);
        let theirs =
            chamber::simulate::simulate(&recipe.chamber, run.set, run.start, &signals, &t.time_s, 1e-9).unwrap();
        let worst = ours.iter().zip(&theirs).map(|(a, b)| (a - b.measured_pressure).abs()).fold(0.0, f64::max);
        assert!(worst < 15.0, "{}: {worst} Pa", card.name);
    }
}

#[test]
fn a_conducting_wall_takes_no_more_steps_than_its_fastest_mode_requires() {
    // Its modes pass through zero, where an error relative to each of them would ask for ever shorter steps. An explicit method of
    // order five is stable up to 3.3 time constants a step, of the fastest mode's 1/41 s.
    let (effect, _) = effects::find("wall_conduction").unwrap();
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(61) };
    let steps = |recipe: &Recipe| {
        let data = Data::prepare(&recipe.rig()).unwrap();
        let t = &data.traces[1];
        let run = from_rest(recipe, &data, 1e-7);
        let mut steps = 0;
        run.disturbed(&t.time_s, &Undisturbed, |_, _| steps += 1).unwrap();
        (f64::from(steps), t.time_s[t.time_s.len() - 1])
    };
    let ((conducts, duration), (without, _)) = (steps(&recipe.clone().with_strength(effect, 1.0)), steps(&recipe));
    let stable = duration * 41.0 / 3.3;
    assert!(conducts < without + 1.5 * stable, "{conducts} {without} {stable}");
}
