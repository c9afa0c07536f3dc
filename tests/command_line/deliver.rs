//! `pneutherm fmu` and `pneutherm sweep`: what they write, and what they refuse.

use crate::common::{Bench, MODEL, text};

const STUDY: &str = "\
[study]
name = \"bores\"
model = \"model.toml\"
design = \"factorial\"
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.1
final_stroke_m = 0.05
push_time_s = 0.04
duration_s = 2.0
[vary]
bore_m = { values = [0.016, 0.032] }
initial_pressure_pa = { from = 1.0e5, to = 3.0e5, count = 3 }
";

fn bench() -> Bench {
    let bench = Bench::new();
    bench.file("study.toml", STUDY);
    bench
}

#[test]
fn an_fmu_is_a_zip_archive_the_same_each_time() {
    let bench = bench();
    let told = text(&bench.call(0, &["fmu", "model.toml", "-o", "my chamber.fmu"]).stdout);
    assert!(
        told.contains("my chamber.fmu: FMI 2.0, Model Exchange and co-simulation, for linux64")
            || !cfg!(target_os = "linux"),
        "{told}"
    );
    let archive = std::fs::read(bench.path("my chamber.fmu")).unwrap();
    assert!(archive.starts_with(b"PK\x03\x04"));
    let names = ["modelDescription.xml", "binaries/", "resources/"];
    assert!(names.iter().all(|name| archive.windows(name.len()).any(|part| part == name.as_bytes())));
    // Its name is the file's; standard output has none.
    assert!(bench.call(0, &["fmu", "model.toml", "-o", "-"]).stdout.starts_with(b"PK\x03\x04"));
    bench.call(0, &["fmu", "model.toml", "-o", "my chamber.fmu"]);
    assert!(std::fs::read(bench.path("my chamber.fmu")).unwrap() == archive, "two archives of one model differ");
}

#[test]
fn a_record_inside_an_fmu_has_the_error_of_simulate_though_its_stroke_is_recorded_late() {
    let bench = bench();
    bench.file("late.toml", format!("{MODEL}[effect.position_delay]\ndelay_s = 0.02\n"));
    let told = text(&bench.call(0, &["fmu", "late.toml", "--validation", "rig.toml", "-o", "a.fmu"]).stdout);
    let stated = told.split("error of the model ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    bench.call(0, &["simulate", "late.toml", "--motion", "motion.csv", "-o", "simulated.csv"]);
    let pressures = |name: &str| -> Vec<f64> {
        let table = std::fs::read_to_string(bench.path(name)).unwrap();
        let place = table.lines().next().unwrap().split(',').position(|column| column == "pressure_pa").unwrap();
        table.lines().skip(1).map(|row| row.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    let (simulated, measured) = (pressures("simulated.csv"), pressures("motion.csv"));
    let squares: f64 = simulated.iter().zip(&measured).map(|(a, b)| (a - b).powi(2)).sum();
    let error = (squares / measured.len() as f64).sqrt();
    assert!((stated.parse::<f64>().unwrap() / error - 1.0).abs() < 1e-2, "{told} {error}");
    assert!(told.contains("left out of the model: position_delay"), "{told}");
}

#[test]
fn an_fmu_of_a_faulty_model_or_at_an_impossible_place_is_refused() {
    let bench = bench();
    bench.file("faulty.toml", MODEL.replace("bore_m", "boer_m"));
    let sentence = bench.refusal(&["fmu", "faulty.toml", "-o", "a.fmu"]);
    assert!(sentence.contains("faulty.toml: line 2: chamber.boer_m"), "{sentence}");
    assert!(bench.refusal(&["fmu", "absent.toml"]).contains("absent.toml: cannot be read"));
    let sentence = bench.refusal(&["fmu", "model.toml", "-o", "absent/a.fmu"]);
    assert!(sentence.contains("absent/a.fmu: cannot be written"), "{sentence}");
}

#[test]
fn a_study_becomes_parts_and_a_manifest() {
    let bench = bench();
    bench.call(0, &["sweep", "study.toml", "-o", "my results"]);
    let manifest = std::fs::read(bench.path("my results/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    assert!(manifest.to_string().contains("bores"), "{manifest}");
    let parts = std::fs::read_dir(bench.path("my results/rows"))
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().path().extension().is_some_and(|extension| extension == "parquet"));
    assert!(parts.count() >= 1);
    bench.call(0, &["sweep", "study.toml", "-o", "my results"]);
    bench.file("study.toml", STUDY.replace("0.032", "0.04"));
    let sentence = bench.refusal(&["sweep", "study.toml", "-o", "my results"]);
    assert!(sentence.contains("my results"), "{sentence}");
}

#[test]
fn a_dry_run_writes_nothing() {
    let bench = bench();
    let before = bench.names();
    let told = text(&bench.call(0, &["sweep", "study.toml", "-o", "out", "--dry-run"]).stdout);
    assert!(told.contains("rows       6 "), "{told}");
    assert_eq!(bench.names(), before);
}

#[test]
fn faulty_studies_are_refused_by_line_and_key() {
    let faults = [
        ("bore_m", "boer_m", "study.toml: line 12", "bore_m"),
        ("\"factorial\"", "\"factorail\"", "study.toml: line 4", "factorial"),
        ("initial_stroke_m = 0.1", "initial_strok_m = 0.1", "study.toml: line 7", "initial_stroke_m"),
        ("initial_stroke_m = 0.1", "initial_stroke_m = -0.1", "study.toml: line 7", "initial_stroke_m"),
        ("0.016, 0.032", "-0.016", "study.toml: line 12", "bore_m"),
        ("count = 3", "count = \"3\"", "study.toml: line 13", "count"),
        ("\"model.toml\"", "\"absent.toml\"", "absent.toml", "cannot be read"),
        ("[vary]", "[vary", "study.toml: line 11", "unclosed table"),
    ];
    for (from, to, place, says) in faults {
        let bench = bench();
        bench.file("study.toml", STUDY.replacen(from, to, 1));
        let sentence = bench.refusal(&["sweep", "study.toml", "-o", "out"]);
        assert!(sentence.contains(place) && sentence.contains(says), "`{place}` and `{says}`: {sentence}");
    }
}

#[test]
fn a_shard_that_is_none_is_wrong_usage() {
    for shard in ["4/4", "x", "-1/3", "1/0"] {
        bench().call(2, &["sweep", "study.toml", "-o", "out", &format!("--shard={shard}")]);
    }
}
