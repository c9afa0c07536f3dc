//! `pneutherm sweep`: a parameter study of the push-and-hold test as partitioned Parquet.

use crate::output;
use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use std::fmt::Write;
use std::num::NonZero;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use sweep::estimate::{Estimate, calibrate};
use sweep::study::SOLVERS;
use sweep::{Report, Shard, Study, traces};

/// Run a parameter study of the push-and-hold test into a folder of Parquet files
///
/// Run the same command again after an interruption: finished parts stay. Shards of a study may run at the same time, on
/// several machines that share the folder; the last one writes manifest.json.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  pneutherm sweep study.toml -o out --dry-run
  pneutherm sweep study.toml -o out
  pneutherm sweep study.toml -o out --shard 3/16 --jobs 8
  pneutherm sweep study.toml -o out --traces 0,17,100-119")]
pub struct Args {
    /// The study file (TOML)
    study: PathBuf,
    /// Folder for the parts and manifest.json; made where it is absent
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Only the parts i with i mod N = I, I from 0 to N-1
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    shard: Shard,
    /// Number of threads; by default one for each processor
    #[arg(long, short, value_name = "J")]
    jobs: Option<NonZero<usize>>,
    /// Only tell the rows, the time from a short calibration, and the bytes; nothing is written
    #[arg(long)]
    dry_run: bool,
    /// How the equations are solved; in place of the study's `solver`
    #[arg(long, value_name = "NAME", value_parser = SOLVERS.map(|(name, _)| name))]
    solver: Option<String>,
    /// Relative tolerance of the integration; in place of the study's `tolerance`
    #[arg(long, value_name = "RTOL")]
    tolerance: Option<f64>,
    /// Also write the courses of these rows, sampled, into _traces.parquet: numbers and ranges such as 0,17,100-119. Of
    /// several shards the first one does
    #[arg(long, value_name = "ROWS")]
    traces: Option<traces::Rows>,
    /// Samples per second of these traces, Hz
    #[arg(long, value_name = "HZ", default_value_t = traces::RATE_HZ)]
    trace_rate: f64,
}

/// Carries out the study.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let mut study = Study::read(&args.study)?;
    if let Some(name) = &args.solver {
        study.solver = SOLVERS.iter().find(|(n, _)| n == name).map(|(_, solver)| *solver).context("unknown solver")?;
    }
    if let Some(tolerance) = args.tolerance {
        study.set_tolerance(tolerance)?;
    }
    let threads = args.jobs.map_or(0, NonZero::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("threads cannot be started")?;
    if args.dry_run {
        let estimate = pool.install(|| calibrate(&study))?;
        return output::print(estimated(&study, args.shard, &estimate, pool.current_num_threads()).as_bytes());
    }
    let bar = progress_bar(rows_of(&study, args.shard));
    let begun = Instant::now();
    let report = pool.install(|| sweep::run(&study, &args.output, args.shard, &|rows| bar.inc(rows)))?;
    bar.finish_and_clear();
    let mut text = told(args, &study, &report, begun.elapsed());
    if let Some(rows) = args.traces.as_ref().filter(|_| args.shard.index == 0) {
        text += &traced(&pool.install(|| traces::write(&study, &args.output, rows, args.trace_rate))?);
    }
    output::print(text.as_bytes())
}

/// Rows of a shard.
fn rows_of(study: &Study, shard: Shard) -> u64 {
    let mine = (0..study.parts).filter(|part| shard.has(*part));
    mine.map(|part| study.rows_of(part)).map(|rows| rows.end - rows.start).sum()
}

/// Rate and time left on standard error; hidden where that is no terminal.
fn progress_bar(rows: u64) -> ProgressBar {
    const LOOK: &str = "{bar:30} {human_pos} of {human_len} rows, {per_sec}, {eta} left";
    let bar = ProgressBar::new(rows);
    if let Ok(style) = ProgressStyle::with_template(LOOK) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}

fn estimated(study: &Study, shard: Shard, estimate: &Estimate, threads: usize) -> String {
    let rows = rows_of(study, shard);
    let mut text = String::new();
    let _ = writeln!(text, "study      {} ({} design)", study.name, study.design.name());
    let _ = writeln!(
        text,
        "rows       {rows} in {} of {} parts",
        (0..study.parts).filter(|p| shard.has(*p)).count(),
        study.parts
    );
    let _ = writeln!(
        text,
        "time       {} ({:.0} rows/s on {threads} threads, from {} rows)",
        indicatif::HumanDuration(Duration::from_secs_f64(estimate.seconds(rows).min(1e12))),
        estimate.rows_per_second,
        estimate.calibrated_rows,
    );
    let _ = writeln!(
        text,
        "size       {} ({:.0} bytes/row)",
        indicatif::BinaryBytes(estimate.bytes(rows) as u64),
        estimate.bytes_per_row,
    );
    text
}

fn told(args: &Args, study: &Study, report: &Report, elapsed: Duration) -> String {
    let mut text = String::new();
    let seconds = elapsed.as_secs_f64();
    let _ = writeln!(
        text,
        "{}: {} rows in {seconds:.2} s ({:.0} rows/s), {} in {}",
        study.name,
        report.rows_written,
        report.rows_written as f64 / seconds,
        indicatif::BinaryBytes(report.bytes),
        args.output.display(),
    );
    if report.parts_found > 0 {
        let _ = writeln!(text, "{} parts were there already", report.parts_found);
    }
    for (status, count) in &report.statuses {
        let _ = writeln!(text, "{count:>12}  {status}");
    }
    let _ = match report.complete {
        true => writeln!(text, "all {} parts are there: manifest.json is written", study.parts),
        false => writeln!(text, "parts of other shards are still missing: manifest.json is not written yet"),
    };
    text
}

fn traced(report: &traces::Report) -> String {
    let mut text = format!("{}: {} samples of {} rows\n", traces::FILE, report.samples, report.rows);
    for (row, reason) in &report.without {
        let _ = writeln!(text, "row {row} has no trace: {reason}");
    }
    text
}
