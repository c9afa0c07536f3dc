//! Uncertain quantities: drawn from a distribution, or from the model's uncertainty.

use crate::common::{model, text, values};
use records::{Model, Uncertainty};
use sweep::{Study, run_in_memory};

fn study(head: &str, vary: &str) -> Study {
    Study::about(&uncertain(), &text(head, vary)).unwrap()
}

fn refusal(model: &Model, design: &str, vary: &str) -> String {
    let head = format!("design = \"{design}\"\nsamples = 64");
    Study::about(model, &text(&head, vary)).map(drop).unwrap_err().to_string()
}

const LAMBDA: &str = "heat_transfer.coefficient_w_per_m2_k";
const DEAD: &str = "chamber.dead_volume_m3";
const LEAK: &str = "effect.leakage.conductance_m3_per_s_pa";

/// λ0 fitted on a logarithmic scale, dead volume and leak on a linear one, a wall's conductance at its bound.
fn uncertain() -> Model {
    let mut model = model();
    let (leak, _) = chamber::effects::find("leakage").unwrap();
    model.chamber.effects.of_mut(leak)[0] = 3e-12;
    let (lambda0, of_lambda0) = (model.chamber.heat_transfer.coefficient, 4.0);
    let (dead, of_dead) = (model.chamber.geometry.dead_volume, 2e-7);
    let ratio = (1.959964 * of_lambda0 / lambda0).exp();
    let sds = [of_lambda0, of_dead, 5e-13, 0.0];
    let correlation: [[f64; 4]; 4] =
        [[1.0, 0.7, -0.2, 0.0], [0.7, 1.0, 0.3, 0.0], [-0.2, 0.3, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let linear = |value: f64, sd: f64| [value - 1.959964 * sd, value + 1.959964 * sd];
    let names = [
        "lambda0_w_per_m2_k",
        "dead_volume_m3",
        "leakage.conductance_m3_per_s_pa",
        "wall_heating.outer_conductance_w_per_k",
    ];
    model.uncertainty = Some(Uncertainty {
        parameters: names.map(str::to_owned).to_vec(),
        ci95: vec![[lambda0 / ratio, lambda0 * ratio], linear(dead, of_dead), linear(3e-12, 5e-13), [0.0; 2]],
        covariance: (0..4).map(|i| (0..4).map(|j| correlation[i][j] * sds[i] * sds[j]).collect()).collect(),
    });
    model
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn covariance(x: &[f64], y: &[f64]) -> f64 {
    let (mx, my) = (mean(x), mean(y));
    mean(&x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).collect::<Vec<_>>())
}

#[test]
fn a_study_from_the_model_draws_its_parameters_with_their_correlations() {
    for design in ["sobol", "latin-hypercube"] {
        let study = study(&format!("design = \"{design}\"\nsamples = 8192\nseed = 7\nfit = false"), "from = \"model\"");
        assert_eq!(study.varied.iter().map(|v| v.column.as_str()).collect::<Vec<_>>(), [LAMBDA, DEAD, LEAK]);
        let batches = run_in_memory(&study).unwrap();
        let all = |name: &str| batches.iter().flat_map(|batch| values(batch, name)).collect::<Vec<f64>>();
        let lambda0: Vec<f64> = all(LAMBDA).iter().map(|x| (x / 26.5).ln()).collect();
        let (dead, leak) = (all(DEAD), all(LEAK));
        let close = |found: f64, expected: f64, off: f64, what: &str| {
            assert!((found - expected).abs() < off, "{design}, {what}: {found}, not {expected}");
        };
        close(mean(&lambda0), 0.0, 2e-3 * 0.15, "median of λ0");
        close(mean(&dead) / 1.57e-6, 1.0, 2e-3 * 0.13, "mean of the dead volume");
        close(covariance(&lambda0, &lambda0).sqrt() / (4.0 / 26.5), 1.0, 0.01, "spread of ln λ0");
        close(covariance(&dead, &dead).sqrt() / 2e-7, 1.0, 0.01, "spread of the dead volume");
        close(covariance(&leak, &leak).sqrt() / 5e-13, 1.0, 0.01, "spread of the leak");
        let correlation = |x: &[f64], y: &[f64]| covariance(x, y) / (covariance(x, x) * covariance(y, y)).sqrt();
        close(correlation(&lambda0, &dead), 0.7, 0.02, "correlation of ln λ0 and dead volume");
        close(correlation(&lambda0, &leak), -0.2, 0.02, "correlation of ln λ0 and leak");
        close(correlation(&dead, &leak), 0.3, 0.02, "correlation of dead volume and leak");
    }
}

#[test]
fn some_of_the_model_s_parameters_keep_the_correlation_between_them_beside_other_axes() {
    let vary = format!(
        "bore_m = {{ distribution = \"uniform\", from = 0.016, to = 0.032 }}
{DEAD} = {{ from = \"model\" }}\n{LAMBDA} = {{ from = \"model\" }}"
    );
    let study = study("design = \"sobol\"\nsamples = 4096\nfit = false", &vary);
    let batch = &run_in_memory(&study).unwrap()[0];
    let (bore, dead) = (values(batch, "bore_m"), values(batch, DEAD));
    let lambda0: Vec<f64> = values(batch, LAMBDA).iter().map(|x| x.ln()).collect();
    let correlation = |x: &[f64], y: &[f64]| covariance(x, y) / (covariance(x, x) * covariance(y, y)).sqrt();
    assert!((correlation(&dead, &lambda0) - 0.7).abs() < 0.02 && correlation(&bore, &dead).abs() < 0.02);
    let correlated = &study.json()["correlated"];
    assert_eq!(correlated["quantities"], serde_json::json!([DEAD, LAMBDA]));
    assert!((correlated["correlation"][0][1].as_f64().unwrap() - 0.7).abs() < 1e-12);
}

#[test]
fn the_same_seed_draws_the_same_rows_in_pieces_too() {
    let make = |seed: u64| {
        let vary = "from = \"model\"\nbore_m = { distribution = \"normal\", mean = 0.02, sd = 1e-4 }
push_time_s = { distribution = \"triangular\", from = 0.03, mode = 0.04, to = 0.06 }";
        study(&format!("design = \"latin-hypercube\"\nsamples = 1000\nseed = {seed}"), vary)
    };
    let points = |study: &Study, rows: std::ops::Range<u64>| {
        let mut columns = vec![Vec::new(); study.varied.len()];
        study.design.fill(rows, &mut columns).unwrap();
        columns
    };
    let whole = points(&make(1), 0..1000);
    let piece = points(&make(1), 313..500);
    assert!(whole.iter().zip(&piece).all(|(whole, piece)| whole[313..500] == piece[..]));
    assert_ne!(whole, points(&make(2), 0..1000));
}

#[test]
fn a_distribution_that_cannot_be_is_refused_before_any_row() {
    for (vary, expected) in [
        ("bore_m = { distribution = \"gauss\", mean = 1, sd = 1 }", "expected one of: normal, log-normal"),
        ("bore_m = { distribution = \"normal\", mean = 0.02 }", "bore_m.sd: missing; expected the standard deviation"),
        (
            "bore_m = { distribution = \"normal\", mean = 0.02, std = 1e-4 }",
            "bore_m.std: unknown key; did you mean `sd`?",
        ),
        ("bore_m = { distribution = \"triangular\", from = 0.01, top = 0.02, to = 0.03 }", "bore_m.top: unknown key"),
        ("bore_m = { distribution = \"normal\", mean = 0.02, sd = 0.0 }", "has an `sd` of 0"),
        ("bore_m = { distribution = \"normal\", mean = 0.02, sd = 0.01 }", "reaches -"),
        ("bore_m = { distribution = \"normal\", mean = 0.02, sd = 0.01, from = -1.0 }", "`from` and `to` truncate"),
        (
            "bore_m = { distribution = \"normal\", mean = 0.02, sd = 1e-4, from = 0.03, to = 0.04 }",
            "next to no probability",
        ),
        (
            "bore_m = { distribution = \"normal\", mean = 0.02, sd = 1e-4, from = 0.03, to = 0.01 }",
            "`from` has to be below `to`",
        ),
        ("bore_m = { distribution = \"normal\", mean = 0.02, sd = 1e-4, var = 1 }", "bore_m.var: unknown key"),
        (
            "bore_m = { distribution = \"log-normal\", median = 0.02 }",
            "either `median` and `sd_log` or `mean` and `sd`",
        ),
        ("bore_m = { distribution = \"log-normal\", median = -0.02, sd_log = 0.1 }", "is above 0"),
        ("bore_m = { distribution = \"log-normal\", mean = 0.02, sd = -0.1 }", "both have to be above 0"),
        ("bore_m = { distribution = \"uniform\", from = 0.02, to = 0.01 }", "`from` has to be below `to`"),
        ("bore_m = { distribution = \"triangular\", from = 0.01, mode = 0.03, to = 0.02 }", "in ascending order"),
        ("bore_m = { distribution = \"empirical\", values = [0.02, 0.02] }", "at least two different values"),
        ("bore_m = { distribution = \"empirical\", values = [0.02, -0.02] }", "has to be from 1e-4 to 5"),
        ("bore_m = { from = \"modle\" }", "did you mean `model`?"),
        (
            "bore_m = { from = \"model\" }",
            "has no variance in the model's [uncertainty], which knows that of heat_transfer",
        ),
        ("bore_m = { from = \"model\", to = 1 }", "bore_m.to: unknown key"),
        ("from = \"elsewhere\"", "expected one of: model"),
        ("from = \"model\"\ndead_volume_m3 = { values = [1e-6] }", "repeats chamber.dead_volume_m3, which line"),
    ] {
        let message = refusal(&uncertain(), "sobol", vary);
        assert!(message.contains(expected) && message.starts_with("study: "), "{vary}: {message}");
    }
    let message = refusal(&model(), "sobol", "from = \"model\"");
    assert!(message.contains("the model, which has no [uncertainty]: `identify` and `diagnose` write it"), "{message}");
    let message = refusal(&uncertain(), "saltelli", "from = \"model\"");
    assert!(message.contains("of independent quantities"), "{message}");
    let message = refusal(&uncertain(), "factorial", "bore_m = { distribution = \"normal\", mean = 0.02, sd = 1e-4 }");
    assert!(message.contains("is a distribution, which has no levels"), "{message}");
}

#[test]
fn a_covariance_that_no_numbers_can_have_is_refused() {
    let mut model = uncertain();
    let covariance = &mut model.uncertainty.as_mut().unwrap().covariance;
    for (i, j, correlation) in [(0, 1, 0.9), (0, 2, 0.9), (1, 2, -0.9)] {
        let value = correlation * (covariance[i][i] * covariance[j][j]).sqrt();
        (covariance[i][j], covariance[j][i]) = (value, value);
    }
    let message = refusal(&model, "sobol", "from = \"model\"");
    assert!(message.contains("its correlations contradict each other"), "{message}");
}

#[test]
fn log_normal_by_mean_and_deviation_has_them() {
    let study = study(
        "design = \"sobol\"\nsamples = 65536\nfit = false",
        "bore_m = { distribution = \"log-normal\", mean = 0.02, sd = 0.004 }",
    );
    let mut columns = vec![Vec::new()];
    study.design.fill(0..65536, &mut columns).unwrap();
    let (mean, sd) = (mean(&columns[0]), covariance(&columns[0], &columns[0]).sqrt());
    assert!((mean / 0.02 - 1.0).abs() < 1e-4 && (sd / 0.004 - 1.0).abs() < 2e-3, "{mean} {sd}");
}
