//! A study's folder: resumed, verified, found finished, and left alone where it is another study's.

use crate::common::{BORES, at, parts, quiet, study};
use sweep::{Shard, run, verify};

/// Files of the whole study in its folder.
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
    for place in [0, 4, length / 3, length / 2, length - 200, length - 12, length - 1] {
        let path = folder.path().join("rows").join(study.part_name(1));
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[place] ^= 1 << (place % 8);
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
    // The superuser may write anywhere: nothing was written shows there.
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
    assert_eq!(parts(folder.path()), before);
}
