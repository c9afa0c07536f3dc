//! Units, scales and signs: values come out in SI units, and contradictions to the rig are refused.

use crate::{Bench, assert_says};

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
        // Accepted: the right unit, the column's number, or a scale that converts one unit to the other.
        for right in ["unit = \"psi\"", "unit = \"bar\", scale = 0.0689476"] {
            assert!(bench(&format!("name = \"{name}\", {right}")).read(&text).is_ok(), "{name}: {right}");
        }
        assert!(bench("name = \"column 2\", unit = \"bar\"").read(&text).is_ok());
    }
    // The rig file takes precedence over the end of a name.
    assert!(bench("name = \"p_psi\", unit = \"bar\"").read(format!("t,p_psi,x\n{rows}")).is_ok());
    // Not a unit, although it looks like one.
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
    // The offset may be the ambient pressure.
    assert!(read("barg", ", offset = 1.013").is_ok());
}
