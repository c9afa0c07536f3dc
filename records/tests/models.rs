//! Model files: exact round trips, defaults, and refusals with file, line and key.

use chamber::card::Kind;
use chamber::effects::empirical::{Curve, KNOTS, Term, Variable};
use chamber::effects::{self, EffectValues};
use chamber::{AreaLaw, Chamber, Gas, Geometry, HeatTransfer};
use proptest::prelude::*;
use records::{Document, Model, OfEachRecord, Provenance, RigFile, Rmse, SourceTrace, Uncertainty, Verdict};
use std::path::Path;

const FEW: &str = "[chamber]\nbore_m = 0.02\n[heat_transfer]\ncoefficient_w_per_m2_k = 26.5\n";

fn parse(text: &str) -> Result<Model, records::Error> {
    Model::from_document(&Document::parse(Path::new("model.toml"), text.to_owned())?)
}

#[track_caller]
fn refusal(text: &str, parts: &[&str]) {
    let message = parse(text).expect_err("should be refused").to_string();
    assert!(message.starts_with("model.toml: line ") && !message.contains('\n'), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

#[test]
fn a_model_by_hand_needs_two_numbers() {
    let model = parse(FEW).unwrap();
    assert_eq!((model.gas_name.as_deref(), model.chamber.gas), (Some("air"), Gas::AIR));
    assert_eq!(model.chamber.geometry, Geometry::new(0.02, 0.0, 0.0, AreaLaw::Total));
    assert_eq!(model.chamber.heat_transfer, HeatTransfer::at_paper_reference(26.5));
    assert!(model.active().is_empty());
    assert_eq!(
        (model.chamber.geometry.rod_diameter, model.ambient_temperature_k, model.ambient_pressure_pa),
        (0.0, 293.15, 101325.0)
    );
    assert_eq!((model.uncertainty, model.provenance), (None, Provenance::default()));
}

#[test]
fn an_effect_is_on_once_a_parameter_of_it_is_not_neutral() {
    let model = parse(&format!("{FEW}[effect.leakage]\nconductance_m3_per_s_pa = 2e-12\n")).unwrap();
    let (index, _) = effects::find("leakage").unwrap();
    assert!(model.active().has(index));
    assert_eq!(model.chamber.effects.of(index), [2e-12, 0.3]);
    assert!(parse(&format!("{FEW}[effect.leakage]\n")).unwrap().active().is_empty());
}

#[test]
fn faulty_models_are_refused_by_key() {
    refusal("[heat_transfer]\ncoefficient_w_per_m2_k = 1\n", &["line 1: chamber: missing"]);
    refusal("[chamber]\nbore_m = 0.02\n[heat_transfer]\n", &["line 3: heat_transfer.coefficient_w_per_m2_k: missing"]);
    refusal(&FEW.replace("0.02", "-0.02"), &["line 2: chamber.bore_m: -0.02 is out of range"]);
    refusal(&FEW.replace("0.02", "inf"), &["line 2: chamber.bore_m: inf is out of range"]);
    refusal(&FEW.replace("bore_m", "boer_m"), &["line 2: chamber.boer_m: unknown key", "`bore_m`"]);
    refusal(&format!("{FEW}lambda = 3\n"), &["line 5: heat_transfer.lambda: unknown key"]);
    refusal(&format!("area = 1\n{FEW}"), &["line 1: area: unknown key"]);
    refusal(&FEW.replace("[heat", "area_law = \"totl\"\n[heat"), &["line 3: chamber.area_law", "`total`"]);
    refusal(&FEW.replace("[heat", "rod_m = 0.03\n[heat"), &["line 3: chamber.rod_m", "not less than the bore"]);
    refusal(&format!("{FEW}[ambient]\ntemperature_k = 20.0\n"), &["line 6: ambient.temperature_k", "kelvin"]);
    refusal(&format!("{FEW}[gas]\nname = \"ari\"\n"), &["line 6: gas.name", "did you mean `air`?"]);
    refusal(&format!("{FEW}[provenance]\nday = 1\n"), &["line 6: provenance.day: unknown key"]);
    let of_rig = ["line 6: provenance.of_each_record: unknown value `leakage`", "record_delay"];
    refusal(&format!("{FEW}[provenance]\nof_each_record = [\"leakage\"]\n"), &of_rig);
}

#[test]
fn faulty_effects_are_refused_as_their_cards_say() {
    refusal(&format!("{FEW}[effect.leekage]\n"), &["line 5: effect.leekage: unknown key", "did you mean `leakage`?"]);
    refusal(
        &format!("{FEW}[effect.leakage]\nconductance = 1e-12\n"),
        &["line 6: effect.leakage.conductance: unknown key", "`conductance_m3_per_s_pa`"],
    );
    for (_, card) in effects::all() {
        for parameter in card.parameters.iter().filter(|p| p.kind == Kind::Number) {
            let key = parameter.key();
            let beyond = parameter.bounds.end() * 2.0 + 1.0;
            let text = format!("{FEW}[effect.{}]\n{key} = {beyond:?}\n", card.name);
            refusal(&text, &[&format!("line 6: effect.{}.{key}: {beyond:?} is out of range", card.name)]);
        }
    }
}

#[test]
fn a_faulty_curve_is_refused_in_a_sentence() {
    let table = |balance: &str, variable: &str, knots: &str, values: &str| {
        format!(
            "{FEW}[effect.empirical]\nbalance = {balance}\nvariable = {variable}\nknots = {knots}\nvalues = {values}\n"
        )
    };
    let (heat, pressure, knots, values) = ("\"heat_flow\"", "\"pressure\"", "[1e5, 2e5]", "[0.0, 1]");
    let model = parse(&table(heat, pressure, knots, values)).unwrap();
    let (index, _) = effects::find("empirical").unwrap();
    let curve = Curve::of(model.chamber.effects.of(index)).unwrap();
    assert_eq!((curve.term, curve.variable), (Term::HeatFlow, Variable::Pressure));
    assert_eq!((curve.knots, curve.values), (vec![1e5, 2e5], vec![0.0, 1.0]));
    let faults: [(&str, &str, &str, &str, &[&str]); 10] = [
        ("\"heet_flow\"", pressure, knots, values, &["line 6: effect.empirical.balance", "did you mean `heat_flow`?"]),
        (heat, "\"presure\"", knots, values, &["line 7: effect.empirical.variable", "did you mean `pressure`?"]),
        (heat, "1", knots, values, &["line 7", "is the number 1, expected a text"]),
        (heat, pressure, "[2e5, 1e5]", values, &["line 8", "100000.0 follows 200000.0", "above the one before"]),
        (heat, pressure, "[1e5, 1e5]", values, &["line 8", "100000.0 follows 100000.0"]),
        (heat, pressure, "[]", values, &["line 8", "has 0 numbers; expected a list of 1 to 8 numbers"]),
        (heat, pressure, "[0, 1, 2, 3, 4, 5, 6, 7, 8]", values, &["line 8", "has 9 numbers"]),
        (heat, pressure, knots, "[1, 2, 3]", &["line 9", "effect.empirical.values: has 3 numbers, `knots` has 2"]),
        (heat, pressure, knots, "[1, nan]", &["line 9", "NaN is out of range"]),
        ("\"volume_share\"", "\"mass\"", knots, values, &["line 6", "can follow pressure or position only"]),
    ];
    for (balance, variable, knots, values, parts) in faults {
        refusal(&table(balance, variable, knots, values), parts);
    }
    refusal(
        &format!("{FEW}[effect.empirical]\n"),
        &["line 5: effect.empirical.balance: missing; expected one of heat_flow"],
    );
    let without = table(heat, pressure, knots, values).replace("values", "# values");
    refusal(&without, &["effect.empirical.values: missing; expected a list of 1 to 8 numbers"]);
}

#[test]
fn a_file_written_and_read_is_the_same_model_with_its_provenance() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let mut model = parse(FEW).unwrap();
    model.provenance = Provenance {
        program: Some("pneutherm \"0\"".to_owned()),
        date: Some("2026-11-21T12:00:00Z".to_owned()),
        traces: vec![SourceTrace { path: "run \\ 1\n.csv".to_owned(), sha256: "ab".repeat(32) }],
        verdict: Some(Verdict::Improved),
        rmse_before_pa: Some(Rmse { fit: 151.25, held_out: None }),
        rmse_after_pa: Some(Rmse { fit: 0.1 + 0.2, held_out: Some(1e-300) }),
        of_each_record: OfEachRecord {
            effects: ["record_delay", "sensor_drift"].iter().map(|name| effects::find(name).unwrap().0).collect(),
            initial_temperature: true,
        },
    };
    model.write(&path).unwrap();
    assert_eq!(Model::read(&path).unwrap(), model);
}

#[test]
fn a_model_that_would_not_read_back_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let good = parse(FEW).unwrap();
    let mut lost = good.clone();
    lost.chamber.heat_transfer.coefficient = f64::NAN;
    assert!(lost.write(&path).unwrap_err().to_string().contains("coefficient_w_per_m2_k"));
    let mut elsewhere = good.clone();
    elsewhere.chamber.geometry.piston_area *= 1.1;
    assert!(elsewhere.write(&path).unwrap_err().to_string().contains("piston area"));
    let mut negative = good;
    negative.chamber.geometry.dead_volume = -1e-6;
    assert!(negative.write(&path).unwrap_err().to_string().contains("dead_volume_m3"));
    assert!(!path.exists());
}

#[test]
fn faulty_uncertainties_are_refused_by_key() {
    let table = |rest: &str| format!("{FEW}[uncertainty]\n{rest}");
    refusal(&table(""), &["line 5: uncertainty.parameters: missing"]);
    refusal(&table("parameters = [\"bore_m\"]\n"), &["line 5: uncertainty.ci95: missing", "interval"]);
    let unknown =
        "line 6: uncertainty.parameters: unknown value `lambda1`; expected one of: lambda0_w_per_m2_k, dead_volume_m3";
    refusal(&table("parameters = [\"lambda1\"]\nci95 = [[1, 2]]\ncovariance = [[1]]\n"), &[unknown]);
    let full = |names: &str, ci95: &str, covariance: &str| {
        table(&format!("parameters = {names}\nci95 = {ci95}\ncovariance = {covariance}\n"))
    };
    let (two, intervals) = ("[\"bore_m\", \"dead_volume_m3\"]", "[[0, 1], [2, 3]]");
    assert!(parse(&full(two, intervals, "[[4, 1], [1, 1]]")).unwrap().uncertainty.is_some());
    refusal(
        &full("[\"bore_m\", \"bore_m\"]", intervals, "[]"),
        &["line 6: uncertainty.parameters", "`bore_m` is named twice"],
    );
    refusal(&full(two, "[[0, 1]]", "[]"), &["line 7: uncertainty.ci95", "1 rows for 2 parameters"]);
    refusal(
        &full(two, "[[0, 1], [3, 2]]", "[[1, 0], [0, 1]]"),
        &["line 7", "[3.0, 2.0] is no interval", "`dead_volume_m3`"],
    );
    refusal(&full(two, "[[0, 1], [3]]", "[[1, 0], [0, 1]]"), &["line 7", "[3.0] is no interval"]);
    refusal(&full(two, "[[0, 1], [0, inf]]", "[]"), &["line 7: uncertainty.ci95: inf is out of range", "finite"]);
    refusal(&full(two, "[0, 1]", "[]"), &["line 7: uncertainty.ci95", "expected a list of lists of numbers"]);
    refusal(&full(two, intervals, "[[1, 0], [0]]"), &["line 8", "the row of `dead_volume_m3` has 1 numbers"]);
    refusal(&full(two, intervals, "[[1, 0], [0, -1]]"), &["line 8", "variance of `dead_volume_m3`, -1.0, is negative"]);
    refusal(
        &full(two, intervals, "[[1, 0.1], [0.2, 1]]"),
        &["line 8", "`bore_m` and `dead_volume_m3`", "different values"],
    );
    refusal(&full(two, intervals, "[[4, 3], [3, 1]]"), &["line 8", "`bore_m` and `dead_volume_m3`, 3.0, is beyond"]);
    refusal(&format!("{FEW}[provenance]\nverdict = \"adequat\"\n"), &["provenance.verdict", "`adequate`"]);
}

fn any_curve() -> impl Strategy<Value = Curve> {
    let knots = prop::collection::btree_map(-1_000_000..1_000_000_i32, -0.9..0.9_f64, 1..=KNOTS);
    (0..Term::ALL.len(), knots).prop_map(|(term, table)| Curve {
        term: Term::ALL[term],
        variable: Variable::Pressure,
        knots: table.keys().map(|knot| f64::from(*knot) / 7.0).collect(),
        values: table.into_values().collect(),
    })
}

fn any_effects() -> impl Strategy<Value = EffectValues> {
    let shares = prop::collection::vec((any::<bool>(), 0.0..=1.0_f64), effects::PARAMETERS);
    (shares, prop::option::of(any_curve())).prop_map(|(shares, curve)| {
        let mut values = EffectValues::NEUTRAL;
        let parameters = effects::all().flat_map(|(_, card)| card.parameters);
        for ((value, parameter), (set, share)) in values.0.iter_mut().zip(parameters).zip(shares) {
            if set && parameter.kind == Kind::Number {
                *value = parameter.bounds.start() + share * (parameter.bounds.end() - parameter.bounds.start());
            }
        }
        if let (Some(curve), Some((index, _))) = (curve, effects::find("empirical")) {
            values.of_mut(index).copy_from_slice(&curve.parameters());
        }
        values
    })
}

/// Arbitrary parameters with intervals, correlated over many orders of magnitude.
fn any_uncertainty() -> impl Strategy<Value = Uncertainty> {
    let name = prop::sample::select(vec![
        "lambda0_w_per_m2_k",
        "dead_volume_m3",
        "bore_m",
        "leakage.conductance_m3_per_s_pa",
        "empirical.values[2]",
    ]);
    let parameter = (name.prop_map(str::to_owned), -1e3..1e3_f64, 1e-12..1e3_f64);
    (prop::collection::btree_map(parameter.0, (parameter.1, parameter.2), 0..5), -1.0..1.0_f64).prop_map(
        |(all, tilt)| {
            let sizes: Vec<f64> = all.values().map(|(_, size)| *size).collect();
            let covariance = |(i, a): (usize, &f64)| {
                sizes.iter().enumerate().map(|(j, b)| a * b * if i == j { 1.0 } else { tilt * tilt }).collect()
            };
            Uncertainty {
                parameters: all.keys().cloned().collect(),
                ci95: all.values().map(|(low, size)| [*low, low + size]).collect(),
                covariance: sizes.iter().enumerate().map(covariance).collect(),
            }
        },
    )
}

prop_compose! {
    fn any_model()(
        gas in prop_oneof![Just((Some("helium".to_owned()), 2077.1, 1.667)), (200.0..400.0_f64, 1.1..1.6_f64).prop_map(|(r, k)| (None, r, k))],
        bore in 1e-3..1.0_f64,
        rod_share in 0.0..0.9_f64,
        dead_volume in 0.0..1e-2_f64,
        swept in any::<bool>(),
        heat in (0.0..1e4_f64, 1e4..1e7_f64, 200.0..400.0_f64),
        effects in any_effects(),
        ambient in (200.0..400.0_f64, 5e4..2e5_f64),
        uncertainty in prop::option::of(any_uncertainty()),
    ) -> Model {
        let rod_m = bore * rod_share;
        let area_law = if swept { AreaLaw::Swept } else { AreaLaw::Total };
        Model {
            gas_name: gas.0,
            chamber: Chamber {
                gas: Gas { gas_constant: gas.1, heat_capacity_ratio: gas.2 },
                geometry: Geometry::new(bore, rod_m, dead_volume, area_law),
                heat_transfer: HeatTransfer { coefficient: heat.0, reference_pressure: heat.1, reference_temperature: heat.2 },
                effects,
            },
            ambient_temperature_k: ambient.0,
            ambient_pressure_pa: ambient.1,
            uncertainty,
            provenance: Provenance::default(),
        }
    }
}

proptest! {
    #[test]
    fn the_chamber_of_any_rig_can_be_written_and_read(bore in 0.008..0.2_f64, rod_share in 0.0..0.9_f64, dead_volume in 0.0..1e-3_f64) {
        // As in rig files: in tenths of a millimetre; a rod side has a rod.
        let [bore_m, rod_m] = [bore, bore * rod_share].map(|metres| (metres * 1e4).round().max(1.0) / 1e4);
        let text = format!("[cylinder]\nbore_m = {bore_m:?}\nrod_m = {rod_m:?}\nchamber = \"rod\"\n[ambient]\ntemperature_k = 293.0\n");
        let rig = RigFile::from_document(&Document::parse(Path::new("rig.toml"), text).unwrap()).unwrap().rig;
        let geometry = rig.cylinder.geometry(dead_volume);
        let model = parse(FEW).unwrap();
        let model = Model { chamber: Chamber { geometry, ..model.chamber }, ..model };
        prop_assert_eq!(parse(&model.to_toml().unwrap()).unwrap(), model);
    }

    #[test]
    fn every_bit_of_a_model_survives_its_file(model in any_model()) {
        let read = parse(&model.to_toml().unwrap()).unwrap();
        prop_assert_eq!(&read, &model);
        prop_assert_eq!(read.to_toml().unwrap(), model.to_toml().unwrap());
    }

    #[test]
    fn any_file_is_read_as_a_model_or_refused_with_a_message(text in "(\\[chamber\\]\n)?[a-z_=\\[\\]{}\"0-9. \n]{0,120}") {
        if let Err(error) = parse(&text) {
            prop_assert!(error.to_string().starts_with("model.toml: line "));
        }
    }
}
