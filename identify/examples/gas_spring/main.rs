//! The study of the measured gas spring, written to `results/gas_spring.json` and `.md`.
//!
//! `cargo run --release -p pneutherm-identify --example gas_spring` from the project's root; needs the two records where
//! `rigs/mbari-upper.toml` and `rigs/mbari-lower.toml` point (see there for how to get them).

use identify::gas_spring::{self, Forecast, Record};
use identify::prepare::Data;
use records::{Need, Reading, Rig, RigFile, Trace, Window};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

const OTHER_RECORD: &str = "FrictionIDMovesWithBiasCurr.exp";

#[derive(Serialize)]
struct Chamber {
    name: &'static str,
    records: Vec<Record>,
    forecasts: Vec<Forecast>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut chambers = Vec::new();
    for (name, file) in [("upper", "rigs/mbari-upper.toml"), ("lower", "rigs/mbari-lower.toml")] {
        let (moving, friction) = both(Path::new(file))?;
        eprintln!("{name} chamber");
        let records = vec![gas_spring::record(&moving, &friction)?, gas_spring::record(&friction, &moving)?];
        let forecasts = [&moving, &friction].into_iter().filter_map(|d| gas_spring::forecast(&d.traces[0])).collect();
        chambers.push(Chamber { name, records, forecasts });
    }
    std::fs::create_dir_all("results")?;
    std::fs::write("results/gas_spring.json", serde_json::to_vec_pretty(&chambers)?)?;
    std::fs::write("results/gas_spring.md", page(&chambers))?;
    println!("results/gas_spring.md, results/gas_spring.json");
    Ok(())
}

/// The rig's own record and the other one, read by the same columns.
fn both(path: &Path) -> Result<(Data, Data), Box<dyn std::error::Error>> {
    let rig = Rig::read(path).map_err(|e| {
        format!("{e}\nThe records are public: repository osrf/mbari_wec_gz, commit 71fe25a2, folder buoy_tests/test_inputdata")
    })?;
    let file = RigFile::read(path)?;
    let own = &rig.experiments[0].traces[0].path;
    let reading = Reading { layout: &file.layout, stroke_m: None, window: Window::ALL, need: Need::Measurement };
    let trace = Trace::read(&own.with_file_name(OTHER_RECORD), &reading)?;
    let mut other = rig.clone();
    other.experiments[0].traces = vec![trace];
    Ok((Data::prepare(&rig)?, Data::prepare(&other)?))
}

fn page(chambers: &[Chamber]) -> String {
    let mut out = "# The measured gas spring\n\n\
        Written by `cargo run --release -p pneutherm-identify --example gas_spring`; records and licence: `rigs/mbari-upper.toml`.\n\
        Pressures in psi rms; the record's step is 0.1 psi (0.029 psi rms).\n\n\
        ## Holds: the second half forecast from the first\n\n\
        Laws of three numbers each (final pressure, rise, time), fitted to the first half of the final hold, from 0.4 s after the stop.\n\n\
        | chamber | record | fitted, s | forecast, s | exponential (paper) | 1 − Pf/P exponential | λ ∝ (T − Tw)^¼ |\n|---|---|---|---|---|---|---|\n"
        .to_owned();
    let mut squares = [0.0; 3];
    let mut count = 0.0;
    for c in chambers {
        for f in &c.forecasts {
            let _ = writeln!(
                out,
                "| {} | {} | {:.2}–{:.2} | {:.2}–{:.2} | {:.3} | {:.3} | {:.3} |",
                c.name,
                f.record,
                f.fitted_s[0],
                f.fitted_s[1],
                f.forecast_s[0],
                f.forecast_s[1],
                f.exponential_psi,
                f.eichelberg_psi,
                f.natural_convection_psi
            );
            for (sum, v) in squares.iter_mut().zip([f.exponential_psi, f.eichelberg_psi, f.natural_convection_psi]) {
                *sum += v * v;
            }
            count += 1.0;
        }
    }
    let [a, b, c] = squares.map(|s: f64| (s / count).sqrt());
    let _ = writeln!(out, "| all | rms over the {count} holds | | | **{a:.3}** | **{b:.3}** | **{c:.3}** |\n");
    for chamber in chambers {
        carried_over(&mut out, chamber);
    }
    for chamber in chambers {
        for r in &chamber.records {
            let _ = writeln!(
                out,
                "## {} chamber, fitted on {}\n\nNoise of the quiet parts {:.3} psi. \"Other\": {} predicted with these parameters; only its initial state is its own.\n\n\
                 | effects | ΔBIC | fit | other | parameters |\n|---|---|---|---|---|",
                chamber.name, r.fitted, r.noise_psi, r.predicted
            );
            for row in &r.rows {
                let parameters: Vec<String> = row
                    .parameters
                    .iter()
                    .map(|(n, e)| format!("{n} {:.4e} ({:.3e} … {:.3e})", e.value, e.ci95[0], e.ci95[1]))
                    .collect();
                let effects = if row.effects.is_empty() { "none (paper)".to_owned() } else { row.effects.join(" + ") };
                let other = row.other_rms_psi.map_or("–".to_owned(), |o| format!("{o:.3}"));
                let _ = writeln!(
                    out,
                    "| {effects} | {:.1} | {:.3} | {other} | {} |",
                    row.delta_bic,
                    row.fit_rms_psi,
                    parameters.join("; ")
                );
            }
            out.push('\n');
        }
    }
    out
}

/// The set of effects that both records of a chamber speak for most, and which of its numbers they agree on.
fn carried_over(out: &mut String, chamber: &Chamber) {
    let [a, b] = chamber.records.as_slice() else { return };
    let both = a.rows.iter().filter_map(|r| Some((r, b.rows.iter().find(|o| o.effects == r.effects)?)));
    let best = both
        .filter(|(r, _)| !r.effects.is_empty())
        .max_by(|x, y| (x.0.delta_bic + x.1.delta_bic).total_cmp(&(y.0.delta_bic + y.1.delta_bic)));
    let Some((on_a, on_b)) = best else { return };
    let (paper_a, paper_b) = (&a.rows[0], &b.rows[0]);
    let _ = writeln!(
        out,
        "## What carries over: {} chamber\n\nBoth records speak most for **{}** (ΔBIC {:.0} and {:.0}). Fitted on one record it leaves {:.3} and {:.3} psi (the paper's model {:.3} and {:.3}); \
         the other record, predicted, {} and {} psi (the paper's model {} and {}).\n\n\
         | parameter | on {} | on {} | ratio | 95 % intervals |\n|---|---|---|---|---|",
        chamber.name,
        on_a.effects.join(" + "),
        on_a.delta_bic,
        on_b.delta_bic,
        on_a.fit_rms_psi,
        on_b.fit_rms_psi,
        paper_a.fit_rms_psi,
        paper_b.fit_rms_psi,
        psi(on_a.other_rms_psi),
        psi(on_b.other_rms_psi),
        psi(paper_a.other_rms_psi),
        psi(paper_b.other_rms_psi),
        a.fitted,
        b.fitted
    );
    for ((name, x), (_, y)) in on_a.parameters.iter().zip(&on_b.parameters) {
        let meet = x.ci95[0] <= y.ci95[1] && y.ci95[0] <= x.ci95[1];
        let shown =
            |e: &identify::uncertainty::Estimate| format!("{:.4e} ({:.3e} … {:.3e})", e.value, e.ci95[0], e.ci95[1]);
        let _ = writeln!(
            out,
            "| `{name}`, {} | {} | {} | {:.3} | {} |",
            x.unit,
            shown(x),
            shown(y),
            y.value / x.value,
            if meet { "meet" } else { "do not meet: does not carry over" }
        );
    }
    out.push('\n');
}

fn psi(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |v| format!("{v:.3}"))
}
