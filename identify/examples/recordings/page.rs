//! The tables of `results/recordings.md`.

use crate::grid::Row;
use crate::options::Options;
use identify::synthetic::recording::{ALL, Expected, Outcome};
use std::fmt::Write;

const VERDICTS: [&str; 5] = ["adequate", "explained", "improved", "unexplained", "refused"];

/// `recordings.md`: how it was made, a table of the rigs without and with an effect, the wrong names.
pub fn page(options: &Options, rows: &[Row]) -> String {
    let stated = if options.tolerances {
        "Every rig file states bore, position, ambient temperature and heat capacity ratio with errors drawn from their default \
         tolerances (standard deviations 0.5 %, 0.5 % and 0.5 mm, 2 K, 0.05 %), and its positions lie off a straight line by a wave \
         drawn from the default linearity (0.02 % of the way)."
    } else {
        "Rig files state bore, position and ambient temperature exactly where the row does not say otherwise."
    };
    let mut out = format!(
        "# Diagnosis of recordings as benches make them\n\n\
         Written by `cargo run --release -p pneutherm-identify --example recordings -- {}` (every rig in `recordings.json`): {} rigs a row, no two rows with the same ones, \
         two of three *bench* rigs (five experiments of three repeats, 100 Hz), one of three *wide* (`identify::synthetic`). {stated} Right: what such a \
         recording deserves (`identify::synthetic::recording`). Inside: the 95 % interval of λ0 holds the truth, where the model is the true one, or cannot be told from it, and the rig \
         file allows it. Error: median of |λ0 − truth|. Times are of diagnoses that run beside each other.\n\n",
        options.command, options.rigs
    );
    let clean: Vec<&Row> = rows.iter().filter(|r| r.effect.is_none()).collect();
    table(&mut out, "Rigs without an effect", &clean);
    let plain: Vec<&Row> = rows.iter().filter(|r| r.effect.is_some() && r.is_plain()).collect();
    if rows.iter().any(|r| r.effect.is_some()) {
        let faint = rows.iter().filter(|r| r.effect.is_some() && !r.is_plain()).count();
        table(&mut out, "Rigs with one plain effect", &plain);
        let _ = writeln!(
            out,
            "Plain: beyond what λ0, dead volume and initial pressures take up, the effect is at least twice the noise. {faint} rigs whose effect is fainter \
             even at four times its usual strength (the gas's heat capacity: as tables give it) are left out.\n"
        );
        by_effect(&mut out, &plain);
    }
    wrong(&mut out, rows);
    out
}

fn table(out: &mut String, title: &str, rows: &[&Row]) {
    let _ = write!(
        out,
        "## {title}\n\n| recording | expected | rigs | {} | right | alike | wrong name | missed | λ0 inside | λ0 error | time |\n|---|---|{}\n",
        VERDICTS.join(" | "),
        "---|".repeat(12)
    );
    for recording in ALL {
        let part: Vec<&Row> = rows.iter().filter(|r| r.recording == recording.name).copied().collect();
        if !part.is_empty() {
            let expected = match recording.expected {
                Expected::Adequate => "adequate".to_owned(),
                Expected::Named(names) => names.join(" or "),
                Expected::AdequateOr(names) => format!("adequate or {}", names.join(" or ")),
                Expected::NotExplained => "not explained".to_owned(),
                Expected::Refused => "error".to_owned(),
            };
            line(out, &format!("{} (`{}`)", recording.what, recording.name), &expected, &part);
        }
    }
    line(out, "**all**", "", rows);
    out.push('\n');
}

fn line(out: &mut String, what: &str, expected: &str, rows: &[&Row]) {
    let _ = write!(out, "| {what} | {expected} | {} |", rows.len());
    for verdict in VERDICTS {
        let is = |r: &&&Row| r.verdict == verdict || (verdict == "refused" && r.verdict == "panic");
        let _ = write!(out, " {} |", blank(rows.iter().filter(is).count()));
    }
    for outcome in [Outcome::Right, Outcome::Alike, Outcome::WrongName, Outcome::Missed] {
        let name = format!("{outcome:?}");
        let _ = write!(out, " {} |", blank(rows.iter().filter(|r| r.outcome == name).count()));
    }
    let judged: Vec<bool> = rows.iter().filter_map(|r| r.lambda0_inside).collect();
    let inside = judged.iter().filter(|i| **i).count();
    let errors = rows.iter().filter_map(|r| Some((r.lambda0?.0 / r.true_lambda0 - 1.0).abs())).collect();
    let share = if judged.is_empty() { "–".to_owned() } else { format!("{inside} of {}", judged.len()) };
    let error = median(errors).map_or("–".to_owned(), |e| format!("{:.2} %", 100.0 * e));
    let time = median(rows.iter().map(|r| r.seconds).collect()).unwrap_or(0.0);
    let _ = writeln!(out, " {share} | {error} | {time:.1} s |");
}

fn by_effect(out: &mut String, rows: &[&Row]) {
    out.push_str("## The same by effect\n\n| effect | rigs | right | alike | wrong name | missed | refused |\n|---|---|---|---|---|---|---|\n");
    let mut names: Vec<&str> = rows.iter().filter_map(|r| r.effect).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let part: Vec<&&Row> = rows.iter().filter(|r| r.effect == Some(name)).collect();
        let _ = write!(out, "| `{name}` | {} |", part.len());
        for outcome in Outcome::ALL {
            let outcome = format!("{outcome:?}");
            let _ = write!(out, " {} |", blank(part.iter().filter(|r| r.outcome == outcome).count()));
        }
        out.push('\n');
    }
    out.push('\n');
}

fn wrong(out: &mut String, rows: &[Row]) {
    let wrong: Vec<&Row> = rows.iter().filter(|r| r.outcome == "WrongName" && r.is_plain()).collect();
    let panics = rows.iter().filter(|r| r.verdict == "panic").count();
    let _ = writeln!(out, "## Wrong names: {}\n", wrong.len());
    for r in wrong {
        let truth = r.effect.unwrap_or("no effect");
        let _ = writeln!(
            out,
            "- {}, rig {} ({}), {truth}: {} by {}",
            r.recording,
            r.rig,
            r.kind,
            r.verdict,
            r.effects.join(" + ")
        );
    }
    if panics > 0 {
        let _ = writeln!(out, "\n{panics} diagnoses panicked.");
    }
}

fn blank(count: usize) -> String {
    if count == 0 { String::new() } else { count.to_string() }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
