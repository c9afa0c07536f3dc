//! `pneutherm identify` and `pneutherm diagnose` on the example cylinder, whose leak is known, and on bad rigs.

use crate::common::{Bench, text};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The example's folder: five experiments of three repeats, a leaking cylinder.
fn example() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/cylinder")
}

/// A bench with a copy of the example's rig and traces.
fn bench() -> Bench {
    let bench = Bench::new();
    for entry in std::fs::read_dir(example()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, bench.path(path.file_name().unwrap())).unwrap();
        }
    }
    bench
}

fn number(json: &Value, pointer: &str) -> f64 {
    json.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number at {pointer} in {json}"))
}

#[test]
fn identify_writes_the_contract_s_json_and_a_model_that_can_be_simulated() {
    let bench = bench();
    for method in ["exact", "time-constant"] {
        let call = ["identify", "rig.toml", "--method", method, "--json", "-", "-o", "identified.toml"];
        let json: Value = serde_json::from_slice(&bench.call(0, &call).stdout).unwrap();
        assert_eq!(json["method"], method);
        for name in ["lambda0_w_per_m2_k", "dead_volume_m3", "mass_kg"] {
            let [value, low, high] =
                ["value", "ci95/0", "ci95/1"].map(|part| number(&json, &format!("/parameters/{name}/{part}")));
            assert!(low <= value && value <= high && value > 0.0, "{method}, {name}: {low} {value} {high}");
            assert!(json["parameters"][name]["unit"].is_string());
        }
        assert!(number(&json, "/rmse_pa/fit") > 0.0);
        assert_eq!(json["experiments"].as_array().unwrap().len(), 5);
        assert!(number(&json, "/experiments/0/time_constant_s") > 0.0);
        let simulated = bench.call(0, &["simulate", "identified.toml", "--motion", "validation.csv"]).stdout;
        assert_eq!(
            text(&simulated).lines().count(),
            text(&std::fs::read(bench.path("validation.csv")).unwrap()).lines().count()
        );
    }
}

#[test]
fn a_record_with_several_moves_has_no_values_by_the_paper_s_steps_and_the_reason_is_shown() {
    let bench = bench();
    let rig = std::fs::read_to_string(bench.path("rig.toml")).unwrap();
    bench.file("more.toml", rig + "\n[[experiment]]\nname = \"several\"\ntraces = [\"validation.csv\"]\n");
    let out = text(&bench.call(0, &["identify", "more.toml", "--json", "more.json"]).stdout);
    let row = out.lines().find(|line| line.starts_with("several ")).unwrap_or_else(|| panic!("{out}"));
    assert_eq!(row.split_whitespace().filter(|cell| *cell == "-").count(), 3, "{out}");
    assert!(out.contains("several: no values by the paper's steps: the piston moves more than once"), "{out}");
    let json: Value = serde_json::from_slice(&std::fs::read(bench.path("more.json")).unwrap()).unwrap();
    assert!(
        json["experiments"][5]["steps_lambda0_w_per_m2_k"].is_null()
            && json["experiments"][0]["steps_refused"].is_null()
    );
    assert!(json["experiments"][5]["steps_refused"].is_string(), "{json}");
}

#[test]
fn diagnose_names_the_leak_and_its_model_predicts_a_motion_it_never_saw() {
    let bench = bench();
    let output = bench.call(0, &["diagnose", ".", "--json", "-", "-o", "diagnosed.toml"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let truth: Value = serde_json::from_slice(&std::fs::read(bench.path("answer.json")).unwrap()).unwrap();
    assert_eq!(json["verdict"], "explained");
    assert_eq!(json["effects"][0], truth["effect"], "{truth}");
    assert!(number(&json, "/after/rmse_pa/held_out") < number(&json, "/before/rmse_pa/held_out"));
    let model = text(&std::fs::read(bench.path("diagnosed.toml")).unwrap());
    for part in ["[effect.leakage]", "[provenance]", "sha256 = ", "compress-3bar-1.csv", "rmse_before_pa"] {
        assert!(model.contains(part), "{part} is not in:\n{model}");
    }
    let simulated = text(&bench.call(0, &["simulate", "diagnosed.toml", "--motion", "validation.csv"]).stdout);
    let measured = text(&std::fs::read(bench.path("validation.csv")).unwrap());
    let column = |table: &str| -> Vec<f64> {
        table.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect()
    };
    let squares = column(&simulated).iter().zip(column(&measured)).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let rmse = (squares / (measured.lines().count() - 1) as f64).sqrt();
    assert!(rmse < 1.1 * 150.0, "{rmse} Pa rms where the noise is 150 Pa");
}

#[test]
fn the_same_traces_give_the_same_bytes() {
    let bench = bench();
    let model = || {
        let call = bench.command().args(["diagnose", ".", "-o", "-"]).env("SOURCE_DATE_EPOCH", "0").output().unwrap();
        text(&call.stdout)
    };
    let first = model();
    assert!(first.contains("date = \"1970-01-01T00:00:00Z\""), "{first}");
    assert_eq!(first, model());
}

#[test]
fn bad_rigs_and_traces_are_refused_and_nothing_is_written() {
    let faults = [
        ("rig.toml", "bore_m", "boer_m", "rig.toml: line 3: cylinder.boer_m: unknown key; did you mean `bore_m`?"),
        ("rig.toml", "0.032", "-0.032", "rig.toml: line 3: cylinder.bore_m: -0.032 is out of range"),
        ("rig.toml", "compress-3bar-2.csv", "absent.csv", "absent.csv: cannot be read"),
        ("rig.toml", "[[experiment]]", "[[experimnt]]", "did you mean `experiment`?"),
        ("expand-5bar-2.csv", "pressure_pa", "pressure", "expand-5bar-2.csv: line 1: there is no column `pressure_pa`"),
    ];
    for command in ["identify", "diagnose"] {
        for (file, from, to, says) in faults {
            let bench = bench();
            let good = text(&std::fs::read(bench.path(file)).unwrap());
            assert!(good.contains(from), "{file} has no {from}");
            bench.file(file, good.replacen(from, to, 1));
            let sentence = bench.refusal(&[command, "rig.toml", "-o", "out.toml", "--json", "out.json"]);
            assert!(sentence.contains(says), "`{says}` is not in: {sentence}");
        }
    }
}

/// Keys documented in the guide for a command's JSON.
fn documented(command: &str) -> BTreeSet<String> {
    let page = include_str!("../../book/src/reference/files.md");
    let section = page.split("## Results for programs").nth(1).unwrap();
    let of_command = section.split(&format!("\n`{command}`:\n")).nth(1).unwrap();
    let rows = of_command.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let keys = rows.take_while(|line| line.starts_with('|')).map(|line| line.split('|').nth(1).unwrap());
    keys.flat_map(|keys| keys.split(", ").map(|key| key.trim().trim_matches('`').to_owned())).collect()
}

#[test]
fn the_guide_documents_every_key_of_every_json() {
    let bench = bench();
    bench.call(0, &["identify", "rig.toml", "-o", "identified.toml"]);
    for call in [
        &["identify", "rig.toml"][..],
        &["diagnose", "rig.toml"],
        &["validate", "identified.toml", "validation.toml"],
        &["look", "validation.csv"],
    ] {
        let output = bench.call(0, &[call, &["--json", "-"]].concat());
        let json: serde_json::Map<String, Value> = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(json.keys().cloned().collect::<BTreeSet<_>>(), documented(call[0]), "{call:?}");
    }
}

#[test]
fn validate_notes_records_that_the_model_was_identified_from_and_a_rig_that_is_not_the_model_s() {
    let bench = bench();
    bench.call(0, &["identify", "rig.toml", "--method", "time-constant", "-o", "identified.toml"]);
    let notes = |rig: &str| {
        let json = bench.call(0, &["validate", "identified.toml", rig, "--json", "-"]).stdout;
        let json: Value = serde_json::from_slice(&json).unwrap();
        let notes = json["notes"].as_array().unwrap().iter().map(|note| note.as_str().unwrap().to_owned());
        notes.collect::<Vec<_>>()
    };
    assert_eq!(notes("validation.toml"), Vec::<String>::new());
    let of_own =
        "the model was identified from all 15 records; the error there is that of the fit, not of a prediction";
    assert_eq!(notes("rig.toml"), [of_own]);
    let rig = std::fs::read_to_string(bench.path("validation.toml")).unwrap();
    let rig = rig.replace("bore_m = 0.032", "bore_m = 0.02").replace("\"air\"", "\"helium\"");
    bench.file("other.toml", rig);
    let found = notes("other.toml");
    assert!(found[0].starts_with("bore: 20.00 mm in the rig file, 32.00 mm in the model"), "{found:?}");
    assert!(found[1].starts_with("gas: helium, R = 2077"), "{found:?}");
    let table = text(&bench.call(0, &["validate", "identified.toml", "rig.toml"]).stdout);
    assert!(table.contains(&format!("note: {of_own}")), "{table}");
}
