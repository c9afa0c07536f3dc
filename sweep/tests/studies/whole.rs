//! Whole studies: contents of the table, and its independence of how it was produced.

use crate::common::{BORES, at, model, parts, quiet, read, study, study_at, text, values};
use sweep::{Shard, Study, run, run_in_memory, run_to_file};

#[test]
fn the_same_study_gives_the_same_rows_whatever_the_shard_and_the_number_of_threads() {
    let study = study("design = \"factorial\"", BORES);
    assert_eq!((study.rows, study.parts), (2400, 3));
    let folders: Vec<_> = (0..3).map(|_| tempfile::tempdir().unwrap()).collect();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert!(pool(1).install(|| run(&study, &at(&folders[0]), Shard::WHOLE, &quiet)).unwrap().complete);
    assert!(pool(4).install(|| run(&study, &at(&folders[1]), Shard::WHOLE, &quiet)).unwrap().complete);
    for index in [1, 0] {
        let report = run(&study, &at(&folders[2]), Shard { index, count: 2 }, &quiet).unwrap();
        assert_eq!(report.complete, index == 0);
    }
    let tables: Vec<_> = folders.iter().map(|folder| parts(folder.path())).collect();
    assert_eq!(tables[0].len(), 3);
    assert_eq!(tables[0], tables[1]);
    assert_eq!(tables[0], tables[2]);
    let text = |i: usize| std::fs::read_to_string(folders[i].path().join("manifest.json")).unwrap();
    assert_eq!(text(0), text(1));
    let manifest: serde_json::Value = serde_json::from_str(&text(0)).unwrap();
    // Leaky rows do not settle within the test, or are not exponential.
    let count = |status: &str| manifest["statuses"][status].as_u64().unwrap();
    let solved = count("ok") + count("not_settled") + count("no_time_constant");
    assert_eq!((solved, manifest["rows"].as_u64()), (2400, Some(2400)));
}

#[test]
fn one_file_and_memory_hold_the_rows_of_the_folder() {
    let study = study(
        "design = \"latin-hypercube\"\nsamples = 20000\nseed = 3\nfit = false",
        &BORES.replace("count = 40, ", ""),
    );
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let tables: Vec<_> = parts(folder.path()).into_values().collect();
    let together = arrow::compute::concat_batches(&tables[0].schema(), &tables).unwrap();
    let file = folder.path().join("all.parquet");
    run_to_file(&study, &file, &quiet).unwrap();
    assert_eq!(read(&file), together);
    let memory = run_in_memory(&study).unwrap();
    let memory = arrow::compute::concat_batches(&memory[0].schema(), &memory).unwrap();
    assert_eq!(memory.columns(), together.columns());
    assert!(memory.column_by_name("time_constant_s").is_none(), "fit = false leaves the regression out");
}

#[test]
fn the_schema_is_the_contracts_and_names_every_unit() {
    let study = study("design = \"factorial\"", BORES);
    let schema = sweep::part::columns::schema(&study);
    let fields: Vec<_> = schema.fields().iter().map(|f| (f.name().as_str(), f.metadata()["unit"].as_str())).collect();
    let expected = [
        ("row", "1"),
        ("bore_m", "m"),
        ("initial_pressure_pa", "Pa"),
        ("effect.leakage.conductance_m3_per_s_pa", "m3/(s.Pa)"),
        ("volume_m3", "m3"),
        ("area_m2", "m2"),
        ("volume_to_area_m", "m"),
        ("pressure_peak_pa", "Pa"),
        ("pressure_final_pa", "Pa"),
        ("temperature_final_k", "K"),
        ("temperature_peak_k", "K"),
        ("time_constant_s", "s"),
        ("lambda_av_w_per_m2_k", "W/(m2.K)"),
        ("lambda0_w_per_m2_k", "W/(m2.K)"),
        ("settling_time_s", "s"),
        ("energy_error", "1"),
        ("status", "1"),
    ];
    assert_eq!(fields, expected);
}

#[test]
fn a_table_of_ones_own_is_a_design() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..3000).map(|i| format!("{},{}\n", 0.02 + 1e-5 * f64::from(i), 1e5 + f64::from(i))).collect();
    std::fs::write(folder.path().join("points.csv"), format!("chamber.bore_m,initial_pressure_pa\n{rows}")).unwrap();
    model().write(&folder.path().join("model.toml")).unwrap();
    let head = "model = \"model.toml\"\ndesign = \"table\"\nfit = false\ntable = ";
    let study = |file: &str| study_at(&text(&format!("{head}\"{file}\""), ""), &folder.path().join("s.toml")).unwrap();
    let from_csv = run_in_memory(&study("points.csv")).unwrap();
    assert_eq!(from_csv.iter().map(|b| b.num_rows()).sum::<usize>(), 3000);
    assert_eq!(values(&from_csv[0], "chamber.bore_m")[7], 0.02 + 7e-5);
    // A study's own output serves as a table, with the selected columns.
    run_to_file(&study("points.csv"), &folder.path().join("points.parquet"), &quiet).unwrap();
    let again = text(&format!("{head}\"points.parquet\"\ncolumns = [\"chamber.bore_m\", \"initial_pressure_pa\"]"), "");
    let again = study_at(&again, &folder.path().join("s.toml")).unwrap();
    assert_eq!(run_in_memory(&again).unwrap()[0].columns(), from_csv[0].columns());
}

const STATISTICS: &str = "
[statistics]
quantiles = [0.05, 0.5, 0.95]
histograms = { pressure_peak_pa = { from = 1.5e5, to = 1e6, bins = 17 } }
";

#[test]
fn statistics_are_the_same_whatever_the_shards_with_rows_or_without_and_afterwards() {
    let with = |statistics: &str| {
        let text = text("design = \"factorial\"", &format!("{BORES}\nrod_m = {{ values = [0.0, 0.02] }}"));
        Study::about(&model(), &(text + statistics)).unwrap()
    };
    let study = with(STATISTICS);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let folders: Vec<_> = (0..4).map(|_| tempfile::tempdir().unwrap()).collect();
    pool(1).install(|| run(&study, &at(&folders[0]), Shard::WHOLE, &quiet)).unwrap();
    let no_rows = |shard| sweep::Options { shard, rows: false, earlier: None };
    pool(4).install(|| run(&study, &at(&folders[1]), no_rows(Shard::WHOLE), &quiet)).unwrap();
    for index in [1, 2, 0] {
        run(&study, &at(&folders[2]), no_rows(Shard { index, count: 3 }), &quiet).unwrap();
    }
    // Requested after the rows exist: nothing is solved again.
    run(&with(""), &at(&folders[3]), Shard::WHOLE, &quiet).unwrap();
    assert!(!folders[3].path().join("statistics.json").exists());
    let report = run(&study, &at(&folders[3]), Shard::WHOLE, &quiet).unwrap();
    assert_eq!((report.rows_written, report.results.as_slice()), (0, ["statistics.json"].as_slice()));
    let found: Vec<_> =
        folders.iter().map(|folder| std::fs::read_to_string(folder.path().join("statistics.json")).unwrap()).collect();
    assert!(found.iter().all(|text| *text == found[0]));
    assert!(parts(folders[1].path()).is_empty());

    let tables: Vec<_> = parts(folders[0].path()).into_values().collect();
    let rows = arrow::compute::concat_batches(&tables[0].schema(), &tables).unwrap();
    let found: serde_json::Value = serde_json::from_str(&found[0]).unwrap();
    for name in ["pressure_peak_pa", "temperature_final_k", "lambda0_w_per_m2_k", "energy_error"] {
        let all = values(&rows, name);
        let mut some: Vec<f64> = all.iter().copied().filter(|v| v.is_finite()).collect();
        some.sort_by(f64::total_cmp);
        let (n, column) = (some.len() as f64, &found["columns"][name]);
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert_eq!(column["count"], some.len());
        assert_eq!(column["nulls"], all.len() - some.len());
        assert!(column["nulls"].as_u64() > Some(0), "rods that fill the bore are nulls");
        let mean = some.iter().sum::<f64>() / n;
        let variance = some.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        assert!((number(&column["mean"]) - mean).abs() <= 1e-12 * mean.abs());
        assert!((number(&column["variance"]) - variance).abs() <= 1e-11 * variance);
        assert_eq!(number(&column["minimum"]["value"]), some[0]);
        let row = column["maximum"]["row"].as_u64().unwrap() as usize;
        assert_eq!((number(&column["maximum"]["value"]), all[row]), (some[some.len() - 1], some[some.len() - 1]));
        assert_eq!(number(&column["maximum"]["at"]["bore_m"]), values(&rows, "bore_m")[row]);
        for quantile in column["quantiles"].as_array().unwrap() {
            let rank = number(&quantile["probability"]) * (n - 1.0);
            let (below, above) = (some[rank.floor() as usize], some[rank.ceil() as usize]);
            let exact = below + (above - below) * rank.fract();
            let miss = (number(&quantile["value"]) - exact).abs();
            assert!(miss <= number(&quantile["error_bound"]) * (1.0 + 1e-3), "{name}: {quantile} {exact}");
        }
    }
    let histogram = &found["columns"]["pressure_peak_pa"]["histogram"];
    let counts: u64 = histogram["counts"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).sum();
    let outside = histogram["below"].as_u64().unwrap() + histogram["above"].as_u64().unwrap();
    assert_eq!(counts + outside, found["columns"]["pressure_peak_pa"]["count"].as_u64().unwrap());
    let first = values(&rows, "pressure_peak_pa").iter().filter(|p| (1.5e5..2e5).contains(*p)).count();
    assert_eq!(histogram["counts"][0], first);
}
