//! Studies and their tables of points: a sentence for what is refused, and rows for what is not.

use hostile::assert_is_a_sentence;
use std::path::Path;
use sweep::Study;

/// Far less than a study that runs away takes. A row that is given up after 100,000 steps has had them logged in eight
/// lanes, which is up to 0.7 GB a thread.
const MEMORY: u64 = 2 << 30;
/// Studies of no more rows than this are carried out.
const ROWS: u64 = 8;

const TABLE: &str = "
[study]
model = \"model.toml\"
design = \"table\"
table = \"points.csv\"
[test]
initial_pressure_pa = 1.01e5
initial_stroke_m = 0.15
final_stroke_m = 0.08
push_time_s = 0.04
duration_s = 10.0
";

/// A folder with what the studies name: a model and tables of points.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    std::fs::copy(corpus.join("model/leaking.toml"), folder.path().join("model.toml")).unwrap();
    std::fs::copy(corpus.join("points/plain.csv"), folder.path().join("points.csv")).unwrap();
    folder
}

/// Reads the study and, when it is small, carries it out: every row is there.
fn read_and_carry_out(study: &Path, folder: &Path) {
    let refused = |error: sweep::Error| {
        // A study may name a file anywhere on the machine; that file is then the one to name.
        let message = error.to_string();
        let named = Path::new(message.split(':').next().unwrap_or_default());
        assert_is_a_sentence(&message, if named.is_absolute() { named } else { folder });
    };
    match Study::read(study) {
        Ok(study) => {
            assert!(study.rows > 0 && study.parts > 0 && study.parts <= study.rows);
            assert_eq!(study.rows_of(study.parts - 1).end, study.rows);
            // What is written beside the rows is a file of bearable size.
            assert!(study.json().to_string().len() < 1 << 20);
            if study.rows <= ROWS {
                match sweep::run_in_memory(&study) {
                    Ok(batches) => {
                        assert_eq!(batches.iter().map(|batch| batch.num_rows() as u64).sum::<u64>(), study.rows);
                    }
                    Err(error) => refused(error),
                }
            }
        }
        Err(error) => refused(error),
    }
    if let Some(peak) = hostile::peak_memory() {
        assert!(peak < MEMORY, "{peak} bytes");
    }
}

#[test]
fn a_study_is_carried_out_or_refused_in_a_sentence() {
    let folder = folder();
    let path = folder.path().join("study.toml");
    let words = [
        "[study]",
        "model = \"model.toml\"",
        "design = \"factorial\"",
        "\"latin-hypercube\"",
        "\"sobol\"",
        "\"saltelli\"",
        "\"table\"",
        "table = \"points.csv\"",
        "samples = 1000000000000000",
        "parts",
        "seed",
        "fit",
        "solver = \"exact\"",
        "tolerance",
        "[test]",
        "push_time_s",
        "hold_time_constants",
        "duration_s",
        "[vary]",
        "values = [1, 2]",
        "from",
        "to",
        "count = 100000000",
        "scale = \"log\"",
        "volume_to_area_m",
        "chamber.bore_m",
        "\"effect.gas_zones.mass_fraction\"",
        "\"effect.sensor_lag.time_constant_s\"",
        "\"effect.record_delay.delay_s\"",
        "\"effect.tube_volume.volume_m3\"",
    ];
    hostile::run("study", &words, |bytes| {
        std::fs::write(&path, bytes).unwrap();
        read_and_carry_out(&path, folder.path());
    });
}

#[test]
fn a_table_of_points_is_carried_out_or_refused_in_a_sentence() {
    let folder = folder();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, TABLE).unwrap();
    let words = ["bore_m", "initial_pressure_pa", "final_stroke_m", "effect.leakage.conductance_m3_per_s_pa", ","];
    hostile::run("points", &words, |bytes| {
        std::fs::write(folder.path().join("points.csv"), bytes).unwrap();
        read_and_carry_out(&path, folder.path());
    });
}

#[test]
fn a_parquet_table_of_points_is_carried_out_or_refused_in_a_sentence() {
    let folder = folder();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, TABLE.replace("points.csv", "points.parquet")).unwrap();
    hostile::run("parquet", &[], |bytes| {
        std::fs::write(folder.path().join("points.parquet"), bytes).unwrap();
        read_and_carry_out(&path, folder.path());
    });
}
