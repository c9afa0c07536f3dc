//! Measures the cost of statistics: rows of a study on one thread, solved only, and with statistics of every column. The two
//! alternate; the best time of each counts, since the machine may have other work.
//!
//! cargo run --release --example statistics_rate -- benches/sealed.toml

use std::time::Instant;
use sweep::Study;
use sweep::row::chunk::CHUNK;
use sweep::row::solve::RowSolver;
use sweep::run::work::{Work, Workers};
use sweep::study::plan::Plan;

/// Rows per turn: some ten milliseconds, which other work may leave undisturbed. The first rows of a part cost most: they
/// determine the spacing of its numbers.
const ROWS: u64 = 16 * CHUNK;
const TURNS: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: statistics_rate STUDY.toml")?;
    let study = Study::read(path.as_ref())?;
    let rows = ROWS.min(study.rows);
    let plan = Plan::all(study.outputs());
    let mut solver = RowSolver::new(&study);
    let with_statistics = Work { plan: Some(&plan), workers: Workers::One, ..Work::new(&study, &|_: u64| {}) };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..TURNS {
        let begun = Instant::now();
        for first in (0..rows).step_by(CHUNK as usize) {
            std::hint::black_box(solver.rows(first..rows.min(first + CHUNK))?);
        }
        best[0] = best[0].min(begun.elapsed().as_secs_f64());
        let begun = Instant::now();
        std::hint::black_box(with_statistics.write(0..rows, None)?);
        best[1] = best[1].min(begun.elapsed().as_secs_f64());
    }
    let [plain, statistics] = best.map(|seconds| rows as f64 / seconds);
    println!("solved only       {plain:.0} rows/s");
    println!("with statistics   {statistics:.0} rows/s, {:.1} %", 100.0 * statistics / plain);
    Ok(())
}
