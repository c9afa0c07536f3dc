//! Traces: what is read as it is, and what is refused, with file, line, column and value in the message.

use records::{Document, Error, Layout, Need, Reading, RigFile, Trace, Window};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const RIG: &str = "[cylinder]\nbore_m = 0.02\n[ambient]\npressure_pa = 101300.0\n";

struct Bench {
    folder: TempDir,
    layout: Layout,
    stroke_m: Option<f64>,
    window: Window,
    need: Need,
}

impl Bench {
    fn new() -> Self {
        Self::with_rig("")
    }

    /// A bench whose rig file has this beside its cylinder and ambient.
    fn with_rig(more: &str) -> Self {
        let document = Document::parse(Path::new("rig.toml"), format!("{RIG}{more}")).unwrap();
        let layout = RigFile::from_document(&document).unwrap().layout;
        Self { folder: TempDir::new().unwrap(), layout, stroke_m: None, window: Window::ALL, need: Need::Measurement }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("trace.csv")
    }

    fn read(&self, content: impl AsRef<[u8]>) -> Result<Trace, Error> {
        std::fs::write(self.path(), content).unwrap();
        let Self { layout, stroke_m, window, need, .. } = self;
        Trace::read(&self.path(), &Reading { layout, stroke_m: *stroke_m, window: *window, need: *need })
    }

    /// The refusal, without the folder's name before the file's.
    fn refusal(&self, content: impl AsRef<[u8]>) -> String {
        let message = self.read(content).expect_err("should be refused").to_string();
        assert!(!message.contains('\n'), "a sentence has one line: {message}");
        let at = message.find("trace.csv").expect("the message names the file");
        message[at..].to_owned()
    }
}

fn table(rows: &[&str]) -> String {
    format!("time_s,pressure_pa,position_m\n{}\n", rows.join("\n"))
}

const GOOD: [&str; 4] = ["0.0,101300,0.1", "0.01,101310.5,0.1", "0.02,150000,0.08", "0.03,200000,0.05"];

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn plain_columns_are_read_with_every_bit() {
    let trace = Bench::new().read(table(&GOOD)).unwrap();
    assert_eq!(trace.time_s, [0.0, 0.01, 0.02, 0.03]);
    assert_eq!(trace.pressure_pa.as_deref(), Some(&[101300.0, 101310.5, 150000.0, 200000.0][..]));
    assert_eq!(trace.position_m, [0.1, 0.1, 0.08, 0.05]);
    assert_eq!(trace.ambient_temperature_k, None);
    assert_eq!(trace.sha256.len(), 64);
}

#[test]
fn byte_order_mark_line_ends_quotes_and_blank_lines_do_not_matter() {
    let bench = Bench::new();
    let plain = bench.read(table(&GOOD)).unwrap();
    let dressed = "\u{feff}\"time_s\" , \"pressure_pa\",position_m,\"note, unread\"\r\n\
                   0.0,\"101300\",0.1,start\r\n0.01, 101310.5 ,0.1,\r\n\r\n0.02,1.5e5,0.08,\"a \"\"b\"\", c\"\r\n\
                   +0.03,200000,5e-2,end\r\n\r\n  \r\n";
    let trace = bench.read(dressed).unwrap();
    assert_eq!(
        (trace.time_s, trace.pressure_pa, trace.position_m),
        (plain.time_s, plain.pressure_pa, plain.position_m)
    );
}

#[test]
fn a_file_without_a_last_line_end_loses_nothing() {
    assert_eq!(Bench::new().read(table(&GOOD).trim_end()).unwrap().len(), 4);
}

#[test]
fn other_names_units_and_signs_are_mapped() {
    let bench = Bench::with_rig(
        r#"
        [columns]
        time = { name = "t", unit = "ms" }
        pressure = { name = "p", unit = "bar", reference = "gauge" }
        position = { name = "s", unit = "mm", sign = -1, offset_m = 0.2 }
        ambient_temperature = { name = "Ta", unit = "degC" }
        mass_flow = { name = "q", unit = "g/s" }
        [format]
        separator = ";"
        "#,
    );
    let trace = bench.read("t;s;p;Ta;q\n0;100;0.0;20;0\n10;120;1.5;21;1\n20;140;-0.5;22;-2\n").unwrap();
    assert_eq!(trace.time_s, [0.0, 0.01, 0.02]);
    assert_eq!(trace.pressure_pa.unwrap(), [101300.0, 251300.0, 51300.0]);
    assert!(trace.position_m.iter().zip([0.1, 0.08, 0.06]).all(|(a, b)| (a - b).abs() < 1e-15));
    assert_eq!(trace.ambient_temperature_k.unwrap(), [293.15, 294.15, 295.15]);
    assert_eq!(trace.mass_flow_kg_per_s.unwrap(), [0.0, 1e-3, -2e-3]);
}

#[test]
fn every_unit_has_its_factor() {
    let units = [("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("bar", 1e5), ("mbar", 1e2), ("psi", 6894.757293168361)];
    for (unit, factor) in units {
        let bench = Bench::with_rig(&format!("[columns]\npressure = {{ name = \"p\", unit = \"{unit}\" }}\n"));
        let trace = bench.read("time_s,p,position_m\n0,2,0.1\n1,2,0.1\n2,2,0.1\n").unwrap();
        let pressure = trace.pressure_pa.unwrap()[0];
        assert!((pressure / (2.0 * factor) - 1.0).abs() < 1e-15, "{unit}: {pressure}");
    }
}

#[test]
fn a_hash_before_a_header_with_commas_over_blank_separated_rows() {
    let bench = Bench::with_rig(
        "[columns]\ntime = { name = \"time(s)\" }\npressure = { name = \"P(psia)\", unit = \"psi\" }\n\
         position = { name = \"Pos(in)\", unit = \"in\" }\n[format]\nseparator = \"whitespace\"\n",
    );
    let trace = bench.read("#time(s),Pos(in),P(psia)\n  0.00 4.0 14.7\n  0.02  3.0 15\n  0.04\t2.0 16\n").unwrap();
    assert_eq!(trace.time_s, [0.0, 0.02, 0.04]);
    assert!((trace.position_m[2] - 0.0508).abs() < 1e-15);
    let spaced = bench.read("# time(s) Pos(in) P(psia)\n0 4 14.7\n1 3 15\n2 2 16\n").unwrap();
    assert_eq!(spaced.time_s, [0.0, 1.0, 2.0]);
}

#[test]
fn a_missing_column_offers_the_nearest_and_lists_those_there() {
    let message = Bench::new().refusal("time_s,presure_pa,position_m\n0,1e5,0.1\n");
    assert_says(
        &message,
        &["line 1", "no column `pressure_pa`", "did you mean `presure_pa`", "`position_m`", "[columns]"],
    );
}

#[test]
fn another_separator_is_recognised_and_named() {
    let message = Bench::new().refusal("time_s;pressure_pa;position_m\n0;1e5;0.1\n");
    assert_says(&message, &["no column `time_s`", "separator = \";\""]);
    assert_says(&Bench::new().refusal("time_s\tposition_m\n0\t1\n"), &["separator = \"tab\""]);
    assert_says(&Bench::new().refusal("time_s  position_m\n0 1\n"), &["separator = \"whitespace\""]);
}

#[test]
fn a_mapped_column_must_be_there_but_not_for_a_motion() {
    let mut bench = Bench::with_rig("[columns]\nambient_temperature = { name = \"Tamb\" }\n");
    assert_says(&bench.refusal(table(&GOOD)), &["no column `Tamb`"]);
    bench.need = Need::Motion;
    assert_eq!(bench.read(table(&GOOD)).unwrap().ambient_temperature_k, None);
    assert_eq!(bench.read("time_s,position_m\n0,0.1\n1,0.1\n2,0.05\n").unwrap().pressure_pa, None);
}

#[test]
fn a_column_named_twice_is_ambiguous() {
    let message = Bench::new().refusal("time_s,pressure_pa,pressure_pa,position_m\n0,1e5,1e5,0.1\n");
    assert_says(&message, &["line 1", "two columns are named `pressure_pa`"]);
}

#[test]
fn a_missing_header_is_told_from_a_missing_column() {
    assert_says(&Bench::new().refusal("0,1e5,0.1\n1,1e5,0.1\n"), &["line 1", "header line"]);
}

#[test]
fn values_that_are_no_finite_numbers_are_refused_where_they_stand() {
    for (value, says) in [
        ("NaN", "`NaN` is not a finite number"),
        ("inf", "`inf` is not a finite number"),
        ("-Infinity", "not a finite number"),
        ("1e999", "`1e999` is not a finite number"),
        ("n/a", "`n/a` is not a number"),
        ("", "the field is empty"),
        ("1e5 Pa", "`1e5 Pa` is not a number"),
        ("\"100000,5\"", "not a comma"),
    ] {
        let message = Bench::new().refusal(table(&[GOOD[0], GOOD[1], &format!("0.02,{value},0.1")]));
        assert_says(&message, &["trace.csv: line 4, column `pressure_pa`", says]);
    }
}

#[test]
fn decimal_commas_are_recognised() {
    let message = Bench::new().refusal(table(&["0,00,101300,0,100000,1"]));
    assert_says(&message, &["line 2", "fields where the header names 3", "decimal commas"]);
    let semicolons = Bench::with_rig("[format]\nseparator = \";\"\n");
    let message = semicolons.refusal("time_s;pressure_pa;position_m\n0,01;1e5;0.1\n");
    assert_says(&message, &["line 2, column `time_s`", "`0,01`", "decimal point, not a comma"]);
}

#[test]
fn a_row_cut_short_is_refused() {
    assert_says(&Bench::new().refusal(table(&[GOOD[0], GOOD[1], "0.02,1013"])), &["line 4", "2 fields", "names 3"]);
}

#[test]
fn time_that_stands_still_or_falls_is_refused() {
    let still = Bench::new().refusal(table(&[GOOD[0], GOOD[1], "0.01,101300,0.1"]));
    assert_says(&still, &["line 4, column `time_s`", "does not increase", "0.01 s after 0.01 s"]);
    let falling = Bench::new().refusal(table(&[GOOD[0], GOOD[2], "", GOOD[1]]));
    assert_says(&falling, &["line 5", "0.01 s after 0.02 s"]);
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
    assert_says(&message, &["line 4, column `position_m`", "-0.1 m is below zero"]);
}

#[test]
fn celsius_in_a_kelvin_column_is_noticed() {
    let message = Bench::new().refusal("time_s,pressure_pa,position_m,ambient_temperature_k\n0,1e5,0.1,23.5\n");
    assert_says(&message, &["line 2, column `ambient_temperature_k`", "23.5 K cannot be", "degC"]);
}

#[test]
fn files_without_a_record_are_refused() {
    let bench = Bench::new();
    assert_says(&bench.refusal(""), &["the file is empty"]);
    assert_says(&bench.refusal("\n \r\n\n"), &["the file is empty"]);
    assert_says(&bench.refusal(table(&[])), &["no row after the header in line 1"]);
    assert_says(&bench.refusal(table(&GOOD[..1])), &["1 row is too few", "3 are the least"]);
    assert_says(&bench.refusal(table(&GOOD[..2])), &["2 rows are too few"]);
}

#[test]
fn a_window_keeps_its_rows_and_looks_at_no_other() {
    let mut bench = Bench::new();
    bench.window = Window { from_s: 0.01, to_s: 0.03 };
    let trace = bench.read(table(&["0.0,broken,", GOOD[1], GOOD[2], GOOD[3], "0.04,NaN,0.1"])).unwrap();
    assert_eq!(trace.time_s, [0.01, 0.02, 0.03]);
    bench.window.to_s = 0.02;
    assert_says(&bench.refusal(table(&GOOD)), &["2 rows between from_s and to_s are too few"]);
}

#[test]
fn what_is_no_text_is_refused() {
    let bench = Bench::new();
    assert_says(&bench.refusal(b"\x7fELF\x02\x01\x01\0\0\0\0"), &["line 1", "binary data"]);
    assert_says(&bench.refusal(b"\xff\xfet\0i\0m\0e\0"), &["line 1", "UTF-16"]);
    assert_says(&bench.refusal(b"time_s,pressure_pa,position_m,T(\xb0C)\n"), &["line 1", "not UTF-8"]);
    let late = [table(&GOOD).as_bytes(), b"0.04,1e5,0.1\xe9\n"].concat();
    assert_says(&bench.refusal(late), &["line 6", "not UTF-8"]);
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
    assert_says(&message, &["600 MB are more than a trace may have (512 MB)"]);
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

/// Whatever bytes a file has, reading ends with a trace or a sentence.
mod any_bytes {
    use super::*;
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
