//! Files without a record, or with arbitrary bytes: a trace or an error.

use crate::{Bench, GOOD, assert_says, table};
use records::{Need, Reading, Trace, Window};

#[test]
fn files_without_a_record_are_refused() {
    let bench = Bench::new();
    assert_says(&bench.refusal(""), &["the file is empty"]);
    assert_says(&bench.refusal("\n \r\n\n"), &["the file is empty"]);
    assert_says(&bench.refusal(table(&[])), &["no row of numbers after the header in line 1"]);
    assert_says(&bench.refusal(table(&GOOD[..1])), &["1 row is too few", "at least 3 are needed"]);
    assert_says(&bench.refusal(table(&GOOD[..2])), &["2 rows are too few"]);
}

#[test]
fn a_header_and_units_without_rows_are_reported_as_such() {
    let mapped = "[columns]\ntime = { name = \"Zeit\", unit = \"ms\" }\npressure = { name = \"Druck\", unit = \"bar\" }\n\
                  position = { name = \"Weg\", unit = \"mm\" }\n";
    let bench = Bench::with_rig(mapped);
    for units in ["[ms];[bar];[mm]", "ms;bar;mm"] {
        let message = bench.refusal(format!("Pruefstand 3\nZeit;Druck;Weg\n{units}\n"));
        assert_says(&message, &["no row of numbers after the header in line 2"]);
    }
}

#[test]
fn skipping_more_lines_than_there_are_is_reported() {
    let bench = Bench::with_rig("[format]\nskip_lines = 9\n");
    assert_says(&bench.refusal(table(&GOOD[..2])), &["skip_lines = 9", "leaves no line to read; the file has 3"]);
    assert_says(&bench.refusal(""), &["the file is empty"]);
}

#[test]
fn what_is_no_text_is_refused() {
    let bench = Bench::new();
    assert_says(&bench.refusal(b"\x7fELF\x02\x01\x01\0\0\0\0"), &["line 1", "binary data"]);
    let stated = Bench::with_rig("[format]\nencoding = \"utf-8\"\n");
    assert_says(&stated.refusal(b"time_s,pressure_pa,position_m,T(\xb0C)\n"), &["line 1", "not UTF-8"]);
    assert_says(&bench.refusal("x".repeat(3 << 20)), &["line 1", "a line of more than"]);
    assert_says(&bench.refusal(table(&["0,\"1e5,0.1"])), &["line 2", "quote"]);
}

#[test]
fn a_huge_file_is_refused_at_once() {
    let bench = Bench::new();
    let file = std::fs::File::create(bench.path()).unwrap();
    file.set_len(600 << 20).unwrap(); // sparse: takes no room
    let Bench { layout, stroke_m, window, need, .. } = &bench;
    let reading = Reading { layout, stroke_m: *stroke_m, window: *window, need: *need };
    let message = Trace::read(&bench.path(), &reading).unwrap_err().to_string();
    assert_says(&message, &["the file has 600 MB; the limit is 512 MB"]);
}

#[test]
fn files_that_cannot_be_read_are_named_with_the_reason() {
    let bench = Bench::new();
    let reading = Reading { layout: &bench.layout, stroke_m: None, window: Window::ALL, need: Need::Motion };
    let message = Trace::read(&bench.folder.path().join("absent.csv"), &reading).unwrap_err().to_string();
    assert_says(&message, &["absent.csv: cannot be read: No such file"]);
    let message = Trace::read(bench.folder.path(), &reading).unwrap_err().to_string();
    assert_says(&message, &["it is a folder"]);
}

/// For arbitrary bytes, reading ends with a trace or an error.
mod any_bytes {
    use crate::Bench;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn end_with_a_trace_or_a_sentence(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            if let Err(error) = Bench::new().read(bytes) {
                prop_assert!(error.to_string().contains("trace.csv"));
            }
        }

        #[test]
        fn that_look_like_a_table_do_too(rows in "time_s,pressure_pa,position_m\n([-0-9e.,\" \n]{0,80})") {
            if let Err(error) = Bench::new().read(rows) {
                prop_assert!(error.to_string().contains("trace.csv"));
            }
        }

        #[test]
        fn numbers_written_in_full_are_read_back(
            rows in prop::collection::vec((1e-6..10.0_f64, 1.0..1e7_f64, 0.0..0.5_f64), 3..20)
        ) {
            let mut time = 0.0;
            let mut text = "time_s,pressure_pa,position_m\n".to_owned();
            let mut times = Vec::new();
            for (step, pressure, position) in &rows {
                time += step;
                times.push(time);
                text += &format!("{time:?},{pressure:?},{position:?}\n");
            }
            let trace = Bench::new().read(text).unwrap();
            prop_assert_eq!(trace.time_s, times);
            prop_assert_eq!(trace.pressure_pa.unwrap(), rows.iter().map(|r| r.1).collect::<Vec<_>>());
            prop_assert_eq!(trace.position_m, rows.iter().map(|r| r.2).collect::<Vec<_>>());
        }
    }
}
