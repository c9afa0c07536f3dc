//! `pneutherm diagnose`: closes the loop between measured traces and the model.

use crate::commands::estimates;
use crate::{evaluation, output};
use identify::diagnosis::{Closest, Diagnosis, Rmse, Unnamed};
use identify::report::number;
use std::fmt::Write;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Find what the model lacks: the residual, the effect that causes it, the error before and after on held-out traces
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm diagnose examples/cylinder/rig.toml -o model.toml --report report.html
  pneutherm diagnose examples/cylinder --json diagnosis.json

The verdict: `adequate`, the paper's model leaves no more than noise; `explained`, with the effects that it lacks; \
`unexplained`, something is there that no known effect accounts for. Pressures in Pa, other units by name.")]
pub struct Args {
    /// The rig file, or the folder that holds its rig.toml
    rig: PathBuf,
    /// Write the model to go on with to this file: with the effects found, the paper's where there are none
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Where no known effects explain the residual: write the model of those that come closest, not the paper's
    #[arg(long, requires = "output")]
    closest: bool,
    /// Write the result as JSON to this file, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a report for people to this file: one self-contained page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Diagnoses, writes what was asked for, and prints the table unless standard output is taken.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let bar = progress_bar();
    let model = args.output.as_deref().filter(|_| !args.closest);
    let found = evaluation::diagnose(&args.rig, model, args.report.as_deref(), &|what, share| {
        bar.set_message(what.to_owned());
        bar.set_position((share * 100.0) as u64);
    });
    bar.finish_and_clear();
    let found = found?;
    if let Some(path) = args.output.as_ref().filter(|_| args.closest) {
        evaluation::write_closest(&args.rig, &found, path)?;
    }
    if let Some(path) = &args.json {
        output::write(path, &[serde_json::to_vec_pretty(&found.diagnosis)?, b"\n".to_vec()].concat())?;
    }
    let taken = [&args.output, &args.json, &args.report].into_iter().flatten().any(|p| output::is_stdout(p));
    if taken { Ok(()) } else { output::print(table(&found.diagnosis).as_bytes()) }
}

/// A bar on standard error, on a terminal only.
fn progress_bar() -> indicatif::ProgressBar {
    if !std::io::stderr().is_terminal() {
        return indicatif::ProgressBar::hidden();
    }
    let bar = indicatif::ProgressBar::new(100);
    if let Ok(style) = indicatif::ProgressStyle::with_template("{bar:30} {percent:>3} % {msg}") {
        bar.set_style(style);
    }
    bar
}

fn table(d: &Diagnosis) -> String {
    let mut out = String::new();
    let what = match d.verdict {
        "adequate" => "the paper's model leaves no more than noise".to_owned(),
        "explained" => format!("the residual is explained by {}", d.effects.join(" and ")),
        _ => format!(
            "no known effect accounts for all of the residual; what is missing points to the {} balance",
            d.balance
        ),
    };
    let _ = writeln!(out, "{}: {what}\n", d.verdict);
    let error = |rmse: &Rmse| {
        let held_out = rmse.held_out.map_or("-".to_owned(), |h| format!("{h:.1}"));
        format!("{:>10.1} {held_out:>12}", rmse.fit)
    };
    let _ = writeln!(out, "error, Pa rms        fit     held out     (noise of the sensor {:.1})", d.noise_pa);
    let _ = writeln!(out, "before       {}", error(&d.before.rmse_pa));
    let _ = writeln!(out, "after        {}", error(&d.after.rmse_pa));
    if let Some(c) = &d.closest {
        let _ = writeln!(out, "closest      {}", error(&c.rmse_pa));
    }
    out.push('\n');
    estimates::parameters(&mut out, &d.after.parameters);
    if let Some(c) = &d.closest {
        closest(&mut out, c);
    }
    let _ = writeln!(out, "\n{:<44} {:>12} {:>14}", "effects tried", "delta BIC", "held out Pa");
    for c in &d.candidates {
        let held_out = c.held_out_rmse_pa.map_or("-".to_owned(), |h| format!("{h:.1}"));
        let _ = writeln!(out, "{:<44} {:>12.1} {held_out:>14}", c.effect, c.delta_bic);
    }
    for group in &d.indistinguishable {
        let _ = writeln!(out, "\nthe data cannot tell apart: {}", group.join(", "));
    }
    for m in d.missing.iter().take(3) {
        missing(&mut out, m);
    }
    for n in &d.next_experiments {
        let by = n.difference_over_noise.map_or(String::new(), |d| format!(" (they differ by {d:.1} times the noise)"));
        let _ = writeln!(out, "\nto tell {} from {}: {}{by}", n.separates[0], n.separates[1], n.test);
    }
    estimates::notes(&mut out, &d.undetermined, &d.assumptions);
    out
}

/// The known effects that come closest to a residual that they do not explain.
fn closest(out: &mut String, c: &Closest) {
    let _ = writeln!(
        out,
        "\nclosest: {} take away {:.1} % of what is beyond noise (delta BIC {:.1}), but clearly more than noise remains:\na description of these traces, not yet a cause (--closest writes it as a model)",
        c.effects.join(" + "),
        100.0 * c.share,
        c.delta_bic
    );
    for (first, rest) in c.indistinguishable.iter().filter_map(|group| group.split_first()) {
        let _ = writeln!(out, "as close would come {} in place of {first}", rest.join(" or "));
    }
    estimates::parameters(out, &c.parameters);
}

/// A missing term as a function of what it follows.
fn missing(out: &mut String, m: &Unnamed) {
    let _ = writeln!(
        out,
        "\nmissing: {} as a function of {} would take away {:.0} % of what is beyond noise ({} balance)",
        m.quantity,
        m.variable,
        100.0 * m.share,
        m.balance
    );
    for ((at, value), sd) in m.at.iter().zip(&m.value).zip(&m.sd) {
        let _ = writeln!(
            out,
            "   at {:>11} {:<5} {:>11} ± {} {}",
            number(*at, 4),
            m.variable_unit,
            number(*value, 3),
            number(*sd, 2),
            m.unit
        );
    }
}
