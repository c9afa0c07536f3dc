//! Whole studies: what is in the table, and that it does not depend on how it came about.

use crate::common::{at, model, parts, quiet, read, statuses, study, text, values};
use arrow::array::Int64Array;
use sweep::{Shard, Study, run, run_in_memory, run_to_file, verify};

const BORES: &str = "bore_m = { from = 0.016, to = 0.063, count = 40, scale = \"log\" }
initial_pressure_pa = { from = 1e5, to = 7e5, count = 30 }
\"effect.leakage.conductance_m3_per_s_pa\" = { values = [0.0, 1e-12] }";

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
    // Leaky rows do not settle within the test, or are no exponential's.
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
    let stale_manifest = folder.path().join(".manifest.json.1-2.tmp");
    for path in [&stale, &stale_record, &stale_manifest] {
        std::fs::write(path, "half").unwrap();
    }
    let report = run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    assert_eq!((report.parts_written, report.parts_found, report.complete), (2, 1, true));
    assert_eq!(report.parts_damaged, 1);
    for path in [&stale, &stale_record, &stale_manifest] {
        assert!(!path.exists(), "{}: what a killed run left is removed", path.display());
    }
    assert_eq!(parts(folder.path()), before);
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

#[test]
fn a_row_that_cannot_be_is_a_row_with_nulls_and_its_reason() {
    let study = study(
        "design = \"factorial\"",
        "final_stroke_m = { values = [0.05, 0.0] }\ndead_volume_m3 = { values = [1e-6, 0.0] }\nrod_m = { values = [0.0, 0.03] }
bore_m = { values = [0.02, 0.04] }",
    );
    let batches = run_in_memory(&study).unwrap();
    let batch = &batches[0];
    let rod = "failed: the rod leaves no piston area";
    let empty = "failed: the gas volume is not positive along the whole stroke";
    let whole = ["ok", "ok", rod, "ok"];
    let expected = [whole, whole, whole, [empty, empty, rod, empty]].concat();
    assert_eq!(statuses(batch), expected);
    let peaks = values(batch, "pressure_peak_pa");
    assert!(peaks.iter().zip(&expected).all(|(peak, status)| peak.is_nan() == status.starts_with("failed")));
    for column in ["time_constant_s", "lambda_av_w_per_m2_k", "lambda0_w_per_m2_k"] {
        assert!(values(batch, column).iter().zip(&expected).all(|(value, status)| value.is_nan() == (*status != "ok")));
    }
    assert_eq!(values(batch, "rod_m"), [0.0, 0.0, 0.03, 0.03].repeat(4));
}

#[test]
fn a_leaky_row_is_not_ok_and_has_no_coefficient() {
    let vary = "\"effect.leakage.conductance_m3_per_s_pa\" = { values = [0.0, 3e-12, 1e-11, 3e-11] }";
    let long = text("design = \"factorial\"", vary).replace("duration_s = 5.0", "duration_s = 60.0");
    let batches = run_in_memory(&Study::about(&model(), &long).unwrap()).unwrap();
    let found = statuses(&batches[0]);
    assert_eq!(found[0], "ok");
    assert!(found[1..].iter().all(|status| *status == "no_time_constant" || *status == "not_settled"), "{found:?}");
    assert!(found.contains(&"no_time_constant".into()), "{found:?}");
    for (row, status) in found.iter().enumerate().filter(|(_, status)| status.as_str() == "no_time_constant") {
        for column in ["time_constant_s", "lambda_av_w_per_m2_k", "lambda0_w_per_m2_k"] {
            assert!(values(&batches[0], column)[row].is_nan(), "{column}, {status}");
        }
        assert!(values(&batches[0], "pressure_peak_pa")[row] > 1.01e5);
    }
}

#[test]
fn the_bore_is_solved_for_a_volume_to_area_ratio() {
    for dead_volume in [0.0, 1.57e-6, 2e-5] {
        let vary = format!(
            "volume_to_area_m = {{ from = 0.002, to = 0.02, count = 25 }}\ndead_volume_m3 = {{ values = [{dead_volume}] }}"
        );
        let study = study("design = \"factorial\"\nfit = false", &vary);
        let batch = &run_in_memory(&study).unwrap()[0];
        let (wanted, volume, area) =
            (values(batch, "volume_to_area_m"), values(batch, "volume_m3"), values(batch, "area_m2"));
        for i in 0..wanted.len() {
            assert!((volume[i] / area[i] / wanted[i] - 1.0).abs() < 1e-13, "{} {}", wanted[i], volume[i] / area[i]);
        }
    }
    // At a stroke of 50 mm the ratio stays below 25 mm and a little for the dead volume, whatever the bore.
    let study = study("design = \"factorial\"", "volume_to_area_m = { values = [0.03] }");
    assert_eq!(statuses(&run_in_memory(&study).unwrap()[0]), ["failed: no bore gives this volume-to-area ratio"]);
}

#[test]
fn the_strokes_are_solved_for_a_volume_to_area_ratio_at_a_bore() {
    for (dead_volume, bore) in [(0.0, 0.02), (1.57e-6, 0.032), (2e-5, 0.063)] {
        let vary = format!(
            "volume_to_area_by_length_m = {{ values = [{}] }}\ndead_volume_m3 = {{ values = [{dead_volume}] }}\nbore_m = {{ values = [{bore}] }}",
            [0.12, 0.16, 0.2, 0.24].map(|share| (share * bore).to_string()).join(", ")
        );
        let study = study("design = \"factorial\"\nfit = false", &vary);
        let batch = &run_in_memory(&study).unwrap()[0];
        let (wanted, ratio) = (values(batch, "volume_to_area_by_length_m"), values(batch, "volume_to_area_m"));
        let (initial, last) = (values(batch, "initial_stroke_m"), values(batch, "final_stroke_m"));
        for (i, status) in statuses(batch).iter().enumerate() {
            // A cylinder by the book: V = Vd + π φ² x/4, A = 4V/φ + π φ²/2.
            let volume = dead_volume + std::f64::consts::PI / 4.0 * bore * bore * last[i];
            let area = 4.0 * volume / bore + std::f64::consts::PI / 2.0 * bore * bore;
            if status == "failed: no length gives this volume-to-area ratio at this bore" {
                // The dead volume alone has more.
                let least = dead_volume / (4.0 * dead_volume / bore + std::f64::consts::PI / 2.0 * bore * bore);
                assert!(wanted[i] <= least);
                continue;
            }
            assert!((volume / area / wanted[i] - 1.0).abs() < 1e-12 && (ratio[i] / wanted[i] - 1.0).abs() < 1e-12);
            assert!((initial[i] / last[i] / 2.0 - 1.0).abs() < 1e-14, "the strokes keep the test's proportion");
        }
        assert!(statuses(batch).iter().filter(|status| status.starts_with("failed")).count() < 2);
    }
}

#[test]
fn a_hold_in_time_constants_ends_where_the_exact_solution_says() {
    // 1 - Pf/P decays with exactly one time constant, so P at the end follows from P at the begin of the hold.
    let text = text("design = \"factorial\"\ntolerance = 1e-12", "bore_m = { values = [0.016, 0.063] }")
        .replace("duration_s = 5.0", "hold_time_constants = 3.0");
    let study = Study::about(&model(), &text).unwrap();
    let batch = &run_in_memory(&study).unwrap()[0];
    let (peak, last, volume) =
        (values(batch, "pressure_peak_pa"), values(batch, "pressure_final_pa"), values(batch, "volume_m3"));
    for (i, bore) in [0.016, 0.063f64].into_iter().enumerate() {
        let initial = 1.57e-6 + std::f64::consts::PI / 4.0 * bore * bore * 0.1;
        let settled = 1.01e5 * initial / volume[i];
        let decay = (1.0 - settled / last[i]) / (1.0 - settled / peak[i]);
        assert!((decay / (-3.0f64).exp() - 1.0).abs() < 1e-9, "{decay}");
    }
    assert_eq!(statuses(batch), ["not_settled", "not_settled"]);
}

#[test]
fn the_schema_is_the_contracts_and_names_every_unit() {
    let study = study("design = \"factorial\"", BORES);
    let schema = sweep::columns::schema(&study);
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
    let study =
        |file: &str| Study::from_toml(&text(&format!("{head}\"{file}\""), ""), &folder.path().join("s.toml")).unwrap();
    let from_csv = run_in_memory(&study("points.csv")).unwrap();
    assert_eq!(from_csv.iter().map(|b| b.num_rows()).sum::<usize>(), 3000);
    assert_eq!(values(&from_csv[0], "chamber.bore_m")[7], 0.02 + 7e-5);
    // A study's own output serves as a table, with the columns that are picked.
    run_to_file(&study("points.csv"), &folder.path().join("points.parquet"), &quiet).unwrap();
    let again = text(&format!("{head}\"points.parquet\"\ncolumns = [\"chamber.bore_m\", \"initial_pressure_pa\"]"), "");
    let again = Study::from_toml(&again, &folder.path().join("s.toml")).unwrap();
    assert_eq!(run_in_memory(&again).unwrap()[0].columns(), from_csv[0].columns());
}

#[test]
fn the_traces_of_a_study_end_where_its_rows_do_and_reach_their_peaks() {
    let study = study(
        "design = \"latin-hypercube\"\nsamples = 300\nseed = 5\nfit = false",
        "bore_m = { from = 0.016, to = 0.063 }
push_time_s = { from = 0.05, to = 0.5 }
initial_pressure_pa = { from = 1e5, to = 7e5 }
mass_flow_in_kg_per_s = { from = 0.0, to = 1e-6 }
\"effect.leakage.conductance_m3_per_s_pa\" = { from = 1e-13, to = 1e-11 }
\"effect.record_delay.delay_s\" = { from = 0.0, to = 0.03 }",
    );
    let folder = tempfile::tempdir().unwrap();
    run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap();
    let asked = "290-299,0,17".parse().unwrap();
    let report = sweep::traces::write(&study, &at(&folder), &asked, 1000.0).unwrap();
    assert_eq!((report.rows, report.samples), (12, 12 * 5001));
    let traces = read(&folder.path().join("traces/traces.parquet"));
    let rows = read(&folder.path().join("rows/part-00000-of-00001.parquet"));
    let numbers: &Int64Array = traces.column(0).as_any().downcast_ref().unwrap();
    let (time, pressure) = (values(&traces, "time_s"), values(&traces, "pressure_pa"));
    let (gas, mass) = (values(&traces, "gas_pressure_pa"), values(&traces, "mass_kg"));
    for row in asked.iter().map(|row| row as usize) {
        let mine: Vec<usize> = (0..traces.num_rows()).filter(|i| numbers.value(*i) == row as i64).collect();
        let (first, last) = (mine[0], mine[mine.len() - 1]);
        assert_eq!((time[first], time[last]), (0.0, 5.0));
        let close = |a: f64, b: f64, tolerance: f64| assert!((a / b - 1.0).abs() < tolerance, "row {row}: {a} {b}");
        close(gas[first], values(&rows, "initial_pressure_pa")[row], 1e-12);
        close(pressure[last], values(&rows, "pressure_final_pa")[row], 1e-8);
        // Between samples of 1 kHz the pressure changes by little.
        let push = values(&rows, "push_time_s")[row];
        let peak = mine.iter().filter(|i| time[**i] >= push).map(|i| pressure[*i]).fold(0.0, f64::max);
        close(peak, values(&rows, "pressure_peak_pa")[row], 1e-2);
        // Perfect gas: P V = m R T in each sample.
        let (volume, temperature) = (values(&traces, "volume_m3")[last], values(&traces, "temperature_k")[last]);
        close(gas[last] * volume, mass[last] * 287.0 * temperature, 1e-12);
        assert!(mass[last] != mass[first]);
    }
    // The folder is still the study's, and the table of traces is replaced by another one.
    assert!(run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap().complete);
    assert_eq!(sweep::traces::write(&study, &at(&folder), &"3".parse().unwrap(), 10.0).unwrap().samples, 51);
    let refused = sweep::traces::write(&study, &at(&folder), &"300".parse().unwrap(), 10.0).unwrap_err().to_string();
    assert!(refused.contains("row 300") && refused.contains("0 to 299"), "{refused}");
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
    // Asked for when the rows are there already: nothing is solved again.
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
