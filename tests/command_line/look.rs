//! `pneutherm look`: its output for a record.

use crate::common::{Bench, motion, text};

/// The record of a logger that counts seconds from `since`, with noise so that it is not constant.
fn logged(since: f64) -> String {
    let mut out = "unix_time,p_bar,x_mm\n".to_owned();
    for (k, line) in motion().lines().skip(1).enumerate() {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let push = if k > 20 { 1.0 + (-((k - 20) as f64) / 50.0).exp() } else { 0.0 };
        let bar = 1.013 + push + 1e-4 * f64::from(u8::try_from(k * 7 % 5).unwrap());
        out += &format!("{:.3},{bar:.4},{:.3}\n", since + fields[0], 1e3 * fields[2]);
    }
    out
}

#[test]
fn a_header_without_rows_is_refused() {
    let bench = Bench::new();
    bench.file("header.csv", "time_s,pressure_pa,position_m\n");
    let sentence = bench.refusal(&["look", "header.csv", "-o", "looked.toml"]);
    assert!(sentence.contains("header.csv: there is no row of numbers after the header in line 1"), "{sentence}");
}

#[test]
fn seconds_since_1970_stand_in_their_columns() {
    let bench = Bench::new();
    bench.file("logged.csv", logged(1_764_000_000.0));
    let out = text(&bench.call(0, &["look", "logged.csv"]).stdout);
    assert!(out.contains("1764000000 s to 1764000001.99 s"), "{out}");
    let table: Vec<&str> =
        out.lines().skip_while(|line| !line.contains("from s")).take_while(|l| !l.is_empty()).collect();
    assert!(table.len() >= 4, "{out}");
    assert!(table.iter().all(|line| line.len() == table[0].len()), "{out}");
}

#[test]
fn a_clock_s_times_are_printed_without_rounding_errors() {
    let bench = Bench::new();
    let clock = logged(9.0).replace("unix_time", "time");
    let clock: Vec<String> = clock
        .lines()
        .map(|line| match line.split_once(',') {
            Some((time, rest)) if time != "time" => format!("08:59:{:0>6},{rest}", time),
            _ => line.to_owned(),
        })
        .collect();
    bench.file("clock.csv", clock.join("\n"));
    let out = text(&bench.call(0, &["look", "clock.csv"]).stdout);
    assert!(out.contains("0 s to 1.99 s"), "{out}");
}

#[test]
fn columns_without_names_are_asked_for_by_number() {
    let bench = Bench::new();
    let rows: String = motion().lines().skip(1).map(|line| format!("{line}\n")).collect();
    bench.file("bare.csv", rows);
    let out = text(&bench.call(0, &["look", "bare.csv"]).stdout);
    assert!(out.contains("--time COLUMN, --pressure COLUMN, --position COLUMN, by its number: \"column 1\""), "{out}");
    let named = ["--time", "column 1", "--pressure", "column 2", "--position", "column 3"];
    assert!(text(&bench.call(0, &[&["look", "bare.csv"][..], &named].concat()).stdout).contains("200 rows"));
}

#[test]
fn windows_of_single_tests_are_written_without_what_rounding_adds() {
    let bench = Bench::new();
    // Three pushes in one record, with times unlike those of a clock.
    let rows: Vec<Vec<f64>> =
        logged(0.0).lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect();
    let mut out = "time_s,p_bar,x_mm\n".to_owned();
    for test in 0..3 {
        for row in &rows {
            out += &format!("{},{},{}\n", f64::from(test) * 2.0 + row[0] + 2.9e-12, row[1], row[2]);
        }
    }
    bench.file("tests.csv", out);
    bench.call(0, &["look", "tests.csv", "--bore-mm", "20", "--split", "-o", "split.toml"]);
    let rig = std::fs::read_to_string(bench.path("split.toml")).unwrap();
    let times: Vec<&str> =
        rig.lines().filter_map(|l| l.strip_prefix("from_s = ").or(l.strip_prefix("to_s = "))).collect();
    assert!(!times.is_empty(), "{rig}");
    assert!(times.iter().all(|time| time.len() <= "5.990".len()), "{times:?}");
    let json: serde_json::Value =
        serde_json::from_slice(&bench.call(0, &["look", "tests.csv", "--json", "-"]).stdout).unwrap();
    for phase in json["record"]["phases"].as_array().unwrap() {
        assert!(phase["from_s"].to_string().len() <= "5.990".len(), "{phase}");
    }
}

#[test]
fn a_rig_file_that_was_filled_in_is_replaced_only_by_force() {
    let bench = Bench::new();
    let look = ["look", "motion.csv", "-o", "looked.toml"];
    bench.call(0, &look);
    let proposed = std::fs::read(bench.path("looked.toml")).unwrap();
    // Writing the same again loses nothing.
    bench.call(0, &look);
    let filled_in = [&proposed[..], b"# filled in\n"].concat();
    bench.file("looked.toml", &filled_in);
    let sentence = bench.refusal(&look);
    assert!(sentence.contains("looked.toml: not written, because another rig file is there"), "{sentence}");
    assert_eq!(std::fs::read(bench.path("looked.toml")).unwrap(), filled_in);
    bench.call(0, &[&look[..], &["--force"]].concat());
    assert_eq!(std::fs::read(bench.path("looked.toml")).unwrap(), proposed);
    assert!(text(&bench.call(2, &["look", "motion.csv", "--force"]).stderr).contains("--output"));
}
