//! The report of a diagnosis: one self-contained HTML page with inline SVG, for a person who did not write it.

mod page;
mod svg;

use crate::discrepancy::Variable;
use crate::outcome::diagnosis::{Diagnosed, Diagnosis, Rmse, Unnamed};
use crate::outcome::validation::Validated;
use chamber::effects;
pub use page::number;
use page::{chosen_row, row};
use std::fmt::Write;
use std::path::Path;
use svg::{Chart, Curve, escape};

const BEFORE: &str = "#c2410c";
const AFTER: &str = "#1f5fa8";
const MEASURED: &str = "#555555";
/// Rows of the evidence that the page shows.
const SHOWN: usize = 24;
const WIDE: (f64, f64) = (640.0, 230.0);
const SMALL: (f64, f64) = (420.0, 210.0);

/// The page.
pub fn html(rig: &records::Rig, found: &Diagnosed) -> String {
    let d = &found.diagnosis;
    let mut out = page::head(&format!("Diagnosis of {}", rig.path.display()));
    summary(&mut out, rig, d);
    parameters(&mut out, d);
    recording(&mut out, d);
    evidence(&mut out, d);
    if !d.missing.is_empty() {
        unnamed(&mut out, &d.missing);
    }
    traces(&mut out, found);
    against(&mut out, found);
    next(&mut out, d);
    data(&mut out, rig, found);
    out.push_str("</body></html>\n");
    out
}

/// The page of a validation.
pub fn validation_html(model: &Path, rig: &Path, found: &Validated) -> String {
    let v = &found.validation;
    let mut out = page::head(&format!("{} on {}", model.display(), rig.display()));
    let how =
        if v.whole_record { "all of each record" } else { "each record's rest and first move; what follows is judged" };
    let _ = write!(
        out,
        "<h1>A model on records that took no part</h1><p class=\"source\">{} on {}</p>\
         <p class=\"verdict\">The error is <b>{} Pa rms</b>; the recording's noise is {} Pa.</p>\
         <p>The records' own numbers are fitted to {how}; everything else is the model's.</p>",
        escape(&model.display().to_string()),
        escape(&rig.display().to_string()),
        number(v.rmse_pa, 4),
        number(v.noise_pa, 3)
    );
    let names: Vec<&str> =
        v.records.first().map_or(Vec::new(), |r| r.parameters.iter().map(|(n, _)| n.as_str()).collect());
    let head: String = names.iter().map(|n| format!("<th>{n}</th>")).collect();
    let _ = write!(out, "<table><tr><th>record</th><th>error, Pa rms</th><th>judged from, s</th>{head}</tr>");
    for r in &v.records {
        let mut cells = vec![r.trace.clone(), number(r.rmse_pa, 4), number(r.judged_from_s, 4)];
        let value = |name: &&str| {
            r.parameters.iter().find(|(n, _)| n == name).map_or("–".to_owned(), |(_, e)| number(e.value, 5))
        };
        cells.extend(names.iter().map(value));
        out.push_str(&row(&cells.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    out.push_str("</table><h2>Records and residuals</h2>");
    for ((t, residual), r) in found.data.traces.iter().zip(&found.residuals).zip(&v.records) {
        // A page of some hundred kilobytes: every record with no more points than a screen shows.
        let step = t.time_s.len().div_ceil(2000);
        let series = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            (0..t.time_s.len()).step_by(step).map(|i| (t.time_s[i], value(i))).collect()
        };
        let pressures = [
            Curve { points: series(&|i| t.pressure_pa[i] / 1e5), colour: MEASURED, label: "measured", dots: true },
            Curve {
                points: series(&|i| (t.pressure_pa[i] - residual[i]) / 1e5),
                colour: AFTER,
                label: "model",
                dots: false,
            },
        ];
        let left =
            [Curve { points: series(&|i| residual[i]), colour: AFTER, label: "measured − model", dots: false }];
        let pressure = Chart { title: &r.trace, x: "time, s", y: "pressure, bar", band: None, size: WIDE };
        let rest = Chart { title: "", x: "time, s", y: "residual, Pa", band: Some(2.0 * v.noise_pa), size: WIDE };
        let _ = write!(
            out,
            "<div class=\"charts pair\"><figure>{}</figure><figure>{}</figure></div>",
            pressure.draw(&pressures),
            rest.draw(&left)
        );
    }
    let _ = writeln!(out, "<p class=\"small\">pneutherm {}</p></body></html>", env!("CARGO_PKG_VERSION"));
    out
}

fn summary(out: &mut String, rig: &records::Rig, d: &Diagnosis) {
    let _ = write!(
        out,
        "<h1>What the model of this cylinder lacks</h1><p class=\"source\">{}</p>",
        escape(&rig.path.display().to_string())
    );
    let named = || d.effects.join("</b> and <b>");
    let docs =
        || d.effects.iter().filter_map(|e| effects::find(e)).map(|(_, c)| lower(c.doc)).collect::<Vec<_>>().join("; ");
    let verdict = match d.verdict {
        "adequate" => format!(
            "The paper's chamber model describes these traces: what is systematic in its residual is {} Pa, no more than noise or than the {} Pa that matter.",
            number(d.remaining_pa, 2),
            number(d.accuracy_pa, 2)
        ),
        "explained" => format!(
            "The paper's chamber model is visibly wrong here. What it lacks is <b>{}</b> ({} balance): {}. With it, what remains is noise.",
            named(),
            d.balance,
            docs()
        ),
        "improved" => format!(
            "The paper's chamber model is visibly wrong here. <b>{}</b> predict left-out data decisively better ({}) and are in the model. \
             More than noise remains, {} Pa rms: they describe these records, and need not be the cause.",
            named(),
            docs(),
            number(d.remaining_pa, 3)
        ),
        _ => format!(
            "The paper's chamber model is visibly wrong here, and <b>no known effect helps</b>: none predicts left-out data decisively better. \
             What is missing ({} Pa rms) points to the <b>{}</b> balance. No effect is added to the model.",
            number(d.remaining_pa, 3),
            d.balance
        ),
    };
    let _ = write!(out, "<p class=\"verdict {}\">{verdict}</p>", d.verdict);
    let steps: String = d
        .steps
        .iter()
        .map(|s| match s.effects.is_empty() {
            true => errors("before (the paper's model)", &s.rmse_pa),
            false => errors(&format!("with {}", s.effects.join(" + ")), &s.rmse_pa),
        })
        .collect();
    let _ = write!(
        out,
        "<table><tr><th>error, Pa rms</th><th>on the data fitted</th><th>on data left out of the fit</th></tr>{steps}{}</table>",
        row(&["noise of the recording", &number(d.noise_pa, 4), ""])
    );
    out.push_str(
        "<p class=\"small\">Left out: each repeat in turn; without repeats, records in turn; with few records, the last third of each, simulated on from its beginning. \
         A record that was left out brings its own initial pressure: each half of its rows is judged with the one that the other half asks for.</p>",
    );
    for group in &d.indistinguishable {
        let _ = write!(
            out,
            "<p>These data cannot tell apart: <b>{}</b> (difference of BIC below 6).</p>",
            group.join("</b>, <b>")
        );
    }
}

fn errors(name: &str, rmse: &Rmse) -> String {
    let held_out = rmse.held_out.map_or("–".to_owned(), |h| number(h, 4));
    row(&[name, &number(rmse.fit, 4), &held_out])
}

/// The recording: its noise, and what each record has for itself.
fn recording(out: &mut String, d: &Diagnosis) {
    let n = &d.noise;
    out.push_str("<h2>The recording</h2><table><tr><th>noise of the pressure</th><th>value</th></tr>");
    out.push_str(&row(&["white, Pa rms", &number(n.white_pa, 3)]));
    if n.coloured_pa > 0.0 {
        out.push_str(&row(&["coloured, Pa rms", &number(n.coloured_pa, 3)]));
        out.push_str(&row(&["its correlation time, s", &number(n.correlation_s, 3)]));
    }
    if let Some(hz) = n.hum_hz {
        out.push_str(&row(&["hum, Hz", &number(hz, 3)]));
    }
    if n.step_pa > 0.0 {
        out.push_str(&row(&["step between readings, Pa", &number(n.step_pa, 3)]));
    }
    if let Some(hz) = n.readout_hz {
        out.push_str(&row(&["readings in a second", &number(hz, 3)]));
    }
    out.push_str(&row(&["readings left out", &n.outliers.to_string()]));
    out.push_str("</table>");
    let shares: Vec<String> = d
        .lambda0_budget
        .iter()
        .filter(|b| b.share > 0.005)
        .map(|b| format!("{} {:.0} %", b.source, 100.0 * b.share))
        .collect();
    let _ = write!(out, "<p>The variance of λ0 comes from: {}.</p>", shares.join(", "));
    let names: Vec<&str> =
        d.records.first().map_or(Vec::new(), |r| r.parameters.iter().map(|(n, _)| n.as_str()).collect());
    let head: String = names.iter().map(|n| format!("<th>{n}</th>")).collect();
    let _ = write!(out, "<table><tr><th>record</th><th>error, Pa rms</th>{head}</tr>");
    for r in &d.records {
        let mut cells = vec![r.trace.clone(), number(r.rmse_pa, 4)];
        let value = |name: &&str| {
            r.parameters.iter().find(|(n, _)| n == name).map_or("–".to_owned(), |(_, e)| number(e.value, 5))
        };
        cells.extend(names.iter().map(value));
        out.push_str(&row(&cells.iter().map(String::as_str).collect::<Vec<_>>()));
    }
    out.push_str("</table>");
}

fn parameters(out: &mut String, d: &Diagnosis) {
    out.push_str("<h2>Parameters</h2><table><tr><th>parameter</th><th>before</th><th>after</th><th>95 % interval (after)</th><th>unit</th></tr>");
    for (name, e) in &d.after.parameters {
        let before =
            d.before.parameters.iter().find(|(n, _)| n == name).map_or("–".to_owned(), |(_, b)| number(b.value, 5));
        out.push_str(&row(&[name, &before, &number(e.value, 5), &e.interval(), &e.unit]));
    }
    out.push_str("</table>");
    for u in &d.undetermined {
        let _ = write!(out, "<p>Hardly determined by these traces: {}.</p>", escape(&u.words()));
    }
    for (_, card) in d.effects.iter().filter_map(|e| effects::find(e)) {
        let (equation, source) = (escape(card.equation), escape(card.source));
        let _ = write!(out, "<p class=\"small\">{}: <code>{equation}</code>. {source}</p>", card.name);
    }
}

fn evidence(out: &mut String, d: &Diagnosis) {
    out.push_str(
        "<h2>Evidence</h2><p>Each effect was added to the model and everything fitted anew. ΔBIC: how much the data speak for it against the paper's \
         model, each parameter paid for; above 10 is decisive. An effect enters only if the error on left-out data falls too.</p>\
         <table><tr><th>effect</th><th>ΔBIC</th><th>error on left-out data, Pa rms</th><th>its parameters</th></tr>"
    );
    let paper: Vec<&String> = d.before.parameters.iter().map(|(n, _)| n).collect();
    for c in d.candidates.iter().take(SHOWN) {
        let own: Vec<String> = c
            .parameters
            .iter()
            .filter(|(n, _)| !paper.contains(&n))
            .map(|(n, e)| format!("{} = {}", n.split('.').next_back().unwrap_or(n), number(e.value, 4)))
            .collect();
        let held_out = c.held_out_rmse_pa.map_or("–".to_owned(), |h| number(h, 4));
        let row = if is_chosen(&c.effect, d) { chosen_row } else { row };
        out.push_str(&row(&[&c.effect, &format!("{:.1}", c.delta_bic), &held_out, &own.join(", ")]));
    }
    out.push_str("</table>");
    if d.candidates.len() > SHOWN {
        let _ = write!(out, "<p class=\"small\">{} more are in the JSON.</p>", d.candidates.len() - SHOWN);
    }
}

/// Whether a row of the evidence is the set that was chosen.
fn is_chosen(row: &str, d: &Diagnosis) -> bool {
    let names: Vec<&str> = row.split(" + ").collect();
    names.len() == d.effects.len() && d.effects.iter().all(|e| names.contains(e))
}

fn unnamed(out: &mut String, missing: &[Unnamed]) {
    out.push_str(
        "<h2>What is missing, without a name</h2><p>The residual as a free function of one variable, to first order; the best ones by what they take away \
         of the squares beyond noise. Bars: two standard deviations.</p><div class=\"charts\">",
    );
    for m in missing.iter().take(4) {
        let curve: Vec<(f64, f64)> = m.at.iter().copied().zip(m.value.iter().copied()).collect();
        let mut curves = vec![Curve { points: curve, colour: AFTER, label: "", dots: false }];
        for ((at, value), sd) in m.at.iter().zip(&m.value).zip(&m.sd) {
            curves.push(Curve {
                points: vec![(*at, value - 2.0 * sd), (*at, value + 2.0 * sd)],
                colour: MEASURED,
                label: "",
                dots: false,
            });
        }
        let title = format!("takes away {:.0} % ({} balance)", 100.0 * m.share, m.balance);
        let (x, y) = (format!("{}, {}", m.variable, m.variable_unit), format!("{}, {}", m.quantity, m.unit));
        let chart = Chart { title: &title, x: &x, y: &y, band: None, size: (420.0, 260.0) };
        let _ = write!(out, "<figure>{}</figure>", chart.draw(&curves));
    }
    out.push_str("</div>");
}

/// What is drawn beside the paper's model, and its residuals: those of the model found.
fn second(found: &Diagnosed) -> Option<(&'static str, &Vec<Vec<f64>>)> {
    (found.diagnosis.steps.len() > 1).then_some(("after", &found.residuals_after))
}

fn traces(out: &mut String, found: &Diagnosed) {
    out.push_str("<h2>Traces and residuals</h2><p>The first repeat of each experiment. Residual: measured less model; the grey band is twice the noise.</p>");
    let noise = found.diagnosis.noise_pa;
    let second = second(found);
    for (k, t) in found.data.traces.iter().enumerate().filter(|(_, t)| t.repeat == 0) {
        let series = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            (0..t.time_s.len()).map(|i| (t.time_s[i], values(i))).collect()
        };
        let before = &found.residuals_before[k];
        let mut pressures = vec![
            Curve { points: series(&|i| t.pressure_pa[i] / 1e5), colour: MEASURED, label: "measured", dots: true },
            Curve {
                points: series(&|i| (t.pressure_pa[i] - before[i]) / 1e5),
                colour: BEFORE,
                label: "before",
                dots: false,
            },
        ];
        let mut residuals =
            vec![Curve { points: series(&|i| before[i]), colour: BEFORE, label: "before", dots: false }];
        if let Some((label, after)) = second {
            let after = &after[k];
            pressures.push(Curve {
                points: series(&|i| (t.pressure_pa[i] - after[i]) / 1e5),
                colour: AFTER,
                label,
                dots: false,
            });
            residuals.push(Curve { points: series(&|i| after[i]), colour: AFTER, label, dots: false });
        }
        let title = found.data.experiments.get(t.experiment).map_or("", String::as_str);
        let pressure = Chart { title, x: "time, s", y: "pressure, bar", band: None, size: WIDE };
        let residual = Chart { title: "", x: "time, s", y: "residual, Pa", band: Some(2.0 * noise), size: WIDE };
        let _ = write!(
            out,
            "<div class=\"charts pair\"><figure>{}</figure><figure>{}</figure></div>",
            pressure.draw(&pressures),
            residual.draw(&residuals)
        );
    }
}

fn against(out: &mut String, found: &Diagnosed) {
    out.push_str("<h2>Residual against what the gas does</h2><p>All records, means of blocks of rows. A flat cloud within the band is noise.</p><div class=\"charts\">");
    for variable in [
        Variable::Time,
        Variable::Pressure,
        Variable::TemperatureDifference,
        Variable::Speed,
        Variable::PressureRate,
        Variable::SinceMove,
    ] {
        let mut curves = Vec::new();
        let sides = [Some(("before", &found.residuals_before)), second(found)];
        for ((label, residuals), colour) in sides.into_iter().flatten().zip([BEFORE, AFTER]) {
            let mut points = Vec::new();
            for ((t, path), r) in found.data.traces.iter().zip(&found.paths).zip(residuals) {
                let values = path.variable(variable);
                for b in &t.blocks {
                    let mean = |v: &[f64]| v[b.first..b.end].iter().sum::<f64>() / (b.end - b.first) as f64;
                    points.push((mean(&values), mean(r)));
                }
            }
            let step = points.len().div_ceil(600);
            curves.push(Curve { points: points.into_iter().step_by(step.max(1)).collect(), colour, label, dots: true });
        }
        let (name, unit) = variable.name();
        let x = format!("{name}, {unit}");
        let chart =
            Chart { title: "", x: &x, y: "residual, Pa", band: Some(2.0 * found.diagnosis.noise_pa), size: SMALL };
        let _ = write!(out, "<figure>{}</figure>", chart.draw(&curves));
    }
    out.push_str("</div>");
}

fn next(out: &mut String, d: &Diagnosis) {
    if d.next_experiments.is_empty() {
        return;
    }
    out.push_str("<h2>What to measure next</h2><ul>");
    for n in &d.next_experiments {
        let by = n
            .difference_over_noise
            .map_or(String::new(), |x| format!(" The two differ there by {} times the noise.", number(x, 2)));
        let _ = write!(
            out,
            "<li>To tell <b>{}</b> from <b>{}</b>: {}.{by}</li>",
            n.separates[0],
            n.separates[1],
            escape(&n.test)
        );
    }
    out.push_str("</ul>");
}

fn data(out: &mut String, rig: &records::Rig, found: &Diagnosed) {
    out.push_str("<h2>Data</h2>");
    for a in &found.diagnosis.assumptions {
        let _ = write!(out, "<p>{}.</p>", escape(a));
    }
    out.push_str("<table><tr><th>experiment</th><th>trace</th><th>rows</th><th>SHA-256</th></tr>");
    for e in &rig.experiments {
        for t in &e.traces {
            let file = t.path.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
            out.push_str(&row(&[&e.name, &file, &t.len().to_string(), t.sha256.get(..16).unwrap_or("")]));
        }
    }
    let _ = write!(out, "</table><p class=\"small\">pneutherm {}</p>", env!("CARGO_PKG_VERSION"));
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}
