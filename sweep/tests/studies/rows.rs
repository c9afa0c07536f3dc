//! Definition and results of rows: solved geometry, reasons, traces.

use crate::common::{at, model, quiet, read, statuses, study, text, values};
use arrow::array::Int64Array;
use sweep::{Shard, Study, run, run_in_memory};

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
fn a_chamber_that_leaks_on_is_not_settled_whatever_the_duration() {
    let vary = "duration_s = { values = [10.0, 20.0, 40.0] }
\"effect.leakage.conductance_m3_per_s_pa\" = { values = [0.0, 1e-16, 1e-12] }";
    let study = study("design = \"factorial\"\nfit = false", vary);
    let batch = &run_in_memory(&study).unwrap()[0];
    assert_eq!(statuses(batch), ["ok", "ok", "not_settled"].repeat(3));
    let settling = values(batch, "settling_time_s");
    for of_duration in settling.chunks(3) {
        assert!((of_duration[0] / settling[0] - 1.0).abs() < 1e-6 && (of_duration[1] / settling[0] - 1.0).abs() < 1e-2);
        assert!(of_duration[2].is_nan());
    }
}

#[test]
fn a_reading_that_is_too_late_to_show_the_gas_settle_is_not_settled() {
    let study = study(
        "design = \"factorial\"",
        "\"effect.record_delay.delay_s\" = { values = [0.0, 1.0, 4.5, 4.98, 5.0, 7.0] }",
    );
    let batch = &run_in_memory(&study).unwrap()[0];
    assert_eq!(statuses(batch), ["ok", "ok", "not_settled", "not_settled", "not_settled", "not_settled"]);
    let has = |column: &str| values(batch, column).iter().map(|value| !value.is_nan()).collect::<Vec<_>>();
    assert_eq!(has("settling_time_s"), [true, true, false, false, false, false]);
    // No relaxation to describe.
    assert_eq!(has("lambda0_w_per_m2_k")[3..], [false, false, false]);
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
    // At a stroke of 50 mm the ratio stays below 25 mm plus a little for the dead volume, whatever the bore.
    let vary = "volume_to_area_m = { values = [0.03] }\nfinal_stroke_m = { values = [0.05, 0.09] }";
    let found = statuses(&run_in_memory(&study("design = \"factorial\"", vary)).unwrap()[0]);
    assert_eq!(found[0], "failed: no bore gives this volume-to-area ratio");
    assert!(!found[1].contains("no bore"), "{found:?}");
}

#[test]
fn the_strokes_are_solved_for_a_volume_to_area_ratio_at_a_bore() {
    for (dead_volume, bore) in [(0.0, 0.02), (1.57e-6, 0.032), (2e-5, 0.063)] {
        let vary = format!(
            "volume_to_area_by_length_m = {{ values = [{}] }}\ndead_volume_m3 = {{ values = [{dead_volume}] }}\nbore_m = {{ values = [{bore}] }}",
            [0.12, 0.16, 0.2, 0.24].map(|fraction| (fraction * bore).to_string()).join(", ")
        );
        let study = study("design = \"factorial\"\nfit = false", &vary);
        let batch = &run_in_memory(&study).unwrap()[0];
        let (wanted, ratio) = (values(batch, "volume_to_area_by_length_m"), values(batch, "volume_to_area_m"));
        let (initial, last) = (values(batch, "initial_stroke_m"), values(batch, "final_stroke_m"));
        for (i, status) in statuses(batch).iter().enumerate() {
            // Textbook cylinder: V = Vd + π φ² x/4, A = 4V/φ + π φ²/2.
            let volume = dead_volume + std::f64::consts::PI / 4.0 * bore * bore * last[i];
            let area = 4.0 * volume / bore + std::f64::consts::PI / 2.0 * bore * bore;
            assert!(!status.starts_with("failed"), "{status}");
            assert!((volume / area / wanted[i] - 1.0).abs() < 1e-12 && (ratio[i] / wanted[i] - 1.0).abs() < 1e-12);
            assert!((initial[i] / last[i] / 2.0 - 1.0).abs() < 1e-14, "the strokes keep the test's proportion");
        }
    }
}

#[test]
fn a_hold_in_time_constants_ends_where_the_exact_solution_says() {
    // 1 - Pf/P decays with exactly one time constant, so P at the end follows from P at the start of the hold.
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
        // Between samples at 1 kHz the pressure changes little.
        let push = values(&rows, "push_time_s")[row];
        let peak = mine.iter().filter(|i| time[**i] >= push).map(|i| pressure[*i]).fold(0.0, f64::max);
        close(peak, values(&rows, "pressure_peak_pa")[row], 1e-2);
        // Perfect gas: P V = m R T in each sample.
        let (volume, temperature) = (values(&traces, "volume_m3")[last], values(&traces, "temperature_k")[last]);
        close(gas[last] * volume, mass[last] * 287.0 * temperature, 1e-12);
        assert!(mass[last] != mass[first]);
    }
    // The folder still belongs to the study, and the table of traces is replaced.
    assert!(run(&study, &at(&folder), Shard::WHOLE, &quiet).unwrap().complete);
    assert_eq!(sweep::traces::write(&study, &at(&folder), &"3".parse().unwrap(), 10.0).unwrap().samples, 51);
    let refused = sweep::traces::write(&study, &at(&folder), &"300".parse().unwrap(), 10.0).unwrap_err().to_string();
    assert!(refused.contains("row 300") && refused.contains("0 to 299"), "{refused}");
}
