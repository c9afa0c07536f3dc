//! What is wrong with a study file is said with its line and key.

mod common;

use common::{model, text};
use sweep::Study;

fn refusal(text: &str) -> String {
    Study::about(&model(), text).map(drop).unwrap_err().to_string()
}

const BORE: &str = "bore_m = { values = [0.02, 0.03] }";

#[test]
fn an_unknown_key_is_offered_the_nearest_one() {
    let message = refusal(&text("desing = \"factorial\"", BORE));
    assert!(message.contains("has no `design`") || message.contains("did you mean `design`?"), "{message}");
    let message = refusal(&text("design = \"factorial\"\nseeed = 1", BORE));
    assert!(message.contains("line 3: `seeed` is not known in [study]; did you mean `seed`?"), "{message}");
    let message = refusal(&text("design = \"factorial\"", BORE).replace("push_time_s", "push_tme_s"));
    assert!(message.contains("push_time_s") || message.contains("push_tme_s"), "{message}");
    let message = refusal(&text("design = \"factorial\"", "bore_m = { vlues = [1] }"));
    assert!(message.contains("`vlues` is not known in [bore_m]; did you mean `values`?"), "{message}");
}

#[test]
fn an_unknown_or_ambiguous_quantity_is_named_with_what_it_could_be() {
    let message = refusal(&text("design = \"factorial\"", "boer_m = { values = [0.02] }"));
    assert!(
        message.contains("line 12: `boer_m` is no number of the model or of the test; did you mean `bore_m`?"),
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
        ("bore_m = { from = -0.01, to = 0.02, count = 3 }", "takes -0.01, but has to be above 0"),
        ("bore_m = { from = 0.03, to = 0.02, count = 3 }", "`from` has to be below `to`"),
        ("bore_m = { from = 0.01, to = 0.02 }", "needs a `count`"),
        ("bore_m = { from = 0.01, to = 0.02, count = 1 }", "has to be a whole number from 2 on"),
        ("bore_m = { from = 0.01, to = 0.02, count = 2.5 }", "has to be a whole number from 2 on"),
        ("rod_m = { from = 0.0, to = 0.02, count = 3, scale = \"log\" }", "a logarithmic scale needs a value above 0"),
        (
            "bore_m = { from = 0.01, to = 0.02, count = 3, scale = \"cubic\" }",
            "one of \"linear\", \"log\" was expected",
        ),
        ("bore_m = { from = 0.01, count = 3 }", "says too little"),
        ("bore_m = { values = [] }", "is empty"),
        ("bore_m = { values = [nan] }", "has to be a list of finite numbers"),
        ("bore_m = 0.02", "is float"),
        (
            "bore_m = { values = [0.02] }\n\"chamber.bore_m\" = { values = [0.02] }",
            "is chamber.bore_m once more: line 12",
        ),
        ("bore_m = { values = [0.02] }\nvolume_to_area_m = { values = [0.004] }", "vary one of the two"),
        ("hold_time_constants = { values = [3.0] }", "keep one of duration_s and hold_time_constants"),
        ("", "at least one quantity to vary was expected"),
    ] {
        let message = refusal(&text("design = \"factorial\"", vary));
        assert!(message.contains(expected), "{vary}: {message}");
    }
}

#[test]
fn a_study_beyond_all_measure_is_refused_before_it_takes_time_or_memory() {
    for (design, expected) in [
        ("design = \"sobol\"\nsamples = 4000000000000000", "more rows than a study may have (1099511627776)"),
        ("design = \"saltelli\"\nsamples = 4000000000000000", "more rows than a study may have (1099511627776)"),
        ("design = \"sobol\"\nsamples = 1000000000000\nparts = 100000000000", "1048576 files at most were expected"),
    ] {
        let message = refusal(&text(design, "bore_m = { from = 0.02, to = 0.03 }"));
        assert!(message.contains(expected), "{message}");
    }
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
            "line 5: `initial_pressure_pa` is -1, but has to be above 0",
        ),
        ("initial_pressure_pa = 1.01e5", "", "[test] has no `initial_pressure_pa`"),
        ("duration_s = 5.0", "duration_s = 0.01", "the test would end before its push of 0.04 s"),
        ("duration_s = 5.0", "", "duration_s or hold_time_constants was expected"),
        ("duration_s = 5.0", "duration_s = \"5 s\"", "is a string: a finite number was expected"),
        ("[vary]", "[varry]", "`varry` is not known in a study file; did you mean `vary`?"),
        ("design = \"factorial\"", "design = \"grid\"", "one of \"factorial\", \"latin-hypercube\""),
        ("design = \"factorial\"", "design = \"sobol\"", "[study] has no `samples`"),
        ("[study]", "[study", "line 1:"),
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
fn a_quantity_named_like_a_result_gets_a_column_of_its_full_name() {
    let study =
        Study::about(&model(), &text("design = \"factorial\"", "tube_volume.volume_m3 = { values = [0.0] }")).unwrap();
    assert_eq!(study.varied[0].column, "tube_volume.volume_m3");
    let study = Study::about(&model(), &text("design = \"factorial\"", "volume_m3 = { values = [0.0] }")).unwrap();
    assert_eq!(study.varied[0].column, "effect.tube_volume.volume_m3");
}
