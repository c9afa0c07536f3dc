//! Awkward files become rigs without user input: the proposed rig reads the record that was written.

use records::layout::Quantity;
use records::look::columns::Names;
use records::look::proposal::{UserInput, rig_file};
use records::look::{Look, motion};
use records::{Layout, Need, Reading, Rig, Trace, Window};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn example() -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/cylinder/compress-ambient-1.csv");
    let layout = Layout::default();
    let reading = Reading { layout: &layout, stroke_m: None, window: Window::ALL, need: Need::Measurement };
    Trace::read(&path, &reading).unwrap()
}

/// Writes the example's rows, each formatted by `row`, under a header.
fn table(header: &str, row: impl Fn(f64, f64, f64) -> String) -> String {
    let trace = example();
    let pressure = trace.pressure_pa.as_deref().unwrap();
    let rows = (0..trace.len()).map(|i| row(trace.time_s[i], pressure[i], trace.position_m[i]) + "\n");
    std::iter::once(header.to_owned() + "\n").chain(rows).collect()
}

/// Writes the file, examines it, writes its rig beside it, and reads the rig's trace.
fn looked_at(name: &str, bytes: &[u8]) -> (TempDir, PathBuf, Look, Trace) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let look = Look::at(&path, &Names::default()).unwrap();
    let stated = UserInput { bore_m: Some(0.032), trace: name.to_owned(), name: "test".to_owned(), cycles: None };
    std::fs::write(folder.path().join("rig.toml"), rig_file(&look, &stated)).unwrap();
    let mut rig = Rig::read(folder.path()).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert_eq!(rig.cylinder.bore_m, 0.032);
    let trace = rig.experiments.remove(0).traces.remove(0);
    (folder, path, look, trace)
}

/// Asserts that the record is the example's, with times from the first row, to within the format's rounding.
#[track_caller]
fn assert_is_the_example(name: &str, bytes: &[u8]) -> Trace {
    let (_folder, _, _, trace) = looked_at(name, bytes);
    let expected = example();
    assert_eq!(trace.len(), expected.len(), "{name}");
    let pressure = trace.pressure_pa.as_deref().unwrap();
    for (i, pressure) in pressure.iter().enumerate() {
        let time = trace.time_s[i] - trace.time_s[0];
        assert!((time - expected.time_s[i]).abs() < 2e-6, "{name}: row {i}: {time} s");
        assert!((pressure - expected.pressure_pa.as_deref().unwrap()[i]).abs() < 1.0, "{name}: row {i}");
        assert!((trace.position_m[i] - expected.position_m[i]).abs() < 1e-6, "{name}: row {i}");
    }
    trace
}

fn comma(number: impl std::fmt::Display) -> String {
    number.to_string().replace('.', ",")
}

#[test]
fn decimal_commas_between_semicolons() {
    let text = table("Zeit [s];Druck [bar];Weg [mm]", |t, p, x| {
        [format!("{t:.3}"), format!("{:.6}", p / 1e5), format!("{:.4}", x * 1e3)].map(comma).join(";")
    });
    assert_is_the_example("german.csv", text.as_bytes());
}

#[test]
fn days_as_excel_counts_them() {
    let row = |t: f64, p: f64, x: f64| format!("{:.12};{:.6};{:.4}", 45_000.375 + t / 86_400.0, p / 1e5, x * 1e3);
    let (_folder, path, look, trace) = looked_at("excel.csv", table("Time;p [bar];x [mm]", row).as_bytes());
    let time = look.guess.of(Quantity::Time).unwrap();
    assert_eq!((time.unit.name, time.unit_guessed), ("d", true));
    let (expected, last) = (example(), trace.len() - 1);
    assert!((trace.time_s[last] - trace.time_s[0] - expected.time_s[last]).abs() < 2e-6);
    // Read as seconds they are refused.
    let mut layout = look.guess.layout();
    layout.columns[Quantity::Time as usize].unit = "s";
    layout.columns[Quantity::Time as usize].factor = 1.0;
    let reading = Reading { layout: &layout, stroke_m: None, window: Window::ALL, need: Need::Measurement };
    let message = Trace::read(&path, &reading).unwrap_err().to_string();
    assert!(message.contains("column `Time`: times from 45000.375 to 45000.375"), "{message}");
    assert!(message.ends_with("write unit = \"d\" for time in the [columns] of the rig file"), "{message}");
}

#[test]
fn a_header_without_rows_is_refused() {
    let folder = TempDir::new().unwrap();
    for (name, text) in [("header.csv", "time_s,pressure_pa,position_m\n"), ("units.csv", "t;p;x\ns;bar;mm\n")] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let message = Look::at(&path, &Names::default()).unwrap_err().to_string();
        assert!(
            message.contains(name) && message.contains("there is no row of numbers after the header in line 1"),
            "{message}"
        );
    }
}

#[test]
fn numbers_in_quotes_with_decimal_commas_are_read_and_the_rig_file_says_so() {
    let text = table("\"Zeit (s)\",\"Druck (bar)\",\"Weg (mm)\"", |t, p, x| {
        [format!("{t:.3}"), format!("{:.6}", p / 1e5), format!("{:.4}", x * 1e3)]
            .map(|number| format!("\"{}\"", comma(number)))
            .join(",")
    });
    assert_is_the_example("quoted.csv", text.as_bytes());
}

#[test]
fn a_refusal_says_that_there_is_no_rig_file_yet() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, table("time_s,p (bar abs),position_m", |t, p, x| format!("{t},{},{x}", p * 1e-5 - 1.1)))
        .unwrap();
    let message = Look::at(&path, &Names::default()).unwrap_err().to_string();
    assert!(message.contains("cannot be an absolute pressure"), "{message}");
    assert!(message.ends_with("there is no rig file yet: write one by hand that states how to read it)"), "{message}");
    let names = Names { pressure: Some("p (bar ab)".to_owned()), ..Names::default() };
    let message = Look::at(&path, &names).unwrap_err().to_string();
    assert!(message.contains("did you mean `p (bar abs)`?") && !message.contains("rig"), "{message}");
}

#[cfg(unix)]
#[test]
fn what_can_be_read_only_once_is_looked_at_like_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let text = table("time_s,pressure_pa,position_m", |t, p, x| format!("{t},{p},{x}"));
    let file = folder.path().join("run.csv");
    std::fs::write(&file, &text).unwrap();
    let writer = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::write(pipe, text).unwrap()
    });
    let [once, again] = [&pipe, &file].map(|path| Look::at(path, &Names::default()).unwrap().found.unwrap().trace);
    writer.join().unwrap();
    assert_eq!((once.time_s, once.sha256), (again.time_s, again.sha256));
}

#[test]
fn a_workbook_is_refused_with_what_to_do() {
    let folder = TempDir::new().unwrap();
    let begins: [(&str, &[u8]); 2] =
        [("run.xlsx", b"PK\x03\x04\x14\0"), ("run.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")];
    for (name, bytes) in begins {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let message = Look::at(&path, &Names::default()).unwrap_err().to_string();
        assert!(
            message.contains(name) && message.ends_with("in the spreadsheet program, save the sheet as CSV"),
            "{message}"
        );
    }
}

#[test]
fn comments_and_a_line_of_units() {
    let head = "# Logger 7, run of 22 November\n# by hand\nt\tp\tx\ns\tkPa\tcm";
    let text = table(head, |t, p, x| format!("{t}\t{:.4}\t{:.5}", p / 1e3, x * 100.0));
    assert_is_the_example("units.txt", text.as_bytes());
}

#[test]
fn a_labview_measurement() {
    let head = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\n\
                Multi_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\n***End_of_Header***\t\n\t\n\
                Channels\t2\t\t\nSamples\t519\t519\t\nY_Unit_Label\tbar\tmm\t\nX_Dimension\tTime\tTime\t\n\
                X0\t0,0E+0\t0,0E+0\t\nDelta_X\t0,01\t0,01\t\n***End_of_Header***\t\t\t\n\
                X_Value\tPressure\tPosition\tComment";
    let text = table(head, |t, p, x| {
        [format!("{t:.6}"), format!("{:.7}", p / 1e5), format!("{:.5}", x * 1e3)].map(comma).join("\t")
    });
    assert_is_the_example("run.lvm", text.as_bytes());
}

#[test]
fn clock_times_over_midnight() {
    let clock = |t: f64| {
        let s = (86_398.5 + t) % 86_400.0;
        format!("{:02}:{:02}:{:06.3}", (s / 3600.0) as u32, (s / 60.0) as u32 % 60, s % 60.0)
    };
    let text = table("Time,Chamber pressure (psia),Position (in)", |t, p, x| {
        format!("{},{:.6},{:.6}", clock(t), p / 6894.757293168361, x / 0.0254)
    });
    assert_is_the_example("clock.csv", text.as_bytes());
}

#[test]
fn dates_and_a_zone_with_a_gauge_pressure() {
    let text = table("Timestamp,P_A [bar(g)],stroke_cm", |t, p, x| {
        format!("2026-11-22T07:59:{:06.3}+01:00,{:.6},{:.5}", 50.0 + t, (p - 101_325.0) / 1e5, x * 100.0)
    });
    assert_is_the_example("iso.csv", text.as_bytes());
}

#[test]
fn latin_1_and_utf_16_as_windows_exports_them() {
    let head = "Prüfstand;;\nZeit (ms);Druck (hPa);Kolbenweg (µm)";
    let text = table(head, |t, p, x| format!("{:.0};{:.3};{:.1}", t * 1e3, p / 100.0, x * 1e6).replace('.', ","));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    assert_is_the_example("latin.csv", &latin);
    let wide: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_is_the_example("wide.csv", &[b"\xff\xfe", &wide[..]].concat());
}

#[test]
fn thousands_set_apart_and_the_line_ends_of_an_old_macintosh() {
    let apart = |pa: f64| {
        let text = format!("{pa:.1}");
        let (whole, decimals) = text.split_once('.').unwrap();
        let (thousands, rest) = whole.split_at(whole.len() - 3);
        format!("{thousands}.{rest},{decimals}")
    };
    let text = table("time_s;pressure_pa;position_m", |t, p, x| {
        [comma(format!("{t:.3}")), apart(p), comma(format!("{x:.6}"))].join(";")
    });
    assert_is_the_example("thousands.csv", text.as_bytes());
    assert_is_the_example("quoted.csv", text.replace('.', "'").replace(',', ".").as_bytes());
    assert_is_the_example("macintosh.csv", text.replace('\n', "\r").as_bytes());
}

#[test]
fn blanks_under_a_commented_header_with_empty_cells_and_repeated_times() {
    let mut text =
        table("% time_s  pressure_kPa  position_mm", |t, p, x| format!("  {t:8.3}   {:.4}  {:.3}", p / 1e3, x * 1e3));
    assert_is_the_example("blanks.dat", text.as_bytes());
    let last = text.lines().last().unwrap().to_owned();
    text += &format!("{last}\n    5.190   -  100.0\n");
    let trace = assert_is_the_example("blanks.dat", text.as_bytes());
    assert_eq!(trace.dropped_rows.len(), 2);
}

#[test]
fn unsorted_rows() {
    let text = table("time_s,pressure_pa,position_m", |t, p, x| format!("{t},{p},{x}"));
    let mut rows: Vec<&str> = text.lines().collect();
    rows[1..].reverse();
    assert!(assert_is_the_example("reversed.csv", (rows.join("\n") + "\n").as_bytes()).sorted);
}

#[test]
fn positions_from_the_other_end_and_below_zero_are_converted_and_reported() {
    let text = table("t (s),p (bar),x (mm)", |t, p, x| format!("{t},{:.6},{:.4}", p / 1e5, 200.0 - x * 1e3));
    let (_folder, _, look, trace) = looked_at("turned.csv", text.as_bytes());
    assert_eq!(look.guess.of(Quantity::Position).unwrap().sign, -1.0);
    let rig = rig_file(&look, &UserInput::default());
    let check =
        "CHECK: offset_m is guessed from where the piston moved in this record; replace it by what the sensor shows";
    assert!(rig.lines().any(|line| line.starts_with("position = ") && line.contains(check)), "{rig}");
    let expected = example();
    let shift = trace.position_m[0] - expected.position_m[0];
    assert!(trace.position_m.iter().zip(&expected.position_m).all(|(a, b)| (a - b - shift).abs() < 1e-6));
    let below = table("t (s),p (bar),x (mm)", |t, p, x| format!("{t},{:.6},{:.4}", p / 1e5, x * 1e3 - 500.0));
    let (_folder, _, _, trace) = looked_at("below.csv", below.as_bytes());
    assert!(trace.position_m.iter().all(|x| *x >= -1e-9));
}

#[test]
fn a_pressure_of_unknown_reference_is_marked_and_a_stated_one_is_not() {
    for (header, marked) in
        [("p [bar]", true), ("p [bar(g)]", false), ("p [bara]", false), ("p_abs [bar]", false), ("pressure_pa", false)]
    {
        let offset = if header.contains("(g)") { 101_325.0 } else { 0.0 };
        let unit = if header == "pressure_pa" { 1.0 } else { 1e-5 };
        let text = table(&format!("time_s,{header},position_m"), |t, p, x| format!("{t},{},{x}", (p - offset) * unit));
        let (_folder, _, look, _) = looked_at("p.csv", text.as_bytes());
        let rig = rig_file(&look, &UserInput::default());
        assert_eq!(rig.contains("CHECK: absolute or gauge?"), marked, "{header}: {rig}");
    }
}

#[test]
fn readings_far_off_tell_neither_where_pressures_count_from_nor_their_unit() {
    for marker in ["0", "-0.02", "-9999", "9.9E37", "1e9"] {
        for name in ["p", "pressure_pa", "p (bar abs)", "p_abs", "Absolutdruck"] {
            let unit = if name == "pressure_pa" { 1e5 } else { 1.0 };
            let row = |t: f64, p: f64, x: f64| match (t - 1.0).abs() < 1e-6 {
                true => format!("{t},{marker},{x}"),
                false => format!("{t},{},{x}", p * 1e-5 * unit),
            };
            let text = table(&format!("time_s,{name},position_m"), row);
            let (_folder, _, look, trace) = looked_at("marker.csv", text.as_bytes());
            let pressure = look.guess.of(Quantity::Pressure).unwrap();
            assert!(!pressure.gauge, "{marker} in {name}");
            assert_eq!(pressure.unit.factor * unit, 1e5, "{marker} in {name}");
            assert!(marker == "1e9" || trace.dropped_rows.len() == 1, "{marker} in {name}");
        }
    }
}

#[test]
fn a_unit_in_the_name_is_read_in_every_spelling_and_an_unknown_one_is_reported() {
    for (header, unit, factor) in [
        ("Pressure mbar(a)", "mbar", 100.0),
        ("Druck mbar abs", "mbar", 100.0),
        ("p (inHg)", "inHg", 3386.3886),
        ("p [mH2O]", "mH2O", 9806.65),
        ("p (cmH2O abs)", "cmH2O", 98.0665),
        ("p (bar) abs", "bar", 1e5),
    ] {
        let text = table(&format!("time_s,{header},position_m"), |t, p, x| format!("{t},{},{x}", p / factor));
        let (_folder, _, look, trace) = looked_at("p.csv", text.as_bytes());
        let pressure = look.guess.of(Quantity::Pressure).unwrap();
        assert_eq!((pressure.unit.name, pressure.unit_guessed, pressure.gauge), (unit, false, false), "{header}");
        assert!((trace.pressure_pa.unwrap()[0] / example().pressure_pa.unwrap()[0] - 1.0).abs() < 1e-5, "{header}");
    }
    let text = table("time_s,Pressure (dyn/mm2),position_m", |t, p, x| format!("{t},{},{x}", p * 1e-5));
    let (_folder, _, look, _) = looked_at("p.csv", text.as_bytes());
    let rig = rig_file(&look, &UserInput::default());
    assert!(rig.contains("CHECK the unit: `dyn/mm2` is not a known unit; guessed from the values"), "{rig}");
}

#[test]
fn readings_around_zero_are_gauge_and_marked_unless_the_name_says_so() {
    for (name, remark) in [
        ("p", Some("CHECK: taken as gauge, since many readings are at or below zero")),
        ("pressure_pa", Some("although the name is that of absolute pressures")),
        ("p gauge", None),
    ] {
        let unit = if name == "pressure_pa" { 1.0 } else { 1e-5 };
        let row = |t: f64, p: f64, x: f64| format!("{t},{},{x}", (p - 102_000.0) * unit);
        let (_folder, _, look, _) = looked_at("p.csv", table(&format!("time_s,{name},position_m"), row).as_bytes());
        assert!(look.guess.of(Quantity::Pressure).unwrap().gauge, "{name}");
        let rig = rig_file(&look, &UserInput::default());
        let line = rig.lines().find(|line| line.starts_with("pressure = ")).unwrap();
        match remark {
            Some(remark) => assert!(line.contains(remark), "{line}"),
            None => assert!(!line.contains("gauge, since"), "{line}"),
        }
    }
}

#[test]
fn a_voltage_is_left_to_the_user() {
    let text = table("t (s);U1 pressure [V];U2 position [V]", |t, p, x| format!("{t};{:.6};{:.6}", p / 1e5, x * 10.0));
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("volts.csv");
    std::fs::write(&path, text).unwrap();
    let look = Look::at(&path, &Names::default());
    let rig = rig_file(
        &look.unwrap(),
        &UserInput { trace: "volts.csv".to_owned(), name: "t".to_owned(), ..UserInput::default() },
    );
    assert!(rig.contains("FILL IN scale") && !rig.contains("scale = 1"), "{rig}");
    assert!(rig.contains("# bore_m = ") && rig.contains("FILL IN: the bore"), "{rig}");
}

#[test]
fn a_position_in_percent_is_asked_for_its_range() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("percent.csv");
    for name in ["position_%", "Position [%]", "Hub in %"] {
        std::fs::write(&path, table(&format!("time_s,pressure_pa,{name}"), |t, p, x| format!("{t},{p},{}", 500.0 * x)))
            .unwrap();
        let look = Look::at(&path, &Names::default()).unwrap();
        let rig = rig_file(&look, &UserInput { trace: "percent.csv".to_owned(), ..UserInput::default() });
        assert!(rig.contains("unit = \"%\" }  # FILL IN unit"), "{rig}");
    }
}

#[test]
fn what_cannot_be_inferred_is_asked_for_and_a_named_column_is_used() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("abc.csv");
    std::fs::write(&path, table("a,b,c", |t, p, x| format!("{t},{p},{x}"))).unwrap();
    let look = Look::at(&path, &Names::default()).unwrap();
    assert_eq!(look.guess.missing(), [Quantity::Time, Quantity::Pressure, Quantity::Position]);
    let rig = rig_file(&look, &UserInput::default());
    assert!(rig.contains("# pressure = { name = \"...\", unit = \"Pa\" }  # FILL IN"), "{rig}");
    let name = |name: &str| Some(name.to_owned());
    let names = Names { time: name("a"), pressure: name("b"), position: name("column 3") };
    let look = Look::at(&path, &names).unwrap();
    let found = look.found.unwrap();
    assert_eq!(found.trace.len(), 518);
    assert!((found.readings.rate_hz() - 100.0).abs() < 1e-6);
    assert_eq!(found.phases.iter().filter(|phase| phase.moving).count(), 1);
    let message = Look::at(&path, &Names { pressure: name("p"), ..Names::default() }).unwrap_err().to_string();
    assert!(message.contains("abc.csv: line 1: there is no column `p`"), "{message}");
}

#[test]
fn cycles_in_one_file_become_experiments() {
    let (trace, mut text) = (example(), "time_s,pressure_pa,position_m\n".to_owned());
    let (rows, pressure) = (trace.len(), trace.pressure_pa.as_deref().unwrap());
    for k in 0..3 {
        let start = 7.0 * f64::from(k);
        for (i, pressure) in pressure.iter().enumerate() {
            text += &format!("{:.3},{pressure},{}\n", start + trace.time_s[i], trace.position_m[i]);
        }
        // The port opens and the piston returns slowly.
        for i in 0..150 {
            let share = (f64::from(i) / 100.0).min(1.0);
            let position = trace.position_m[rows - 1] + share * (trace.position_m[0] - trace.position_m[rows - 1]);
            text += &format!("{:.3},{},{position}\n", start + 5.2 + f64::from(i) * 0.01, pressure[0]);
        }
    }
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("cycles.csv");
    std::fs::write(&path, text).unwrap();
    let look = Look::at(&path, &Names::default()).unwrap();
    let found = look.found.as_ref().unwrap();
    let pressure = found.trace.pressure_pa.as_deref().unwrap();
    let (cycles, open) =
        motion::cycles([&found.trace.time_s, pressure, &found.trace.position_m], &found.readings, &found.phases);
    assert_eq!((cycles.len(), open), (3, 3), "{cycles:?}");
    let stated = UserInput {
        bore_m: Some(0.032),
        trace: "cycles.csv".to_owned(),
        name: "cycle".to_owned(),
        cycles: Some(cycles),
    };
    std::fs::write(folder.path().join("rig.toml"), rig_file(&look, &stated)).unwrap();
    let rig = Rig::read(folder.path()).unwrap();
    assert_eq!(rig.experiments.len(), 3);
    for (k, experiment) in rig.experiments.iter().enumerate() {
        let trace = &experiment.traces[0];
        let (first, last) = (trace.time_s[0] - 7.0 * k as f64, trace.time_s[trace.len() - 1] - 7.0 * k as f64);
        assert!(first >= 0.0 && last < 5.2 && last > 4.5, "{first} {last}");
        assert!((10..trace.len()).contains(&trace.rows_at_rest()), "{}", trace.rows_at_rest());
    }
}
