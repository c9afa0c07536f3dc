//! `pneutherm fmu` and `pneutherm sweep`: their output and refusals.

use crate::common::{Bench, MODEL, RIG, motion, text};

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
    // It is named after the file; standard output has no name.
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
fn readings_far_off_are_no_part_of_the_record_in_an_fmu_nor_of_the_error() {
    let bench = bench();
    let noise = |k: usize| f64::from(u8::try_from(k * 7919 % 101).unwrap()) - 50.0;
    bench.call(0, &["simulate", "model.toml", "--motion", "motion.csv", "-o", "clean.csv"]);
    let clean = std::fs::read_to_string(bench.path("clean.csv")).unwrap();
    let columns: Vec<&str> = clean.lines().next().unwrap().split(',').collect();
    let place = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let (pressure, motion) = (place("pressure_pa"), motion());
    // One marker during the rest, one spike during the hold.
    let record = |spoilt: &[(usize, &str)]| {
        let row = |(k, (line, clean)): (usize, (&str, &str))| {
            let (time, rest) = line.split_once(',').unwrap();
            let (_, position) = rest.split_once(',').unwrap();
            let value: f64 = clean.split(',').nth(pressure).unwrap().parse().unwrap();
            let value =
                spoilt.iter().find(|(row, _)| *row == k).map_or(format!("{}", value + noise(k)), |s| s.1.into());
            format!("{time},{value},{position}\n")
        };
        let rows = motion.lines().skip(1).zip(clean.lines().skip(1)).enumerate().map(row);
        "time_s,pressure_pa,position_m\n".to_owned() + &rows.collect::<String>()
    };
    let told = |spoilt: &[(usize, &str)]| {
        bench.file("motion.csv", record(spoilt));
        let output = bench.call(0, &["fmu", "model.toml", "--validation", "rig.toml", "-o", "a.fmu"]);
        let told = text(&output.stdout);
        let stated = told.split("error of the model ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
        (stated.parse::<f64>().unwrap(), text(&output.stderr))
    };
    let (error, note) = told(&[]);
    assert!((20.0..40.0).contains(&error) && note.is_empty(), "{error} {note}");
    let (spoilt, note) = told(&[(8, "1000000.0"), (150, "990000.0")]);
    assert!((spoilt / error - 1.0).abs() < 0.1, "{spoilt} for {error}: {note}");
    assert!(note.contains("motion.csv: 2 readings far off are left out (lines 10, 152;"), "{note}");
}

#[test]
fn an_fmu_says_so_where_readings_far_off_are_not_looked_for_in_its_records() {
    let bench = bench();
    let rest: String = (0..200).map(|k| format!("{},101300,0.1\n", 0.01 * f64::from(k))).collect();
    bench.file("motion.csv", format!("time_s,pressure_pa,position_m\n{rest}"));
    let refused = bench.refusal(&["validate", "model.toml", "rig.toml"]);
    let output = bench.call(0, &["fmu", "model.toml", "--validation", "rig.toml", "-o", "a.fmu"]);
    let note = text(&output.stderr);
    let reason = refused.strip_prefix("error: rig.toml: ").unwrap();
    assert_eq!(note, format!("note: readings far off are not looked for: {reason}"));
}

#[cfg(unix)]
#[test]
fn a_model_from_a_pipe_gives_the_fmu_of_its_file() {
    let bench = bench();
    bench.call(0, &["fmu", "model.toml", "-o", "a.fmu"]);
    let of_file = std::fs::read(bench.path("a.fmu")).unwrap();
    bench.pipe("pipe");
    let pipe = bench.path("pipe");
    let writer = std::thread::spawn(move || std::fs::write(pipe, MODEL).unwrap());
    bench.call(0, &["fmu", "pipe", "-o", "a.fmu"]);
    writer.join().unwrap();
    assert!(std::fs::read(bench.path("a.fmu")).unwrap() == of_file, "the pipe's FMU is another");
}

#[cfg(unix)]
#[test]
fn a_table_of_points_that_is_no_file_is_refused_at_once() {
    let bench = bench();
    bench.pipe("points.csv");
    std::fs::create_dir(bench.path("points.parquet")).unwrap();
    let (head, _) = STUDY.split_once("[vary]").unwrap();
    for name in ["points.csv", "points.parquet"] {
        let design = format!("\"table\"\ntable = \"{name}\"");
        bench.file("study.toml", head.replace("\"factorial\"", &design));
        let sentence = bench.refusal(&["sweep", "study.toml", "-o", "out"]);
        assert!(sentence.contains(&format!("{name}: it is no file; expected a Parquet or CSV file")), "{sentence}");
    }
}

#[test]
fn what_is_no_date_does_not_become_one_in_an_fmu() {
    let bench = bench();
    bench.file("dated.toml", format!("{MODEL}[provenance]\ndate = \"yesterday\"\n"));
    let sentence = bench.refusal(&["fmu", "dated.toml", "-o", "a.fmu"]);
    assert!(sentence.contains("provenance.date = \"yesterday\" is no date"), "{sentence}");
    for epoch in ["99999999999999", "-1", "now"] {
        let call = bench.command().args(["fmu", "model.toml", "-o", "a.fmu"]).env("SOURCE_DATE_EPOCH", epoch).output();
        let told = text(&call.unwrap().stderr);
        assert!(told.contains("expected whole seconds since 1970, before the year 10000"), "{epoch}: {told}");
    }
}

#[test]
fn a_version_of_fmi_is_known_with_and_without_its_decimal() {
    let bench = bench();
    for (version, told) in [("2", "FMI 2.0"), ("2.0", "FMI 2.0"), ("3", "FMI 3.0"), ("3.0", "FMI 3.0")] {
        let out = text(&bench.call(0, &["fmu", "model.toml", "--fmi", version, "-o", "a.fmu"]).stdout);
        assert!(out.contains(told), "{version}: {out}");
    }
    assert!(text(&bench.call(2, &["fmu", "model.toml", "--fmi", "1.0"]).stderr).contains("expected 2 or 3"));
}

#[test]
fn an_fmu_under_another_ending_is_noted() {
    let bench = bench();
    let note = |name: &str| text(&bench.call(0, &["fmu", "model.toml", "-o", name]).stderr);
    assert_eq!(note("Chamber.zip"), "note: Chamber.zip: most tools open an FMU only if its name ends in .fmu\n");
    for name in ["Chamber.fmu", "Chamber.FMU", "-"] {
        assert_eq!(note(name), "", "{name}");
    }
}

#[test]
fn records_of_another_rig_in_an_fmu_are_noted_as_validate_notes_them() {
    let bench = bench();
    let notes = |rig: &str| {
        bench.file("other.toml", rig);
        text(&bench.call(0, &["fmu", "model.toml", "--validation", "other.toml", "-o", "a.fmu"]).stderr)
    };
    // The pressure of the bench's motion does not respond to the stroke, which is noted too.
    let not_looked_for = "note: readings far off are not looked for: motion.csv: the pressure stays within";
    assert!(notes(RIG).starts_with(not_looked_for) && notes(RIG).lines().count() == 1, "{}", notes(RIG));
    let found = notes(&RIG.replace("bore_m = 0.02", "bore_m = 0.032"));
    assert!(found.starts_with("note: bore: 32.00 mm in the rig file, 20.00 mm in the model, which is used"), "{found}");
    assert!(notes(&format!("{RIG}[gas]\nname = \"helium\"\n")).contains("note: gas: helium, R = 2077"));
}

#[test]
fn reproduce_replaces_no_file_of_other_work() {
    for name in ["model.toml", "Chamber.fmu", "report.html", "table4.csv"] {
        let bench = Bench::new();
        std::fs::create_dir(bench.path("out")).unwrap();
        bench.file(&format!("out/{name}"), "mine");
        let sentence = bench.refusal(&["reproduce", "-o", "out"]);
        let says = format!("out/{name}: not written, because a file that `pneutherm reproduce` did not write is there");
        assert!(sentence.contains(&says) && sentence.contains("choose another folder"), "{sentence}");
        assert_eq!(std::fs::read(bench.path(format!("out/{name}"))).unwrap(), b"mine");
        assert_eq!(std::fs::read_dir(bench.path("out")).unwrap().count(), 1);
    }
}

#[test]
fn an_fmu_of_a_faulty_model_or_at_an_impossible_path_is_refused() {
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

#[test]
fn a_dry_run_without_rows_shows_no_size_of_rows() {
    let told = text(&bench().call(0, &["sweep", "study.toml", "-o", "out", "--dry-run", "--no-rows"]).stdout);
    assert!(told.contains("size       statistics only, no rows") && !told.contains("bytes/row"), "{told}");
}

#[test]
fn a_dry_run_into_the_folder_of_another_study_is_refused_as_the_run_is() {
    let bench = bench();
    bench.call(0, &["sweep", "study.toml", "-o", "out"]);
    bench.call(0, &["sweep", "study.toml", "-o", "out", "--dry-run"]);
    bench.file("study.toml", STUDY.replace("0.032", "0.04"));
    let sentences = [&["--dry-run"][..], &[]].map(|option| {
        let arguments = [&["sweep", "study.toml", "-o", "out"], option].concat();
        bench.refusal(&arguments)
    });
    assert!(sentences[0].contains("holds another study"), "{}", sentences[0]);
    assert_eq!(sentences[0], sentences[1]);
}

#[test]
fn a_trace_rate_without_traces_is_wrong_usage() {
    let told = text(&bench().call(2, &["sweep", "study.toml", "-o", "out", "--trace-rate", "10"]).stderr);
    assert!(told.contains("--traces"), "{told}");
}

#[test]
fn a_study_whose_rows_all_fail_is_written_and_ends_with_an_error() {
    let bench = bench();
    let emptied = STUDY.replace("bore_m = { values = [0.016, 0.032] }", "mass_flow_out_kg_per_s = { values = [1.0] }");
    bench.file("study.toml", emptied);
    let told = text(&bench.call(1, &["sweep", "study.toml", "-o", "out"]).stderr);
    assert!(
        told.contains(
            "no row of the study has a result; the most frequent reason (3 of 3 rows): the chamber runs empty"
        ),
        "{told}"
    );
    assert!(text(&bench.call(0, &["sweep", "--verify", "out"]).stdout).contains("3 rows"));
}

#[test]
fn verify_names_what_it_compares_and_what_of_it_is_missing() {
    let bench = bench();
    bench.call(0, &["sweep", "study.toml", "-o", "out", "--no-rows", "--traces", "0"]);
    let told = text(&bench.call(0, &["sweep", "--verify", "out"]).stdout);
    assert!(told.contains("statistics.json, traces/traces.parquet: agree with manifest.json"), "{told}");
    std::fs::remove_file(bench.path("out/traces/traces.parquet")).unwrap();
    let sentence = bench.refusal(&["sweep", "--verify", "out"]);
    assert!(sentence.contains("traces/traces.parquet: it is not there"), "{sentence}");
    assert!(sentence.contains("with --traces"), "{sentence}");
    std::fs::remove_file(bench.path("out/manifest.json")).unwrap();
    let sentence = bench.refusal(&["sweep", "--verify", "out"]);
    assert!(
        sentence.contains("the study is not complete: all parts are there (1), but manifest.json is not"),
        "{sentence}"
    );
}
