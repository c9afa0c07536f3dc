//! The fits to the six measured points: `geometry_effect.json` and a section of the report.

use super::figures;
use anyhow::{Context, Result};
use paper::geometry_effect::{COLUMN_HALF, FORMS, GeometryEffect, ONE_LAMBDA0, Outcome, REFERENCE_LENGTH_M};
use report::{Block, Section, Table, digits, percent};
use serde_json::{Map, Value, json};

/// The list in `geometry_effect.json`: every form tried.
pub fn entries(effect: &GeometryEffect) -> Vec<Value> {
    let entry = |o: &Outcome| {
        let values: Map<String, Value> = o.values.iter().map(|v| (v.name.clone(), v.value.into())).collect();
        json!({
            "name": o.name,
            "equation": o.equation,
            "parameters": o.parameters,
            "rms_fitted": o.rms_fitted,
            "rms_left_out": o.rms_held_out,
            "values": values,
        })
    };
    effect.outcomes.iter().map(entry).collect()
}

/// The section of the report.
///
/// # Errors
/// If a drawing fails.
pub fn section(effect: &GeometryEffect) -> Result<Section> {
    let mut section = Section::new("A coefficient that depends on the column length: a hypothesis");
    let before = effect.outcome(ONE_LAMBDA0).context("the baseline is missing")?;
    let after = effect.outcome(COLUMN_HALF).context("the column length's form is missing")?;
    let best = effect.best_held_out().context("no form was fitted")?;
    section.text(format!(
        "With one λ0 for all six tests, the predicted time constants are off by {} rms, and by {} for an actuator left out of \
         the fit. {} forms of λ were fitted to the same six numbers. With a single parameter too, λ = {} W/(m² K) · √(P T/(P0 T0)) \
         · (l/{} m)^(−1/2) has an error of {} ({} left out), where l = V/(piston area) is the length of the gas column. The form with \
         the smallest left-out error, {}, has an error of {} ({} left out).",
        percent(before.rms_fitted, 0),
        rms(before.rms_held_out),
        FORMS.len(),
        digits(after.values[0].value, 3),
        REFERENCE_LENGTH_M,
        percent(after.rms_fitted, 1),
        rms(after.rms_held_out),
        best.equation,
        percent(best.rms_fitted, 1),
        rms(best.rms_held_out),
    ));
    let chosen: Vec<String> = effect.chosen_blind.iter().map(|(a, form)| format!("{a} by “{form}”")).collect();
    let exponents: Vec<String> = effect.pressure_exponents.iter().map(|(a, n)| format!("{a} {n:.2}")).collect();
    section.text(format!(
        "This is a hypothesis, not a law. There are three actuators, two pressures each and one laboratory, and the form was chosen \
         after seeing the data. If the form is also chosen without the actuator that it then predicts ({}), the error is {}: two \
         actuators do not determine the form. Records of more sizes would; `pneutherm diagnose` tries the same effect on traces. \
         The exponent of P T within each actuator is {}, below the ½ of equation 5.",
        chosen.join(", "),
        percent(effect.rms_chosen_blind, 0),
        exponents.join(", "),
    ));
    section.blocks.push(Block::Figure {
        file: "time_constants.svg",
        svg: figures::time_constants::draw(effect)?,
        caption: format!(
            "Predicted over measured time constant of each test. Each actuator is predicted from the other two, with one λ0 for all \
             ({} rms) and with λ ∝ √(P T) l^(−1/2) ({} rms). Both have one fitted parameter.",
            rms(before.rms_held_out),
            rms(after.rms_held_out)
        ),
    });
    section.table(forms(effect));
    section.text(
        "c in W/(m² K) at P0 = 5.65 bar, T0 = 293 K, l = 0.1 m, V/A = 5 mm, φ = 25 mm, V = 1e-4 m³, A = 0.01 m², dT = 10 K. \
         A dash: the tests of two actuators do not determine the form (B and C share a bore).",
    );
    section.blocks.push(Block::Figure {
        file: "geometry_forms.svg",
        svg: figures::forms::draw(effect)?,
        caption: "All forms of λ: rms error of τ on the fitted points and on actuators left out of the fit.".to_owned(),
    });
    Ok(section)
}

fn rms(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| percent(v, 1))
}

fn forms(effect: &GeometryEffect) -> Table {
    let mut table = Table::new(&["form", "λ", "parameters", "rms fitted", "rms left out", "fitted values"]);
    for o in &effect.outcomes {
        let values: Vec<String> = o.values.iter().map(|v| format!("{} = {}", v.name, digits(v.value, 3))).collect();
        table.row([
            o.name.clone(),
            o.equation.clone(),
            o.parameters.to_string(),
            percent(o.rms_fitted, 1),
            rms(o.rms_held_out),
            values.join(", "),
        ]);
    }
    table
}
