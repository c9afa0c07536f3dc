//! Traces, rigs, models and studies: no panic, no runaway, a sentence for what is refused, and sense in what is not.

use hostile::assert_is_a_sentence;
use records::{Model, Rig, Trace};
use std::path::Path;

/// Far more than any input of these tests needs; far less than one that runs away.
const MEMORY: u64 = 1 << 30;

fn assert_memory_is_bounded() {
    if let Some(peak) = hostile::peak_memory() {
        assert!(peak < MEMORY, "{peak} bytes");
    }
}

fn assert_is_a_trace(trace: &Trace) {
    let rows = trace.time_s.len();
    assert!(rows >= 3);
    assert!(trace.time_s.windows(2).all(|pair| pair[0] < pair[1]), "time does not increase");
    let columns = [
        Some(&trace.position_m),
        trace.pressure_pa.as_ref(),
        trace.ambient_temperature_k.as_ref(),
        trace.gas_temperature_k.as_ref(),
        trace.mass_flow_kg_per_s.as_ref(),
    ];
    for column in columns.into_iter().flatten() {
        assert_eq!(column.len(), rows);
        assert!(column.iter().all(|value| value.is_finite()));
    }
    assert!(trace.pressure_pa.iter().flatten().all(|pressure| *pressure > 0.0), "a pressure below vacuum");
}

/// A folder with what the other files name: a model, and the records of a rig.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    std::fs::copy(corpus.join("model/leaking.toml"), folder.path().join("model.toml")).unwrap();
    std::fs::copy(corpus.join("trace/plain.csv"), folder.path().join("one.csv")).unwrap();
    std::fs::copy(corpus.join("trace/plain.csv"), folder.path().join("two.csv")).unwrap();
    std::fs::copy(corpus.join("trace/gauge.csv"), folder.path().join("gauge.csv")).unwrap();
    folder
}

#[test]
fn a_trace_is_read_or_refused_in_a_sentence() {
    let folder = folder();
    let (rig, csv) = (folder.path().join("rig.toml"), folder.path().join("one.csv"));
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus/rig/plain.toml"), &rig).unwrap();
    let words =
        ["time_s", "pressure_pa", "position_m", "ambient_temperature_k", "gas_temperature_k", ",", ";", "\"a,b\""];
    hostile::run("trace", &words, |bytes| {
        std::fs::write(&csv, bytes).unwrap();
        match Rig::read(&rig) {
            Ok(rig) => assert_is_a_trace(&rig.experiments[0].traces[0]),
            Err(error) => assert_is_a_sentence(&error.to_string(), &csv),
        }
    });
    assert_memory_is_bounded();
}

#[test]
fn a_rig_is_read_or_refused_in_a_sentence() {
    let folder = folder();
    let path = folder.path().join("rig.toml");
    let words = [
        "[cylinder]", "bore_m", "rod_m", "area_m2", "chamber = \"rod\"", "stroke_m = 0.1", "[ambient]",
        "temperature_k", "pressure_pa", "[gas]", "name", "[sensor]", "noise_pa", "[columns]", "unit = \"bar\"",
        "reference = \"gauge\"", "[format]", "separator = \"whitespace\"", "[[experiment]]", "traces = [\"one.csv\"]",
        "from_s", "to_s", "dead_volume_m3", "dead_volume_known", "true", "gauge.csv",
    ];
    hostile::run("rig", &words, |bytes| {
        std::fs::write(&path, bytes).unwrap();
        match Rig::read(&path) {
            Ok(rig) => {
                assert!(rig.cylinder.piston_area_m2 > 0.0 && rig.cylinder.bore_m > rig.cylinder.rod_through_m);
                assert!(rig.ambient.pressure_pa > 0.0 && rig.gas.gas.gas_constant > 0.0);
                assert!(rig.gas.gas.heat_capacity_ratio > 1.0);
                assert!(!rig.experiments.is_empty());
                for experiment in &rig.experiments {
                    assert!(!experiment.traces.is_empty());
                    experiment.traces.iter().for_each(assert_is_a_trace);
                }
            }
            Err(error) => {
                // A rig may name a trace anywhere on the machine; that file is then the one to name.
                let message = error.to_string();
                let named = Path::new(message.split(':').next().unwrap_or_default());
                assert_is_a_sentence(&message, if named.is_absolute() { named } else { folder.path() });
            }
        }
    });
    assert_memory_is_bounded();
}

#[test]
fn a_model_is_read_or_refused_in_a_sentence_and_round_trips_exactly() {
    let folder = folder();
    let (path, again) = (folder.path().join("model.toml"), folder.path().join("again.toml"));
    let words = [
        "[gas]", "name", "[chamber]", "bore_m", "rod_m", "dead_volume_m3", "area_law = \"swept\"", "[heat_transfer]",
        "coefficient_w_per_m2_k", "reference_pressure_pa", "[effect.leakage]", "conductance_m3_per_s_pa",
        "[effect.wall_heating]", "capacity_j_per_k", "[effect.sensor_lag]", "time_constant_s", "[provenance]",
        "[ambient]",
    ];
    hostile::run("model", &words, |bytes| {
        std::fs::write(&path, bytes).unwrap();
        match Model::read(&path) {
            Ok(model) => {
                model.write(&again).unwrap();
                assert_eq!(model, Model::read(&again).unwrap());
            }
            Err(error) => assert_is_a_sentence(&error.to_string(), &path),
        }
    });
    assert_memory_is_bounded();
}
