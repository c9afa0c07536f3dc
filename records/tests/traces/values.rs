//! Impossible values: refused with their location and the remedy.

use crate::{Bench, GOOD, assert_says, table};

#[test]
fn values_that_are_no_finite_numbers_are_refused_where_they_stand() {
    // One row in three cannot be left out.
    for (value, says) in [
        ("NaN", "`NaN` is not a finite number"),
        ("inf", "`inf` is not a finite number"),
        ("-Infinity", "not a finite number"),
        ("1e999", "`1e999` is not a finite number"),
        ("9.9E37", "`9.9E37` is an instrument's mark of no reading"),
        ("-9.9e+37", "`-9.9e+37` is an instrument's mark of no reading"),
        ("9.91E37", "mark of no reading"),
        ("n/a", "`n/a` is not a number"),
        ("", "the field is empty"),
        ("1e5 Pa", "`1e5 Pa` is not a number"),
        ("\"100000,5\"", "for decimal commas say decimal = \",\""),
    ] {
        let message = Bench::new().refusal(table(&[GOOD[0], GOOD[1], &format!("0.02,{value},0.1")]));
        assert_says(&message, &["trace.csv: line 4, column `pressure_pa`", says]);
    }
}

#[test]
fn a_row_with_a_mark_of_no_reading_in_any_column_is_dropped() {
    let row = |k: usize| format!("{},{},0.1", 0.01 * k as f64, 101_300 + k % 7);
    for marked in ["0.5,9.9E37,0.1", "0.5,-9.9E37,0.1", "0.5,101300,9.90000015E+37", "9.91E37,101300,0.1"] {
        let mut rows: Vec<String> = (0..100).map(row).collect();
        rows[50] = marked.to_owned();
        let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
        let trace = Bench::new().read(table(&rows)).unwrap();
        assert_eq!((trace.len(), trace.dropped_rows.len(), trace.dropped_rows[0].line), (99, 1, 52), "{marked}");
    }
}

#[test]
fn pressures_below_vacuum_are_refused_with_the_remedy() {
    for value in ["0", "-250.5"] {
        let message = Bench::new().refusal(table(&[GOOD[0], &format!("0.01,{value},0.1")]));
        assert_says(&message, &["line 3, column `pressure_pa`", "cannot be an absolute pressure", "\"gauge\""]);
    }
    let gauge = Bench::with_rig("[columns]\npressure = { name = \"pressure_pa\", reference = \"gauge\" }\n");
    assert_says(&gauge.refusal(table(&["0,-101300.5,0.1"])), &["line 2", "even with the ambient pressure added"]);
}

#[test]
fn millimetres_taken_for_metres_are_refused_with_the_remedy() {
    let message = Bench::new().refusal(table(&["0,1e5,160.0", "0.01,1e5,80.0"]));
    assert_says(&message, &["line 2, column `position_m`", "160.00 m is not plausible", "unit = \"mm\""]);
    let inches = Bench::with_rig("[columns]\nposition = { name = \"position_m\", unit = \"in\" }\n");
    assert_says(&inches.refusal(table(&["0,1e5,6300"])), &["160.02 m is not plausible", "unit and scale"]);
    let mut long = Bench::new();
    long.stroke_m = Some(40.0);
    assert!(long.read(table(&["0,1e5,39.0", "1,1e5,35.0", "2,1e5,30.0"])).is_ok(), "a stroke that the rig states");
}

#[test]
fn a_position_beyond_the_cylinder_is_refused_but_not_the_noise_at_its_end() {
    let mut bench = Bench::new();
    bench.stroke_m = Some(0.1);
    assert!(bench.read(table(&["0,1e5,0.1004", "1,1e5,0.0999", "2,1e5,-0.0003"])).is_ok());
    let message = bench.refusal(table(&[GOOD[0], GOOD[1], "0.02,1e5,0.13"]));
    assert_says(&message, &["line 4, column `position_m`", "0.13 m", "beyond the stroke of 0.1 m"]);
    assert_says(
        &bench.refusal(table(&[GOOD[0], "0.02,1e5,-0.02", GOOD[3]])),
        &["line 3", "-0.02 m is below zero", "sign"],
    );
}

#[test]
fn a_stroke_of_the_wrong_sign_is_noticed_without_knowing_the_stroke() {
    let message = Bench::new().refusal(table(&["0,1e5,-0.05", "1,1e5,-0.08", "2,1e5,-0.1"]));
    assert_says(&message, &["line 2, column `position_m`", "-0.05 m is below zero", "3 of 3 rows"]);
}

#[test]
fn celsius_in_a_kelvin_column_is_noticed() {
    let message = Bench::new().refusal("time_s,pressure_pa,position_m,ambient_temperature_k\n0,1e5,0.1,23.5\n");
    assert_says(&message, &["line 2, column `ambient_temperature_k`", "23.5 K is not plausible", "degC"]);
}
