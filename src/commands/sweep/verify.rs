//! `pneutherm sweep --verify`: compares a folder with its manifest.

use super::summaries::counted;
use crate::{output, stores};
use anyhow::bail;
use std::fmt::Write;
use std::path::Path;
use sweep::file_names;
use sweep::folder::verify::Report;

/// Number of parts named when a folder does not match its manifest.
const NAMED: usize = 5;

pub fn verify(folder: &Path) -> anyhow::Result<()> {
    let report = sweep::verify(&*stores::open(folder)?)?;
    if let Some(first) = report.foreign.first() {
        let others =
            if report.foreign.len() > 1 { format!(" and {} more", report.foreign.len() - 1) } else { String::new() };
        bail!(
            "{}: {first}{others}: not named in manifest.json; readers read every file of that folder, so move it elsewhere",
            folder.display()
        );
    }
    match differences(&report) {
        None => output::print(verified_summary(folder, &report).as_bytes()),
        Some(differences) => bail!("{}: {differences}; run the study again to recompute them", folder.display()),
    }
}

/// Differences from the manifest, if any.
fn differences(report: &Report) -> Option<String> {
    let differences: Vec<String> =
        [of_parts(report), of_results(report), of_traces(report)].into_iter().flatten().collect();
    (!differences.is_empty()).then(|| differences.join("; "))
}

/// Differences of the parts, the first of them by name.
fn of_parts(Report { parts, wrong, .. }: &Report) -> Option<String> {
    let named = wrong.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join("; ");
    let more = match wrong.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    let text = || format!("{} of {parts} parts do not agree with manifest.json: {named}{more}", wrong.len());
    (!wrong.is_empty()).then(text)
}

/// Differences of the statistics, the sensitivity indices and the traces.
fn of_results(Report { wrong_results, .. }: &Report) -> Option<String> {
    let text = || format!("results do not agree with manifest.json: {}", wrong_results.join("; "));
    (!wrong_results.is_empty()).then(text)
}

/// How to rewrite wrong traces, which the study does not request itself.
fn of_traces(Report { wrong_results, .. }: &Report) -> Option<String> {
    let are_wrong = wrong_results.iter().any(|result| result.starts_with(file_names::TRACES_PATH));
    are_wrong.then(|| "traces are written again with --traces".to_owned())
}

/// Summary of what was verified.
fn verified_summary(folder: &Path, report: &Report) -> String {
    let Report { rows, parts, bytes, results, not_covered, .. } = report;
    let (parts, bytes) = (counted(*parts as u64), indicatif::BinaryBytes(*bytes));
    let results: String = results.iter().map(|result| format!(", {result}")).collect();
    let mut text = format!("{}: {rows} rows, {parts}, {bytes}{results}: agree with manifest.json\n", folder.display());
    if !not_covered.is_empty() {
        let _ = writeln!(
            text,
            "not named in manifest.json, so not compared: {}; to have them named, run the study again (for traces with --traces)",
            not_covered.join(", ")
        );
    }
    text
}
