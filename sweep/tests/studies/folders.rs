//! A study's folder: resumed, verified, found finished, and left alone if it belongs to another study.

use crate::common::{BORES, at, model, parts, quiet, study, text};
use sweep::{Options, Shard, Study, run, traces, verify};

/// Files of the study as a whole in its folder.
const OF_THE_FOLDER: [&str; 5] =
    ["manifest.json", "statistics.json", "sensitivity.json", "statistics.svg", "sensitivity.svg"];

#[test]
fn an_interrupted_study_resumes_with_the_parts_that_are_missing_or_broken() {
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let before = parts(folder.path());
    std::fs::remove_file(folder.path().join("rows").join(study.part_name(0))).unwrap();
    let broken = folder.path().join("rows").join(study.part_name(2));
    let bytes = std::fs::read(&broken).unwrap();
    std::fs::write(&broken, &bytes[..bytes.len() / 2]).unwrap();
    let stale = folder.path().join("parts").join(format!(".{}.1-2-3.tmp", study.part_name(0)));
    let stale_record = folder.path().join("parts/.part-00001-of-00003.json.1-2.tmp");
    let of_folder = OF_THE_FOLDER.map(|name| folder.path().join(format!(".{name}.1-2.tmp")));
    let stale: Vec<_> = [stale, stale_record].into_iter().chain(of_folder).collect();
    for path in &stale {
        std::fs::write(path, "half").unwrap();
    }
    let report = run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!((report.parts_written, report.parts_found, report.complete), (2, 1, true));
    assert_eq!(report.parts_damaged, 1);
    for path in &stale {
        assert!(!path.exists(), "{}: what a killed run left is removed", path.display());
    }
    assert_eq!(parts(folder.path()), before);
}

#[test]
fn what_a_run_killed_at_its_last_files_left_is_removed_though_no_part_is_missing() {
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let stale = OF_THE_FOLDER.map(|name| folder.path().join(format!(".{name}.1-2.tmp")));
    let of_others = folder.path().join(".picture.svg.1-2.tmp");
    for path in stale.iter().chain([&of_others]) {
        std::fs::write(path, "half").unwrap();
    }
    assert_eq!(run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap().parts_written, 0);
    for path in &stale {
        assert!(!path.exists(), "{}", path.display());
    }
    assert!(of_others.exists(), "what is none of the study's stays");
}

#[test]
fn a_temporary_file_that_a_living_run_writes_stays() {
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("parts")).unwrap();
    let busy = folder.path().join("parts").join(format!(".{}.1-2-3.tmp", study.part_name(0)));
    let file = std::fs::File::create(&busy).unwrap();
    file.lock().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert!(busy.exists());
}

#[test]
fn a_flipped_bit_anywhere_in_a_part_is_found_by_verify_and_by_a_second_run() {
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let before = parts(folder.path());
    assert_eq!(verify(&at(&folder)).unwrap().wrong, Vec::<String>::new());
    let length = std::fs::metadata(folder.path().join("rows").join(study.part_name(1))).unwrap().len() as usize;
    for offset in [0, 4, length / 3, length / 2, length - 200, length - 12, length - 1] {
        let path = folder.path().join("rows").join(study.part_name(1));
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[offset] ^= 1 << (offset % 8);
        std::fs::write(&path, bytes).unwrap();
        let wrong = verify(&at(&folder)).unwrap().wrong;
        assert_eq!(wrong, ["rows/part-00001-of-00003.parquet: its SHA-256 differs"]);
        let report = run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
        assert_eq!((report.parts_written, report.parts_damaged, report.complete), (1, 1, true));
        assert_eq!(verify(&at(&folder)).unwrap().wrong, Vec::<String>::new());
    }
    assert_eq!(parts(folder.path()), before);
    std::fs::remove_file(folder.path().join("rows").join(study.part_name(2))).unwrap();
    let wrong = verify(&at(&folder)).unwrap().wrong;
    assert!(wrong.len() == 1 && wrong[0].starts_with("rows/part-00002-of-00003.parquet: "), "{wrong:?}");
}

#[test]
fn a_foreign_file_among_the_rows_is_found_by_verify_but_for_one_that_readers_pass_over() {
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    std::fs::write(folder.path().join("rows/.listed"), "").unwrap();
    assert_eq!(verify(&at(&folder)).unwrap().foreign, Vec::<String>::new());
    std::fs::write(folder.path().join("rows/other.parquet"), "").unwrap();
    let report = verify(&at(&folder)).unwrap();
    assert_eq!((report.wrong, report.foreign), (Vec::new(), vec!["rows/other.parquet".to_owned()]));
}

#[cfg(unix)]
#[test]
fn a_finished_study_is_found_finished_in_a_folder_that_cannot_be_written() {
    use std::os::unix::fs::PermissionsExt;
    let study = study("design = \"factorial\"", BORES);
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let modified = || {
        let files = ["manifest.json", "parts", "rows", "."];
        files.map(|name| std::fs::metadata(folder.path().join(name)).unwrap().modified().unwrap())
    };
    let before = modified();
    for name in ["parts", "rows", "."] {
        std::fs::set_permissions(folder.path().join(name), std::fs::Permissions::from_mode(0o555)).unwrap();
    }
    let report = run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!((report.parts_written, report.parts_found, report.complete), (0, 3, true));
    // The superuser may write anywhere: the modification times show that nothing was written.
    assert_eq!(modified(), before);
    for name in [".", "rows", "parts"] {
        std::fs::set_permissions(folder.path().join(name), std::fs::Permissions::from_mode(0o755)).unwrap();
    }
}

#[test]
fn a_folder_with_another_study_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let first = study("design = \"factorial\"", BORES);
    run(&first, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    std::fs::remove_file(folder.path().join("manifest.json")).unwrap();
    let before = parts(folder.path());
    let second = study("design = \"factorial\"\ntolerance = 1e-8", BORES);
    let message = run(&second, &at(&folder), Shard::WHOLE, &quiet).unwrap_err().to_string();
    assert!(message.contains("holds another study") && message.contains("differs in tolerance"), "{message}");
    let slower = text("design = \"factorial\"", BORES).replace("push_time_s = 0.04", "push_time_s = 0.125");
    let third = Study::about(&model(), &slower).unwrap();
    let message = run(&third, &at(&folder), Shard::WHOLE, &quiet).unwrap_err().to_string();
    assert!(message.contains("differs in test.push_time_s (0.04 there, 0.125 here)"), "{message}");
    assert_eq!(parts(folder.path()), before);
}

/// A study whose folder contains every kind of result.
fn with_results() -> Study {
    let head = "design = \"saltelli\"\nsamples = 16\nfit = false";
    let vary = "bore_m = { from = 0.016, to = 0.063 }\ninitial_pressure_pa = { from = 1e5, to = 7e5 }";
    Study::about(&model(), &(text(head, vary) + "[statistics]\n")).unwrap()
}

#[test]
fn results_beside_the_rows_that_are_gone_or_not_as_written_are_found_by_verify() {
    let (study, folder) = (with_results(), tempfile::tempdir().unwrap());
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    traces::write(&study, &at(&folder), &"0-2".parse().unwrap(), 10.0).unwrap();
    let wrong = || verify(&at(&folder)).unwrap().wrong_results;
    let names = ["statistics.json", "sensitivity.json", "traces/traces.parquet"];
    let report = verify(&at(&folder)).unwrap();
    assert_eq!((report.results, report.not_covered), (names.map(str::to_owned).to_vec(), vec![]));
    assert_eq!(wrong(), Vec::<String>::new());
    for name in names {
        let path = folder.path().join(name);
        let whole = std::fs::read(&path).unwrap();
        let mut bytes = whole.clone();
        bytes[whole.len() / 2] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(wrong(), [format!("{name}: its SHA-256 differs")]);
        std::fs::remove_file(&path).unwrap();
        assert_eq!(wrong(), [format!("{name}: it is not there")]);
        std::fs::write(&path, whole).unwrap();
        assert_eq!(wrong(), Vec::<String>::new());
    }
}

#[test]
fn a_second_run_mends_results_and_further_traces_are_named_in_the_manifest() {
    let (study, folder) = (with_results(), tempfile::tempdir().unwrap());
    let of_rows = |rows: &str| traces::write(&study, &at(&folder), &rows.parse().unwrap(), 10.0).unwrap();
    let wrong = || verify(&at(&folder)).unwrap().wrong_results;
    // Traces may exist before the rows.
    of_rows("0");
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!(verify(&at(&folder)).unwrap().results.len(), 3);
    std::fs::write(folder.path().join("statistics.json"), "{}").unwrap();
    std::fs::write(folder.path().join("traces/traces.parquet"), "").unwrap();
    assert_eq!(wrong().len(), 2);
    // Without a new request for traces, the damaged file is not mistaken for the recorded one.
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!(wrong(), ["traces/traces.parquet: 0 bytes, not ".to_owned() + &bytes_of_traces(folder.path())]);
    of_rows("1-3");
    assert_eq!(wrong(), Vec::<String>::new());
}

/// Length of the traces according to the manifest.
fn bytes_of_traces(folder: &std::path::Path) -> String {
    let manifest = std::fs::read(folder.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    manifest["results"][2]["bytes"].to_string()
}

#[test]
fn results_that_an_older_manifest_does_not_name_are_reported() {
    let (study, folder) = (with_results(), tempfile::tempdir().unwrap());
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let path = folder.path().join("manifest.json");
    let mut manifest: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    manifest.as_object_mut().unwrap().remove("results");
    std::fs::write(&path, manifest.to_string()).unwrap();
    assert_eq!(verify(&at(&folder)).unwrap().not_covered, ["statistics.json", "sensitivity.json"]);
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!(verify(&at(&folder)).unwrap().not_covered, Vec::<&str>::new());
}

#[test]
fn verify_of_an_unfinished_study_says_how_many_parts_are_there() {
    let study = study("design = \"factorial\"", BORES);
    for rows in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let options = Options { shard: Shard { index: 0, count: 2 }, rows, ..Options::default() };
        run(&study, &at(&folder), options, &quiet).unwrap();
        let message = verify(&at(&folder)).unwrap_err().to_string();
        assert!(message.contains("the study is not complete: 2 of its 3 parts are there"), "{message}");
    }
    let whole = tempfile::tempdir().unwrap();
    run(&study, &at(&whole), Shard::WHOLE, &quiet).unwrap();
    std::fs::remove_file(whole.path().join("manifest.json")).unwrap();
    let message = verify(&at(&whole)).unwrap_err().to_string();
    assert!(message.contains("all parts are there (3), but manifest.json is not"), "{message}");
    let message = verify(&at(&tempfile::tempdir().unwrap())).unwrap_err().to_string();
    assert!(message.contains("holds no manifest.json; expected the folder of a finished study"), "{message}");
}

#[test]
fn a_study_without_any_result_has_its_most_frequent_reason() {
    let why = |vary: &str| {
        let folder = tempfile::tempdir().unwrap();
        let report = run(&study("design = \"factorial\"", vary), &at(&folder), Shard::WHOLE, &quiet).unwrap();
        report.why_without_results().map(|(reason, rows)| (reason.to_owned(), rows))
    };
    let (reason, rows) = why("mass_flow_out_kg_per_s = { values = [0.5, 1.0] }").unwrap();
    assert!(reason.contains("runs empty") && rows == 2, "{reason} {rows}");
    assert_eq!(why("mass_flow_out_kg_per_s = { values = [0.0, 1.0] }"), None);
}
