//! Data that cannot be what it should be is named, with the number that gives it away.

use identify::record::data::Data;
use identify::synthetic::outside::Outside;
use identify::synthetic::{Recipe, Shape};
use identify::{Diagnosed, Error, Method};
use records::units::{Quantity, Unit};
use records::{Rig, Trace};

fn spoilt(change: impl Fn(&mut Trace)) -> Error {
    let mut rig = Recipe { repeats: 1, ..Recipe::from_seed(7) }.rig();
    for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
        change(t);
    }
    refused(&rig)
}

fn refused(rig: &Rig) -> Error {
    match identify::identify(rig, Method::Exact) {
        Err(error) => error,
        Ok(found) => panic!("accepted: {:?}", found.parameters),
    }
}

fn pressures(t: &mut Trace) -> &mut Vec<f64> {
    t.pressure_pa.as_mut().unwrap()
}

#[test]
fn too_few_rows_are_counted() {
    let error = spoilt(|t| {
        t.time_s.truncate(12);
        t.position_m.truncate(12);
        pressures(t).truncate(12);
        t.ambient_temperature_k = None;
    });
    assert!(matches!(error, Error::TooFewSamples { rows: 12, .. }), "{error}");
}

#[test]
fn strokes_of_a_hundred_bores_are_in_another_unit_unless_the_rig_states_so_long_a_stroke() {
    for (per_metre, unit) in [(100.0, "cm"), (1.0 / 0.0254, "in")] {
        let mut rig = Recipe { repeats: 1, ..Recipe::from_seed(7) }.rig();
        rig.cylinder.bore_m = 0.02;
        for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
            t.position_m.iter_mut().for_each(|x| *x *= per_metre);
        }
        let error = refused(&rig);
        assert!(matches!(&error, Error::ImplausibleStroke { units, .. } if units.contains(&unit)), "{error}");
        rig.cylinder.stroke_m = Some(50.0);
        let stated = identify::identify(&rig, Method::Exact);
        assert!(!matches!(stated, Err(Error::ImplausibleStroke { .. })));
    }
}

#[test]
fn a_piston_at_rest_is_no_test() {
    let error = spoilt(|t| {
        let first = t.position_m[0];
        t.position_m.iter_mut().enumerate().for_each(|(i, x)| *x = first + 2e-6 * (i % 3) as f64);
    });
    assert!(matches!(error, Error::NoMove { .. }), "{error}");
    assert!(error.to_string().contains("0.004 mm"), "{error}");
}

#[test]
fn a_constant_pressure_is_no_answer_to_a_move() {
    let error = spoilt(|t| pressures(t).iter_mut().enumerate().for_each(|(i, p)| *p = 3e5 + 15.0 * (i % 3) as f64));
    assert!(matches!(error, Error::ConstantPressure { range_pa, .. } if range_pa == 30.0), "{error}");
}

#[test]
fn positions_that_count_from_a_little_too_far_leave_no_negative_dead_volume() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(7) };
    let geometry = recipe.chamber.geometry;
    let mut rig = recipe.rig();
    let diagnosed = |rig: &Rig| identify::diagnose(rig, &|_, _| ()).unwrap();
    let coefficient = |found: &Diagnosed| {
        let (_, lambda0) = found.diagnosis.after.parameters[0].clone();
        assert_eq!(lambda0.unit, "W/(m2.K)");
        lambda0
    };
    let as_stated = coefficient(&diagnosed(&rig));
    let traces = || rig.experiments.iter().flat_map(|e| &e.traces).flat_map(|t| &t.position_m);
    let smallest = traces().copied().fold(f64::INFINITY, f64::min);
    let by_m = geometry.dead_volume / geometry.piston_area + 0.02 * smallest;
    for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
        t.position_m.iter_mut().for_each(|x| *x += by_m);
    }
    let found = diagnosed(&rig);
    assert_eq!(found.chamber().geometry.dead_volume, 0.0);
    let note = found.diagnosis.assumptions.iter().find(|note| note.contains("positions seem to read")).unwrap();
    assert!(note.contains(&format!("{:.1} mm too much", 1e3 * 0.02 * smallest)), "{note}");
    // The other numbers are those of positions that count from where they should.
    let half_width = 0.5 * (as_stated.ci95[1] - as_stated.ci95[0]);
    assert!((coefficient(&found).value - as_stated.value).abs() < 0.05 * half_width);
    let parameters = found.diagnosis.after.parameters;
    let (_, dead) = parameters.iter().find(|(name, _)| name == "dead_volume_m3").unwrap();
    assert!(dead.value == 0.0 && dead.ci95[0] == 0.0 && dead.ci95[1] > 0.0, "{:?}", dead.ci95);
}

#[test]
fn a_negative_dead_volume_that_the_tolerance_of_the_positions_zero_allows_is_no_contradiction() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(7) };
    let geometry = recipe.chamber.geometry;
    let mut rig = recipe.rig();
    let traces = rig.experiments.iter().flat_map(|e| &e.traces).flat_map(|t| &t.position_m);
    let smallest = traces.copied().fold(f64::INFINITY, f64::min);
    let too_far_m = 0.2 * smallest;
    let by_m = geometry.dead_volume / geometry.piston_area + too_far_m;
    for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
        t.position_m.iter_mut().for_each(|x| *x += by_m);
    }
    assert!(matches!(identify::diagnose(&rig, &|_, _| ()), Err(Error::NegativeDeadVolume { .. })));
    rig.tolerance.position_offset_m = 0.5 * too_far_m;
    assert_eq!(identify::diagnose(&rig, &|_, _| ()).unwrap().chamber().geometry.dead_volume, 0.0);
}

#[test]
fn a_saturated_sensor_is_reported_with_value_and_time() {
    let error = spoilt(|t| {
        let p = pressures(t);
        let (low, high) = p.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        let limit = (low + 0.7 * (high - low)).round();
        p.iter_mut().for_each(|v| *v = v.min(limit));
    });
    assert!(matches!(error, Error::Saturated { high: true, .. }), "{error}");
}

#[test]
fn saturated_rows_of_one_record_among_others_are_left_out_and_named() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(7) };
    let mut rig = recipe.rig();
    let saturated = &mut rig.experiments[0].traces[0];
    let p = pressures(saturated);
    let (low, high) = p.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let limit = (low + 0.7 * (high - low)).round();
    p.iter_mut().for_each(|v| *v = v.min(limit));
    let rows = p.iter().filter(|v| **v == limit).count();
    let found = identify::identify(&rig, Method::Exact).unwrap();
    let note = found.assumptions.iter().find(|note| note.contains("is saturated")).unwrap();
    assert!(note.starts_with(&rig.experiments[0].traces[0].path.display().to_string()), "{note}");
    assert!(note.contains("in which it reads an end of its range are left out"), "{note}");
    let told: usize = note.split("; ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((rows..=rows + rows / 10).contains(&told), "{rows} rows: {note}");
    let (_, lambda0) = &found.parameters[0];
    let truth = recipe.chamber.heat_transfer.coefficient;
    assert!(lambda0.ci95[0] < truth && truth < lambda0.ci95[1] && found.residual_is_noise, "{truth}: {lambda0:?}");
}

#[test]
fn a_coarse_sensor_that_shows_no_step_more_at_the_end_of_a_pull_is_not_saturated() {
    let mut rig = Recipe { repeats: 1, ..Recipe::from_seed(7) }.rig();
    rig.experiments.truncate(1);
    let time_s: Vec<f64> = (0..700).map(|i| f64::from(i) / 200.0).collect();
    let (from_m, travel_m, began_s, lasts_s) = (0.036, 0.010, 1.0, 0.1);
    let position = |t: &f64| {
        let u = ((t - began_s) / lasts_s).clamp(0.0, 1.0);
        from_m + travel_m * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
    };
    let pressure = |step_pa: f64, least_pa: f64| {
        let adiabatic = |x: f64| 1e5 * (from_m / x).powf(1.3);
        let (settled, to_m) = (1e5 * from_m / (from_m + travel_m), from_m + travel_m);
        let of_gas = move |t: &f64| match t - began_s - lasts_s {
            since if since > 0.0 => settled + (adiabatic(to_m) - settled) * (-since / 0.4).exp(),
            _ => adiabatic(position(t)),
        };
        time_s.iter().map(move |t| (of_gas(t).max(least_pa) / step_pa).round() * step_pa).collect::<Vec<f64>>()
    };
    let mut of_sensor = |step_pa: f64, least_pa: f64| {
        let trace = &mut rig.experiments[0].traces[0];
        trace.position_m = time_s.iter().map(position).collect();
        trace.pressure_pa = Some(pressure(step_pa, least_pa));
        (trace.time_s, trace.ambient_temperature_k) = (time_s.clone(), None);
        Data::prepare(&rig).map(drop)
    };
    // Eight bits of a sensor for 10 bar: 83 equal rows of the lowest reading, from the last rows of the pull on.
    assert!(of_sensor(3906.0, 0.0).is_ok());
    for (step_pa, least_pa) in [(3906.0, 8.6e4), (10.0, 8e4)] {
        let error = of_sensor(step_pa, least_pa).err();
        assert!(matches!(error, Some(Error::Saturated { high: false, .. })), "{step_pa} {error:?}");
    }
}

#[test]
fn equal_readings_of_a_rest_without_noise_are_no_saturation_and_those_of_a_push_are() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(7) }.without_noise();
    let mut rig = recipe.rig();
    let found = identify::identify(&rig, Method::Exact).unwrap();
    let (_, lambda0) = &found.parameters[0];
    assert!((lambda0.value / recipe.chamber.heat_transfer.coefficient - 1.0).abs() < 1e-3, "{lambda0:?}");
    rig.experiments.retain(|e| e.name.starts_with("compress"));
    for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
        let (low, high) = pressures(t).iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        pressures(t).iter_mut().for_each(|p| *p = p.min(low + 0.7 * (high - low)));
    }
    let error = refused(&rig);
    assert!(matches!(error, Error::Saturated { high: true, .. }), "{error}");
}

#[test]
fn readings_that_follow_the_piston_late_and_without_noise_are_no_saturation() {
    let recipe = Recipe { repeats: 1, ..Recipe::from_seed(7) }.without_noise().with("record_delay", &[0.1]);
    let found = identify::diagnose(&recipe.rig(), &|_, _| ()).unwrap();
    assert_eq!(found.diagnosis.effects, ["record_delay"]);
}

#[test]
fn gauge_pressures_are_recognised_by_the_offset_they_require() {
    // The expansions from ambient would be below vacuum: a reader of records refuses those.
    let mut rig = Recipe { repeats: 1, ..Recipe::from_seed(7) }.rig();
    rig.experiments.retain(|e| e.name == "compress-3bar" || e.name == "expand-5bar" || e.name == "compress-part");
    rig.experiments
        .iter_mut()
        .flat_map(|e| &mut e.traces)
        .for_each(|t| pressures(t).iter_mut().for_each(|p| *p -= 101_300.0));
    let traced = identify::diagnose(&rig, &|_, _| ()).err();
    assert!(matches!(traced, Some(Error::Gauge { .. })), "{traced:?}");
    let error = refused(&rig);
    assert!(matches!(error, Error::Gauge { offset_pa, .. } if (offset_pa / 101_300.0 - 1.0).abs() < 0.1), "{error}");
}

#[test]
fn a_position_with_an_offset_requires_a_negative_dead_volume() {
    let error = spoilt(|t| t.position_m.iter_mut().for_each(|x| *x += 0.05));
    assert!(matches!(error, Error::NegativeDeadVolume { dead_volume_m3, .. } if dead_volume_m3 < 0.0), "{error}");
}

#[test]
fn a_position_counted_from_the_other_end_is_noticed() {
    let error = spoilt(|t| t.position_m.iter_mut().for_each(|x| *x = 0.4 - *x));
    assert!(matches!(error, Error::WrongSign { correlation, .. } if correlation > 0.5), "{error}");
}

/// Rigs whose rig file says gauge: the ambient pressure has been added to what the logger wrote.
fn declared_gauge(recipe: Recipe, logged_absolute: bool, kept: &[&str]) -> Rig {
    let mut rig = recipe.rig();
    rig.gauge_pressures = true;
    rig.experiments.retain(|e| kept.is_empty() || kept.contains(&e.name.as_str()));
    if logged_absolute {
        let ambient_pa = rig.ambient.pressure_pa;
        let traces = rig.experiments.iter_mut().flat_map(|e| &mut e.traces);
        traces.for_each(|t| pressures(t).iter_mut().for_each(|p| *p += ambient_pa));
    }
    rig
}

#[test]
fn absolute_pressures_declared_gauge_are_recognised_by_their_excess() {
    let rig = declared_gauge(Recipe { repeats: 1, ..Recipe::from_seed(7) }, true, &[]);
    let traced = identify::diagnose(&rig, &|_, _| ()).err();
    assert!(matches!(traced, Some(Error::NotGauge { .. })), "{traced:?}");
    let error = refused(&rig);
    assert!(matches!(error, Error::NotGauge { offset_pa, .. } if (offset_pa / 101_300.0 - 1.0).abs() < 0.1), "{error}");
}

#[test]
fn the_zero_of_a_gauge_is_recognised_beside_a_leak_that_the_first_fit_lacks() {
    let kept = ["compress-3bar", "expand-5bar", "compress-part"];
    let leaky = || Recipe { repeats: 1, ..Recipe::from_seed(9).with("leakage", &[6e-12, 0.3]) };
    let too_much = declared_gauge(leaky(), true, &kept);
    let mut too_little = declared_gauge(leaky(), false, &kept);
    too_little.gauge_pressures = false;
    let traces = too_little.experiments.iter_mut().flat_map(|e| &mut e.traces);
    traces.for_each(|t| pressures(t).iter_mut().for_each(|p| *p -= 101_300.0));
    for rig in [&too_much, &too_little] {
        assert!(
            identify::identify(rig, Method::Exact).is_ok(),
            "the paper's model alone tells: no test of the second look"
        );
    }
    let traced = identify::diagnose(&too_much, &|_, _| ()).err();
    assert!(matches!(traced, Some(Error::NotGauge { .. })), "{traced:?}");
    let traced = identify::diagnose(&too_little, &|_, _| ()).err();
    assert!(matches!(traced, Some(Error::Gauge { .. })), "{traced:?}");
}

#[test]
fn honest_gauge_pressures_pass_whatever_the_model_lacks() {
    for recipe in [
        Recipe::from_seed(7),
        Recipe::from_seed(3).with("leakage", &[3e-12, 0.3]),
        Recipe::from_seed(5).with("wall_heating", &[2.0, 0.05]),
        Recipe::from_seed(11).with("sensor_offset", &[4000.0]),
        Recipe::from_seed(13).with_outside(Outside::HotGauge(30.0, 0.5)),
    ] {
        for kept in [&[][..], &["compress-3bar", "expand-5bar", "compress-part"]] {
            let rig = declared_gauge(Recipe { repeats: 1, ..recipe.clone() }, false, kept);
            identify::identify(&rig, Method::Exact).unwrap();
            identify::diagnose(&rig, &|_, _| ()).unwrap();
        }
    }
}

fn unit(name: &str) -> &'static Unit {
    Quantity::Pressure.unit_spelled(name).unwrap()
}

/// A rig whose pressures, absolute or gauge, are in one unit and declared in another.
fn misdeclared(seed: u64, truth: &str, declared: &str, gauge: bool, keep: &[&str]) -> Rig {
    let mut rig = Recipe { repeats: 2, ..Recipe::from_seed(seed) }.rig();
    rig.experiments.retain(|e| keep.is_empty() || keep.contains(&e.name.as_str()));
    let zero = if gauge { rig.ambient.pressure_pa } else { 0.0 };
    let ratio = unit(declared).factor / unit(truth).factor;
    for t in rig.experiments.iter_mut().flat_map(|e| &mut e.traces) {
        pressures(t).iter_mut().for_each(|p| *p = zero + (*p - zero) * ratio);
    }
    (rig.gauge_pressures, rig.pressure_unit) = (gauge, Some(unit(declared)));
    rig
}

#[test]
fn absolute_pressures_in_another_unit_are_refused_where_some_rest_at_that_of_the_surroundings() {
    for (truth, declared) in [("psi", "bar"), ("bar", "psi"), ("kPa", "bar"), ("MPa", "bar"), ("psi", "kPa")] {
        let error = refused(&misdeclared(7, truth, declared, false, &[]));
        assert!(
            matches!(&error, Error::OtherPressureUnit { doubt } if doubt.unit == truth && doubt.at_ambient),
            "{error}"
        );
        for part in [&format!("unit = \"{truth}\""), &format!("declared in {declared}"), "surroundings", "scale = 1.0"]
        {
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}

#[test]
fn absolute_pressures_that_may_be_right_get_a_note_and_with_a_scale_of_their_own_none() {
    let found = |rig: &Rig| identify::identify(rig, Method::Exact).unwrap().assumptions;
    // None at that of the surroundings; and at 10 bar, a usual level.
    for (truth, declared, keep) in
        [("psi", "bar", &["compress-3bar", "expand-5bar", "compress-part"][..]), ("bar", "MPa", &[])]
    {
        let mut rig = misdeclared(7, truth, declared, false, keep);
        let notes = found(&rig);
        let is_note =
            |note: &String| note.contains(&format!("check the unit of the pressure column (unit = \"{truth}\")"));
        assert!(notes.iter().any(is_note), "{notes:?}");
        rig.pressure_unit = None;
        assert!(!found(&rig).iter().any(is_note));
    }
}

#[test]
fn pressures_in_their_own_unit_are_not_doubted() {
    for seed in 0..12 {
        for declared in ["bar", "kPa", "psi", "MPa", "Pa"] {
            let rig = misdeclared(seed, declared, declared, false, &[]);
            let data = identify::record::data::Data::prepare(&rig).unwrap();
            assert_eq!(data.unit_doubt, None, "{seed} {declared}");
        }
    }
}

#[test]
fn gauge_pressures_in_another_unit_are_recognised_by_the_misfit() {
    let keep = ["compress-3bar", "expand-5bar", "compress-part"];
    for (truth, declared) in [("psi", "bar"), ("bar", "psi"), ("kPa", "bar"), ("MPa", "bar")] {
        let error = refused(&misdeclared(7, truth, declared, true, &keep));
        assert!(matches!(error, Error::GaugeUnit { unit, .. } if unit == truth), "{truth} as {declared}: {error}");
    }
    // With records from the surroundings' pressure on the answer to the move is too small for any gas.
    let error = refused(&misdeclared(7, "bar", "psi", true, &[]));
    assert!(matches!(&error, Error::ConstantPressure { units, .. } if units[..] == ["bar"]), "{error}");
}

#[test]
fn an_implausible_level_names_the_units_that_would_make_one_of_compressed_air() {
    let error = refused(&misdeclared(7, "bar", "Pa", false, &[]));
    assert!(error.to_string().contains("(is it in bar?)"), "{error}");
}

#[test]
fn a_pressure_of_the_surroundings_in_another_unit_is_noted() {
    let mut rig = Recipe { repeats: 1, ..Recipe::from_seed(7) }.rig();
    let notes = |rig: &Rig| identify::identify(rig, Method::Exact).unwrap().assumptions;
    let is_note = |note: &String| note.contains("the pressure of the surroundings is stated as 0.0101 bar");
    assert!(!notes(&rig).iter().any(|note| note.contains("weather and altitude")));
    rig.ambient.pressure_pa = 1013.0;
    assert!(notes(&rig).iter().any(is_note), "{:?}", notes(&rig));
}

#[test]
fn a_short_stop_in_a_bounce_that_a_slow_or_coarse_gauge_sees_at_rest_is_no_open_port() {
    let mut recipe = Recipe { repeats: 1, rate_hz: 1000.0, noise_pa: 60.0, ..Recipe::from_seed(7) };
    for test in &mut recipe.tests {
        let (to, push_s, shape, hold_s) = test.moves[0];
        let back = to + 0.004 * (test.from_m - to);
        test.moves = vec![(to, push_s, shape, 0.025), (back, 0.02, shape, 0.025), (to, 0.02, shape, hold_s)];
    }
    let rig = recipe.rig();
    let read = |change: fn(&mut Vec<f64>)| {
        let mut rig = rig.clone();
        rig.experiments.iter_mut().flat_map(|e| &mut e.traces).for_each(|t| change(pressures(t)));
        identify::identify(&rig, Method::Exact).map(|found| found.parameters[0].1.value)
    };
    let slow = read(|p| *p = (0..p.len()).map(|i| p[i - i % 40]).collect()).unwrap();
    let coarse = read(|p| p.iter_mut().for_each(|p| *p = (*p / 2000.0).round() * 2000.0)).unwrap();
    let truth = recipe.chamber.heat_transfer.coefficient;
    assert!((slow / truth - 1.0).abs() < 0.03 && (coarse / truth - 1.0).abs() < 0.03, "{slow} {coarse} {truth}");
}

#[test]
fn a_piston_that_turns_without_a_stop_is_no_open_port() {
    for relaxes_faster in [1.0, 3.0] {
        let mut recipe = Recipe { repeats: 1, rate_hz: 2000.0, noise_pa: 60.0, ..Recipe::from_seed(7) };
        (recipe.position_noise_m, recipe.position_step_m) = (1e-5, 5e-5);
        recipe.chamber.heat_transfer.coefficient *= relaxes_faster;
        for test in &mut recipe.tests {
            let (to, _, _, hold_s) = test.moves[0];
            let turn = |to: f64, hold_s: f64| (to, 0.35, Shape::Cosine, hold_s);
            test.moves = vec![turn(to, 0.0), turn(test.from_m, 0.0), turn(to, 0.0), turn(test.from_m, hold_s)];
        }
        let found = identify::identify(&recipe.rig(), Method::Exact).map(|found| found.parameters[0].1.value);
        let (found, truth) = (found.unwrap(), recipe.chamber.heat_transfer.coefficient);
        assert!((found / truth - 1.0).abs() < 0.03, "{found} {truth}");
    }
}

#[test]
fn one_wrong_position_does_not_change_the_result_of_either_method() {
    let recipe = Recipe::from_seed(21);
    let rig = Recipe { chamber: recipe.with("leakage", &[2e-11, 0.3]).chamber, ..Recipe::from_seed(21) }.rig();
    let mut wrong = rig.clone();
    let at = wrong.experiments[1].traces[0].position_m.len() / 2;
    wrong.experiments[1].traces[0].position_m[at] += 0.02;
    for method in Method::ALL {
        let [as_it_is, beside_it] = [&rig, &wrong].map(|rig| {
            let found = identify::identify(rig, method).unwrap();
            let taus: Vec<f64> = found.experiments.iter().filter_map(|e| e.time_constant_s).collect();
            (found.parameters[0].1.value, found.noise_pa, taus)
        });
        let apart = |a: f64, b: f64| (a / b - 1.0).abs();
        assert!(apart(as_it_is.0, beside_it.0) < 0.01, "{method:?}: {} {}", as_it_is.0, beside_it.0);
        assert!(apart(as_it_is.1, beside_it.1) < 0.05, "{method:?}: {} {}", as_it_is.1, beside_it.1);
        assert_eq!(as_it_is.2.len(), beside_it.2.len());
        for (a, b) in as_it_is.2.iter().zip(&beside_it.2) {
            assert!(apart(*a, *b) < 0.01, "{method:?}: {a} {b}");
        }
    }
}

#[test]
fn the_papers_model_is_fitted_as_in_the_diagnosis_whatever_it_lacks() {
    let rig = Recipe::from_seed(5).with("gas_zones", &[0.3, 0.1]).rig();
    let alone = identify::identify(&rig, Method::Exact).unwrap();
    let beside = identify::diagnose(&rig, &|_, _| ()).unwrap().diagnosis;
    assert!(!alone.residual_is_noise);
    let (a, b) = (alone.parameters[0].1.value, beside.before.parameters[0].1.value);
    assert!((a / b - 1.0).abs() < 1e-3, "{a} {b}");
    assert!((alone.rmse_pa.fit / beside.before.rmse_pa.fit - 1.0).abs() < 1e-3);
}

#[test]
fn a_leak_that_shows_in_a_stop_shorter_than_its_move_is_no_open_port() {
    let laminar = chamber::effects::find("laminar_leakage").unwrap().0;
    let recipe = Recipe::wide(2_000_252).with_strength(laminar, 1.0).varied();
    assert!(recipe.tests.iter().any(|test| test.moves.len() > 1));
    assert!(identify::diagnose(&recipe.rig(), &|_, _| ()).is_ok());
}
