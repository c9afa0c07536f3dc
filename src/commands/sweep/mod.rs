//! `pneutherm sweep`: a parameter study of the push-and-hold test as partitioned Parquet.

mod of_shard;
mod summaries;
mod verify;

use super::progress::{Progress, ProgressFormat};
use crate::{interrupt, output, stores, study_pictures};
use anyhow::{Context, bail};
use of_shard::{parts_of, rows_of};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;
use summaries::{earlier_summary, estimate_summary, size_summary, summary, traces_summary};
use sweep::estimate::{Estimate, calibrate, most_bytes};
use sweep::file_names;
use sweep::folder::Folder;
use sweep::study_file::{Overrides, SOLVERS};
use sweep::{Earlier, Options, Shard, Store, Study, traces};

/// Run a parameter study of the push-and-hold test and write it as a folder of Parquet files
///
/// After an interruption run the same command again: finished parts are kept. Shards of a study may run at the same time, on
/// several machines that share the folder. The last one writes manifest.json.
#[derive(clap::Args)]
#[command(after_help = "\
The [vary] table of a study takes values, ranges and distributions (normal, log-normal, uniform, triangular, empirical). \
from = \"model\" draws the parameters that identify or diagnose found, with their correlations.

Examples:
  pneutherm sweep study.toml -o out --dry-run
  pneutherm sweep study.toml -o out
  pneutherm sweep study.toml -o out --shard 3/16 --jobs 8
  pneutherm sweep study.toml -o out --traces 0,17,100-119
  pneutherm sweep study.toml -o out --no-rows
  pneutherm sweep more_samples.toml -o more --extend out
  pneutherm sweep --verify out")]
pub struct Args {
    /// The study file (TOML)
    #[arg(required_unless_present = "verify")]
    study: Option<PathBuf>,
    /// Folder for the study, with its rows in rows/ and manifest.json; created if it does not exist. A build with the feature
    /// object-store also takes s3://bucket/prefix
    #[arg(short, long, value_name = "DIR", required_unless_present = "verify")]
    output: Option<PathBuf>,
    /// Read the folder of a finished study and compare every part, the statistics, the sensitivity indices and the traces with
    /// their SHA-256 in manifest.json
    #[arg(long, value_name = "DIR", exclusive = true)]
    verify: Option<PathBuf>,
    /// Compute only the parts i with i mod N = I, where I is 0 to N-1
    #[arg(long, value_name = "I/N", default_value_t = Shard::WHOLE)]
    shard: Shard,
    /// Number of threads, 1 to 1024; by default one per processor
    #[arg(long, short, value_name = "J", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Print the number of rows, the estimated time and size, and leave nothing on the disk
    #[arg(long)]
    dry_run: bool,
    /// How to solve the equations; overrides the study's `solver`
    #[arg(long, value_name = "NAME", value_parser = SOLVERS.map(|(name, _)| name))]
    solver: Option<String>,
    /// Relative tolerance of the integration; overrides the study's `tolerance`
    #[arg(long, value_name = "RTOL")]
    tolerance: Option<f64>,
    /// Also write time series of these rows to traces/traces.parquet: numbers and ranges such as 0,17,100-119. With shards,
    /// the first shard writes them
    #[arg(long, value_name = "ROWS")]
    traces: Option<traces::RowNumbers>,
    /// Sampling rate of these time series, Hz
    #[arg(long, value_name = "HZ", default_value_t = traces::RATE_HZ, requires = "traces")]
    trace_rate: f64,
    /// Keep only statistics.json, no rows: the study's [statistics], or those of every result
    #[arg(long)]
    no_rows: bool,
    /// Take rows from the folder of a smaller study instead of solving them again: fewer samples of a sobol or saltelli design,
    /// fewer values of the first axis of a factorial design, or fewer rows of a table
    #[arg(long, value_name = "DIR")]
    extend: Option<PathBuf>,
    /// How to report progress on standard error
    #[arg(long, value_name = "HOW", value_enum, default_value_t = ProgressFormat::Bar)]
    progress: ProgressFormat,
}

/// Runs the study.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let threads = args.jobs.map_or(0, usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("the threads cannot be started")?;
    if let Some(folder) = &args.verify {
        return pool.install(|| verify::verify(folder));
    }
    let (Some(path), Some(folder)) = (&args.study, &args.output) else {
        bail!("expected a study file and an output folder")
    };
    if output::is_stdout(folder) {
        bail!("-: a study is a folder of files, which standard output cannot take; name a folder");
    }
    let solver = SOLVERS.iter().find(|(name, _)| Some(*name) == args.solver.as_deref()).map(|(_, solver)| *solver);
    let study = Study::read_with(path, Overrides { solver, tolerance: args.tolerance })?;
    // Report impossible requests before any work.
    let traces = args.traces.as_ref().filter(|_| args.shard.index == 0);
    if let Some(rows) = traces {
        traces::check(&study, rows, args.trace_rate)?;
    }
    let store = stores::open(folder)?;
    if args.dry_run {
        Folder::open(&study, &*store)?;
        let estimate = pool.install(|| calibrate(&study, folder, !args.no_rows))?;
        print_notes(&study.notes, path);
        warn_about_space(&*store, &study, args, "about", |rows| estimate.bytes(rows) as u64);
        return output::print(promised(&study, args, &estimate, pool.current_num_threads()).as_bytes());
    }
    let smaller = args.extend.as_deref().map(stores::open).transpose()?;
    let earlier = smaller.as_deref().map(|store| pool.install(|| Earlier::open(&study, store))).transpose()?;
    print_notes(&study.notes, path);
    warn_about_space(&*store, &study, args, "up to", |rows| most_bytes(&study, rows));
    interrupt::ends_the_program(Some("interrupted: finished parts are kept; run the same command again to continue"));
    let options = Options { shard: args.shard, rows: !args.no_rows, earlier: earlier.as_ref() };
    let progress = Progress::new(args.progress, rows_of(&study, args.shard));
    let begun = Instant::now();
    let mut report = progress.during(|progress| pool.install(|| sweep::run(&study, &*store, options, progress)))?;
    report.results.extend(study_pictures::write(&*store, &report.results)?);
    let mut text = summary(folder, &study, args.shard, &report, begun.elapsed());
    if let Some(earlier) = &earlier {
        text += &earlier_summary(&report, earlier);
    }
    if let Some(rows) = traces {
        text += &traces_summary(&pool.install(|| traces::write(&study, &*store, rows, args.trace_rate))?);
    }
    output::print(text.as_bytes())?;
    match report.why_without_results() {
        None => Ok(()),
        Some((reason, rows)) => bail!(
            "{}: no row of the study has a result; the most frequent reason ({rows} of {} rows): {reason}",
            folder.display(),
            study.rows
        ),
    }
}

/// A dry run's summary of a study.
fn promised(study: &Study, args: &Args, estimate: &Estimate, threads: usize) -> String {
    let size = match args.no_rows {
        true => "size       statistics only, no rows\n".to_owned(),
        false => size_summary(study, args.shard, estimate),
    };
    estimate_summary(study, args.shard, estimate, threads) + &size
}

/// Reports ineffective settings in the study file.
fn print_notes(notes: &[String], path: &Path) {
    notes.iter().for_each(|note| output::note(&format!("{}: {note}", path.display())));
}

/// Warns if there is not enough space for the rows still to be written; `bytes` is the size for a number of rows.
fn warn_about_space(store: &dyn Store, study: &Study, args: &Args, about: &str, bytes: impl Fn(u64) -> u64) {
    let Some(free) = store.free().filter(|free| !args.no_rows && bytes(rows_of(study, args.shard)) > *free) else {
        return;
    };
    let there: HashSet<String> = store.names(file_names::ROWS).unwrap_or_default().into_iter().collect();
    let missing = parts_of(study, args.shard).filter(|part| !there.contains(&study.part_name(*part)));
    let bytes = bytes(missing.map(|part| study.rows_of(part)).map(|rows| rows.end - rows.start).sum());
    if bytes > free {
        let (bytes, free) = (indicatif::BinaryBytes(bytes), indicatif::BinaryBytes(free));
        output::note(&format!(
            "{}: the rows take {about} {bytes}, and the disk has {free} left",
            store.location().display()
        ));
    }
}
