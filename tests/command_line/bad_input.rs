//! Bad input ends with exit code 1 and one sentence that names file, line and key or column; nothing is written.

use crate::common::{Bench, MODEL, RIG, motion, text};

const CALL: [&str; 8] = ["simulate", "model.toml", "--motion", "motion.csv", "--rig", "rig.toml", "-o", "out.csv"];

#[track_caller]
fn refused(file: &str, content: impl AsRef<[u8]>, parts: &[&str]) {
    let bench = Bench::new();
    bench.file(file, content);
    let sentence = bench.refusal(&CALL);
    for part in parts {
        assert!(sentence.contains(part), "`{part}` is not in: {sentence}");
    }
}

#[test]
fn in_a_motion() {
    refused("motion.csv", motion().replace("position_m", "positon_m"), &["motion.csv: line 1", "`positon_m`"]);
    refused("motion.csv", "", &["motion.csv: the file is empty"]);
    refused("motion.csv", "time_s,pressure_pa,position_m\n", &["motion.csv: there is no row"]);
    refused("motion.csv", b"PK\x03\x04\0\0\0", &["motion.csv: line 1: a ZIP archive"]);
}

#[test]
fn a_lone_bad_row_of_a_motion_is_dropped_and_named() {
    let bench = Bench::new();
    for (row, says) in [
        ("2.5,NaN,0.05", "line 202, column `pressure_pa`"),
        ("2.5,1e5,wide", "line 202, column `position_m`"),
        ("2.5,-20,0.05", "line 202, column `pressure_pa`"),
        ("2.5,1e5,0.3", "line 202, column `position_m`: position 0.3 m is beyond the stroke of 0.12 m"),
    ] {
        bench.file("motion.csv", format!("{}{row}\n", motion()));
        let notes = text(&bench.call(0, &CALL).stderr);
        assert!(notes.contains("1 row is left out") && notes.contains(says), "`{says}` is not in: {notes}");
    }
}

#[test]
fn in_a_model() {
    refused("model.toml", MODEL.replace("0.02", "-0.02"), &["model.toml: line 2: chamber.bore_m: -0.02"]);
    refused("model.toml", MODEL.replace("bore_m", "boer_m"), &["model.toml: line 2: chamber.boer_m", "`bore_m`"]);
    refused("model.toml", MODEL.replace("leakage", "leekage"), &["model.toml: line 6: effect.leekage", "`leakage`"]);
    refused("model.toml", MODEL.replace("1e-12", "1"), &["model.toml: line 7: effect.leakage.conductance_m3_per_s_pa"]);
    refused("model.toml", MODEL.replace("26.5", "\"26.5\""), &["model.toml: line 5", "expected a number"]);
    refused("model.toml", MODEL.replace("[chamber]", "[chamber"), &["model.toml: line 1, column", "not valid TOML"]);
    refused("model.toml", "", &["model.toml: line 1: chamber: missing"]);
    refused("model.toml", b"\xff\xfe\0", &["model.toml: cannot be read: line 1 has bytes that are not UTF-8"]);
}

#[test]
fn in_a_rig() {
    refused("rig.toml", RIG.replace("stroke_m", "stroke"), &["rig.toml: line 3: cylinder.stroke", "`stroke_m`"]);
    refused("rig.toml", RIG.replace("0.12", "-0.12"), &["rig.toml: line 3: cylinder.stroke_m: -0.12"]);
}

#[test]
fn a_file_of_another_kind_is_named_as_such() {
    let bench = Bench::new();
    bench.file("study.toml", "[study]\nname = \"a\"\n");
    // As written by `identify`.
    bench.file("whole_model.toml", "[gas]\nname = \"air\"\n[chamber]\nbore_m = 0.032\n");
    let of_rig = "motion.csv: this looks like a trace; a rig file (TOML) that names it is expected here";
    let of_model = "motion.csv: this looks like a trace; a model file (TOML)";
    let calls: [(&[&str], &str); 10] = [
        (&["fmu", "rig.toml"], "rig.toml: line 1: cylinder: belongs to a rig file"),
        (&["identify", "model.toml"], "model.toml: line 1: chamber: belongs to a model file"),
        (&["identify", "study.toml"], "study.toml: line 1: study: belongs to a study file"),
        (&["sweep", "rig.toml", "-o", "out"], "rig.toml: line 1: cylinder: belongs to a rig file"),
        (&["sweep", "whole_model.toml", "-o", "out"], "whole_model.toml: line 1: gas: belongs to a rig or model file"),
        (&["identify", "motion.csv"], of_rig),
        (&["diagnose", "motion.csv"], of_rig),
        (&["validate", "model.toml", "motion.csv"], of_rig),
        (&["simulate", "motion.csv", "--motion", "motion.csv"], of_model),
        (&["fmu", "motion.csv"], of_model),
    ];
    for (call, says) in calls {
        let sentence = bench.refusal(call);
        assert!(sentence.contains(says), "`{says}` is not in: {sentence}");
    }
}

#[test]
fn missing_files_are_named() {
    let bench = Bench::new();
    for missing in ["model.toml", "motion.csv", "rig.toml"] {
        let arguments: Vec<String> = CALL.iter().map(|a| a.replace(missing, &format!("no such {missing}"))).collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let sentence = bench.refusal(&arguments);
        assert!(sentence.starts_with(&format!("error: no such {missing}: cannot be read")), "{sentence}");
    }
}
