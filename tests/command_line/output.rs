//! Destinations of results: odd paths, protected folders, full devices, closed pipes.

use crate::common::{Bench, text};
use std::io::Read;
use std::process::Stdio;

const CALL: [&str; 4] = ["simulate", "model.toml", "--motion", "motion.csv"];

#[test]
fn a_failed_run_leaves_the_older_result_alone() {
    let bench = Bench::new();
    bench.file("out.csv", "older");
    bench.file("motion.csv", "time_s,position_m\n0,0.1\n0,0.1\n");
    bench.refusal(&[&CALL[..], &["-o", "out.csv"]].concat());
    assert_eq!(std::fs::read(bench.path("out.csv")).unwrap(), b"older");
}

#[test]
fn an_output_that_cannot_be_written_is_named() {
    let bench = Bench::new();
    let sentence = bench.refusal(&[&CALL[..], &["-o", "absent/out.csv"]].concat());
    assert!(sentence.contains("absent/out.csv: cannot be written: No such file"), "{sentence}");
    let sentence = bench.refusal(&[&CALL[..], &["-o", "."]].concat());
    assert!(sentence.contains("cannot be written"), "{sentence}");
}

/// A typing error does not replace an hour's record.
#[test]
fn no_result_replaces_a_file_that_the_command_reads() {
    let bench = Bench::new();
    let simulated = [&CALL[..], &["--rig", "rig.toml", "-o"]].concat();
    let calls: [(&[&str], &[&str]); 6] = [
        (&simulated, &["motion.csv", "model.toml", "rig.toml", "./motion.csv"]),
        (&["look", "motion.csv", "-o"], &["motion.csv"]),
        (&["identify", "rig.toml", "--json"], &["rig.toml", "motion.csv"]),
        (&["diagnose", ".", "--report"], &["rig.toml", "motion.csv"]),
        (&["validate", "model.toml", "rig.toml", "--json"], &["model.toml", "rig.toml", "motion.csv"]),
        (&["fmu", "model.toml", "--validation", "rig.toml", "-o"], &["model.toml", "rig.toml", "motion.csv"]),
    ];
    for (call, inputs) in calls {
        for input in inputs {
            let before = std::fs::read(bench.path(input)).unwrap();
            let sentence = bench.refusal(&[call, &[*input]].concat());
            assert!(sentence.contains("not written, because it is read by this command"), "{call:?} {sentence}");
            assert_eq!(std::fs::read(bench.path(input)).unwrap(), before, "{call:?} {input}");
        }
    }
}

#[test]
fn two_results_are_not_written_to_one_file() {
    let bench = Bench::new();
    let sentence = bench.refusal(&["identify", "rig.toml", "-o", "-", "--json", "-"]);
    assert!(sentence.contains("standard output can take one result only"), "{sentence}");
    let sentence = bench.refusal(&["diagnose", "rig.toml", "-o", "x", "--report", "./x"]);
    assert!(sentence.contains("./x: two results cannot go to one file"), "{sentence}");
}

#[test]
fn a_missing_folder_is_reported_before_the_work() {
    let sentence = Bench::new().refusal(&["diagnose", "rig.toml", "--json", "x.json", "-o", "absent/model.toml"]);
    assert!(sentence.contains("absent/model.toml: cannot be written: No such file"), "{sentence}");
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_named_and_left_as_it_is() {
    use std::os::unix::fs::PermissionsExt;
    let bench = Bench::new();
    let folder = bench.path("protected");
    std::fs::create_dir(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(folder.join("probe"), "").is_ok() {
        println!("skipped: this user may write anywhere");
        return;
    }
    let sentence = bench.refusal(&[&CALL[..], &["-o", "protected/out.csv"]].concat());
    assert!(sentence.contains("protected/out.csv: cannot be written: Permission denied"), "{sentence}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_named() {
    let sentence = Bench::new().refusal(&[&CALL[..], &["-o", "/dev/full"]].concat());
    assert!(sentence.contains("/dev/full: cannot be written: No space left"), "{sentence}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let output = Bench::new().command().args(CALL).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(
        text(&output.stderr).contains("standard output cannot be written: No space left"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let bench = Bench::new();
    // More than a pipe's capacity, so that the program is still writing when the reader closes it.
    let rows: String = (0..20_000).map(|k| format!("{},0.1\n", f64::from(k) / 100.0)).collect();
    bench.file("motion.csv", format!("time_s,position_m\n{rows}"));
    let mut command = bench.command();
    command.args(CALL).args(["--initial-pressure", "1e5"]).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut some = [0; 100];
    let mut pipe = child.stdout.take().unwrap();
    pipe.read_exact(&mut some).unwrap();
    drop(pipe);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
}

#[cfg(target_os = "linux")]
#[test]
fn names_with_spaces_and_bytes_that_are_no_text_are_names() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::new();
    let odd = |name: &'static [u8]| bench.path(OsStr::from_bytes(name));
    std::fs::rename(bench.path("model.toml"), odd(b"my model \xff.toml")).unwrap();
    std::fs::rename(bench.path("motion.csv"), odd(b"fahrt \xfc 1.csv")).unwrap();
    let mut command = bench.command();
    command.arg("simulate").arg(odd(b"my model \xff.toml")).arg("--motion").arg(odd(b"fahrt \xfc 1.csv"));
    let output = command.arg("-o").arg(odd(b"aus gabe \xe9.csv")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(odd(b"aus gabe \xe9.csv").is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_rig_file_is_not_proposed_for_a_trace_whose_name_it_cannot_have() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let bench = Bench::new();
    let rows = (0..40).map(|i| format!("{},2e5,0.1\n", f64::from(i) * 0.01)).collect::<String>();
    let trace = bench.path(OsStr::from_bytes(b"fahrt \xfc.csv"));
    std::fs::write(&trace, format!("time_s,pressure_pa,position_m\n{rows}")).unwrap();
    let output = bench.command().arg("look").arg(&trace).arg("-o").arg(bench.path("proposed.toml")).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("the name is no UTF-8 text"), "{}", text(&output.stderr));
    assert!(!bench.path("proposed.toml").exists());
}
