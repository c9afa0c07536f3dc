//! Four of the labelled cases (two repeats of each experiment), from a simulator written apart from this project.

use chamber::simulate::Start;
use identify::fit::readings;
use identify::forward::Correction;
use identify::outcome::diagnosis::Diagnosed;
use identify::parameters::Setting;
use identify::record::data::Data;
use records::{Rig, Verdict};
use std::path::PathBuf;

fn folder(case: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(case)
}

fn diagnosed(case: &str) -> Diagnosed {
    identify::diagnose(&Rig::read(&folder(case)).unwrap(), &|_, _| ()).unwrap()
}

/// Error of the diagnosed model on a motion that no experiment has, over the noise.
fn validation_error_over_noise(case: &str, found: &Diagnosed) -> f64 {
    let mut rig = Rig::read(&folder(case)).unwrap();
    let text = std::fs::read_to_string(folder(case).join("rig.toml")).unwrap();
    let only = format!(
        "{}[[experiment]]\nname = \"validation\"\ntraces = [\"validation.csv\"]\n",
        text.split("[[experiment]]").next().unwrap()
    );
    let copy = tempfile::tempdir().unwrap();
    std::fs::write(copy.path().join("rig.toml"), only).unwrap();
    std::fs::copy(folder(case).join("validation.csv"), copy.path().join("validation.csv")).unwrap();
    rig = Rig { path: rig.path, ..Rig::read(copy.path()).unwrap() };
    let data = Data::prepare(&rig).unwrap();
    let t = &data.traces[0];
    let chamber = found.chamber();
    let start = Start { pressure: t.initial_pressure_pa, temperature: t.initial_temperature_k };
    let setting = Setting { chamber, start, correction: Correction::NONE };
    let model = readings(t, &setting, chamber.active()).unwrap();
    let squares: f64 = t.pressure_pa.iter().zip(&model).map(|(y, m)| (y - m).powi(2)).sum();
    (squares / model.len() as f64).sqrt() / found.diagnosis.noise_pa
}

fn assert_within(value: f64, truth: f64, share: f64) {
    assert!((value / truth - 1.0).abs() < share, "{value} against {truth}");
}

#[test]
fn a_clean_cylinder_raises_no_alarm() {
    let found = diagnosed("case01");
    assert_eq!((found.diagnosis.verdict, found.diagnosis.balance), (Verdict::Adequate, "none"));
    assert!(found.diagnosis.effects.is_empty());
    assert_within(found.chamber().heat_transfer.coefficient, 43.257, 0.01);
    assert_within(found.chamber().geometry.dead_volume, 9.645e-6, 0.01);
    assert!(validation_error_over_noise("case01", &found) < 1.1);
}

#[test]
fn a_leak_is_named_and_measured() {
    let found = diagnosed("case03");
    assert_eq!((found.diagnosis.verdict, found.diagnosis.balance), (Verdict::Explained, "mass"));
    assert_eq!(found.diagnosis.effects, ["leakage"]);
    assert_within(found.chamber().heat_transfer.coefficient, 33.132, 0.01);
    let leak = found.diagnosis.after.parameters.iter().find(|(n, _)| n == "leakage.conductance_m3_per_s_pa").unwrap();
    assert_within(leak.1.value, 3e-12, 0.01);
    assert!(found.diagnosis.after.rmse_pa.held_out < found.diagnosis.before.rmse_pa.held_out);
}

#[test]
fn a_slow_sensor_is_named_and_not_taken_for_a_delay() {
    let found = diagnosed("case08");
    assert_eq!((found.diagnosis.effects.as_slice(), found.diagnosis.balance), (["sensor_lag"].as_slice(), "sensor"));
    assert_within(found.chamber().heat_transfer.coefficient, 44.519, 0.01);
    assert!(validation_error_over_noise("case08", &found) < 1.1);
}

#[test]
fn an_effect_without_a_card_is_never_called_explained() {
    let found = diagnosed("case13");
    let verdict = found.diagnosis.verdict;
    assert!(matches!(verdict, Verdict::Unexplained | Verdict::Improved), "{verdict:?}");
    assert!(found.diagnosis.missing.len() > 2 && found.diagnosis.balance != "none");
    assert!(found.diagnosis.remaining_pa > found.diagnosis.noise_pa);
    let after = found.diagnosis.after.rmse_pa.held_out.unwrap();
    assert!(after <= found.diagnosis.before.rmse_pa.held_out.unwrap());
}

#[test]
fn the_result_has_the_contract_s_names() {
    let found = diagnosed("case03");
    let json = serde_json::to_value(&found.diagnosis).unwrap();
    assert!(json["before"]["parameters"]["lambda0_w_per_m2_k"]["ci95"][0].as_f64().unwrap() > 0.0);
    assert!(json["after"]["parameters"]["leakage.conductance_m3_per_s_pa"]["value"].as_f64().unwrap() > 0.0);
    assert!(json["candidates"][0]["delta_bic"].as_f64().unwrap() > 10.0);
    assert_eq!(json["effects"], serde_json::json!(["leakage"]));
    assert!(json["candidates"][0]["effect"].as_str().unwrap().starts_with("leakage"));
    assert!(json["candidates"][0]["held_out_rmse_pa"].is_number() && json["noise_pa"].is_number());
}
