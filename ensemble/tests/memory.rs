//! Memory stays bounded for any rows: a fast sensor with flowing gas is a filter of a known pressure and costs no steps, and a long
//! history of steps is read in smaller groups of rows.
//!
//! The rows are solved by a separate process with 256 MB of address space. `PNEUTHERM_ROWS=100000` solves as many as a study has.
#![cfg(unix)]

use chamber::{AreaLaw, Chamber, EffectSet, Gas, Geometry, HeatTransfer, effects};
use ensemble::{CHUNK, Failure, Kernel, Options, Outcome, Scenario};
use std::process::Command;

const ROWS: &str = "PNEUTHERM_ROWS";

fn rows() -> usize {
    std::env::var(ROWS).ok().and_then(|rows| rows.parse().ok()).unwrap_or(4 * CHUNK)
}

/// Runs an ignored test of this file in little memory.
fn in_little_memory(test: &str) {
    let program = std::env::current_exe().unwrap();
    let limited = format!("ulimit -v 262144 && exec '{}' --exact {test} --ignored --test-threads 1", program.display());
    let output = Command::new("sh").args(["-c", &limited]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"));
}

fn test(row: usize) -> Scenario {
    let geometry = Geometry::new(0.02 + 1e-5 * (row % 1000) as f64, 0.0, 2e-6, AreaLaw::Total);
    let chamber = Chamber::new(Gas::AIR, geometry, HeatTransfer::at_paper_reference(26.5));
    let mut scenario = Scenario::push(chamber, 1.2e5, [0.1, 0.05], 0.04, 10.0);
    scenario.mass_flow_in_kg_per_s = 1e-8 * (1 + row % 100) as f64;
    scenario
}

/// Solves rows with an effect, all of which must succeed; `value` is the effect's first parameter.
fn solve(effect: &str, value: f64) {
    let place = effects::find(effect).unwrap().0;
    let (mut kernel, options) = (Kernel::default(), Options::default());
    for first in (0..rows()).step_by(CHUNK) {
        let mut scenarios: Vec<Scenario> = (first..first + CHUNK).map(test).collect();
        scenarios.iter_mut().for_each(|s| s.chamber.effects.of_mut(place)[0] = value);
        let mut out = vec![Outcome::failed(Failure::TooManySteps); CHUNK];
        kernel.run(EffectSet::one(place), &scenarios, &options, &mut out);
        for outcome in out {
            assert_eq!(outcome.status, Ok(()));
            assert!(outcome.fit.is_some());
        }
    }
}

#[test]
fn a_lag_of_a_tenth_of_a_millisecond_over_ten_seconds_with_flows_takes_little_memory() {
    in_little_memory("solve_rows_with_a_short_lag");
}

#[test]
#[ignore = "run by the test above"]
fn solve_rows_with_a_short_lag() {
    solve("sensor_lag", 1e-4);
}
