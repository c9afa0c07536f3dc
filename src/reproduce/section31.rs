//! Section 3.1 of the paper as a section of the report.

use super::figures;
use anyhow::Result;
use paper::section31::{Section31, Timing, reproduce};
use report::{Block, Section, Table, digits, percent, signed_percent};

/// The section of the report.
///
/// # Errors
/// If a drawing fails.
pub fn section(found: &Section31) -> Result<Section> {
    let mut section = Section::new("Section 3.1: the simulated test");
    let timing = found.timing;
    section.text(format!(
        "The paper simulates a push from {} to {} mm with λ0 = {} W/(m² K) and with the lateral area of the swept length. It \
         evaluates the pressure by its seven steps, with the lateral area of the whole gas volume (equation 27). Here both are done with \
         a push of {} s, a hold of {} s and {} rows per second; the paper states none of the three. A push of 0.03 to \
         0.05 s changes λ0 by less than {}. There are no intervals, because the record has no noise.",
        digits(found.description.initial_stroke_m * 1e3, 3),
        digits(found.description.final_stroke_m * 1e3, 2),
        digits(found.description.coefficient_w_per_m2_k, 3),
        timing.push_s,
        timing.hold_s,
        timing.sample_rate_hz,
        percent(push_time_sensitivity(found)?, 2),
    ));
    section.table(comparison(found));
    let same = found.same_area.steps.coefficient_0_w_per_m2_k.value;
    let published = found.published.steps.coefficient_0_w_per_m2_k.value;
    let truth = found.description.coefficient_w_per_m2_k;
    section.text(format!(
        "The result of the published steps deviates by {} from the true {truth} W/(m² K) (in the paper: {}). This small error is the sum of two larger ones that cancel. \
         The first: the steps fit an exponential to P, although only 1 − Pf/P is exponential. With the same area in simulation and evaluation this gives \
         {} W/(m² K), an error of {}. The second: the evaluation counts the lateral area of the dead volume, but the simulated cylinder does not have it. \
         This reduces the result by {}. For a real cylinder, which equation 27 describes, the second error is absent and the first remains. \
         The exact regression 1/P = (1/Pf)(1 − a e^(−kt)) needs no averages and recovers {} W/(m² K).",
        signed_percent(published / truth - 1.0, 1),
        signed_percent(printed_error(found), 1),
        digits(same, 4),
        signed_percent(found.bias_fit, 1),
        signed_percent(found.bias_area, 1).trim_start_matches('-'),
        digits(found.lambda0_exact(), 9),
    ));
    let largest = found.published.fit.residuals_pa.iter().map(|r| r.abs()).fold(0.0, f64::max);
    section.blocks.push(Block::Figure {
        file: "pressure_response.svg",
        svg: figures::pressure_response::draw(found)?,
        caption: format!(
            "Pressure after the push with both fits, and their residuals. The residual of the exponential is systematic, up to {} bar; \
             that of the exact regression is rounding only.",
            digits(largest * 1e-5, 2)
        ),
    });
    Ok(section)
}

/// Relative error of the λ0 printed in the paper.
fn printed_error(found: &Section31) -> f64 {
    let printed = found.lines.iter().find(|l| l.symbol == "lambda0_hat").and_then(|l| l.paper);
    printed.map_or(f64::NAN, |p| p / found.description.coefficient_w_per_m2_k - 1.0)
}

fn comparison(found: &Section31) -> Table {
    let mut table = Table::new(&["quantity", "symbol", "unit", "paper", "ours", "difference"]);
    for line in &found.lines {
        table.row([
            line.quantity.clone(),
            line.symbol.clone(),
            line.unit.clone(),
            line.paper.map_or("–".to_owned(), |p| digits(p, 4)),
            digits(line.ours, 4),
            match line.paper {
                None => "–".to_owned(),
                Some(paper) if paper == line.ours => "given".to_owned(),
                Some(paper) => signed_percent(line.ours / paper - 1.0, 2),
            },
        ]);
    }
    table
}

/// Relative change of λ0 from the published steps for push times of 0.03 to 0.05 s.
fn push_time_sensitivity(found: &Section31) -> Result<f64> {
    let mut largest = 0.0_f64;
    for push_s in [0.03, 0.05] {
        let other = reproduce(&Timing { push_s, ..found.timing })?;
        let lambda0 = |s: &Section31| s.published.steps.coefficient_0_w_per_m2_k.value;
        largest = largest.max((lambda0(&other) / lambda0(found) - 1.0).abs());
    }
    Ok(largest)
}
