//! Rust contenders on the benchmark's scenarios: `contenders NAME SCENARIOS.f64 [KEY=VALUE]...`
//!
//! Uses the protocol of `../contenders/contender.py`: prints `ready`, then for each line `go ROWS` on standard input solves the
//! first ROWS scenarios on all threads, `passes` times, and prints the seconds per pass; `save FILE` writes peak and final
//! pressure, Pa, as 64-bit floats, two per scenario.

#[cfg(feature = "peers")]
mod by_diffsol;
#[cfg(feature = "peers")]
mod by_dop853;
mod by_ours;
#[cfg(feature = "peers")]
mod equations;
mod options;
mod scenario;

use options::Options;
use scenario::{Answer, Case};
use std::io::{BufRead, Write};
use std::time::Instant;

/// Solves the scenarios into the answers, on all threads of the pool.
type Solve = Box<dyn Fn(&[Case], &mut [Answer])>;

fn main() {
    let options = Options::of_the_command_line();
    rayon::ThreadPoolBuilder::new()
        .num_threads(options.number("threads", 2.0) as usize)
        .build_global()
        .expect("threads");
    let cases = Case::read(options.scenarios.as_ref());
    let solve: Solve = match options.name.as_str() {
        "ours" => by_ours::solver(&cases, &options),
        #[cfg(feature = "peers")]
        "dop853" => by_dop853::solver(&options),
        #[cfg(feature = "peers")]
        "diffsol" => by_diffsol::solver(&options),
        other => panic!("{other} is no contender of this program, or it was built without the feature `peers`"),
    };
    serve(&cases, &solve, options.number("passes", 1.0) as usize);
}

/// Responds to lines on standard input until its end.
fn serve(cases: &[Case], solve: &Solve, passes: usize) {
    let mut answers = vec![Answer::default(); cases.len()];
    let mut solved = 0;
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let line = line.expect("standard input");
        match line.split_once(' ') {
            Some(("go", rows)) => {
                solved = rows.parse().expect("a number of rows");
                let begun = Instant::now();
                for _ in 0..passes {
                    solve(&cases[..solved], &mut answers[..solved]);
                }
                println!("{}", begun.elapsed().as_secs_f64() / passes as f64);
            }
            Some(("save", path)) => {
                let bytes: Vec<u8> =
                    answers[..solved].iter().flat_map(|a| [a.peak_pa, a.final_pa]).flat_map(f64::to_le_bytes).collect();
                std::fs::write(path, bytes).expect(path);
                println!("saved");
            }
            _ => panic!("{line}: `go ROWS` or `save FILE` was expected"),
        }
        std::io::stdout().flush().expect("standard output");
    }
}
