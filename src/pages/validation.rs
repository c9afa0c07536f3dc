//! The page written by `validate --report`: a model on records not used in its fit.

use super::quantities::pressure;
use super::{file, record_table};
use identify::outcome::validation::Validated;
use report::document::{Block, Drawing, Section, Table};
use report::{Axis, Chart, Colour, Error, Mark, Series, chart, digits, page};
use std::path::Path;

const WIDTH: u32 = 440;

/// How well a model predicts other records, as one self-contained HTML page.
///
/// # Errors
/// If a drawing fails.
pub fn html(model: &Path, rig: &Path, found: &Validated) -> Result<String, Error> {
    let v = &found.validation;
    let mut result = Section::new("Result");
    result.blocks.push(Block::Verdict {
        kind: "",
        text: format!(
            "The error is **{}** rms; the noise of the recording is {}.",
            pressure(v.rmse_pa, 3),
            pressure(v.noise_pa, 3)
        ),
    });
    let to = if v.whole_record {
        "the whole of each record"
    } else {
        "the rest and first move of each record; the error is that of the rest of the record"
    };
    result.text(format!("The records' own parameters are fitted to {to}. Everything else is taken from the model."));
    if !v.notes.is_empty() {
        result.blocks.push(Block::List(v.notes.iter().map(|note| format!("{note}.")).collect()));
    }
    result.table(records(found));
    let mut drawn = Section::new("Records and residuals");
    drawn.note("The residual is measured minus model; the grey band is ± two standard deviations of the noise.");
    drawn.blocks.push(Block::Charts((0..v.records.len()).map(|k| record(found, k)).collect::<Result<_, _>>()?));
    drawn.note(format!("pneutherm {}", env!("CARGO_PKG_VERSION")));
    let lead = format!("{} on {}", model.display(), rig.display());
    Ok(page::page("Validation of a model on other records", &lead, &[result, drawn]))
}

fn records(found: &Validated) -> Table {
    let records = found.validation.records.iter().map(|r| {
        let cells = vec![
            file(&r.trace).to_owned(),
            r.rmse_pa.map_or("-".to_owned(), |error| digits(error, 3)),
            digits(r.judged_from_s, 3),
        ];
        (cells, &r.parameters)
    });
    record_table::table(&["record", "error, Pa", "compared from, s"], &records.collect::<Vec<_>>())
}

/// A record's measured and simulated pressure, above its residual.
fn record(found: &Validated, k: usize) -> Result<Drawing, Error> {
    let (t, residual) = (&found.data.traces[k], &found.residuals[k]);
    let rows = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        (0..t.time_s.len()).map(|i| (t.time_s[i], value(i))).collect()
    };
    let line = |points, colour, label, width| Series { points, colour, label, mark: Mark::Line(width) };
    let above = Chart {
        title: file(&found.validation.records[k].trace),
        y: Axis::new("pressure, bar"),
        series: vec![
            line(rows(&|i| t.pressure_pa[i] * 1e-5), Colour::Ink, "measured", 2.2),
            line(rows(&|i| (t.pressure_pa[i] - residual[i]) * 1e-5), Colour::After, "model", 1.0),
        ],
        size: (WIDTH, 210),
        ..Chart::default()
    };
    let below = Chart {
        x: Axis::new("time, s"),
        y: Axis::new("residual, Pa"),
        band: Some(2.0 * found.validation.noise_pa),
        series: vec![line(rows(&|i| residual[i]), Colour::After, "", 0.8)],
        size: (WIDTH, 160),
        ..Chart::default()
    };
    Ok(Drawing { svg: chart::sheet("", &[above, below], 1)?, caption: String::new() })
}
