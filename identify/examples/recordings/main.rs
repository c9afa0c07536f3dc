//! Success of diagnoses on recordings as benches make them: every kind of `identify::synthetic::recording`, on several rigs,
//! without and with an effect.
//!
//! From the project's root: `cargo run --release -p pneutherm-identify --example recordings -- --rigs 3`; to write the
//! tables `… --rigs 12 --tolerances --out results`; for a quick look `… --rigs 1 --effects none --only held,white`.

mod grid;
mod options;
mod page;

use options::Options;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::from_arguments(std::env::args().skip(1))?;
    let jobs = grid::jobs(&options);
    let done = AtomicUsize::new(0);
    let results: Vec<grid::Row> = jobs
        .par_iter()
        .map(|job| {
            let row = job.run();
            eprintln!("{}/{} {}", 1 + done.fetch_add(1, Ordering::Relaxed), jobs.len(), row.line());
            row
        })
        .collect();
    let page = page::page(&options, &results);
    println!("{page}");
    if let Some(folder) = &options.out {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("recordings.md"), page)?;
        std::fs::write(folder.join("recordings.json"), format!("{}\n", serde_json::to_string_pretty(&results)?))?;
    }
    Ok(())
}
