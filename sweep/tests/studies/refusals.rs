//! Errors in a study file are reported with line and key.

use crate::common::{model, study_at, text};
use sweep::Study;

fn refusal(text: &str) -> String {
    Study::about(&model(), text).map(drop).unwrap_err().to_string()
}

const BORE: &str = "bore_m = { values = [0.02, 0.03] }";

#[test]
fn an_unknown_key_is_offered_the_nearest_one() {
    let message = refusal(&text("desing = \"factorial\"", BORE));
    assert!(message.contains("study.desing: unknown key; did you mean `design`?"), "{message}");
    let message = refusal(&text("design = \"factorial\"\nseeed = 1", BORE));
    assert!(message.contains("line 3: study.seeed: unknown key; did you mean `seed`?"), "{message}");
    let message = refusal(&text("design = \"factorial\"", BORE).replace("push_time_s", "push_tme_s"));
    assert!(message.contains("push_time_s") || message.contains("push_tme_s"), "{message}");
    let message = refusal(&text("design = \"factorial\"", "bore_m = { vlues = [1] }"));
    assert!(message.contains("vary.bore_m.vlues: unknown key; did you mean `values`?"), "{message}");
}

#[test]
fn samples_and_counts_without_effect_are_noted() {
    let notes = |head: &str, vary: &str| Study::about(&model(), &text(head, vary)).unwrap().notes;
    assert!(notes("design = \"factorial\"", BORE).is_empty());
    let of_factorial = notes("design = \"factorial\"\nsamples = 16", BORE);
    assert_eq!(of_factorial, ["study.samples has no effect: a \"factorial\" design has the rows that it has"]);
    let of_sobol = notes("design = \"sobol\"\nsamples = 16", "bore_m = { from = 0.02, to = 0.03, count = 4 }");
    assert_eq!(of_sobol, ["vary.bore_m: count has no effect: a \"sobol\" design draws study.samples values"]);
}

#[test]
fn an_unknown_or_ambiguous_quantity_is_named_with_what_it_could_be() {
    let message = refusal(&text("design = \"factorial\"", "boer_m = { values = [0.02] }"));
    assert!(
        message.contains("line 12: vary.boer_m: is no number of the model or of the test; did you mean `bore_m`?"),
        "{message}"
    );
    let message = refusal(&text("design = \"factorial\"", "exponent = { values = [0.25] }"));
    assert!(
        message.contains("could be effect.natural_convection.exponent or effect.gas_column_length.exponent"),
        "{message}"
    );
}

#[test]
fn a_range_that_cannot_be_is_named() {
    for (vary, expected) in [
        ("bore_m = { from = -0.01, to = 0.02, count = 3 }", "takes -0.01, but has to be from 1e-4 to 5"),
        ("bore_m = { from = 0.03, to = 0.02, count = 3 }", "`from` has to be below `to`"),
        ("bore_m = { from = 0.01, to = 0.02 }", "needs a `count`"),
        ("bore_m = { from = 0.01, to = 0.02, count = 1 }", "expected a whole number, 2 or above"),
        ("bore_m = { from = 0.01, to = 0.02, count = 2.5 }", "expected a whole number, 2 or above"),
        ("rod_m = { from = 0.0, to = 0.02, count = 3, scale = \"log\" }", "a logarithmic scale needs a value above 0"),
        ("bore_m = { from = 0.01, to = 0.02, count = 3, scale = \"cubic\" }", "expected one of: linear, log"),
        ("bore_m = { from = 0.01, count = 3 }", "is incomplete"),
        ("bore_m = { values = [] }", "is empty"),
        ("bore_m = { values = [nan] }", "expected a finite number"),
        ("bore_m = 0.02", "is the number 0.02, expected { values = [...] }"),
        (
            "bore_m = { values = [0.02] }\n\"chamber.bore_m\" = { values = [0.02] }",
            "repeats chamber.bore_m, which line 12 varies already",
        ),
        ("bore_m = { values = [0.02] }\nvolume_to_area_m = { values = [0.004] }", "vary one of the two"),
        (
            "hold_time_constants = { values = [3.0] }",
            "duration_s and hold_time_constants both set the length of the test",
        ),
        ("", "vary: names no quantity; at least one quantity to vary is needed"),
    ] {
        let message = refusal(&text("design = \"factorial\"", vary));
        assert!(message.contains(expected), "{vary}: {message}");
    }
}

#[test]
fn a_study_beyond_all_measure_is_refused_before_it_takes_time_or_memory() {
    let more = "line 3: study.samples: asks for more rows than a study may have (1099511627776); coarsen the design";
    for (design, expected) in [
        ("design = \"sobol\"\nsamples = 1099511627777", more),
        ("design = \"sobol\"\nsamples = 9000000000000000000", more),
        ("design = \"latin-hypercube\"\nsamples = 9000000000000000000", more),
        // In this design a sample has three rows or more.
        ("design = \"saltelli\"\nsamples = 1000000000000", more),
        ("design = \"sobol\"\nsamples = 1000000000000\nparts = 100000000000", "at most 1048576 files are allowed"),
    ] {
        let message = refusal(&text(design, "bore_m = { from = 0.02, to = 0.03 }"));
        assert!(message.contains(expected), "{message}");
    }
    let levels = ["bore_m", "push_time_s", "final_stroke_m"]
        .map(|name| format!("{name} = {{ from = 0.01, to = 0.02, count = 2000000 }}"));
    let message = refusal(&text("design = \"factorial\"", &levels.join("\n")));
    assert!(message.contains("line 2: study.design: asks for more rows than a study may have"), "{message}");
    let largest = text("design = \"sobol\"\nsamples = 1099511627776", "bore_m = { from = 0.02, to = 0.03 }");
    assert_eq!(Study::about(&model(), &largest).unwrap().parts, 1 << 20);
}

#[test]
fn a_number_of_the_test_that_cannot_be_is_named() {
    let whole = text("design = \"factorial\"", BORE);
    for (from, to, expected) in [
        (
            "initial_pressure_pa = 1.01e5",
            "initial_pressure_pa = -1.0",
            "line 5: test.initial_pressure_pa: is -1, but has to be from 1000 to 1e8",
        ),
        ("initial_pressure_pa = 1.01e5", "", "test.initial_pressure_pa: missing"),
        ("duration_s = 5.0", "", "test.duration_s: missing; expected duration_s or hold_time_constants"),
        ("duration_s = 5.0", "duration_s = \"5 s\"", "expected a finite number"),
        ("[vary]", "[varry]", "varry: unknown key; did you mean `vary`?"),
        ("design = \"factorial\"", "design = \"grid\"", "expected one of: factorial, latin-hypercube"),
        ("design = \"factorial\"", "design = \"sobol\"", "study.samples: missing"),
        ("[study]", "[study", "line 1, column 7: not valid TOML"),
    ] {
        let message = refusal(&whole.replace(from, to));
        assert!(message.contains(expected), "{to}: {message}");
    }
}

#[test]
fn dotted_names_work_with_and_without_quotes_and_keep_the_files_order() {
    let vary = "effect.leakage.conductance_m3_per_s_pa = { values = [0.0] }\n\"test.push_time_s\" = { values = [0.04] }\nchamber.bore_m = { values = [0.02] }";
    let study = Study::about(&model(), &text("design = \"factorial\"", vary)).unwrap();
    let names: Vec<_> = study.varied.iter().map(|v| v.column.as_str()).collect();
    assert_eq!(names, ["effect.leakage.conductance_m3_per_s_pa", "test.push_time_s", "chamber.bore_m"]);
}

#[test]
fn a_name_that_could_mean_two_things_is_refused_with_both() {
    for (name, first, other) in [
        ("volume_m3", "effect.tube_volume.volume_m3", "chamber.dead_volume_m3"),
        ("volume_m3", "effect.tube_volume.volume_m3", "the result volume_m3"),
        ("time_constant_s", "effect.sensor_lag.time_constant_s", "the result time_constant_s"),
        ("pressure_pa", "ambient.pressure_pa", "test.initial_pressure_pa"),
        ("temperature_k", "ambient.temperature_k", "heat_transfer.reference_temperature_k"),
        ("coefficient", "effect.forced_convection.coefficient", "heat_transfer.coefficient_w_per_m2_k"),
    ] {
        let message = refusal(&text("design = \"factorial\"", &format!("{name} = {{ values = [1e5] }}")));
        let expected = format!("line 12: vary.{name}: could be {first} or ");
        assert!(message.contains(&expected) && message.contains(other), "{message}");
        assert!(message.contains(&format!("write `{first}`")), "{message}");
        let study = Study::about(&model(), &text("design = \"factorial\"", &format!("{first} = {{ values = [1.0] }}")));
        assert!(study.is_ok() || !study.unwrap_err().to_string().contains("could be"), "{first}");
    }
}

#[test]
fn a_value_that_no_row_could_use_is_refused_before_the_first_row() {
    let base = text("design = \"factorial\"", BORE);
    let by_length = "volume_to_area_by_length_m = { values = [0.004] }";
    for (vary, expected) in [
        (
            "rod_m = { values = [0.0, 0.02] }",
            "takes 0.02, but chamber.bore_m is 0.02 at most: the rod has to be thinner",
        ),
        (
            "bore_m = { values = [0.01, 0.03] }\nrod_m = { values = [0.012] }",
            "takes 0.01, but chamber.rod_m is 0.012 at least",
        ),
        (
            "push_time_s = { values = [0.04, 6.0] }",
            "takes 6, but test.duration_s is 5 at most: the test must not end before",
        ),
        ("final_stroke_m = { values = [0.0] }\ndead_volume_m3 = { values = [0.0] }", "takes 0 without a dead volume"),
        (
            "volume_to_area_m = { values = [0.03] }\ndead_volume_m3 = { values = [0.0] }",
            "takes 0.03, but at a final stroke of 0.05 m every bore gives less than 0.025 m",
        ),
        ("volume_to_area_m = { values = [0.004, 1e-9] }", "takes 0.000000001, but no bore gives less than"),
        ("volume_to_area_m = { values = [0.004, 0.04] }", "takes 0.04, but no bore gives more than 0.02"),
        (
            "volume_to_area_by_length_m = { values = [0.005] }",
            "at a bore of 0.02 m every length gives less than 0.005000 m",
        ),
        (
            "dead_volume_m3 = { values = [1e-3] }\nvolume_to_area_by_length_m = { values = [0.001] }",
            "takes 0.001, but at a bore of 0.02 m every length gives more than 0.004984 m",
        ),
        (
            "bore_m = { values = [0.02, 0.03] }\nvolume_to_area_by_length_m = { values = [0.006, 0.008] }",
            "takes 0.008, but at a bore from 0.02 m to 0.03 m every length gives less than 0.007500 m",
        ),
        (&format!("{by_length}\nfinal_stroke_m = {{ values = [0.05] }}"), "is what both strokes are solved from"),
        (&format!("{by_length}\nvolume_to_area_m = {{ values = [0.004] }}"), "solved for in two ways"),
    ] {
        let message = refusal(&text("design = \"factorial\"", vary));
        assert!(message.contains("study: line 1") && message.contains(expected), "{vary}: {message}");
    }
    let message = refusal(&base.replace("duration_s = 5.0", "duration_s = 0.01"));
    assert!(message.contains("the test must not end before its push"), "{message}");
    let no_heat = "coefficient_w_per_m2_k = { values = [0.0, 20.0] }";
    let message =
        refusal(&text("design = \"factorial\"", no_heat).replace("duration_s = 5.0", "hold_time_constants = 5.0"));
    assert!(message.contains("takes 0: without heat transfer there is no time constant"), "{message}");
}

#[test]
fn what_has_no_closed_form_is_refused_with_its_name_where_only_that_is_to_be_taken() {
    let refused = |vary: &str| refusal(&text("design = \"factorial\"\nsolver = \"exact\"", vary));
    for (vary, expected) in [
        (
            "effect.leakage.conductance_m3_per_s_pa = { values = [0.0, 1e-12] }",
            "line 13: vary.effect.leakage.conductance_m3_per_s_pa: takes 1e-12: with the effect leakage there is no closed form",
        ),
        (
            "effect.pressure_exponent.temperature_exponent = { values = [0.4, 0.5] }",
            "takes 0.4: with the effect pressure_exponent",
        ),
        ("mass_flow_in_kg_per_s = { values = [0.0, 1e-6] }", "takes 1e-6: with a mass flow there is no closed form"),
    ] {
        let message = refused(vary);
        assert!(message.contains(expected) && message.contains("set solver = \"auto\""), "{vary}: {message}");
    }
    let mut leaking = model();
    leaking.chamber.effects.of_mut(chamber::effects::find("leakage").unwrap().0)[0] = 1e-12;
    let exact = text("design = \"factorial\"\nsolver = \"exact\"", BORE);
    let message = Study::about(&leaking, &exact).map(drop).unwrap_err().to_string();
    assert!(message.contains("study: effect.leakage.conductance_m3_per_s_pa takes 1e-12"), "{message}");
    let off = "effect.leakage.conductance_m3_per_s_pa = { values = [0.0] }\nmass_flow_in_kg_per_s = { values = [0.0] }";
    assert!(Study::about(&leaking, &text("design = \"factorial\"\nsolver = \"exact\"", off)).is_ok());
    let kept = "effect.warm_wall.temperature_difference_k = { values = [0.0, 5.0] }\neffect.sensor_lag.time_constant_s = { values = [0.0, 0.01] }";
    assert!(Study::about(&model(), &text("design = \"factorial\"\nsolver = \"exact\"", kept)).is_ok());
}

#[test]
fn every_row_of_a_table_is_checked_before_the_first_is_solved() {
    let folder = tempfile::tempdir().unwrap();
    model().write(&folder.path().join("model.toml")).unwrap();
    let good = "0.02,1e-11,0.0\n".repeat(20_000);
    for (last, expected) in [
        (
            "0.02,-1e-11,0.0",
            "line 20002, column `leakage.conductance_m3_per_s_pa`: is -1e-11, but has to be from 0 to 1e-7",
        ),
        ("0,1e-11,0.0", "line 20002, column `bore_m`: is 0, but has to be from 1e-4 to 5"),
        ("0.02,1e-11,0.03", "row 20000: chamber.rod_m takes 0.03, but chamber.bore_m is 0.02 at most"),
    ] {
        let header = "bore_m,leakage.conductance_m3_per_s_pa,rod_m\n";
        std::fs::write(folder.path().join("points.csv"), format!("{header}{good}{last}\n")).unwrap();
        let head = "model = \"model.toml\"\ndesign = \"table\"\ntable = \"points.csv\"";
        let message = study_at(&text(head, ""), &folder.path().join("study.toml")).map(drop).unwrap_err().to_string();
        assert!(message.contains("points.csv: ") && message.contains(expected), "{message}");
    }
    std::fs::write(folder.path().join("points.csv"), "bore_m,leakage.conductance_m3_per_s_pa\n0.02,0\n0.02,1e-12\n")
        .unwrap();
    let exact = "model = \"model.toml\"\ndesign = \"table\"\ntable = \"points.csv\"\nsolver = \"exact\"";
    let message = study_at(&text(exact, ""), &folder.path().join("study.toml")).map(drop).unwrap_err().to_string();
    assert!(message.contains("row 1: effect.leakage.conductance_m3_per_s_pa takes 1e-12"), "{message}");
}

#[test]
fn statistics_that_cannot_be_are_named() {
    for (statistics, expected) in [
        ("columns = [\"pressure_peek_pa\"]", "which is no result of this study; did you mean `pressure_peak_pa`?"),
        ("columns = []", "is empty"),
        ("quantiles = [0.5, 1.5]", "takes 1.5; probabilities from 0 to 1"),
        ("quantlies = [0.5]", "statistics.quantlies: unknown key; did you mean `quantiles`?"),
        ("histograms = { volume_m3 = { from = 1.0, to = 0.0, bins = 3 } }", "`from` has to be below `to`"),
        ("histograms = { volume_m3 = { from = 0.0, to = 1.0, bins = 0 } }", "expected a whole number, 1 or above"),
        ("histograms = { volume_m3 = { from = 0.0, to = 1.0, bins = 1000000 } }", "at most 100000"),
        (
            "columns = [\"area_m2\"]\nhistograms = { volume_m3 = { from = 0.0, to = 1.0, bins = 3 } }",
            "is none of the `columns`",
        ),
    ] {
        let message = refusal(&(text("design = \"factorial\"", BORE) + "[statistics]\n" + statistics));
        assert!(message.contains("line 1") && message.contains(expected), "{statistics}: {message}");
    }
}
