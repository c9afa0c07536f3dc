//! `pneutherm simulate`: its table, initial state, and mapping of columns.

use crate::common::{Bench, MODEL, motion, text};

const CALL: [&str; 4] = ["simulate", "model.toml", "--motion", "motion.csv"];

/// The table's columns, by rows.
fn rows(table: &[u8]) -> Vec<Vec<f64>> {
    let table = text(table);
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("time_s,pressure_pa,gas_pressure_pa,temperature_k,mass_kg,volume_m3,heat_flow_w"));
    lines.map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}

#[test]
fn each_row_of_the_motion_has_its_row_and_the_gas_obeys_its_law() {
    let rows = rows(&Bench::new().call(0, &CALL).stdout);
    assert_eq!(rows.len(), 200);
    assert_eq!(rows[0][0], 0.0);
    for (found, start) in rows[0][1..4].iter().zip([101300.0, 101300.0, 296.0]) {
        assert!((found / start - 1.0).abs() < 1e-14, "{found} {start}");
    }
    for row in &rows {
        let &[_, shown, pressure, temperature, mass, volume, heat_flow] = &row[..] else { panic!("seven columns") };
        assert_eq!(shown, pressure, "a leak is not the sensor's");
        assert!((pressure * volume / (mass * 287.0 * temperature) - 1.0).abs() < 1e-12);
        assert!(heat_flow <= 0.0 || temperature <= 296.0, "heat flows from hot to cold");
    }
    assert!(rows[199][4] < rows[20][4], "the compressed gas leaks out");
    let first_volume = std::f64::consts::PI / 4.0 * 4e-4 * 0.1 + 1.6e-6;
    assert!((rows[0][5] / first_volume - 1.0).abs() < 1e-14);
}

#[test]
fn a_file_holds_what_standard_output_shows() {
    let bench = Bench::new();
    let shown = bench.call(0, &CALL).stdout;
    assert_eq!(bench.call(0, &[&CALL[..], &["-o", "out.csv"]].concat()).stdout, b"");
    assert_eq!(std::fs::read(bench.path("out.csv")).unwrap(), shown);
    assert_eq!(bench.call(0, &[&CALL[..], &["-o", "-"]].concat()).stdout, shown);
}

#[test]
fn small_numbers_have_an_exponent_and_large_ones_none() {
    let bench = Bench::new();
    let table = text(&bench.call(0, &[&CALL[..], &["--initial-pressure", "2e5"]].concat()).stdout);
    let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    assert!(row[1] == "200000" || row[1].starts_with("199999.99") || row[1].starts_with("200000.0000"), "{row:?}");
    assert!(row[5].starts_with("3.3") && row[5].ends_with("e-5"), "{row:?}");
}

#[test]
fn bar_in_place_of_pascal_is_noticed() {
    let output = Bench::new().call(2, &[&CALL[..], &["--initial-pressure", "6"]].concat());
    assert!(text(&output.stderr).contains("in Pa, absolute (1 bar is 1e5)"), "{}", text(&output.stderr));
}

/// The motion with alternately 1 kPa above and below 201.3 kPa while at rest, and nonsense once the piston has moved.
fn shaky_motion() -> String {
    let mut lines: Vec<String> = motion().lines().map(str::to_owned).collect();
    for (k, line) in lines.iter_mut().enumerate().skip(1) {
        let pressure = if k > 21 { 9e5 } else { 201300.0 + if k % 2 == 0 { 1e3 } else { -1e3 } };
        *line = line.replace("101300.0", &pressure.to_string());
    }
    lines.join("\n")
}

#[test]
fn the_start_is_the_mean_before_the_first_movement_or_what_is_asked_for() {
    let bench = Bench::new();
    bench.file("model.toml", MODEL.replace("1e-12", "0"));
    bench.file("motion.csv", shaky_motion());
    let start = rows(&bench.call(0, &CALL).stdout)[0][1];
    assert!((start - 201300.0).abs() < 60.0, "{start}");
    let asked = rows(&bench.call(0, &[&CALL[..], &["--initial-pressure", "6e5"]].concat()).stdout);
    assert!((asked[0][1] / 6e5 - 1.0).abs() < 1e-15, "{}", asked[0][1]);
}

#[test]
fn a_leak_before_the_first_movement_is_allowed_for_in_the_start() {
    let bench = Bench::new();
    bench.file("model.toml", MODEL.replace("1e-12", "1e-10"));
    bench.file("motion.csv", shaky_motion());
    let rows = rows(&bench.call(0, &CALL).stdout);
    assert!(rows[0][1] > 206_000.0, "a strong leak: {} Pa", rows[0][1]);
    let mean = rows[..20].iter().map(|row| row[1]).sum::<f64>() / 20.0;
    assert!((mean - 201_300.0).abs() < 60.0, "{mean}");
}

#[test]
fn a_plan_without_pressure_needs_the_start() {
    let bench = Bench::new();
    bench.file("motion.csv", "time_s,position_m\n0,0.1\n0.1,0.1\n0.2,0.05\n1,0.05\n");
    assert!(bench.refusal(&CALL).contains("motion.csv: no pressure column to take the initial pressure from"));
    assert_eq!(rows(&bench.call(0, &[&CALL[..], &["--initial-pressure", "2e5"]].concat()).stdout).len(), 4);
}

#[test]
fn a_rig_maps_the_motion_s_columns() {
    let bench = Bench::new();
    let plain = bench.call(0, &CALL).stdout;
    let mapped = motion().replace("time_s,pressure_pa,position_m", "#t p x").replace(',', " ");
    bench.file("motion.csv", mapped);
    bench.file(
        "rig.toml",
        "[cylinder]\nbore_m = 0.02\n[columns]\ntime = { name = \"t\" }\npressure = { name = \"p\" }\n\
         position = { name = \"x\" }\n[format]\nseparator = \"whitespace\"\n",
    );
    assert!(bench.refusal(&CALL).contains("`time_s`"));
    assert_eq!(bench.call(0, &[&CALL[..], &["--rig", "rig.toml"]].concat()).stdout, plain);
    assert_eq!(bench.call(0, &[&CALL[..], &["--rig", "."]].concat()).stdout, plain, "a folder means its rig.toml");
}

#[test]
fn a_mass_flow_and_an_ambient_temperature_of_the_motion_count() {
    let bench = Bench::new();
    bench.file("model.toml", "[chamber]\nbore_m = 0.02\n[heat_transfer]\ncoefficient_w_per_m2_k = 26.5\n");
    bench.file(
        "motion.csv",
        "time_s,pressure_pa,position_m,mass_flow_kg_per_s,ambient_temperature_k\n\
         0,1e5,0.1,1e-6,300\n1,1e5,0.1,1e-6,300\n3,1e5,0.1,1e-6,300\n",
    );
    let rows = rows(&bench.call(0, &CALL).stdout);
    assert!((rows[0][3] / 300.0 - 1.0).abs() < 1e-14 && (rows[0][1] / 1e5 - 1.0).abs() < 1e-14);
    assert!((rows[2][4] - rows[0][4] - 3e-6).abs() < 1e-15, "mass closes to rounding");
}

#[test]
fn a_motion_into_the_chamber_s_end_is_refused() {
    let bench = Bench::new();
    bench.file("model.toml", "[chamber]\nbore_m = 0.02\n[heat_transfer]\ncoefficient_w_per_m2_k = 26.5\n");
    bench.file("motion.csv", motion().replace("0.05\n", "0.0\n"));
    assert!(bench.refusal(&CALL).contains("motion.csv: at 0.24 s the position 0 m leaves no gas"));
}

#[test]
fn pressures_that_no_chamber_has_are_refused_as_identify_refuses_them_unless_they_are_not_used() {
    let bench = Bench::new();
    bench.file("motion.csv", motion().replace("101300.0", "1.013"));
    let refusal = bench.refusal(&CALL);
    assert!(refusal.contains("no pneumatic chamber has; check the unit of the pressure column"), "{refusal}");
    assert!(refusal.contains("bar"), "{refusal}");
    bench.call(0, &[&CALL[..], &["--initial-pressure", "2e5"]].concat());
}

#[test]
fn a_motion_of_few_rows_begins_at_its_first_reading() {
    let bench = Bench::new();
    bench.file("motion.csv", "time_s,position_m,pressure_pa\n0,0.1,1e5\n1,0.08,1.1e5\n2,0.05,1.2e5\n");
    let start = rows(&bench.call(0, &CALL).stdout)[0][1];
    assert!((start / 1e5 - 1.0).abs() < 1e-9, "{start}");
}

#[test]
fn a_reading_far_off_before_the_movement_is_left_out_of_the_start_and_named() {
    let bench = Bench::new();
    let plain = rows(&bench.call(0, &CALL).stdout)[0][1];
    bench.file("motion.csv", motion().replacen("101300.0", "301300.0", 1));
    let output = bench.call(0, &CALL);
    assert!((rows(&output.stdout)[0][1] / plain - 1.0).abs() < 1e-9);
    let says = "motion.csv: one reading far off is left out (line 2, 0.000 s after the first row)";
    assert!(text(&output.stderr).contains(says), "{}", text(&output.stderr));
}

#[test]
fn a_misspelt_pressure_column_is_named() {
    let bench = Bench::new();
    bench.file("motion.csv", motion().replace("pressure_pa", "presure_pa"));
    let refusal = bench.refusal(&CALL);
    assert!(refusal.contains("(it has `presure_pa`: did you mean `pressure_pa`?)"), "{refusal}");
}

#[test]
fn standard_input_is_not_read_under_the_name_of_standard_output() {
    let refusal = Bench::new().refusal(&["simulate", "model.toml", "--motion", "-"]);
    assert!(refusal.contains("-: standard input is not read under this name"), "{refusal}");
}
