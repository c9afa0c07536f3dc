//! Speed, accuracy and memory of rows with each effect, compared with sealed ones.
//!
//! `cargo run --release -p pneutherm-ensemble --example effect_rates` writes `results/effect_rates.md`: all cases in turn on
//! one thread, with the best time of all rounds for each few hundred rows, as the machine may have other work. Rows are those of
//! `benches/sealed.toml`, drawn at random, with one effect at its typical values. The error is the largest over the rows, against the
//! integrator at a tolerance of 1e-13. With names of cases as arguments, only sealed rows and these are run, and the page is only
//! printed.

#[path = "../tests/common/numbers.rs"]
mod numbers;

use chamber::{AreaLaw, Chamber, EffectSet, Gas, Geometry, HeatTransfer, effects};
use ensemble::{CHUNK, Failure, Kernel, Options, Outcome, Scenario, Solver};
use numbers::Numbers;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Number of rows that each case is timed on, and number of those whose errors are evaluated.
const ROWS: usize = 16 * CHUNK;
const CHECKED: usize = CHUNK;
const ROUNDS: usize = 15;
/// Set for a child process that reports the memory of a case.
const MEMORY_OF: &str = "PNEUTHERM_MEMORY_OF";

struct Case {
    name: String,
    set: EffectSet,
    /// Its effects, at typical values except for the first parameter if it is given.
    changes: Vec<(usize, Option<f64>)>,
    /// Whether gas flows in.
    flow: bool,
    rows: Vec<Scenario>,
    solver: Solver,
    /// Best times without and with the regression, by chunk.
    seconds: [[f64; ROWS / CHUNK]; 2],
}

/// The rows of `benches/sealed.toml`, at random.
fn sealed() -> Vec<Scenario> {
    let mut r = Numbers(1);
    (0..ROWS)
        .map(|_| {
            let geometry = Geometry::new(r.log_between(0.016, 0.1), 0.0, r.log_between(1e-6, 1e-5), AreaLaw::Total);
            let heat_transfer = HeatTransfer::at_paper_reference(r.between(10.0, 60.0));
            let chamber = Chamber::new(Gas::AIR, geometry, heat_transfer);
            let positions = [r.between(0.1, 0.4), r.between(0.05, 0.1)];
            Scenario::push(chamber, r.between(1e5, 7e5), positions, 0.04, 5.04)
        })
        .collect()
}

fn case(name: &str, solver: Solver, effects_and_values: &[(&str, Option<f64>)], flow: bool) -> Case {
    let place = |effect: &str| effects::find(effect).expect("an effect of that name");
    let set: EffectSet = effects_and_values.iter().map(|(effect, _)| place(effect).0).collect();
    let changes: Vec<(usize, Option<f64>)> =
        effects_and_values.iter().map(|(effect, value)| (place(effect).0, *value)).collect();
    Case {
        name: name.into(),
        set,
        changes,
        flow,
        rows: Vec::new(),
        solver,
        seconds: [[f64::INFINITY; ROWS / CHUNK]; 2],
    }
}

fn cases() -> Vec<Case> {
    let mut all = vec![
        case("sealed, as it comes (closed form)", Solver::Auto, &[], false),
        case("sealed, full equations", Solver::Adaptive, &[], false),
        case("gas_column_length, as results/model.toml", Solver::Auto, &[("gas_column_length", None)], false),
        case("constant inflow", Solver::Auto, &[], true),
        case("leakage and inflow", Solver::Auto, &[("leakage", None)], true),
        case("sensor_lag of 1 ms and inflow", Solver::Auto, &[("sensor_lag", Some(1e-3))], true),
        case("sensor_lag of 0.1 ms and inflow", Solver::Auto, &[("sensor_lag", Some(1e-4))], true),
        case("leakage and sensor_lag", Solver::Auto, &[("leakage", None), ("sensor_lag", None)], false),
        case("leakage and wall_heating", Solver::Auto, &[("leakage", None), ("wall_heating", None)], false),
        case(
            "wall_heating, natural_convection, dead_volume_surface",
            Solver::Auto,
            &[("wall_heating", None), ("natural_convection", None), ("dead_volume_surface", None)],
            false,
        ),
    ];
    for (_, card) in effects::all().filter(|(_, card)| card.name != "gas_column_length") {
        all.push(case(card.name, Solver::Auto, &[(card.name, None)], false));
    }
    all
}

impl Case {
    /// Makes its rows.
    fn fill(&mut self) {
        self.rows = sealed();
        for row in &mut self.rows {
            row.chamber = row.chamber.with_typical(self.set);
            for &(effect, value) in &self.changes {
                let first = &mut row.chamber.effects.of_mut(effect)[0];
                *first = value.unwrap_or(*first);
            }
            row.mass_flow_in_kg_per_s = if self.flow { 1e-6 } else { 0.0 };
        }
    }

    fn solve(&self, rows: &[Scenario], options: &Options) -> Vec<Outcome> {
        let mut out = vec![Outcome::failed(Failure::TooManySteps); rows.len()];
        Kernel::default().run(self.set, rows, options, &mut out);
        out
    }

    /// Solves all rows once, and keeps the times of chunks that were faster than before.
    fn time(&mut self, fit: bool) {
        let (mut kernel, options) = (Kernel::default(), self.options(fit));
        let mut out = vec![Outcome::failed(Failure::TooManySteps); CHUNK];
        // Its working memory grows with the first chunk.
        kernel.run(self.set, &self.rows[..CHUNK], &options, &mut out);
        for (rows, best) in self.rows.chunks(CHUNK).zip(&mut self.seconds[usize::from(fit)]) {
            let begun = Instant::now();
            kernel.run(self.set, rows, &options, std::hint::black_box(&mut out));
            *best = best.min(begun.elapsed().as_secs_f64());
        }
    }

    fn options(&self, fit: bool) -> Options {
        Options { solver: self.solver, fit, ..Options::default() }
    }

    fn rate(&self, fit: bool) -> f64 {
        ROWS as f64 / self.seconds[usize::from(fit)].iter().sum::<f64>()
    }

    /// Largest relative errors of the peak, final pressure and settling time.
    fn errors(&self) -> [f64; 3] {
        let rows = &self.rows[..CHECKED];
        let tight = Options { solver: Solver::Adaptive, relative_tolerance: 1e-13, fit: false };
        let mut worst = [0.0f64; 3];
        for (ours, reference) in self.solve(rows, &self.options(false)).iter().zip(self.solve(rows, &tight)) {
            let settling = |o: &Outcome| o.settling_time_s.unwrap_or(1.0);
            let pairs = [
                (ours.pressure_peak_pa, reference.pressure_peak_pa),
                (ours.pressure_final_pa, reference.pressure_final_pa),
                (settling(ours), settling(&reference)),
            ];
            for (worst, (a, b)) in worst.iter_mut().zip(pairs) {
                if b != 0.0 {
                    *worst = worst.max((a / b - 1.0).abs());
                }
            }
        }
        worst
    }

    /// Memory that a process takes to solve its rows on one thread, MB.
    fn memory(&self) -> Option<f64> {
        let output = Command::new(std::env::current_exe().ok()?).env(MEMORY_OF, &self.name).output().ok()?;
        String::from_utf8(output.stdout).ok()?.trim().parse().ok()
    }
}

/// Largest resident memory of the process so far, MB, if the system reports it.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kb| kb / 1024.0)
}

fn main() {
    if let Ok(name) = std::env::var(MEMORY_OF) {
        let mut case = cases().into_iter().find(|case| case.name == name).expect("a case of that name");
        case.fill();
        let before = resident().unwrap_or(f64::NAN);
        case.solve(&case.rows, &case.options(true));
        println!("{}", resident().unwrap_or(f64::NAN) - before);
        return;
    }
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let mut cases = cases();
    cases.retain(|case| wanted.is_empty() || case.name.starts_with("sealed") || wanted.contains(&case.name));
    cases.iter_mut().for_each(Case::fill);
    for _ in 0..ROUNDS {
        for case in &mut cases {
            for fit in [false, true] {
                case.time(fit);
            }
        }
    }
    let sealed = [false, true].map(|fit| [cases[0].rate(fit), cases[1].rate(fit)]);
    let mut page = String::from(
        "# Rows with effects beside sealed ones\n\n\
         Written by `cargo run --release -p pneutherm-ensemble --example effect_rates`. Not to be edited.\n\n\
         One thread, all cases in turn, of each 512 rows the best of fifteen rounds; rows of `benches/sealed.toml` at random, each effect at its typical values.\n\
         Rates in thousand rows a second and, in brackets, over sealed rows as they come and over sealed rows by their full\n\
         equations. *Memory*: what solving with the regression adds to the process. Errors: the largest over 512\n\
         rows, against the integrator at a tolerance of 1e-13.\n\n\
         | rows | rate | rate with the regression | memory, MB | error, peak | error, final | error, settling |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for case in &cases {
        let rates = [false, true].map(|fit| {
            let (rate, of) = (case.rate(fit), sealed[usize::from(fit)]);
            format!("{:.0} ({:.2}, {:.2})", rate / 1e3, rate / of[0], rate / of[1])
        });
        let memory = case.memory().map_or("?".into(), |mb| format!("{mb:.1}"));
        let errors = case.errors().map(|error| format!("{error:.1e}"));
        writeln!(page, "| {} | {} | {memory} | {} |", case.name, rates.join(" | "), errors.join(" | ")).unwrap();
    }
    print!("{page}");
    if !wanted.is_empty() {
        return;
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../results/effect_rates.md");
    std::fs::write(path, page).expect("results/effect_rates.md");
}
