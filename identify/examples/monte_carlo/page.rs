//! Tables and figures from the sets' lines: `results/diagnosis.md`, `diagnosis_rates.svg`, `diagnosis_reliability.svg`.

use crate::sets::{INTERVALS, STRENGTHS};
use crate::{figure, reliability};
use chamber::effects::CARDS;
use identify::policy::ACCURACY_OF_NOISE;
use identify::synthetic::simulated;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// One line of a file of sets.
#[derive(Clone)]
struct Line {
    study: String,
    wide: bool,
    truth: String,
    strength: f64,
    verdict: String,
    named: String,
    alike: String,
    seconds: f64,
    deviations: Vec<(String, f64)>,
    probabilities: Vec<(String, f64)>,
    /// Error on left-out data, relative to the noise.
    left_out: f64,
    /// What each effect leaves beside the others, relative to the noise.
    shows: Vec<(String, f64)>,
}

impl Line {
    /// Whether the true effects are named, in any order.
    fn is_named(&self) -> bool {
        let parts = |s: &str| {
            let mut parts: Vec<String> = s.split('+').map(str::to_owned).collect();
            parts.sort();
            parts
        };
        self.verdict == "explained" && parts(&self.named) == parts(&self.truth)
    }

    /// Effects that the data cannot tell apart, group by group.
    fn groups(&self) -> Vec<Vec<&str>> {
        self.alike.split('&').map(|group| group.split('|').collect()).collect()
    }

    /// Whether something else is named, with the truth among what the data cannot tell apart from it.
    fn is_alike(&self) -> bool {
        self.verdict == "explained" && !self.is_named() && self.truth.split('+').all(|effect| self.has(effect))
    }

    /// Whether an effect is named, or belongs to a group that the data cannot tell apart.
    fn has(&self, effect: &str) -> bool {
        let alike = self.groups().into_iter().flatten();
        self.verdict == "explained" && self.named.split('+').chain(alike).any(|name| name == effect)
    }

    /// Whether every named effect is present and every visible one is named, or in a group with one that is.
    fn is_named_as_far_as_it_shows(&self) -> bool {
        let is_true = |name: &str| self.truth.split('+').any(|e| e == name);
        let groups = self.groups();
        let has_truth = |name: &str| groups.iter().any(|g| g.contains(&name) && g.iter().any(|other| is_true(other)));
        let shown = self.shows.iter().filter(|(_, over_noise)| *over_noise >= ACCURACY_OF_NOISE);
        self.verdict == "explained"
            && self.named.split('+').all(|name| is_true(name) || has_truth(name))
            && shown.into_iter().all(|(effect, _)| self.has(effect))
    }
}

fn read(files: &[&str]) -> Result<Vec<Line>, Box<dyn std::error::Error>> {
    let mut lines = BTreeMap::new();
    for file in files {
        for record in csv::ReaderBuilder::new().flexible(true).from_path(file)?.into_records() {
            let record = record?;
            let cell = |i: usize| record.get(i).unwrap_or("").to_owned();
            let pairs = |text: String| -> Vec<(String, f64)> {
                let named = text.split(';').filter_map(|part| part.split_once(':'));
                named.filter_map(|(name, value)| Some((name.to_owned(), value.parse().ok()?))).collect()
            };
            let line = Line {
                study: cell(0),
                wide: cell(2) == "wide",
                truth: cell(3),
                strength: cell(4).parse().unwrap_or(0.0),
                verdict: cell(5),
                named: cell(6),
                alike: cell(7),
                seconds: cell(15).parse().unwrap_or(0.0),
                deviations: pairs(cell(16)),
                probabilities: pairs(cell(17)),
                left_out: cell(18).parse().unwrap_or(f64::NAN),
                shows: pairs(cell(19)),
            };
            lines.insert((cell(0), cell(1)), line);
        }
    }
    Ok(lines.into_values().collect())
}

fn percent(n: usize, of: usize) -> String {
    if of == 0 { "–".to_owned() } else { format!("{:.1} %", 100.0 * n as f64 / of as f64) }
}

/// Writes the page and the figures.
pub fn write(files: &[&str]) -> Result<(), Box<dyn std::error::Error>> {
    let lines = read(files)?;
    let of = |study: &str| -> Vec<Line> { lines.iter().filter(|l| l.study == study).cloned().collect() };
    let seconds: f64 = lines.iter().map(|l| l.seconds).sum();
    let mut out = format!(
        "# How often a diagnosis is right\n\n\
         Written by `cargo run --release -p pneutherm-identify --example monte_carlo -- report {}` from one line for each of {} synthetic rigs; the same example's \
         `run clean 0 1000 FILE` (`effects`, `pairs`, `many`, `outside`, `intervals`) makes the lines, `show effects 17` tells all of one. Sixteen diagnoses run beside each other; their times add up to {:.0} minutes, {:.1} s a rig.\n\n\
         Half of the rigs are *bench* rigs (five push-and-hold experiments of three repeats, smooth moves, 100 Hz), half are *wide*: bore 10–80 mm, stroke 30–400 mm, \
         rod side or cap side, air or nitrogen, λ0 8–80 W/(m² K), noise 25–600 Pa, a step of up to 1.5 times the noise, position noise 0.5–20 µm, 50–500 Hz, \
         2–6 experiments of 1–4 repeats at 0.9–6 bar, one or two moves of 0.05–0.8 s (ramps with corners between the rows, sines, cubics, quintics, trapezoids). \
         Strength 1 is about what a worn bench shows: a leak that loses 1 % of the gas in a relaxation time at 3 bar, a wall of 8 heat capacities of the gas, \
         |Δn| = 0.15 in an exponent of λ (0.3 for the gas column), k = 1.5 (s/m)^0.8, a zone of 20 % of the mass, a tube of 3 % of the volume, 10 ms of lag or delay, \
         150 Pa/s of drift. Every rig file states bore, position, ambient temperature and heat capacity ratio with errors drawn from their default tolerances, and positions lie off a straight line by a wave drawn from the default linearity (0.02 % of the way). Other signs, critical ratios from 0.1 to 0.55 and other proportions of second parameters are drawn on wide rigs.\n\n",
        files.join(" "),
        lines.len(),
        seconds / 60.0,
        seconds / lines.len().max(1) as f64
    );
    clean(&mut out, &of("clean"));
    let found: Vec<Line> = lines.iter().filter(|l| l.study != INTERVALS).cloned().collect();
    coverage(&mut out, &of(INTERVALS), &found);
    let curves = rates(&mut out, &of("effects"));
    std::fs::write("results/diagnosis_rates.svg", figure::rates(&curves)?)?;
    together(&mut out, "Two effects at once", "Every pair of the list, strengths 0.1–1.5.", &of("pairs"));
    let drawn = "Drawn from the list, strengths 0.3–1.5.";
    together(&mut out, "Three and four effects at once", drawn, &of("many"));
    let statements: Vec<reliability::Statement> = lines.iter().flat_map(statements).collect();
    reliability::section(&mut out, &statements);
    std::fs::write("results/diagnosis_reliability.svg", reliability::figure(&statements)?)?;
    outside(&mut out, &of("outside"));
    std::fs::write(Path::new("results/diagnosis.md"), out)?;
    println!("results/diagnosis.md, results/diagnosis_rates.svg, results/diagnosis_reliability.svg");
    Ok(())
}

fn clean(out: &mut String, lines: &[Line]) {
    out.push_str("## Clean rigs: false alarms\n\n| rigs | number | adequate | named an effect | unexplained | false alarms |\n|---|---|---|---|---|---|\n");
    for (what, wide) in [("bench", Some(false)), ("wide", Some(true)), ("all", None)] {
        let part: Vec<&Line> = lines.iter().filter(|l| wide.is_none_or(|w| l.wide == w)).collect();
        let count = |verdict: &str| part.iter().filter(|l| l.verdict == verdict).count();
        let alarms = part.len() - count("adequate");
        let _ = writeln!(
            out,
            "| {what} | {} | {} | {} | {} | {} |",
            part.len(),
            count("adequate"),
            count("explained"),
            part.len() - count("adequate") - count("explained"),
            percent(alarms, part.len())
        );
    }
    out.push('\n');
}

/// How often intervals contain the truth: with the true model fitted, and over all rigs for which the search found it.
fn coverage(out: &mut String, fitted: &[Line], found: &[Line]) {
    out.push_str("## 95 % intervals\n\nHow often they hold the truth; rms: the errors in units of the intervals' own standard deviation (1 is right).\n\n");
    if !fitted.is_empty() {
        let _ = write!(
            out,
            "Where the true model is fitted, with one effect of strength 0.3 to 1.5 in each of {} rigs (`run intervals`):\n\n",
            fitted.len()
        );
        coverage_table(out, fitted);
        out.push_str("Over all rigs for which the search has ended with the true model, the faint ones among them, whose effects have a name only where noise shows them larger than they are:\n\n");
    }
    coverage_table(out, found);
    out.push_str(
        "Of 30 intervals that are right, chance lets 87 to 100 % hold the truth (95 % of the time), of 100 91 to 99 %, of 470 93 to 97 %.\n\nA leak's conductance is that of a critical pressure ratio of 0.3 unless the data speak decisively for another; on wide rigs the true ratio is \
         0.1–0.55. Its interval counts the ratio as known within 0.12.\n\n",
    );
}

fn coverage_table(out: &mut String, lines: &[Line]) {
    let mut found: BTreeMap<(String, bool), (usize, usize, f64)> = BTreeMap::new();
    for l in lines {
        for (name, deviation) in &l.deviations {
            // A value at its bound has no interval of its own.
            if !deviation.is_finite() {
                continue;
            }
            let entry = found.entry((name.clone(), l.wide)).or_default();
            entry.0 += usize::from(deviation.abs() <= 1.96);
            entry.1 += 1;
            entry.2 += deviation * deviation;
        }
    }
    out.push_str("| parameter | bench: held | of | rms | wide: held | of | rms |\n|---|---|---|---|---|---|---|\n");
    let names: std::collections::BTreeSet<&String> = found.keys().map(|(n, _)| n).collect();
    let cells = |is_meant: &dyn Fn(&str) -> bool, wide: bool| {
        let meant = found.iter().filter(|((name, of), _)| *of == wide && is_meant(name));
        let (inside, n, squares) = meant.fold((0, 0, 0.0), |sum, (_, a)| (sum.0 + a.0, sum.1 + a.1, sum.2 + a.2));
        match n {
            0 => "– | – | –".to_owned(),
            _ => format!("{} | {n} | {:.2}", percent(inside, n), (squares / n as f64).sqrt()),
        }
    };
    for name in names {
        let is_it = |other: &str| other == name;
        let _ = writeln!(out, "| `{name}` | {} | {} |", cells(&is_it, false), cells(&is_it, true));
    }
    let of_effect = |name: &str| name.contains('.');
    let _ = writeln!(out, "| all of effects | {} | {} |", cells(&of_effect, false), cells(&of_effect, true));
    out.push('\n');
}

fn rates(out: &mut String, lines: &[Line]) -> Vec<(&'static str, figure::Curve)> {
    out.push_str(
        "## One effect: detection and naming against strength\n\n![rates](diagnosis_rates.svg)\n\n\
         Of the rigs with that effect at that strength: named rightly / named as one of those that the data cannot tell apart, the truth among them / wrong name / unexplained / not seen.\n\n\
         | effect |",
    );
    for s in STRENGTHS {
        let _ = write!(out, " {s} |");
    }
    out.push_str("\n|---|---|---|---|---|---|\n");
    let mut curves = Vec::new();
    let mut totals = [0usize; 5];
    for card in simulated().into_iter().map(|e| &CARDS[e]) {
        let _ = write!(out, "| `{}` |", card.name);
        let mut curve = Vec::new();
        for strength in STRENGTHS {
            let part: Vec<&Line> = lines.iter().filter(|l| l.truth == card.name && l.strength == strength).collect();
            let named = part.iter().filter(|l| l.is_named()).count();
            let alike = part.iter().filter(|l| l.is_alike()).count();
            let wrong = part.iter().filter(|l| l.verdict == "explained").count() - named - alike;
            let quiet = part.iter().filter(|l| l.verdict == "adequate").count();
            let rest = part.len() - named - alike - wrong - quiet;
            for (sum, n) in totals.iter_mut().zip([named, alike, wrong, rest, quiet]) {
                *sum += n;
            }
            let _ = write!(out, " {named} / {alike} / {wrong} / {rest} / {quiet} |");
            let n = part.len().max(1) as f64;
            curve.push((strength, (part.len() - quiet) as f64 / n, (named + alike) as f64 / n));
        }
        out.push('\n');
        curves.push((card.name, curve));
    }
    let [named, alike, wrong, rest, quiet] = totals;
    let seen = named + alike + wrong + rest;
    let _ = writeln!(
        out,
        "\nIn all {} rigs: {seen} seen, of these {} named rightly, {} within a group that holds the truth, {} with a wrong name, {} left unexplained; {quiet} within the noise.\n",
        lines.len(),
        percent(named, seen),
        percent(alike, seen),
        percent(wrong, seen),
        percent(rest, seen)
    );
    curves
}

/// The probabilities stated for the effects of a rig from the list, each with whether the rig has it.
fn statements(line: &Line) -> Vec<reliability::Statement> {
    if line.study == "outside" {
        return Vec::new();
    }
    line.probabilities.iter().map(|(name, p)| (*p, line.truth.split('+').any(|t| t == name))).collect()
}

fn together(out: &mut String, title: &str, drawn: &str, lines: &[Line]) {
    if lines.is_empty() {
        return;
    }
    let named = lines.iter().filter(|l| l.is_named()).count();
    let alike = lines.iter().filter(|l| l.is_alike()).count();
    let is_open = |l: &&Line| l.verdict == "explained" && !l.is_named() && !l.is_alike();
    let is_part = |l: &&Line| l.named.split('+').all(|n| l.truth.split('+').any(|t| t == n));
    let partly = lines.iter().filter(|l| is_open(l) && is_part(l)).count();
    let wrong: Vec<&Line> = lines.iter().filter(|l| is_open(l) && !is_part(l)).collect();
    let count = |verdict: &str| lines.iter().filter(|l| l.verdict == verdict).count();
    let _ = write!(
        out,
        "## {title}\n\n{drawn} Of {} rigs: all named {named} ({}), within a group that holds the truth {alike}, \
         some of them named and what the others do within the noise {partly}, a wrong name {}, improved {}, unexplained {}, not seen {}.\n\n",
        lines.len(),
        percent(named, lines.len()),
        wrong.len(),
        count("improved"),
        count("unexplained"),
        count("adequate")
    );
    list(out, &wrong);
    let shown = lines.iter().filter(|l| l.is_named_as_far_as_it_shows()).count();
    let _ = write!(
        out,
        "An effect that leaves less than {ACCURACY_OF_NOISE} of the noise beside the others, whose parameters adapt, has no name: nobody minds it (`[accuracy]`). \
         All that leave more are named, in groups or alone, and nothing else, in **{shown} ({})**.\n\n\
         | an effect leaves beside the others, over the noise | effects | named, or in a group with what was |\n|---|---|---|\n",
        percent(shown, lines.len())
    );
    const LEAVES: [f64; 6] = [0.0, ACCURACY_OF_NOISE, 0.5, 1.0, 3.0, f64::INFINITY];
    for part in LEAVES.windows(2) {
        let within = |over_noise: f64| part[0] <= over_noise && over_noise < part[1];
        let effects = lines.iter().flat_map(|l| l.shows.iter().map(move |(effect, x)| (l, effect, *x)));
        let (mut count, mut named) = (0, 0);
        for (line, effect, _) in effects.filter(|(_, _, x)| within(*x)) {
            count += 1;
            named += usize::from(line.has(effect));
        }
        let range =
            if part[1].is_finite() { format!("{}–{}", part[0], part[1]) } else { format!("{} and more", part[0]) };
        let _ = writeln!(out, "| {range} | {count} | {} |", percent(named, count));
    }
    out.push('\n');
}

fn outside(out: &mut String, lines: &[Line]) {
    /// Error on left-out data, relative to the noise, up to which a model is good enough.
    const NEARLY_NOISE: f64 = 1.3;
    let _ = write!(
        out,
        "## Effects outside the list\n\nStrength 0.3 and 1: unexplained / improved / not seen / explained, and how many rigs leave at most {NEARLY_NOISE} of the noise on left-out data.\n\n\
         | outside | 0.3 | 1 | left out ≤ {NEARLY_NOISE} noise |\n|---|---|---|---|\n"
    );
    let mut kinds: Vec<&String> = lines.iter().map(|l| &l.truth).collect();
    kinds.sort();
    kinds.dedup();
    for kind in kinds {
        let all: Vec<&Line> = lines.iter().filter(|l| &l.truth == kind).collect();
        let _ = write!(out, "| {kind} |");
        for strength in [0.3, 1.0] {
            let count = |verdict: &str| all.iter().filter(|l| l.strength == strength && l.verdict == verdict).count();
            let _ = write!(
                out,
                " {} / {} / {} / {} |",
                count("unexplained"),
                count("improved"),
                count("adequate"),
                count("explained")
            );
        }
        let _ = writeln!(out, " {} of {} |", all.iter().filter(|l| l.left_out <= NEARLY_NOISE).count(), all.len());
    }
    out.push('\n');
    list(out, &lines.iter().filter(|l| l.verdict == "explained").collect::<Vec<_>>());
}

/// Lists all sets with a wrong name.
fn list(out: &mut String, wrong: &[&Line]) {
    for l in wrong {
        let alike = if l.alike.is_empty() { String::new() } else { format!(" (not told apart: {})", l.alike) };
        let _ = writeln!(out, "- {} at {:.2}: named {}{alike}", l.truth, l.strength, l.named);
    }
    if !wrong.is_empty() {
        out.push('\n');
    }
}
