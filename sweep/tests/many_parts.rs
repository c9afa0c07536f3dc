//! Memory of a run that keeps only statistics. The only test in its program, because it reads its own peak.

mod common;

use common::{at, study};
use sweep::{Options, run};

/// Peak memory of this process, MiB; `None` if the system does not report it.
fn peak_mib() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok().map(|kib| kib / 1024.0)
}

#[test]
fn memory_does_not_grow_with_the_number_of_parts() {
    let of_parts = |parts: u64| {
        let head = format!("design = \"sobol\"\nsamples = 300000\nparts = {parts}\nfit = false\nsolver = \"exact\"");
        let vary = "bore_m = { from = 0.016, to = 0.063 }\ninitial_pressure_pa = { from = 1e5, to = 7e5 }";
        let folder = tempfile::tempdir().unwrap();
        let report =
            run(&study(&head, vary), &at(&folder), Options { rows: false, ..Options::default() }, &|_: u64| {});
        assert!(report.unwrap().complete);
    };
    of_parts(4);
    let Some(before) = peak_mib() else {
        println!("skipped: this system does not tell a process's peak memory in /proc/self/status");
        return;
    };
    of_parts(600);
    let growth = peak_mib().unwrap() - before;
    println!("600 parts took {growth:.1} MiB more than 4");
    assert!(growth < 20.0, "{growth} MiB");
}
