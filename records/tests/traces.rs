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
    let units = [
        ("Pa", 1.0),
        ("hPa", 1e2),
        ("kPa", 1e3),
        ("MPa", 1e6),
        ("bar", 1e5),
        ("mbar", 1e2),
        ("psi", 6894.757293168361),
        ("atm", 101325.0),
        ("kgf/cm2", 98066.5),
        ("mmHg", 133.322_387_415),
    ];
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
fn separators_are_found_and_a_wrong_one_is_named() {
    let plain = Bench::new().read(table(&GOOD)).unwrap();
    for separator in [";", "\t", " ", "   "] {
        let trace = Bench::new().read(table(&GOOD).replace(',', separator)).unwrap();
        assert_eq!((&trace.time_s, &trace.pressure_pa), (&plain.time_s, &plain.pressure_pa), "{separator:?}");
    }
    let stated = Bench::with_rig("[format]\nseparator = \";\"\n");
    assert_says(&stated.refusal(table(&GOOD)), &["line 1", "no column `time_s`", "leave out separator"]);
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
    // One row in three cannot be left out.
    for (value, says) in [
        ("NaN", "`NaN` is not a finite number"),
        ("inf", "`inf` is not a finite number"),
        ("-Infinity", "not a finite number"),
        ("1e999", "`1e999` is not a finite number"),
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
fn decimal_commas_are_recognised() {
    let message = Bench::new().refusal(table(&["0,00,101300,0,100000,1"]));
    assert_says(&message, &["line 2", "fields where the header names 3", "decimal commas"]);
    let points = Bench::with_rig("[format]\nseparator = \";\"\ndecimal = \".\"\n");
    let message = points.refusal("time_s;pressure_pa;position_m\n0,01;1e5;0,1\n");
    assert_says(&message, &["line 2, column `time_s`", "`0,01`", "decimal = \",\""]);
    let commas = Bench::new().read(table(&GOOD).replace(',', ";").replace('.', ",")).unwrap();
    assert_eq!(commas.pressure_pa, Bench::new().read(table(&GOOD)).unwrap().pressure_pa);
}

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

/// A record of 200 rows, some of them spoiled.
fn spoiled(spoil: impl Fn(usize, &mut Vec<String>)) -> String {
    let row = |k: usize| format!("{:.2},{},{:.4}", k as f64 * 0.01, 101300 + k, 0.1 - 1e-4 * k as f64);
    let mut rows: Vec<String> = (0..200).map(row).collect();
    (0..200).rev().for_each(|k| spoil(k, &mut rows));
    table(&rows.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn single_bad_rows_are_left_out_and_named() {
    for (bad, says) in [
        ("0.50,,0.1", "column `pressure_pa`: `` is not a number, the field is empty"),
        ("0.50,NaN,0.1", "column `pressure_pa`: `NaN` is not a finite number"),
        ("0.50,-,0.1", "column `pressure_pa`: `-` is not a number"),
        ("0.50,OVER,0.1", "`OVER` is not a number"),
        ("0.50,-36000,0.1", "-36000.0 Pa cannot be an absolute pressure"),
        ("0.50,101350", "2 fields where the header names 3 columns"),
        ("0.49,101350,0.1", "column `time_s`: time does not increase, 0.49 s occurs twice"),
        ("0.20,101350,0.1", "time does not increase, 0.2 s after 0.49 s"),
        ("1e9,101350,0.1", "time does not increase, 1000000000.0 s after 0.49 s"),
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
        assert_eq!((trace.len(), trace.left_out.len(), trace.sorted), (199, 1, false), "{bad}");
        assert!(!trace.time_s.contains(&0.5) && trace.time_s.windows(2).all(|pair| pair[0] < pair[1]), "{bad}");
        let left_out = &trace.left_out[0];
        assert_eq!(left_out.line, 52, "{bad}");
        assert_says(&left_out.to_string(), &["line 52, ", says]);
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
        assert_eq!((trace.len(), &trace.pressure_pa, trace.left_out.len()), (200, &whole.pressure_pa, 0));
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
    assert_eq!(trace.left_out.iter().map(|row| row.line).collect::<Vec<_>>(), [51, 101, 151, 201]);
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
        assert!(trace.sorted && trace.left_out.is_empty());
    }
    let two = at_last(|rows| rows.extend(rows.clone()));
    assert_says(
        &Bench::new().refusal(two),
        &["line 202, column `time_s`", "restarts at 0.0 s after 1.99 s", "file of"],
    );
}

#[test]
fn times_that_are_written_too_coarsely_for_their_rows_are_refused_with_the_remedy() {
    let coarse = spoiled(|k, rows| rows[k] = format!("{:.1}{}", (k / 10) as f64 * 0.1, &rows[k][4..]));
    let says = ["column `time_s`: 200 rows have only 20 different times, 0.1 s apart", "more digits", "scale"];
    assert_says(&Bench::new().refusal(coarse), &says);
}

#[test]
fn numbers_of_a_sensor_are_scaled_to_its_quantity() {
    let bench = Bench::with_rig(
        r#"
        [columns]
        time = { name = "t" }
        pressure = { name = "U1", unit = "bar", scale = 2.5, offset = -1.25 }
        position = { name = "U2", unit = "V", scale = 0.02, offset = 0.01, sign = -1, offset_m = 0.3 }
        "#,
    );
    let trace = bench.read("t,U1,U2\n0,1,0\n1,2,5\n2,3,10\n").unwrap();
    assert_eq!(trace.pressure_pa.unwrap(), [125000.0, 375000.0, 625000.0]);
    assert!(trace.position_m.iter().zip([0.29, 0.19, 0.09]).all(|(a, b)| (a - b).abs() < 1e-15));
}

#[test]
fn clock_times_count_from_the_first_row() {
    let rows = "Zeit;p;x\n23:59:59,9;1;1\n00:00:00,1;1;1\n00:00:00,3;1;1\n";
    for time in ["{ name = \"Zeit\" }", "{ name = \"Zeit\", unit = \"clock\" }"] {
        let columns = "pressure = { name = \"p\", unit = \"bar\" }\nposition = { name = \"x\" }\n";
        let bench = Bench::with_rig(&format!("[columns]\ntime = {time}\n{columns}"));
        let trace = bench.read(rows).unwrap();
        assert!(trace.time_s.iter().zip([0.0, 0.2, 0.4]).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", trace.time_s);
        let message = bench.refusal(rows.replace("00:00:00,1", "noon"));
        assert_says(&message, &["line 3, column `Zeit`: `noon` is not a clock time"]);
    }
}

#[test]
fn a_units_line_that_contradicts_the_rig_is_refused() {
    let text = "time_s,pressure_pa,position_m\n[s],[bar],[m]\n0,1,0.1\n1,1,0.1\n2,1,0.1\n";
    let message = Bench::new().refusal(text);
    assert_says(
        &message,
        &["line 2, column `pressure_pa`", "unit is bar here, but Pa in the [columns] of the rig", "unit = \"bar\""],
    );
    let bench = Bench::with_rig("[columns]\npressure = { name = \"pressure_pa\", unit = \"bar\" }\n");
    assert_eq!(bench.read(text).unwrap().pressure_pa.unwrap(), [1e5; 3]);
}

#[test]
fn header_blocks_comments_and_encodings_do_not_matter() {
    let plain = Bench::new().read(table(&GOOD)).unwrap();
    let text = format!("Prüfstand 3\nNotes, by hand\n\n# Größe\n{}", table(&GOOD).replace("0.02,", "# hold\n0.02,"));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [text.as_bytes(), &latin, &wide, &[b"\xff\xfe", &wide[..]].concat()] {
        let trace = Bench::new().read(bytes).unwrap();
        assert_eq!((&trace.time_s, &trace.pressure_pa), (&plain.time_s, &plain.pressure_pa));
        assert!(trace.left_out.is_empty());
    }
    let format = "[format]\nskip_lines = 3\ncomment = \"#\"\ndecimal = \".\"\nencoding = \"latin-1\"\n";
    assert_eq!(Bench::with_rig(format).read(latin).unwrap().time_s, plain.time_s);
}

#[test]
fn a_file_without_a_header_has_numbered_columns() {
    let column = |quantity: &str, k: usize| format!("{quantity} = {{ name = \"column {k}\" }}\n");
    let columns = [column("time", 1), column("pressure", 3), column("position", 2)].concat();
    let trace = Bench::with_rig(&format!("[columns]\n{columns}")).read("0 0.1 1e5\n1 0.1 1e5\n2 0.1 1e5\n").unwrap();
    assert_eq!((trace.position_m, trace.pressure_pa.unwrap()), (vec![0.1; 3], vec![1e5; 3]));
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

#[test]
fn a_unit_in_a_column_s_name_that_contradicts_the_rig_is_refused() {
    let rows = "0,14.7,0.1\n1,14.7,0.1\n2,14.7,0.1\n";
    let bench = |more: &str| {
        let pressure = format!("pressure = {{ {more} }}\n");
        Bench::with_rig(&format!("[columns]\n{pressure}time = {{ name = \"t\" }}\nposition = {{ name = \"x\" }}\n"))
    };
    let expected = [("Pressure (psi)", ", unit = \"bar\"", "bar"), ("P [psi]", "", "Pa"), ("p_psi", "", "Pa")];
    for (name, stated, unit) in expected {
        let text = format!("t,{name},x\n{rows}");
        let message = bench(&format!("name = \"{name}\"{stated}")).refusal(&text);
        let but = format!("but {unit}");
        assert_says(&message, &[&format!("line 1, column `{name}`"), "unit is psi by its name", &but, "\"psi\""]);
        assert_says(&message, &["name = \"column 2\""]);
        // Right, by its number, and with a scale that makes the one of the other.
        for right in ["unit = \"psi\"", "unit = \"bar\", scale = 0.0689476"] {
            assert!(bench(&format!("name = \"{name}\", {right}")).read(&text).is_ok(), "{name}: {right}");
        }
        assert!(bench("name = \"column 2\", unit = \"bar\"").read(&text).is_ok());
    }
    // What the rig file states counts more than the end of a name.
    assert!(bench("name = \"p_psi\", unit = \"bar\"").read(format!("t,p_psi,x\n{rows}")).is_ok());
    // No unit, whatever it looks like.
    assert!(bench("name = \"p_atm\", unit = \"bar\"").read(format!("t,p_atm,x\n{rows}")).is_ok());
}

#[test]
fn volts_that_are_declared_as_a_pressure_without_a_scale_are_refused() {
    let text = "Time,Ch 1,Ch 2\n(s),(V),(V)\n\n0,1,0.1\n1,1,0.1\n2,1,0.1\n";
    let bench = |pressure: &str| {
        let position = "position = { name = \"Ch 2\", unit = \"V\", scale = 0.1 }";
        Bench::with_rig(&format!(
            "[columns]\ntime = {{ name = \"Time\" }}\npressure = {{ name = \"Ch 1\", {pressure} }}\n{position}\n"
        ))
    };
    let message = bench("unit = \"bar\"").refusal(text);
    assert_says(
        &message,
        &["line 2, column `Ch 1`: these are volts", "but bar", "unit = \"V\" and scale, how many Pa"],
    );
    for right in ["unit = \"V\", scale = 1e5", "unit = \"bar\", scale = 1.0"] {
        assert_eq!(bench(right).read(text).unwrap().pressure_pa.unwrap(), [1e5; 3]);
    }
}

#[test]
fn a_gauge_unit_in_a_file_that_the_rig_declares_absolute_is_refused_and_the_reverse() {
    let read = |unit: &str, reference: &str| {
        let columns = format!("pressure = {{ name = \"p ({unit})\", unit = \"bar\"{reference} }}\n");
        let text = format!("time_s,p ({unit}),position_m\n0,1,0.1\n1,1,0.1\n2,1,0.1\n");
        Bench::with_rig(&format!("[columns]\n{columns}")).read(text).map_err(|error| error.to_string())
    };
    for (unit, right, wrong) in [("barg", "gauge", ""), ("bara", "absolute", ", reference = \"gauge\"")] {
        let message = read(unit, wrong).unwrap_err();
        assert_says(&message, &["line 1", &format!("the pressure is {right} here (`{unit}`)"), "write reference"]);
        assert!(read(unit, &format!(", reference = \"{right}\"")).is_ok());
    }
    // The offset may be that of the surroundings.
    assert!(read("barg", ", offset = 1.013").is_ok());
}
