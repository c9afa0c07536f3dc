//! `pneutherm identify`: heat transfer coefficient, dead volume and mass from measured traces.

use crate::commands::{estimates, progress};
use crate::{evaluation, output};
use identify::{Identification, Method};
use records::Rig;
use report::digits;
use std::fmt::Write;
use std::path::PathBuf;

/// Identify the heat transfer coefficient, dead volume and mass from measured traces, with 95 % intervals
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm identify examples/cylinder/rig.toml -o model.toml
  pneutherm identify examples/cylinder --method time-constant --json -

Units: lambda0 in W/(m2 K) at 5.65 bar and 293 K, dead volume in m3, mass in kg, pressure in Pa, time in s.")]
pub struct Args {
    /// The rig file, or the folder that holds its rig.toml
    rig: PathBuf,
    /// How to identify
    #[arg(long, value_enum, default_value = "exact")]
    method: Choice,
    /// Write the identified model to this file
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Write the result as JSON to this file, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Choice {
    /// Fit all traces at once, through moves and holds
    Exact,
    /// Apply the paper's seven steps to each trace, and average
    TimeConstant,
}

/// Identifies, writes the requested files, and prints the table unless standard output is in use.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let method = match args.method {
        Choice::Exact => Method::Exact,
        Choice::TimeConstant => Method::TimeConstant,
    };
    let rig = Rig::read(&args.rig)?;
    output::check(args.output.iter().chain(&args.json), output::files(&rig))?;
    let work = || evaluation::identify(&rig, method, args.output.as_deref());
    let result = progress::with_spinner("fitting the model to the records", work)?;
    if let Some(path) = &args.json {
        output::write_json(path, &result)?;
    }
    if output::is_stdout_taken([&args.output, &args.json]) { Ok(()) } else { output::print(table(&result).as_bytes()) }
}

fn table(r: &Identification) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "method {}\n", r.method);
    estimates::parameters(&mut out, &r.parameters);
    let _ =
        writeln!(out, "\n{:<22} {:>14} {:>12} {:>10} {:>12}", "experiment", "final Pa", "rise Pa", "tau s", "mass kg");
    for e in &r.experiments {
        let cell = |v: Option<f64>, significant: usize| v.map_or("-".to_owned(), |v| digits(v, significant));
        let _ = writeln!(
            out,
            "{:<22} {:>14} {:>12} {:>10} {:>12}",
            e.name,
            cell(e.final_pressure_pa, 6),
            cell(e.pressure_rise_pa, 5),
            cell(e.time_constant_s, 4),
            cell(e.mass_kg, 4)
        );
    }
    for e in &r.experiments {
        if let Some(reason) = &e.steps_refused {
            let _ = writeln!(out, "{}: no values by the paper's steps: {reason}", e.name);
        }
    }
    let held_out = r.rmse_pa.held_out.map_or(String::new(), |h| format!(", on left-out data {h:.1} Pa"));
    let _ = writeln!(out, "\nerror {:.1} Pa rms{held_out}; noise of the recording {:.1} Pa", r.rmse_pa.fit, r.noise_pa);
    if r.method == "exact" && !r.residual_is_noise {
        let _ = writeln!(out, "the residual is more than noise: `pneutherm diagnose` finds what the model lacks");
    }
    estimates::notes(&mut out, &r.undetermined, &r.assumptions);
    out
}
