//! `pneutherm diagnose`: closes the loop between measured traces and the model.

use crate::commands::{estimates, progress};
use crate::{evaluation, output};
use chamber::words::listed;
use identify::outcome::diagnosis::{Diagnosis, Step};
use identify::outcome::empirical::Empirical;
use identify::outcome::estimates::Rmse;
use identify::outcome::unnamed::Unnamed;
use records::{Rig, Verdict};
use report::{digits, seconds};
use std::fmt::Write;
use std::path::PathBuf;

/// Find which effects the paper's model lacks, with the error before and after on left-out records
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  pneutherm diagnose examples/cylinder/rig.toml -o model.toml --report report.html
  pneutherm diagnose examples/cylinder --json diagnosis.json

The verdict:
  adequate     the residual of the paper's model is noise, or below the accuracy asked for
  explained    with the named effects the residual is noise, or under 2 % of that without them,
               or under 10 % and below the accuracy asked for
  improved     named effects or a curve predict left-out data decisively better, but need not be the
               cause, in most cases because the residual is more than noise
  unexplained  no known effect predicts left-out data decisively better")]
pub struct Args {
    /// The rig file, or the folder that holds its rig.toml
    rig: PathBuf,
    /// Write the model to this file: with the effects found, or the paper's model if there are none
    #[arg(short, long, value_name = "MODEL.toml")]
    output: Option<PathBuf>,
    /// Write the model only if the verdict is `adequate` or `explained`; otherwise exit with an error
    #[arg(long, requires = "output")]
    strict: bool,
    /// Write the result as JSON to this file, `-` for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a report to this file: one self-contained page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Number of effect sets shown in the table.
const SHOWN: usize = 24;

/// Diagnoses, writes the requested files, and prints the table unless standard output is in use.
pub fn run(args: &Args) -> anyhow::Result<()> {
    let rig = Rig::read(&args.rig)?;
    output::check(args.output.iter().chain(&args.json).chain(&args.report), output::files(&rig))?;
    let bar = progress::bar(100, "{bar:30} {percent:>3} % {msg}");
    let found = evaluation::diagnose(&rig, args.report.as_deref(), &|what, fraction| {
        bar.set_message(what.to_owned());
        bar.set_position((fraction * 100.0) as u64);
    });
    bar.finish_and_clear();
    let found = found?;
    if let Some(path) = &args.json {
        output::write_json(path, &found.diagnosis)?;
    }
    if let Some(path) = &args.output {
        let verdict = found.diagnosis.verdict;
        if args.strict && !matches!(verdict, Verdict::Adequate | Verdict::Explained) {
            anyhow::bail!(
                "{}: not written, because --strict requires `adequate` or `explained` and the verdict is `{}`",
                path.display(),
                verdict.name()
            );
        }
        evaluation::write_diagnosed(&rig, &found, path)?;
    }
    if output::is_stdout_taken([&args.output, &args.json, &args.report]) {
        Ok(())
    } else {
        output::print(table(&found.diagnosis).as_bytes())
    }
}

/// What the verdict means in this case, as a sentence.
fn meaning(d: &Diagnosis) -> String {
    match d.verdict {
        Verdict::Adequate => format!(
            "the paper's model{} describes the records: {}",
            if d.terms().is_empty() { String::new() } else { format!(", with {},", d.terms()) },
            d.remainder
        ),
        Verdict::Explained => format!("the residual is explained by {}", listed(&d.effects)),
        Verdict::Improved if d.has_curve() => format!(
            "with {} the model predicts left-out experiments decisively better; the curve describes the records and names no cause ({})",
            listed(&d.each_term().collect::<Vec<_>>()),
            d.remainder
        ),
        Verdict::Improved => format!(
            "with {} the model {} {}. It describes the records; its effects need not be the cause",
            listed(&d.each_term().collect::<Vec<_>>()),
            d.gain(),
            d.remainder
        ),
        Verdict::Unexplained => {
            format!("no known effect predicts left-out data decisively better; {}, and {}", d.remainder, d.pointed_at())
        }
    }
}

fn table(d: &Diagnosis) -> String {
    let mut out = format!("{}: {}\n\n", d.verdict.name(), meaning(d));
    errors(&mut out, d);
    estimates::parameters(&mut out, &d.after.parameters);
    recording(&mut out, d);
    candidates(&mut out, d);
    for group in &d.indistinguishable {
        let _ = writeln!(out, "\nthe data cannot distinguish: {}", group.join(", "));
    }
    if let Some(e) = &d.empirical {
        empirical(&mut out, e);
    }
    for m in d.missing.iter().take(3) {
        missing(&mut out, m);
    }
    for n in &d.next_experiments {
        let [one, other] = &n.separates;
        let by = n.difference_over_noise;
        let _ =
            writeln!(out, "\nto distinguish {one} from {other}: {} (they differ by {by:.1} times the noise)", n.test);
    }
    estimates::notes(&mut out, &d.undetermined, &d.assumptions);
    out
}

/// The errors of the paper's model and of each step after it; also with each row weighted, where that differs.
fn errors(out: &mut String, d: &Diagnosis) {
    let error = |rmse: &Rmse| {
        let held_out = rmse.held_out.map_or("-".to_owned(), |h| format!("{h:.1}"));
        format!("{:>10.1} {held_out:>12}", rmse.fit)
    };
    let rows = |out: &mut String, of_step: &dyn Fn(&Step) -> Rmse| {
        for step in &d.steps {
            let name = match step.terms.as_str() {
                "" => "the paper's model".to_owned(),
                terms => format!("with {terms}"),
            };
            let _ = writeln!(out, "{}   {name}", error(&of_step(step)));
        }
    };
    let _ = writeln!(out, "error, Pa rms        fit     left out     (noise of the recording {:.1})", d.noise_pa);
    rows(out, &|step| step.rmse_pa);
    if d.is_error_of_moves() {
        out.push_str("weighed: in fast moves a row counts less, as the positions leave its pressure uncertain\n");
        rows(out, &|step| step.weighed_pa);
    }
    out.push('\n');
}

/// The effect sets tried, with the evidence for each.
fn candidates(out: &mut String, d: &Diagnosis) {
    let _ = writeln!(out, "\n{:>10} {:>12}   effects tried", "delta BIC", "left out, Pa");
    for c in d.candidates.iter().take(SHOWN) {
        let held_out = c.held_out_rmse_pa.map_or("-".to_owned(), |h| format!("{h:.1}"));
        let _ = writeln!(out, "{:>10.1} {held_out:>12}   {}", c.delta_bic, c.effect);
    }
}

/// The recording's noise, the contributions to the interval of λ0, and each effect's probability.
fn recording(out: &mut String, d: &Diagnosis) {
    let n = &d.noise;
    let mut parts = vec![format!("white {} Pa", digits(n.white_pa, 3))];
    let coloured = digits(n.coloured_pa, 3);
    let hum = n.hum_hz.map(|hz| digits(hz, 3));
    match hum {
        Some(hz) if n.correlation_s == 0.0 => parts.push(format!("hum of {coloured} Pa at {hz} Hz")),
        _ if n.coloured_pa > 0.0 => {
            let time = seconds(n.correlation_s, 2);
            parts.push(format!("coloured {coloured} Pa with a correlation time of {time}"));
            parts.extend(hum.map(|hz| format!("in it a hum at {hz} Hz")));
        }
        _ => {}
    }
    if n.step_pa > 0.0 {
        parts.push(format!("steps of {} Pa", digits(n.step_pa, 3)));
    }
    parts.extend(n.readout_hz.map(|hz| format!("read at {} Hz", digits(hz, 3))));
    parts.push(format!("{} outlier{} left out", n.outliers, if n.outliers == 1 { "" } else { "s" }));
    let _ = writeln!(out, "\nnoise: {}", parts.join(", "));
    let shares: Vec<String> = d
        .lambda0_budget
        .iter()
        .filter(|b| b.share > 0.005)
        .map(|b| format!("{} {:.0} %", b.source, 100.0 * b.share))
        .collect();
    let _ = writeln!(out, "variance of lambda0 by source: {}", shares.join(", "));
    let likely: Vec<String> =
        d.probabilities.iter().filter(|(_, p)| *p > 0.2).map(|(e, p)| format!("{e} {:.0} %", 100.0 * p)).collect();
    if !likely.is_empty() {
        let _ = writeln!(out, "{}: {}", d.meaning_of_probabilities(), likely.join(", "));
    }
}

/// The missing term as a curve.
fn empirical(out: &mut String, e: &Empirical) {
    let ((quantity, unit), (variable, variable_unit)) = (e.subject.quantity(), e.subject.variable.name());
    let _ = writeln!(
        out,
        "\n{}: {} as a curve over {}; error on left-out data {} -> {} Pa",
        if e.fate.is_accepted() { "in the model".to_owned() } else { format!("rejected, because {}", e.fate.words()) },
        quantity,
        variable,
        digits(e.left_out_rmse_pa.without, 3),
        digits(e.left_out_rmse_pa.with, 3)
    );
    let [variable_unit, unit] = [variable_unit, unit].map(shown);
    for ((at, value), [low, high]) in e.knots.iter().zip(&e.values).zip(&e.ci95) {
        let (at, value, low, high) = (digits(*at, 4), digits(*value, 3), digits(*low, 3), digits(*high, 3));
        let line = format!("   at {at:>11} {variable_unit:<5} {value:>11} ({low} … {high}) {unit}");
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// A missing term as a function of its variable.
fn missing(out: &mut String, m: &Unnamed) {
    let ((quantity, unit), (variable, variable_unit)) = (m.subject.quantity(), m.subject.variable.name());
    let _ = writeln!(
        out,
        "\na {} as a function of {} would explain {:.0} % of the residual beyond noise ({} balance)",
        quantity,
        variable,
        100.0 * m.share,
        m.balance
    );
    let [variable_unit, unit] = [variable_unit, unit].map(shown);
    for ((at, value), sd) in m.at.iter().zip(&m.value).zip(&m.sd) {
        let (at, value, sd) = (digits(*at, 4), digits(*value, 3), digits(*sd, 2));
        let line = format!("   at {at:>11} {variable_unit:<5} {value:>11} ± {sd} {unit}");
        let _ = writeln!(out, "{}", line.trim_end());
    }
}

/// A unit as written after a number: nothing for a dimensionless one, which is 1.
fn shown(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identify::synthetic::Recipe;

    fn diagnosis() -> Diagnosis {
        let mut recipe = Recipe { repeats: 1, ..Recipe::from_seed(5) };
        recipe.tests.truncate(2);
        identify::diagnose(&recipe.rig(), &|_, _| ()).unwrap().diagnosis
    }

    #[test]
    fn noise_is_reported_with_its_correlation_time() {
        let mut d = diagnosis();
        let mut text = |coloured_pa, correlation_s, hum_hz| {
            (d.noise.coloured_pa, d.noise.correlation_s, d.noise.hum_hz) = (coloured_pa, correlation_s, hum_hz);
            let mut out = String::new();
            recording(&mut out, &d);
            out
        };
        assert!(!text(0.0, 0.0, None).contains("coloured"));
        assert!(text(80.0, 0.0032, None).contains("coloured 80.0 Pa with a correlation time of 3.2 ms"));
        // A pure hum has no correlation time.
        let hum = text(80.0, 0.0, Some(52.5));
        assert!(hum.contains("hum of 80.0 Pa at 52.5 Hz") && !hum.contains("correlation time"), "{hum}");
        assert!(text(80.0, 0.7, Some(52.5)).contains("correlation time of 0.70 s, in it a hum at 52.5 Hz"));
    }

    #[test]
    fn odds_beside_a_model_that_needs_no_effect_are_called_hints() {
        let mut d = diagnosis();
        assert_eq!(d.verdict, Verdict::Adequate);
        d.probabilities = vec![("tube_volume".to_owned(), 0.78)];
        let mut out = String::new();
        recording(&mut out, &d);
        assert!(out.contains("hints of effects, none of which is needed") && out.contains("tube_volume 78 %"), "{out}");
        assert!(!out.contains("probable effects"));
    }

    #[test]
    fn a_verdict_states_what_remains_and_no_number_where_there_is_none() {
        let mut d = diagnosis();
        (d.verdict, d.effects, d.balance) = (Verdict::Unexplained, Vec::new(), "none");
        d.remainder = "a systematic misfit of 12.0 Pa rms remains".to_owned();
        assert!(meaning(&d).ends_with("12.0 Pa rms remains, and nothing points to one of the balances"));
        (d.verdict, d.remaining_pa) = (Verdict::Improved, 0.0);
        d.remainder =
            "what remains has a shape that noise does not have, although it is smaller than the accuracy of 30 Pa"
                .to_owned();
        assert!(!meaning(&d).contains("misfit of 0 Pa"), "{}", meaning(&d));
    }

    #[test]
    fn an_improved_model_is_reported_to_predict_better_only_where_it_does() {
        let mut d = diagnosis();
        d.verdict = Verdict::Improved;
        d.steps.push(d.steps[0].clone());
        let mut text = |plain: f64, weighed: f64| {
            for (step, ratio) in d.steps.iter_mut().zip([1.0, plain]) {
                step.rmse_pa.held_out = Some(400.0 * ratio);
            }
            for (step, ratio) in d.steps.iter_mut().zip([1.0, weighed]) {
                step.weighed_pa.held_out = Some(20.0 * ratio);
            }
            meaning(&d)
        };
        assert!(text(0.5, 0.5).contains("predicts left-out data decisively better"));
        assert!(text(1.2, 0.5).contains("predicts left-out data decisively better"));
        assert!(text(1.2, 1.2).contains("is far likelier, but its error on left-out data is no smaller, and"));
    }

    #[test]
    fn errors_that_the_positions_leave_open_in_moves_are_also_reported_weighed() {
        let mut d = diagnosis();
        let text = |d: &Diagnosis| {
            let mut out = String::new();
            errors(&mut out, d);
            out
        };
        assert!(!text(&d).contains("weighed"), "{}", text(&d));
        let step = d.steps.last_mut().unwrap();
        step.rmse_pa = Rmse { fit: 2994.0, held_out: Some(3105.0) };
        step.weighed_pa = Rmse { fit: 470.0, held_out: Some(480.0) };
        let text = text(&d);
        let lines: Vec<&str> = text.trim_end().lines().collect();
        assert_eq!(
            lines[1..],
            [
                "    2994.0       3105.0   the paper's model",
                "weighed: in fast moves a row counts less, as the positions leave its pressure uncertain",
                "     470.0        480.0   the paper's model",
            ]
        );
    }
}
