//! Positions as benches record them: counted from anywhere, read less often than the pressure.

use chamber::simulate::Start;
use identify::Method;
use identify::fit::readings;
use identify::forward::Correction;
use identify::parameters::Setting;
use identify::record::data::{Data, Prepared};
use identify::synthetic::Recipe;
use identify::synthetic::Shape;
use identify::synthetic::recording;
use records::{Rig, Verdict};

fn rig() -> (Recipe, Rig) {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(21) };
    let rig = recipe.rig();
    (recipe, rig)
}

fn positions(rig: &mut Rig) -> impl Iterator<Item = &mut Vec<f64>> {
    rig.experiments.iter_mut().flat_map(|e| &mut e.traces).map(|t| &mut t.position_m)
}

/// λ0 as found, over the true one.
fn coefficient(recipe: &Recipe, rig: &Rig) -> f64 {
    let found = identify::identify(rig, Method::Exact).unwrap();
    let (name, lambda0) = &found.parameters[0];
    assert_eq!(name, "lambda0_w_per_m2_k");
    lambda0.value / recipe.chamber.heat_transfer.coefficient
}

#[test]
fn positions_that_count_from_the_end_of_the_travel_leave_the_coefficient_as_it_is() {
    let (recipe, mut rig) = rig();
    rig.dead_volume = None;
    let lowest = positions(&mut rig).flat_map(|x| x.iter().copied()).fold(f64::INFINITY, f64::min);
    let as_recorded = coefficient(&recipe, &rig);
    for beyond_m in [0.0, 1e-4, 0.03] {
        let mut moved = rig.clone();
        positions(&mut moved).for_each(|x| x.iter_mut().for_each(|x| *x -= lowest + beyond_m));
        let found = coefficient(&recipe, &moved);
        assert!((found / as_recorded - 1.0).abs() < 2e-3, "{beyond_m}: {found} {as_recorded}");
    }
}

#[test]
fn positions_of_a_larger_scale_than_recorded_have_a_higher_speed() {
    // Forced convection knows the speed, the gas column's length the way.
    let (recipe, rig) = rig();
    let recipe = recipe.with("forced_convection", &[1.5]).with("gas_column_length", &[-0.3, 0.1]);
    let mut longer = rig.clone();
    positions(&mut longer).for_each(|x| x.iter_mut().for_each(|x| *x *= 1.01));
    let shown = |rig: &Rig, position_times: f64| -> Vec<f64> {
        let data = Data::prepare(rig).unwrap();
        let (t, chamber) = (&data.traces[0], recipe.chamber);
        let start = Start { pressure: t.initial_pressure_pa, temperature: t.initial_temperature_k };
        let setting = Setting { chamber, start, correction: Correction { position_times, ..Correction::NONE } };
        readings(t, &setting, chamber.active()).unwrap()
    };
    let (as_recorded, corrected, truth) = (shown(&rig, 1.0), shown(&rig, 1.01), shown(&longer, 1.0));
    let apart = |other: &[f64]| truth.iter().zip(other).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(apart(&corrected) < 1e-6 && apart(&as_recorded) > 1e-3, "{} {}", apart(&corrected), apart(&as_recorded));
}

#[test]
fn a_position_that_is_read_at_every_tenth_row_and_repeated_gives_the_coefficient() {
    let (recipe, mut rig) = rig();
    for x in positions(&mut rig) {
        *x = (0..x.len()).map(|i| x[i - i % 10]).collect();
    }
    let found = coefficient(&recipe, &rig);
    assert!((found - 1.0).abs() < 0.02, "{found}");
    let notes = identify::identify(&rig, Method::Exact).unwrap().assumptions;
    assert!(notes.iter().any(|note| note.contains("the position is read at")), "{notes:?}");
}

/// The verdict and the effects named where a recording like that is made of a rig.
fn diagnosed(name: &str, recipe: Recipe) -> (Verdict, Vec<&'static str>) {
    let recording = recording::ALL.iter().find(|r| r.name == name).unwrap();
    let found = identify::diagnose(&recording.apply(recipe).rig(), &|_, _| ()).unwrap();
    (found.diagnosis.verdict, found.diagnosis.effects)
}

#[test]
fn a_note_states_the_error_due_to_position_noise() {
    let notes = |position_noise_m: f64| {
        let recipe = Recipe { position_noise_m, repeats: 1, ..Recipe::from_seed(21) };
        identify::identify(&recipe.rig(), Method::Exact).unwrap().assumptions
    };
    let says = |notes: Vec<String>| notes.iter().any(|note| note.contains("the positions scatter by up to"));
    assert!(says(notes(1e-4)) && !says(notes(2e-6)));
}

#[test]
fn a_position_sensor_that_is_not_quite_straight_is_no_misfit_unless_it_is_stated_to_be_straight() {
    let bent = recording::ALL.iter().find(|r| r.name == "position-bent").unwrap();
    let verdict = |rig: &Rig| identify::diagnose(rig, &|_, _| ()).unwrap().diagnosis.verdict;
    // Whose tests end at several places.
    let mut rig = bent.apply(Recipe::wide(8)).rig();
    assert_eq!(verdict(&rig), Verdict::Adequate);
    // Nor are the records' surroundings left open, which would take up most of it.
    (rig.tolerance.position_linearity, rig.tolerance.ambient_temperature_k) = (0.0, 0.0);
    assert_ne!(verdict(&rig), Verdict::Adequate);
}

#[test]
fn a_position_of_which_hardly_a_reading_falls_into_the_moves_names_no_effect() {
    for (name, seed) in [("position-held", 3), ("position-interpolated", 3), ("position-held", 12)] {
        assert_eq!(diagnosed(name, Recipe::wide(seed)), (Verdict::Adequate, Vec::new()), "{name} {seed}");
    }
}

#[test]
fn an_effect_is_named_though_hardly_a_reading_of_the_position_falls_into_the_moves() {
    let recipe = Recipe::wide(12);
    let (wall, _) = chamber::effects::find("wall_heating").unwrap();
    assert_eq!(diagnosed("position-held", recipe.with_strength(wall, 1.0)), (Verdict::Explained, vec!["wall_heating"]));
}

#[test]
fn an_even_push_without_position_noise_is_no_encoder_with_steps_as_wide_as_its_travel_from_row_to_row() {
    let mut recipe = Recipe { position_noise_m: 0.0, position_step_m: 1e-7, rest_s: 0.3, ..Recipe::from_seed(21) };
    recipe.tests.iter_mut().flat_map(|t| &mut t.moves).for_each(|(_, push_s, shape, _)| {
        (*push_s, *shape) = (0.04, Shape::Ramp);
    });
    let mut rig = recipe.rig();
    // From a row to a row, in four of them.
    positions(&mut rig).for_each(|x| {
        let (from, to) = (x[0], x[x.len() - 1]);
        let at = |k: usize| from + (to - from) * (k.saturating_sub(30).min(4) as f64) / 4.0;
        (0..x.len()).for_each(|k| x[k] = (at(k) * 1e7).round() * 1e-7);
    });
    let data = Data::prepare(&rig).unwrap();
    let by_position = |t: &Prepared| t.blocks.iter().map(|b| b.position_sd_pa).fold(0.0, f64::max);
    let largest_pa = data.traces.iter().map(by_position).fold(0.0, f64::max);
    assert!(largest_pa < data.noise.total_pa(), "{largest_pa}");
}
