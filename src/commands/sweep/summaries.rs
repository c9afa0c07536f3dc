//! Output of `pneutherm sweep`: about a study before it runs, and about the work done.

use super::of_shard::{parts_of, rows_of};
use crate::output;
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;
use sweep::estimate::Estimate;
use sweep::file_names;
use sweep::{Earlier, Report, Shard, Study, traces};

/// A number of parts in words.
pub fn counted(parts: u64) -> String {
    if parts == 1 { "1 part".to_owned() } else { format!("{parts} parts") }
}

/// Number of rows and estimated time of a study.
pub fn estimate_summary(study: &Study, shard: Shard, estimate: &Estimate, threads: usize) -> String {
    let (rows, parts) = (rows_of(study, shard), parts_of(study, shard).count() as u64);
    let seconds = estimate.seconds(rows, parts);
    let rate = if rows > 0 { rows as f64 / seconds } else { estimate.rows_per_second };
    let mut text = String::new();
    let _ = writeln!(text, "study      {} ({} design)", study.name, study.design.name());
    let _ = writeln!(text, "rows       {rows} in {parts} of {} parts", study.parts);
    let _ = writeln!(
        text,
        "time       {} ({:.0} rows/s on {threads} threads, from {} rows)",
        indicatif::HumanDuration(Duration::from_secs_f64(seconds.min(1e12))),
        rate,
        estimate.calibrated_rows,
    );
    text
}

/// Size of a study.
pub fn size_summary(study: &Study, shard: Shard, estimate: &Estimate) -> String {
    let bytes = estimate.bytes(rows_of(study, shard));
    format!("size       {} ({:.0} bytes/row)\n", indicatif::BinaryBytes(bytes as u64), estimate.bytes_per_row)
}

/// The work done by a shard, and whether the study is complete.
pub fn summary(folder: &Path, study: &Study, shard: Shard, report: &Report, elapsed: Duration) -> String {
    let mut text = String::new();
    if parts_of(study, shard).next().is_none() {
        let _ = writeln!(
            text,
            "{}: shard {shard} has nothing to do: the study has {}; increase `parts` in the study to divide it further",
            study.name,
            counted(study.parts)
        );
        return text;
    }
    let seconds = elapsed.as_secs_f64();
    let _ = writeln!(
        text,
        "{}: {} rows in {seconds:.2} s ({:.0} rows/s), {} in {}",
        study.name,
        report.rows_written,
        report.rows_written as f64 / seconds,
        indicatif::BinaryBytes(report.bytes),
        folder.display(),
    );
    if report.parts_found > 0 {
        let _ = writeln!(text, "{} existed already", counted(report.parts_found));
    }
    if report.parts_damaged > 0 {
        let were = if report.parts_damaged == 1 { "was damaged and has" } else { "were damaged and have" };
        let _ = writeln!(text, "{} {were} been recomputed", counted(report.parts_damaged));
    }
    for (status, count) in &report.statuses {
        let _ = writeln!(text, "{count:>12}  {status}");
    }
    if let Some(note) = output::excluded_effects(study.excluded) {
        text += &note;
    }
    for name in &report.results {
        let _ = writeln!(text, "results: {name}");
    }
    let _ = match report.complete {
        true => writeln!(text, "the study is complete ({}): manifest.json is written", counted(study.parts)),
        false => writeln!(text, "parts of other shards are missing: manifest.json is not yet written"),
    };
    text
}

/// The rows taken from a smaller study.
pub fn earlier_summary(report: &Report, earlier: &Earlier) -> String {
    let mut text = format!("{} rows taken from {}\n", report.rows_taken, earlier.folder().display());
    if earlier.damaged > 0 {
        let _ = writeln!(text, "damaged there, and solved again: {}", counted(earlier.damaged));
    }
    text
}

/// Rows with a trace, and those without.
pub fn traces_summary(report: &traces::Report) -> String {
    let mut text = format!("{}: {} samples of {} rows\n", file_names::TRACES_PATH, report.samples, report.rows);
    for (row, reason) in &report.without {
        let _ = writeln!(text, "row {row} has no trace: {reason}");
    }
    text
}
