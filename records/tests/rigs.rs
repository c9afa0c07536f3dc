//! Rig files: contents, defaults, and refusals with file, line and key.

use records::{Document, Rig, RigFile, Tolerance};
use std::f64::consts::PI;
use std::path::Path;

const CASE_01: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/case01");

fn parse(text: &str) -> Result<RigFile, records::Error> {
    RigFile::from_document(&Document::parse(Path::new("lab/rig.toml"), text.to_owned())?)
}

#[track_caller]
fn refusal(text: &str, parts: &[&str]) {
    let message = parse(text).expect_err("should be refused").to_string();
    assert!(message.starts_with("lab/rig.toml: line ") && !message.contains('\n'), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn a_rig_is_read_with_its_experiments_from_file_or_folder() {
    let rig = Rig::read(Path::new(CASE_01)).unwrap();
    assert_eq!(rig.path, Path::new(CASE_01).join("rig.toml"));
    assert_eq!(rig, Rig::read(&Path::new(CASE_01).join("rig.toml")).unwrap());
    assert_eq!((rig.cylinder.bore_m, rig.cylinder.rod_through_m, rig.cylinder.stroke_m), (0.02, 0.0, None));
    assert!((rig.cylinder.piston_area_m2 / (PI * 1e-4) - 1.0).abs() < 1e-15);
    assert_eq!((rig.ambient.temperature_k, rig.ambient.pressure_pa), (Some(297.2), 101300.0));
    assert_eq!(rig.sensor, records::Sensor { noise_pa: Some(150.0), step_pa: None, readout_hz: None });
    assert_eq!((rig.gas.name.as_deref(), rig.gas.gas), (Some("air"), chamber::Gas::AIR));
    assert_eq!(rig.dead_volume, None);
    let names: Vec<&str> = rig.experiments.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["compress-ambient", "compress-3bar", "expand-5bar", "expand-ambient", "compress-part"]);
    assert!(rig.experiments.iter().all(|e| e.traces.len() == 3 && e.traces.iter().all(|t| t.len() == 119)));
    let first = &rig.experiments[1].traces[0];
    assert_eq!((first.time_s[1], first.position_m[0]), (0.01, 0.099999));
    assert_eq!(first.pressure_pa.as_ref().unwrap()[..2], [320083.6, 319656.4]);
    assert_eq!(first.ambient_temperature_k.as_ref().unwrap()[0], 297.2);
}

#[test]
fn a_problem_of_a_trace_is_reported_with_the_trace_s_name() {
    let folder = tempfile::tempdir().unwrap();
    let rig = "[cylinder]\nbore_m = 0.02\n[[experiment]]\nname = \"a\"\ntraces = [\"run 1.csv\"]\n";
    std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
    let message = Rig::read(folder.path()).unwrap_err().to_string();
    assert!(message.contains("run 1.csv: cannot be read"), "{message}");
}

#[test]
fn what_a_rig_leaves_out_is_stated() {
    let file = parse("[cylinder]\narea_m2 = 0.0127\nstroke_m = 2.03\n").unwrap();
    assert_eq!(file.rig.cylinder.bore_m, (4.0 * 0.0127 / PI).sqrt());
    assert_eq!((file.rig.cylinder.piston_area_m2, file.rig.cylinder.rod_through_m), (0.0127, 0.0));
    assert_eq!((file.rig.ambient.temperature_k, file.rig.ambient.pressure_pa), (None, 101325.0));
    assert_eq!(file.rig.gas.gas, chamber::Gas::AIR);
    assert_eq!(file.layout, records::Layout::default());
}

#[test]
fn the_rod_takes_its_area_on_its_own_side_only() {
    let cap = parse("[cylinder]\nbore_m = 0.05\nrod_m = 0.02\n").unwrap().rig.cylinder;
    let rod = parse("[cylinder]\nbore_m = 0.05\nrod_m = 0.02\nchamber = \"rod\"\n").unwrap().rig.cylinder;
    assert_eq!((cap.rod_through_m, rod.rod_through_m), (0.0, 0.02));
    assert!((cap.piston_area_m2 - PI / 4.0 * 0.05 * 0.05).abs() < 1e-18);
    assert!((rod.piston_area_m2 - PI / 4.0 * (0.05 * 0.05 - 0.02 * 0.02)).abs() < 1e-18);
}

#[test]
fn a_gas_is_a_name_or_its_constants() {
    let nitrogen = parse("[cylinder]\nbore_m = 0.02\n[gas]\nname = \"nitrogen\"\n").unwrap().rig.gas;
    assert_eq!(nitrogen.gas.gas_constant, 296.8);
    let own = "[cylinder]\nbore_m = 0.02\n[gas]\ngas_constant_j_per_kg_k = 290\nheat_capacity_ratio = 1.35\n";
    let own = parse(own).unwrap().rig.gas;
    assert_eq!((own.name, own.gas.gas_constant, own.gas.heat_capacity_ratio), (None, 290.0, 1.35));
}

#[test]
fn constants_beside_a_known_gas_s_name_are_its_own() {
    let gas = |lines: &str| format!("[cylinder]\nbore_m = 0.02\n[gas]\n{lines}\n");
    let helium = "name = \"helium\"\ngas_constant_j_per_kg_k";
    let what_to_do = "leave out the constants, or give the gas that has them another name";
    refusal(
        &gas(&format!("{helium} = 287.0\nheat_capacity_ratio = 1.4")),
        &["line 5: gas.gas_constant_j_per_kg_k: 287.0 is not helium's, which is 2077.1", what_to_do],
    );
    refusal(
        &gas(&format!("{helium} = 2077.1\nheat_capacity_ratio = 1.4")),
        &["line 6: gas.heat_capacity_ratio: 1.4 is not helium's, which is 1.667", what_to_do],
    );
    refusal(&gas("name = \"nitrogen\"\ngas_constant_j_per_kg_k = 287"), &["line 5", "nitrogen's, which is 296.8"]);
    // As rounded by other sources, and as written by the program.
    let argon = parse(&gas("name = \"argon\"\ngas_constant_j_per_kg_k = 208\nheat_capacity_ratio = 1.66")).unwrap();
    assert_eq!((argon.rig.gas.gas.gas_constant, argon.rig.gas.gas.heat_capacity_ratio), (208.0, 1.66));
    for (name, known) in chamber::Gas::NAMED {
        let chamber::Gas { gas_constant, heat_capacity_ratio } = known;
        let both = format!("gas_constant_j_per_kg_k = {gas_constant:?}\nheat_capacity_ratio = {heat_capacity_ratio:?}");
        assert_eq!(parse(&gas(&format!("name = \"{name}\"\n{both}"))).unwrap().rig.gas.gas, known, "{name}");
    }
    let own = parse(&gas("name = \"our mixture\"\ngas_constant_j_per_kg_k = 300\nheat_capacity_ratio = 1.3")).unwrap();
    assert_eq!((own.rig.gas.name.as_deref(), own.rig.gas.gas.gas_constant), (Some("our mixture"), 300.0));
}

#[test]
fn the_rod_side_needs_its_rod() {
    let cylinder = |lines: &str| format!("[cylinder]\nbore_m = 0.05\nchamber = \"rod\"\n{lines}");
    refusal(&cylinder(""), &["line 1: cylinder.rod_m: missing", "which the area of the rod side"]);
    refusal(&cylinder("rod_m = 0\n"), &["line 4: cylinder.rod_m: 0 m is no rod", "the area of the rod side"]);
    assert!(parse("[cylinder]\narea_m2 = 0.0016\nchamber = \"rod\"\n").is_ok());
    assert!(parse("[cylinder]\nbore_m = 0.05\nchamber = \"cap\"\n").is_ok());
}

#[test]
fn two_experiments_of_one_name_are_refused() {
    let experiment = |name: &str| format!("[[experiment]]\nname = \"{name}\"\ntraces = [\"{name}.csv\"]\n");
    let rig = |names: &[&str]| {
        let experiments: String = names.iter().map(|name| experiment(name)).collect();
        format!("[cylinder]\nbore_m = 0.02\n{experiments}")
    };
    refusal(
        &rig(&["push", "pull", "push"]),
        &["line 10: experiment.name: another experiment is named `push` already", "choose another name"],
    );
    assert_eq!(parse(&rig(&["push", "pull"])).unwrap().plan.len(), 2);
}

#[test]
fn sensor_accuracy_and_tolerances_are_read() {
    let text = "[cylinder]\nbore_m = 0.04\n[sensor]\nstep_pa = 390\nreadout_hz = 10\n[accuracy]\npressure_pa = 50\n\
                [tolerance]\nbore_m = 1e-5\nposition_scale = 0.001\nposition_linearity = 0\n\
                position_offset_m = 0\nambient_temperature_k = 0.3\nheat_capacity_ratio = 0.002\n";
    let rig = parse(text).unwrap().rig;
    assert_eq!(rig.sensor, records::Sensor { noise_pa: None, step_pa: Some(390.0), readout_hz: Some(10.0) });
    assert_eq!(rig.accuracy_pa, Some(50.0));
    let stated = Tolerance {
        bore_m: 1e-5,
        position_scale: 0.001,
        position_linearity: 0.0,
        position_offset_m: 0.0,
        ambient_temperature_k: 0.3,
        heat_capacity_ratio: 0.002,
    };
    assert_eq!(rig.tolerance, stated);
    refusal(
        "[cylinder]\nbore_m = 0.04\n[tolerance]\nbore_m = 0.04\n",
        &["line 4: tolerance.bore_m", "half of the bore"],
    );
    refusal(
        "[cylinder]\nbore_m = 0.04\n[tolerance]\nposition_scale = 5\n",
        &["line 4", "5.0 is out of range", "share"],
    );
    refusal("[cylinder]\nbore_m = 0.04\n[tolerance]\nbore = 1\n", &["line 4: tolerance.bore", "`bore_m`"]);
    refusal("[cylinder]\nbore_m = 0.04\n[accuracy]\npressure_pa = 0\n", &["line 4: accuracy.pressure_pa", "positive"]);
    refusal("[cylinder]\nbore_m = 0.04\n[sensor]\nstep_pa = -1\n", &["line 4: sensor.step_pa", "-1.0 is out of range"]);
}

#[test]
fn tolerances_that_a_rig_leaves_out_follow_from_the_rest() {
    let unstated = parse("[cylinder]\nbore_m = 0.04\n").unwrap().rig;
    let default = Tolerance {
        bore_m: 2e-4,
        position_scale: 0.005,
        position_linearity: 2e-4,
        position_offset_m: 0.5e-3,
        ambient_temperature_k: 5.0,
        heat_capacity_ratio: 5e-4,
    };
    assert_eq!((unstated.tolerance, unstated.accuracy_pa), (default, None));
    let stated = parse("[cylinder]\nbore_m = 0.04\n[ambient]\ntemperature_k = 293\n").unwrap().rig;
    assert_eq!(stated.tolerance, Tolerance { ambient_temperature_k: 2.0, ..default });
}

#[test]
fn a_recorded_ambient_temperature_is_known_as_well_as_a_stated_one() {
    let folder = tempfile::tempdir().unwrap();
    let rig = "[cylinder]\nbore_m = 0.04\n[[experiment]]\nname = \"a\"\ntraces = [\"a.csv\"]\n";
    std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
    let rows = "0,1e5,0.1,293\n1,1e5,0.1,293\n2,1e5,0.1,293\n";
    let header = "time_s,pressure_pa,position_m,ambient_temperature_k";
    std::fs::write(folder.path().join("a.csv"), format!("{header}\n{rows}")).unwrap();
    assert_eq!(Rig::read(folder.path()).unwrap().tolerance.ambient_temperature_k, 2.0);
    std::fs::write(folder.path().join("a.csv"), format!("{}\n{rows}", header.replace("ambient", "other"))).unwrap();
    assert_eq!(Rig::read(folder.path()).unwrap().tolerance.ambient_temperature_k, 5.0);
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    refusal("[cylinder]\nboer_m = 0.02\n", &["line 2: cylinder.boer_m: unknown key", "did you mean `bore_m`?"]);
    refusal("[cylinder]\nbore = 0.02\n", &["line 2: cylinder.bore: unknown key", "did you mean `bore_m`?"]);
    refusal("[cylinder]\nbore_m = 0.02\n\n[sensr]\n", &["line 4: sensr", "did you mean `sensor`?"]);
    refusal("[cylinder]\nbore_m = 0.02\n[[experiment]]\nname = \"a\"\ntrace = []\n", &["line 5", "`traces`"]);
    refusal(
        "[cylinder]\nbore_m = 0.02\n[columns]\npresure = { name = \"p\" }\n",
        &["line 4: columns.presure", "`pressure`"],
    );
    refusal(
        "[cylinder]\nbore_m = 0.02\n[columns]\ntime = { name = \"t\", sign = 1 }\n",
        &["line 4: columns.time.sign"],
    );
}

#[test]
fn values_of_the_wrong_type_are_named_with_what_was_expected() {
    refusal("[cylinder]\nbore_m = \"0.02\"\n", &["line 2: cylinder.bore_m", "the text \"0.02\"", "expected a number"]);
    refusal("[cylinder]\nbore_m = 0.02\ndead_volume_known = 1\n", &["line 3", "expected true or false"]);
    refusal("cylinder = 3\n", &["line 1: cylinder", "expected a table"]);
    refusal(
        "[cylinder]\nbore_m = 0.02\n[[experiment]]\nname = \"a\"\ntraces = \"a.csv\"\n",
        &["line 5", "a list of texts"],
    );
    refusal("[cylinder]\nbore_m = 0.02\n[experiment]\nname = \"a\"\n", &["line 3: experiment", "[[experiment]]"]);
}

#[test]
fn numbers_that_cannot_be_are_refused_with_their_bounds() {
    refusal("[cylinder]\nbore_m = -0.02\n", &["line 2: cylinder.bore_m: -0.02 is out of range", "in m"]);
    refusal("[cylinder]\nbore_m = 20\n", &["line 2: cylinder.bore_m: 20.0 is out of range", "in m"]);
    refusal("[cylinder]\nbore_m = nan\n", &["line 2: cylinder.bore_m: NaN is out of range"]);
    refusal("[cylinder]\nbore_m = 0.02\nrod_m = 0.02\n", &["line 3: cylinder.rod_m", "not less than the bore"]);
    refusal("[cylinder]\nbore_m = 0.02\ndead_volume_m3 = -1e-6\n", &["line 3: cylinder.dead_volume_m3"]);
    refusal("[cylinder]\nbore_m = 0.02\n[ambient]\ntemperature_k = 21\n", &["line 4: ambient.temperature_k", "kelvin"]);
    refusal(
        "[cylinder]\nbore_m = 0.02\n[ambient]\npressure_pa = 1.013\n",
        &["line 4: ambient.pressure_pa", "1 bar is 1e5"],
    );
    refusal("[cylinder]\nbore_m = 0.02\n[sensor]\nnoise_pa = -1\n", &["line 4: sensor.noise_pa"]);
    refusal(
        "[cylinder]\nbore_m = 0.02\n[columns]\nposition = { name = \"x\", sign = 2 }\n",
        &["position.sign", "1 or -1"],
    );
}

#[test]
fn words_that_are_not_known_are_refused_with_those_that_are() {
    refusal(
        "[cylinder]\nbore_m = 0.02\nchamber = \"rood\"\n",
        &["line 3: cylinder.chamber: unknown value `rood`", "did you mean `rod`?"],
    );
    refusal(
        "[cylinder]\nbore_m = 0.02\n[gas]\nname = \"nitrgen\"\n",
        &["line 4: gas.name", "did you mean `nitrogen`?"],
    );
    refusal(
        "[cylinder]\nbore_m = 0.02\n[gas]\nname = \"xy\"\n",
        &["line 4: gas.name", "expected one of: air, nitrogen"],
    );
    refusal(
        "[cylinder]\nbore_m = 0.02\n[columns]\npressure = { name = \"p\", unit = \"PSI\" }\n",
        &["columns.pressure.unit", "`psi`"],
    );
    let separators = "expected one of: tab, \";\", \",\", whitespace";
    refusal("[cylinder]\nbore_m = 0.02\n[format]\nseparator = \"|\"\n", &["line 4: format.separator", separators]);
}

#[test]
fn what_is_missing_is_named() {
    refusal("[gas]\nname = \"air\"\n", &["line 1: cylinder: missing", "[cylinder]"]);
    refusal("\n[cylinder]\nstroke_m = 1.0\n", &["line 2: cylinder.bore_m: missing", "area_m2"]);
    refusal("[cylinder]\nbore_m = 0.02\ndead_volume_known = true\n", &["cylinder.dead_volume_m3: missing"]);
    refusal(
        "[cylinder]\nbore_m = 0.02\n[gas]\nheat_capacity_ratio = 1.4\n",
        &["line 3: gas.gas_constant_j_per_kg_k: missing"],
    );
    refusal("[cylinder]\nbore_m = 0.02\n[[experiment]]\ntraces = [\"a\"]\n", &["line 3: experiment.name: missing"]);
    refusal("[cylinder]\nbore_m = 0.02\n[columns]\ntime = { unit = \"s\" }\n", &["line 4: columns.time.name: missing"]);
}

#[test]
fn contradictions_are_refused() {
    refusal("[cylinder]\narea_m2 = 0.01\nbore_m = 0.02\n", &["line 3: cylinder.bore_m", "area_m2"]);
    let gauge = "[cylinder]\nbore_m = 0.02\n[columns]\npressure = { name = \"p\", reference = \"gauge\" }\n";
    refusal(gauge, &["line 4: columns.pressure.reference", "[ambient] pressure_pa"]);
    let experiment = "[cylinder]\nbore_m = 0.02\n[[experiment]]\nname = \"a\"\n";
    refusal(&format!("{experiment}traces = []\n"), &["line 5: experiment.traces", "empty"]);
    refusal(&format!("{experiment}traces = [\"a\", \"a\"]\n"), &["line 5", "named twice"]);
    refusal(
        &format!("{experiment}traces = [\"a\"]\nfrom_s = 2\nto_s = 1\n"),
        &["line 7: experiment.to_s", "not after"],
    );
}

#[test]
fn columns_and_formats_that_cannot_be_are_refused() {
    let columns = |column: &str| format!("[cylinder]\nbore_m = 0.02\n[columns]\n{column}\n");
    refusal(&columns("pressure = { name = \"U\", unit = \"V\" }"), &["columns.pressure.scale: missing", "Pa a volt"]);
    refusal(&columns("pressure = { name = \"U\", scale = 0 }"), &["columns.pressure.scale", "other than zero"]);
    refusal(&columns("time = { name = \"t\", unit = \"V\", scale = 1 }"), &["columns.time.unit", "unknown value `V`"]);
    let format = |format: &str| format!("[cylinder]\nbore_m = 0.02\n[format]\n{format}\n");
    refusal(&format("separator = \",\"\ndecimal = \",\""), &["line 5: format.decimal", "commas separate"]);
    refusal(&format("decimal = \"'\""), &["line 4: format.decimal"]);
    refusal(&format("encoding = \"latin1\""), &["line 4: format.encoding", "did you mean `latin-1`?"]);
    refusal(&format("skip_lines = -7"), &["line 4: format.skip_lines: -7 is out of range", "zero or above"]);
    refusal(&format("skip = 1"), &["line 4: format.skip", "`skip_lines`"]);
}

#[test]
fn a_rig_without_experiments_cannot_be_evaluated() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rig.toml"), "[cylinder]\nbore_m = 0.02\n").unwrap();
    let message = Rig::read(folder.path()).unwrap_err().to_string();
    assert!(message.contains("rig.toml: line 1: experiment: missing"), "{message}");
}

#[test]
fn a_missing_rig_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let message = Rig::read(&folder.path().join("rig.toml")).unwrap_err().to_string();
    assert!(message.contains("rig.toml: cannot be read: No such file"), "{message}");
}

#[test]
fn a_folder_without_a_rig_file_is_refused_with_a_hint_on_how_to_get_one() {
    let folder = tempfile::tempdir().unwrap();
    let message = RigFile::read(folder.path()).unwrap_err().to_string();
    assert!(message.contains("has no rig.toml; `pneutherm look"), "{message}");
}

#[test]
fn a_copy_of_a_record_is_no_repeat_but_another_part_of_the_same_file_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let one = std::fs::read_to_string(Path::new(CASE_01).join("compress-ambient-1.csv")).unwrap();
    for name in ["a.csv", "b.csv"] {
        std::fs::write(folder.path().join(name), &one).unwrap();
    }
    let read = |experiments: &[&str]| {
        let table = |(nth, e)| format!("[[experiment]]\nname = \"x{nth}\"\n{e}\n");
        let experiments: String = experiments.iter().enumerate().map(table).collect();
        std::fs::write(folder.path().join("rig.toml"), format!("[cylinder]\nbore_m = 0.02\n{experiments}")).unwrap();
        Rig::read(folder.path()).map_err(|error| error.to_string())
    };
    for copies in [&["traces = [\"a.csv\", \"b.csv\"]"][..], &["traces = [\"a.csv\"]", "traces = [\"a.csv\"]"]] {
        let message = read(copies).unwrap_err();
        assert!(message.contains("a.csv already; a copy is no repeat") && !message.contains('\n'), "{message}");
    }
    assert!(read(&["traces = [\"a.csv\"]\nto_s = 0.5", "traces = [\"a.csv\"]\nfrom_s = 0.5"]).is_ok());
    // The rest between two tests may belong to both, as with `pneutherm look --split`; most of a record may not.
    assert!(read(&["traces = [\"a.csv\"]\nto_s = 0.6", "traces = [\"a.csv\"]\nfrom_s = 0.4\nto_s = 1.0"]).is_ok());
    assert!(read(&["traces = [\"a.csv\"]\nto_s = 0.6", "traces = [\"a.csv\"]\nfrom_s = 0.1\nto_s = 1.0"]).is_err());
}

#[test]
fn a_dead_volume_beside_which_no_stroke_would_show_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(Path::new(CASE_01).join("compress-ambient-1.csv"), folder.path().join("a.csv")).unwrap();
    let read = |dead_volume: &str| {
        let rig = format!(
            "[cylinder]\nbore_m = 0.02\ndead_volume_m3 = {dead_volume}\n[[experiment]]\nname = \"x\"\ntraces = [\"a.csv\"]\n"
        );
        std::fs::write(folder.path().join("rig.toml"), rig).unwrap();
        Rig::read(folder.path()).map_err(|error| error.to_string())
    };
    let message = read("9.6").unwrap_err();
    assert!(message.contains("line 3: cylinder.dead_volume_m3: ") && message.contains("1 cm3 is 1e-6 m3"), "{message}");
    // A bottle of ten times the swept volume is accepted.
    assert!(read("3.1e-4").is_ok());
}

#[test]
fn a_decimal_comma_in_a_rig_file_is_reported() {
    refusal("[cylinder]\nbore_m = 0,02\n", &["line 2", "not valid TOML", "numbers have a decimal point here"]);
    let message = parse("[cylinder]\nbore_m = 0.02 0.03\n").unwrap_err().to_string();
    assert!(!message.contains("decimal point"), "{message}");
}
