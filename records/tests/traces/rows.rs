//! Rows: single bad ones are left out and named, times are ordered, a window keeps only its rows.

use crate::{Bench, GOOD, assert_says, table};
use records::Window;

#[test]
fn a_row_cut_short_is_refused() {
    assert_says(&Bench::new().refusal(table(&[GOOD[0], GOOD[1], "0.02,1013"])), &["line 4", "2 fields", "names 3"]);
}

#[test]
fn a_time_that_stands_still_in_a_short_record_is_refused() {
    let still = Bench::new().refusal(table(&[GOOD[0], GOOD[1], "0.01,101300,0.1"]));
    assert_says(&still, &["line 4, column `time_s`", "does not increase", "0.01 s occurs twice", "one of only 3 rows"]);
}

#[test]
fn a_window_keeps_its_rows_and_looks_at_no_other() {
    let mut bench = Bench::new();
    bench.window = Window { from_s: 0.01, to_s: 0.03 };
    let trace = bench.read(table(&["0.0,broken,", GOOD[1], GOOD[2], GOOD[3], "0.04,NaN,0.1"])).unwrap();
    assert_eq!(trace.time_s, [0.01, 0.02, 0.03]);
    bench.window.to_s = 0.02;
    assert_says(
        &bench.refusal(table(&GOOD)),
        &["2 rows between from_s and to_s, of a record from 0.0 s to ", " s, are too few"],
    );
}

/// A record of 200 rows, some of them spoiled.
fn spoiled(spoil: impl Fn(usize, &mut Vec<String>)) -> String {
    let row = |k: usize| format!("{:.2},{},{:.4}", k as f64 * 0.01, 101300 + k, 0.1 - 1e-4 * k as f64);
    let mut rows: Vec<String> = (0..200).map(row).collect();
    (0..200).rev().for_each(|k| spoil(k, &mut rows));
    table(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn single_bad_rows_are_dropped_and_named() {
    for (bad, says) in [
        ("0.50,,0.1", "column `pressure_pa`: `` is not a number, the field is empty"),
        ("0.50,NaN,0.1", "column `pressure_pa`: `NaN` is not a finite number"),
        ("0.50,-,0.1", "column `pressure_pa`: `-` is not a number"),
        ("0.50,OVER,0.1", "`OVER` is not a number"),
        ("0.50,-36000,0.1", "-36000.0 Pa cannot be an absolute pressure"),
        ("0.50,101350", "2 fields where the header names 3 columns"),
        ("0.49,101350,0.1", "column `time_s`: time does not increase, 0.49 s occurs twice"),
        ("0.20,101350,0.1", "time does not increase, 0.2 s after 0.49 s"),
        ("1e9,101350,0.1", "the time jumps to 1e9 s, and the next row has 0.51 s"),
        ("0.50,101350,-0.3", "position -0.3 m is below zero"),
        ("\"0.50,101350,0.1", "a quote is opened but not closed"),
        ("end of block", "1 fields where the header names 3 columns"),
    ] {
        let spoil = |k: usize, rows: &mut Vec<String>| {
            if k == 50 {
                rows[k] = bad.to_owned();
            }
        };
        let trace = Bench::new().read(spoiled(spoil)).unwrap();
        assert_eq!((trace.len(), trace.dropped_rows.len(), trace.sorted), (199, 1, false), "{bad}");
        assert!(!trace.time_s.contains(&0.5) && trace.time_s.windows(2).all(|pair| pair[0] < pair[1]), "{bad}");
        let dropped = &trace.dropped_rows[0];
        assert_eq!(dropped.line, 52, "{bad}");
        assert_says(&dropped.to_string(), &["line 52, ", says]);
        let notes = trace.notes();
        assert_eq!(notes.len(), 1);
        assert_says(&notes[0], &["trace.csv: 1 row is left out: line 52", says]);
    }
    assert!(Bench::new().read(table(&GOOD)).unwrap().notes().is_empty());
}

#[test]
fn a_column_with_a_value_at_every_tenth_row_is_joined_by_straight_lines() {
    let whole = Bench::new().read(spoiled(|_, _| {})).unwrap();
    let slow = |offset: usize| {
        spoiled(move |k, rows| {
            if k % 10 != offset {
                rows[k] = rows[k][..rows[k].rfind(',').unwrap() + 1].to_owned();
            }
        })
    };
    for offset in [0, 3] {
        let trace = Bench::new().read(slow(offset)).unwrap();
        assert_eq!((trace.len(), &trace.pressure_pa, trace.dropped_rows.len()), (200, &whole.pressure_pa, 0));
        // The position falls steadily.
        let off = trace.position_m.iter().zip(&whole.position_m).map(|(a, b)| (a - b).abs());
        assert!(off.clone().skip(offset).take(190 - offset).all(|off| off < 1e-12), "{offset}");
    }
    let odd = spoiled(|k, rows| {
        if k % 10 != 0 && k != 55 {
            rows[k] = rows[k][..rows[k].rfind(',').unwrap() + 1].to_owned();
        }
    });
    assert_says(&Bench::new().refusal(odd), &["line 3, column `position_m`", "the field is empty", "179 of 200 rows"]);
}

#[test]
fn one_row_in_fifty_may_be_bad_and_no_more() {
    let bad = |every: usize| {
        spoiled(move |k, rows| {
            if k % every == every - 1 {
                rows[k] = format!("{k},NaN,0.1");
            }
        })
    };
    let trace = Bench::new().read(bad(50)).unwrap();
    assert_eq!(trace.dropped_rows.iter().map(|row| row.line).collect::<Vec<_>>(), [51, 101, 151, 201]);
    assert_says(&trace.notes()[0], &["4 rows are left out: line 51", "line 201"]);
    let message = Bench::new().refusal(bad(40));
    assert_says(&message, &["line 41, column `pressure_pa`", "5 of 200 rows", "lines 41, 81, 121, 161, 201)"]);
    let message = Bench::new().refusal(bad(2));
    assert_says(&message, &["line 3, column `pressure_pa`", "100 of 200 rows", "lines 3, 5, 7, 9, 11, ...)"]);
}

#[test]
fn unsorted_rows_are_sorted_and_records_one_after_the_other_refused() {
    let plain = Bench::new().read(spoiled(|_, _| {})).unwrap();
    let shuffled = spoiled(|k, rows| rows.swap(k, k * 7919 % 200));
    let at_last = |change: fn(&mut Vec<String>)| {
        spoiled(move |k, rows| {
            if k == 0 {
                change(rows);
            }
        })
    };
    let blocks = at_last(|rows| rows.rotate_left(80));
    for unsorted in [shuffled, blocks] {
        let trace = Bench::new().read(unsorted).unwrap();
        assert_eq!((trace.time_s, trace.pressure_pa), (plain.time_s.clone(), plain.pressure_pa.clone()));
        assert!(trace.sorted && trace.dropped_rows.is_empty());
    }
    let two = at_last(|rows| rows.extend(rows.clone()));
    assert_says(&Bench::new().refusal(two), &["line 202, column `time_s`", "restarts at 0 s after 1.99 s", "file of"]);
}

#[test]
fn times_that_are_written_too_coarsely_for_their_rows_are_refused_with_the_remedy() {
    let coarse = spoiled(|k, rows| rows[k] = format!("{:.1}{}", (k / 10) as f64 * 0.1, &rows[k][4..]));
    let says = ["column `time_s`: 200 rows have only 20 different times, 0.1 s apart", "more digits", "scale"];
    assert_says(&Bench::new().refusal(coarse), &says);
}
