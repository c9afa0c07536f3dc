//! Growing studies: rows already solved by a smaller study are reused, and the result equals the study made in one run.

use crate::common::{at, model, parts, quiet, study, study_at, text};
use std::collections::BTreeMap;
use std::path::Path;
use sweep::{Earlier, Options, Shard, Study, run};

/// Contents of all files in a folder, by relative path.
fn files(folder: &Path) -> BTreeMap<std::path::PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in std::fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// Axes with some rows that fail and some that do not settle.
const MIXED: &str = "bore_m = { from = 0.016, to = 0.063 }
rod_m = { from = 0.0, to = 0.03 }
\"effect.leakage.conductance_m3_per_s_pa\" = { values = [0.0, 1e-12] }";
/// The first two of them.
const BORES: &str = "bore_m = { from = 0.016, to = 0.063 }
rod_m = { from = 0.0, to = 0.03 }";
const WANTED: &str =
    "\n[statistics]\npareto = { minimise = [\"settling_time_s\"], maximise = [\"pressure_peak_pa\"] }\n";

/// A smaller and a larger study of the same sequence.
fn growing(head: &str, smaller: &str, larger: &str, vary: [&str; 2]) -> [Study; 2] {
    [(smaller, vary[0]), (larger, vary[1])].map(|(more, vary)| {
        Study::about(&model(), &(text(&format!("{head}\nfit = false\n{more}"), vary) + WANTED)).unwrap()
    })
}

/// Grows the smaller study to the larger one in every possible way, and compares with the larger one made in one run.
fn grow([smaller, larger]: [Study; 2], solved: u64) {
    let [first, second, whole, shards] = [(); 4].map(|()| tempfile::tempdir().unwrap());
    run(&smaller, &at(&first), Shard::WHOLE, &quiet).unwrap();
    let before = files(first.path());
    let earlier = Earlier::open(&larger, &at(&first)).unwrap();
    let options = |shard| Options { shard, earlier: Some(&earlier), ..Options::default() };
    let report = run(&larger, &at(&second), options(Shard::WHOLE), &quiet).unwrap();
    assert_eq!((report.rows_written, report.rows_taken), (solved, smaller.rows), "{}", larger.rows);
    assert!(report.complete);
    run(&larger, &at(&whole), Shard::WHOLE, &quiet).unwrap();
    assert_eq!(files(second.path()), files(whole.path()));
    for index in [1, 0] {
        run(&larger, &at(&shards), options(Shard { index, count: 2 }), &quiet).unwrap();
    }
    for name in ["manifest.json", "statistics.json"] {
        assert!(files(shards.path()).contains_key(Path::new(name)), "{name}");
    }
    assert_eq!(parts(shards.path()), parts(whole.path()));
    assert_eq!(files(first.path()), before, "the smaller study stays as it is");
    // Only the statistics, from the existing rows.
    let summary = tempfile::tempdir().unwrap();
    run(&larger, &at(&summary), Options { rows: false, ..options(Shard::WHOLE) }, &quiet).unwrap();
    let statistics = |folder: &Path| std::fs::read(folder.join("statistics.json")).unwrap();
    assert_eq!(statistics(summary.path()), statistics(whole.path()));
}

#[test]
fn a_study_that_is_grown_is_the_one_made_in_one_go_byte_for_byte() {
    let factorial = ["[0.03, 0.02]", "[0.03, 0.02, 0.04]"].map(|bores| {
        format!("bore_m = {{ values = {bores} }}\ninitial_pressure_pa = {{ from = 1e5, to = 7e5, count = 900 }}")
    });
    grow(growing("design = \"sobol\"\nseed = 4", "samples = 1500", "samples = 9000", [MIXED; 2]), 7500);
    grow(growing("design = \"sobol\"\nseed = 4", "samples = 9000\nparts = 7", "samples = 9001", [MIXED; 2]), 1);
    grow(growing("design = \"saltelli\"", "samples = 256", "samples = 1000\nparts = 3", [BORES; 2]), 744 * 4);
    grow(growing("design = \"factorial\"", "", "", [&factorial[0], &factorial[1]]), 900);
}

#[test]
fn a_study_with_constraints_grows_and_keeps_what_they_leave_out() {
    let sobol = format!("{MIXED}\nconstraints = [\"rod_m < 0.5 * bore_m\"]");
    grow(growing("design = \"sobol\"\nseed = 4", "samples = 1500", "samples = 4000", [&sobol; 2]), 2500);
    let factorial = ["[0.02, 0.03]", "[0.02, 0.03, 0.04]"].map(|bores| {
        format!(
            "bore_m = {{ values = {bores} }}\nrod_m = {{ from = 0.0, to = 0.018, count = 500 }}\nconstraints = [\"rod_m < 0.5 * bore_m\"]"
        )
    });
    grow(growing("design = \"factorial\"", "", "", [&factorial[0], &factorial[1]]), 500);
    // Another constraint leaves out other rows.
    let head = "design = \"sobol\"\nfit = false\nsamples = ";
    let folder = tempfile::tempdir().unwrap();
    run(&study(&format!("{head}600"), &sobol), &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let other = study(&format!("{head}900"), &sobol.replace("0.5 *", "0.4 *"));
    let message = Earlier::open(&other, &at(&folder)).unwrap_err().to_string();
    assert!(message.contains("its constraints is [\"rod_m < 0.5 * bore_m\"]"), "{message}");
}

/// A study of the first rows of a table.
fn on_table(folder: &Path, rows: u32, file: &str, first_bore: f64) -> Study {
    let bore = |i: u32| if i == 0 { first_bore } else { 0.02 + 1e-6 * f64::from(i) };
    let line = |i: u32| format!("{:?},{:?}\n", bore(i), 1e-6 * f64::from(i));
    let text_of_rows: String = (0..rows).map(line).collect();
    std::fs::write(folder.join("points.csv"), format!("bore_m,rod_m\n{text_of_rows}")).unwrap();
    model().write(&folder.join("model.toml")).unwrap();
    let head = "model = \"model.toml\"\nname = \"points\"\ndesign = \"table\"\nfit = false\nparts = 2\ntable = ";
    let study = |file: &str, more: &str| {
        let text = text(&format!("{head}\"{file}\"\n{more}"), "") + WANTED;
        study_at(&text, &folder.join("study.toml")).unwrap()
    };
    if file == "points.parquet" {
        sweep::run_to_file(&study("points.csv", ""), &folder.join(file), &quiet).unwrap();
        return study(file, "columns = [\"bore_m\", \"rod_m\"]");
    }
    study(file, "")
}

#[test]
fn a_study_on_a_table_grows_by_the_rows_at_its_end() {
    for file in ["points.csv", "points.parquet"] {
        // Parts with more rows than a batch.
        let [few, many, other] = [(); 3].map(|()| tempfile::tempdir().unwrap());
        grow([on_table(few.path(), 18_000, file, 0.02), on_table(many.path(), 18_700, file, 0.02)], 700);
        let folder = tempfile::tempdir().unwrap();
        run(&on_table(few.path(), 300, file, 0.02), &at(&folder), Shard::WHOLE, &quiet).unwrap();
        let message = Earlier::open(&on_table(other.path(), 400, file, 0.021), &at(&folder)).unwrap_err().to_string();
        assert!(message.contains("its row 0 is at bore_m = 0.02, this study's at 0.021"), "{message}");
    }
}

#[test]
fn a_study_grows_from_an_unfinished_and_damaged_one_as_well() {
    let [smaller, larger] =
        growing("design = \"sobol\"\nseed = 4", "samples = 3000\nparts = 6", "samples = 5000", [MIXED; 2]);
    let [first, second, whole] = [(); 3].map(|()| tempfile::tempdir().unwrap());
    run(&smaller, &at(&first), Shard { index: 1, count: 2 }, &quiet).unwrap();
    let path = first.path().join("rows").join(smaller.part_name(3));
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let earlier = Earlier::open(&larger, &at(&first)).unwrap();
    assert_eq!(earlier.damaged, 1);
    let options = Options { earlier: Some(&earlier), ..Options::default() };
    let report = run(&larger, &at(&second), options, &quiet).unwrap();
    assert_eq!((report.rows_written, report.rows_taken), (4000, 1000));
    run(&larger, &at(&whole), Shard::WHOLE, &quiet).unwrap();
    assert_eq!(files(second.path()), files(whole.path()));
}

#[test]
fn a_study_that_is_no_beginning_of_another_is_refused_in_a_sentence() {
    let sobol = "design = \"sobol\"\nsamples = 600\nfit = false";
    let larger = study(&sobol.replace("600", "900"), MIXED);
    let refusal = |smaller: &Study, larger: &Study, rows: bool| {
        let folder = tempfile::tempdir().unwrap();
        run(smaller, &at(&folder), Options { rows, ..Options::default() }, &quiet).unwrap();
        let message = Earlier::open(larger, &at(&folder)).unwrap_err().to_string();
        assert!(message.starts_with(&folder.path().display().to_string()) && !message.contains('\n'), "{message}");
        message
    };
    let factorial = |bores: &str| {
        study(
            "design = \"factorial\"\nfit = false",
            &format!("bore_m = {{ values = {bores} }}\nrod_m = {{ values = [0.0, 0.001] }}"),
        )
    };
    let smaller = study(sobol, MIXED);
    let cube = |samples| study(&format!("design = \"latin-hypercube\"\nsamples = {samples}\nfit = false"), MIXED);
    for (message, expected) in [
        (refusal(&smaller, &study(&sobol.replace("600", "300"), MIXED), true), "it has 600 rows, this study only 300"),
        (refusal(&study(&format!("{sobol}\nseed = 2"), MIXED), &larger, true), "its seed is 2, this study's 0"),
        (
            refusal(&study(&format!("{sobol}\ntolerance = 1e-8"), MIXED), &larger, true),
            "its tolerance is 1e-8, this study's 1e-10",
        ),
        (
            refusal(&smaller, &study(&sobol.replace("600", "900"), &MIXED.replace("0.063", "0.06")), true),
            "its bore_m is {\"from\":0.016,\"to\":0.063,",
        ),
        (
            refusal(&smaller, &study(&sobol.replace("600", "900"), BORES), true),
            "its effect.leakage.conductance_m3_per_s_pa is {\"values\":[0.0,1e-12]}, this study's nothing",
        ),
        (
            refusal(&study(&sobol.replace("fit = false", ""), MIXED), &larger, true),
            "its fit is true, this study's false",
        ),
        (refusal(&smaller, &larger, false), "it has no rows"),
        (refusal(&cube(600), &cube(900), true), "a Latin hypercube of more samples has other rows"),
        (refusal(&cube(600), &larger, true), "its design is \"latin-hypercube\", this study's \"sobol\""),
        (
            refusal(&factorial("[0.02, 0.03]"), &factorial("[0.02, 0.025, 0.03]"), true),
            "its row 2 is at bore_m = 0.03, this study's at 0.025",
        ),
    ] {
        assert!(message.contains(expected), "{message}");
    }
    let empty = tempfile::tempdir().unwrap();
    assert!(Earlier::open(&larger, &at(&empty)).unwrap_err().to_string().contains("it holds no study"));
    std::fs::create_dir(empty.path().join("parts")).unwrap();
    std::fs::write(empty.path().join("parts/study.json"), "{").unwrap();
    assert!(Earlier::open(&larger, &at(&empty)).unwrap_err().to_string().contains("cannot be read"));
}
