//! How often a diagnosis is right, on synthetic rigs whose truth is known.
//!
//! From the project's root, one line per set appended to a file, then the tables and the figure from all such files:
//! `cargo run --release -p pneutherm-identify --example monte_carlo -- run clean 0 1000 results/diagnosis_sets.csv`
//! (likewise `effects`, `pairs`, `many`, `outside`, `intervals`), `… -- report results/diagnosis_sets.csv`;
//! `… -- show effects 17` prints all details of one.

mod figure;
mod page;
mod reliability;
mod sets;

use chamber::effects::CARDS;
use identify::fit::{self, Fit, Linear};
use identify::judge::misfit;
use identify::outcome::{diagnosis, estimates};
use identify::parameters::{Model, Sizes, names};
use identify::record::blocks::Block;
use identify::record::data::{Data, Prepared};
use identify::search::{self, Found, Verdict, baseline, reweighting, starts};
use identify::synthetic::visibility;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::Write as _;
use std::time::Instant;

/// Columns of a set's line.
pub const HEADER: &str = "study,set,rig,truth,strength,verdict,named,alike,balance,signal_over_noise,left_over_noise,delta_bic,squares_deviations,family_probability,rows,seconds,deviations,probabilities,left_out_over_noise,shows_over_noise";

const UNKNOWN: &str = "studies are clean, effects, pairs, many, outside, intervals";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["run", study, from, to, file] => run(study, from.parse()?, to.parse()?, file),
        ["show", study, index] => show(study, index.parse()?, 1.0),
        ["show", study, index, noise] => show(study, index.parse()?, noise.parse()?),
        ["report", files @ ..] if !files.is_empty() => page::write(files),
        _ => Err("usage: monte_carlo run STUDY FROM TO FILE | show STUDY SET [NOISE TIMES] | report FILE…".into()),
    }
}

fn traced(set: &sets::Set) -> Result<(Data, Found), identify::Error> {
    search::search(Data::prepare(&set.recipe.rig())?, &|_, _| ())
}

fn run(study: &str, from: u64, to: u64, file: &str) -> Result<(), Box<dyn std::error::Error>> {
    let is_new = !std::path::Path::new(file).exists();
    let mut out = std::fs::OpenOptions::new().create(true).append(true).open(file)?;
    if is_new {
        writeln!(out, "{HEADER}")?;
    }
    const BESIDE_EACH_OTHER: u64 = 16;
    for first in (from..to).step_by(BESIDE_EACH_OTHER as usize) {
        let indices: Vec<u64> = (first..to.min(first + BESIDE_EACH_OTHER)).collect();
        let lines: Option<Vec<String>> = indices.par_iter().map(|index| diagnosed(study, *index)).collect();
        for line in lines.ok_or(UNKNOWN)? {
            writeln!(out, "{line}")?;
        }
    }
    Ok(())
}

/// Diagnoses a set and returns its line.
fn diagnosed(study: &str, index: u64) -> Option<String> {
    let set = sets::set(study, index)?;
    let begun = Instant::now();
    let line = if study == sets::INTERVALS {
        line_of_true_model(&set, begun)
    } else {
        traced(&set).map(|(data, t)| line(&set, data, t, begun))
    };
    let line = match line {
        Ok(line) => line,
        Err(error) => {
            format!("refused,{},,,,,,,,,,{:.2},", error.to_string().replace(',', ";"), begun.elapsed().as_secs_f64())
        }
    };
    let rig = if set.wide { "wide" } else { "bench" };
    Some(format!("{study},{index},{rig},{},{},{line}", set.truth, set.strength))
}

fn line(set: &sets::Set, data: Data, t: Found, begun: Instant) -> String {
    let seconds = begun.elapsed().as_secs_f64();
    let found = names(t.chosen.model.of_rig()).join("+");
    let reported = t.reported();
    // Intervals are judged only where the model is the true one.
    let is_true =
        t.verdict == Verdict::Adequate && set.truth == "none" || t.verdict == Verdict::Explained && found == set.truth;
    let deviations = if is_true { deviations(set, &data, &reported.fit) } else { String::new() };
    let over = |fit| {
        let rms = misfit::rms(&data, &misfit::residuals(&data, fit)) / data.noise.total_pa();
        (rms * rms - 1.0).max(0.0).sqrt()
    };
    let (signal, left) = (over(&t.baseline.fit), over(&t.chosen.fit));
    let best = t.tried.first().map_or(f64::NAN, |c| c.delta_bic);
    let left_out = t.chosen.held_out_pa().map_or(f64::NAN, |pa| pa / data.noise.total_pa());
    // What each of several effects leaves beside the others.
    let active: Vec<usize> = set.recipe.chamber.active().iter().collect();
    let several = if active.len() > 1 { &active[..] } else { &[] };
    let shows = |e: &usize| {
        let over_noise = visibility::beside_others_pa(&set.recipe, *e) / data.noise.total_pa();
        format!("{}:{over_noise:.3}", CARDS[*e].name)
    };
    let shows = several.iter().map(shows).collect::<Vec<String>>().join(";");
    let rows: usize = data.traces.iter().map(|t| t.time_s.len()).sum();
    let a = t.chosen_adequacy.clone();
    let d = diagnosis::describe(data, t).diagnosis;
    let alike: Vec<String> = d.indistinguishable.iter().map(|g| g.join("|")).collect();
    let probabilities: Vec<String> = d.probabilities.iter().map(|(name, p)| format!("{name}:{p:.4}")).collect();
    let probabilities = probabilities.join(";");
    format!(
        "{},{found},{},{},{signal:.4},{left:.4},{best:.1},{:.2},{:.2e},{rows},{seconds:.2},{deviations},{probabilities},{left_out:.3},{shows}",
        d.verdict.name(),
        alike.join("&"),
        d.balance,
        a.squares_deviations,
        a.family_probability
    )
}

/// The same with the true model fitted, to the data with the outliers and noise that this fit shows.
fn line_of_true_model(set: &sets::Set, begun: Instant) -> Result<String, identify::Error> {
    let (data, paper) = baseline::fitted(Data::prepare(&set.recipe.rig())?)?;
    let sizes = Sizes::of(&data, &paper.chamber());
    let model = Model::with(set.recipe.chamber.active());
    let fitted = |data: &Data, part: &Fit| starts::fit_model(data, model, part, &sizes);
    let refitted = fitted(&data, &paper).and_then(|rough| {
        let data = reweighting::reweighted(&data, &rough, true).unwrap_or_else(|| data.clone());
        fitted(&data, &rough).map(|fit| deviations(set, &data, &fit))
    });
    let rows: usize = data.traces.iter().map(|t| t.time_s.len()).sum();
    let (verdict, deviations) = refitted.map_or(("failed", String::new()), |deviations| ("fitted", deviations));
    Ok(format!("{verdict},,,,,,,,,{rows},{:.2},{deviations},,,", begun.elapsed().as_secs_f64()))
}

/// Errors of a fit's parameters, in standard deviations of their intervals.
fn deviations(set: &sets::Set, data: &Data, fit: &Fit) -> String {
    let h = &fit.hypothesis;
    // With the position zero as recorded the true dead volume may be negative, and is then reported as zero.
    let mut truth = set.recipe.chamber_as_recorded();
    truth.geometry.dead_volume = truth.geometry.dead_volume.max(0.0);
    let truth = h.coordinates(&truth);
    let mut out = String::new();
    for ((name, e), (axis, x)) in estimates::parameters(data, fit, true).iter().zip(h.axes.iter().zip(truth)) {
        let half = (e.ci95[1] - e.ci95[0]) / 3.92;
        let _ = write!(out, "{name}:{:.3};", (e.value - axis.value(x)) / half);
    }
    out
}

fn show(study: &str, index: u64, noise: f64) -> Result<(), Box<dyn std::error::Error>> {
    let mut set = sets::set(study, index).ok_or(UNKNOWN)?;
    set.recipe = set.recipe.with_noise_times(noise);
    println!("{:#?}", set.recipe);
    println!("truth {} at {}", set.truth, set.strength);
    let (data, t) = traced(&set)?;
    println!("noise {:?}, {} blocks", data.noise, t.baseline.fit.blocks);
    for trace in &data.traces {
        let parts: Vec<String> = trace
            .course
            .motion
            .segments
            .iter()
            .map(|s| format!("{:?} {:.3}-{:.3} ({} rows)", s.phase, s.from_s, s.to_s, s.end - s.first))
            .collect();
        println!("{}: position noise {:.2e}: {}", trace.path.display(), trace.course.motion.noise_m, parts.join(", "));
    }
    for c in std::iter::once(&t.baseline).chain(&t.tried) {
        let held_out = c.held_out_pa().map_or("–".to_owned(), |h| format!("{h:.2}"));
        let found: Vec<String> =
            estimates::parameters(&data, &c.fit, true).iter().map(|(n, e)| format!("{n} {:.4e}", e.value)).collect();
        println!(
            "{:40} chi2 {:10.1} dBIC {:9.1} held out {held_out} {} iterations {} bounds {:?}",
            c.model.words(),
            c.fit.marginal,
            c.delta_bic,
            found.join(" "),
            c.fit.iterations,
            c.fit.at_bound
        );
    }
    for (what, a) in [("baseline", &t.baseline_adequacy), ("chosen", &t.chosen_adequacy)] {
        println!(
            "{what}: noise {} systematic {:.2} Pa squares {:.2} sd, family {:.2e}",
            a.is_noise, a.systematic_pa, a.squares_deviations, a.family_probability
        );
        for f in a.families.iter().take(4) {
            println!("   {:?} by {:?}: gain {:.1} rank {}", f.term, f.variable, f.gain, f.rank);
        }
    }
    println!("chosen:");
    worst(&data, &t.chosen.fit);
    // The truth itself, with the best-fitting start of each trace.
    let mut h = t.baseline.fit.hypothesis.clone();
    (h.model.effects, h.base) = (set.recipe.chamber.active(), set.recipe.chamber);
    h.axes.clear();
    match fit::fit(&data, &h, Vec::new(), h.record_guesses(&data), &fit::all_blocks(&data)) {
        Ok(truth) => {
            println!("truth: chi2 {:.1} of {} blocks", truth.chi2, truth.blocks);
            worst(&data, &truth);
        }
        Err((k, error)) => println!("truth: {}: {error}", data.traces[k].path.display()),
    }
    println!(
        "{:?}: {}; alike {:?}",
        t.verdict,
        t.chosen.model.words(),
        t.alike.iter().map(Model::words).collect::<Vec<_>>()
    );
    Ok(())
}

/// Prints the largest residuals of a fit and where they lie.
fn worst(data: &Data, fit: &Fit) {
    let of_trace = |(t, l): (&Prepared, &Linear)| -> Vec<(f64, String)> {
        let at = |block: &Block| {
            let Block { phase, first, end, .. } = block;
            format!("{} {phase:?} rows {first}..{end} at {:.3} s", t.path.display(), block.middle_s())
        };
        l.residual.iter().zip(&t.blocks).map(|(r, block)| (*r, at(block))).collect()
    };
    let mut worst: Vec<(f64, String)> = data.traces.iter().zip(&fit.linear).flat_map(of_trace).collect();
    worst.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    for (r, at) in worst.iter().take(8) {
        println!("   {r:8.2} {at}");
    }
}
