//! How often a diagnosis is right, on synthetic rigs whose truth is known.
//!
//! `cargo run --release -p pneutherm-identify --example monte_carlo -- clean 1000` and likewise `coverage 200`,
//! `effects 20`, `outside 20`: results as CSV in `results/monte_carlo/` (or the folder given last), and a summary line.

mod figure;

use identify::prepare::Data;
use identify::synthetic::{Outside, Recipe};
use identify::tracing::{self, Trace, Verdict};
use identify::{diagnosis, hypothesis::names};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const STRENGTHS: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, count, rest @ ..] = arguments.as_slice() else {
        return Err("usage: monte_carlo clean|coverage|effects|outside COUNT [FOLDER]".into());
    };
    let count: u64 = count.parse()?;
    let folder = rest.first().map_or_else(|| PathBuf::from("results/monte_carlo"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    match what.as_str() {
        "clean" => clean(count, &folder),
        "coverage" => coverage(count, &folder),
        "effects" => effects(count, &folder),
        "outside" => outside(count, &folder),
        other => Err(format!("unknown study {other}: clean, coverage, effects or outside").into()),
    }
}

fn traced(recipe: &Recipe) -> Result<(Data, Trace), identify::Error> {
    let data = Data::prepare(&recipe.rig())?;
    let trace = tracing::trace(&data, &|_, _| ())?;
    Ok((data, trace))
}

/// Rigs without any effect: how often something is found all the same; and whether the intervals hold the truth.
fn clean(count: u64, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut csv = "seed,verdict,effects,best_delta_bic,squares_deviations,family_probability,lambda0_inside,dead_volume_inside,lambda0_error_sd,dead_volume_error_sd\n".to_owned();
    let (mut alarms, mut inside) = (0, [0u64; 2]);
    for seed in 1..=count {
        let recipe = Recipe::from_seed(seed);
        let (data, t) = traced(&recipe)?;
        alarms += u64::from(t.verdict != Verdict::Adequate);
        let truth = [recipe.chamber.heat_transfer.coefficient, recipe.chamber.geometry.dead_volume];
        let found = diagnosis::parameters(&data, &t.baseline.fit, true);
        let mut cells = String::new();
        let mut errors = String::new();
        for (k, true_value) in truth.iter().enumerate() {
            let e = &found[k].1;
            let holds = e.ci95[0] <= *true_value && *true_value <= e.ci95[1];
            inside[k] += u64::from(holds);
            let _ = write!(cells, ",{}", u8::from(holds));
            let _ = write!(errors, ",{:.3}", (e.value - true_value) / ((e.ci95[1] - e.ci95[0]) / 3.92));
        }
        let a = &t.baseline_adequacy;
        let _ = writeln!(
            csv,
            "{seed},{:?},{},{:.2},{:.3},{:.3e}{cells}{errors}",
            t.verdict,
            names(t.chosen.effects).join("+"),
            t.tried.first().map_or(f64::NAN, |c| c.delta_bic),
            a.squares_deviations,
            a.family_probability
        );
        if seed % 50 == 0 {
            eprintln!("{seed}: {alarms} alarms, inside {inside:?}");
        }
    }
    std::fs::write(folder.join("clean.csv"), csv)?;
    let share = |n: u64| 100.0 * n as f64 / count as f64;
    println!(
        "clean rigs {count}: false alarms {alarms} ({:.2} %), 95 % intervals hold lambda0 in {:.1} %, the dead volume in {:.1} %",
        share(alarms),
        share(inside[0]),
        share(inside[1])
    );
    Ok(())
}

/// Rigs with one effect at full strength: whether the intervals of all parameters hold the truth.
fn coverage(count: u64, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut csv = "seed,effect,parameter,value,low,high,truth,inside\n".to_owned();
    let mut tally: Vec<(String, u64, u64)> = Vec::new();
    for seed in 1..=count {
        let (e, card) = chamber::effects::all().nth(seed as usize % chamber::effects::COUNT).ok_or("no effect")?;
        let recipe = Recipe::from_seed(10_000 + seed).with_strength(e, 1.0);
        let (data, t) = traced(&recipe)?;
        if t.verdict != Verdict::Explained || names(t.chosen.effects) != [card.name] {
            continue;
        }
        let truth = t.chosen.fit.hypothesis.coordinates(&recipe.chamber);
        for ((name, estimate), (axis, x)) in
            diagnosis::parameters(&data, &t.chosen.fit, true).iter().zip(t.chosen.fit.hypothesis.axes.iter().zip(truth))
        {
            let true_value = axis.value(x);
            let holds = estimate.ci95[0] <= true_value && true_value <= estimate.ci95[1];
            let [low, high] = estimate.ci95;
            let _ = writeln!(
                csv,
                "{seed},{},{name},{:e},{low:e},{high:e},{true_value:e},{}",
                card.name,
                estimate.value,
                u8::from(holds)
            );
            match tally.iter_mut().find(|(n, ..)| n == name) {
                Some(entry) => *entry = (entry.0.clone(), entry.1 + u64::from(holds), entry.2 + 1),
                None => tally.push((name.clone(), u64::from(holds), 1)),
            }
        }
    }
    std::fs::write(folder.join("coverage.csv"), csv)?;
    for (name, inside, of) in tally {
        println!(
            "{name}: 95 % interval holds the truth in {inside} of {of} ({:.1} %)",
            100.0 * inside as f64 / of as f64
        );
    }
    Ok(())
}

/// One effect at a time against its strength: found at all, and named rightly.
fn effects(count: u64, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut csv = "effect,strength,rigs,detected,named,alike,wrong,unexplained\n".to_owned();
    let mut curves = Vec::new();
    for (e, card) in chamber::effects::all() {
        let mut curve = Vec::new();
        for strength in STRENGTHS {
            let [mut detected, mut named, mut alike, mut wrong, mut unexplained] = [0u64; 5];
            for seed in 1..=count {
                let recipe = Recipe::from_seed(20_000 + 97 * seed + e as u64).with_strength(e, strength);
                let (_, t) = traced(&recipe)?;
                let found = names(t.chosen.effects);
                match t.verdict {
                    Verdict::Adequate => continue,
                    Verdict::Unexplained => unexplained += 1,
                    Verdict::Explained if found == [card.name] => named += 1,
                    Verdict::Explained if t.alike.iter().any(|s| names(*s) == [card.name]) => alike += 1,
                    Verdict::Explained => wrong += 1,
                }
                detected += 1;
            }
            let _ = writeln!(csv, "{},{strength},{count},{detected},{named},{alike},{wrong},{unexplained}", card.name);
            eprintln!(
                "{} {strength}: {detected} detected, {named} named, {alike} alike, {wrong} wrong, {unexplained} unexplained",
                card.name
            );
            curve.push((strength, detected as f64 / count as f64, (named + alike) as f64 / count as f64));
        }
        curves.push((card.name, curve));
    }
    std::fs::write(folder.join("effects.csv"), csv)?;
    std::fs::write(folder.join("effects.svg"), figure::rates(&curves))?;
    println!("detection and naming rates: {}", folder.join("effects.svg").display());
    Ok(())
}

/// What no card describes: left unnamed?
fn outside(count: u64, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let kinds: [fn(f64) -> Outside; 7] = [
        |s| Outside::WarmWall(3.0 * s),
        |s| Outside::FadingTurbulence(0.6 * s, 0.4),
        |s| Outside::Compliance(0.004 * s),
        |s| Outside::BentSensor(0.01 * s),
        |s| Outside::NeighbourLeak(3e-13 * s),
        |s| Outside::Hysteresis(600.0 * s),
        |s| Outside::OneSided(0.3 * s),
    ];
    let mut csv = "outside,strength,seed,verdict,effects,balance,base_rms,left_rms\n".to_owned();
    for kind in kinds {
        for strength in [0.3, 1.0] {
            let (mut quiet, mut unnamed, mut named) = (0, 0, 0);
            for seed in 1..=count {
                let recipe = Recipe::from_seed(30_000 + seed).with_outside(kind(strength));
                let (data, t) = traced(&recipe)?;
                match t.verdict {
                    Verdict::Adequate => quiet += 1,
                    Verdict::Unexplained => unnamed += 1,
                    Verdict::Explained => named += 1,
                }
                let effects = names(t.chosen.effects).join("+");
                let rms = |c: &tracing::Candidate| (c.fit.chi2 / c.fit.blocks as f64).sqrt();
                let (base, left, verdict) = (rms(&t.baseline), rms(&t.chosen), t.verdict);
                let balance = diagnosis::describe(data, t).diagnosis.balance;
                let _ = writeln!(
                    csv,
                    "{},{strength},{seed},{verdict:?},{effects},{balance},{base:.3},{left:.3}",
                    kind(1.0).name()
                );
            }
            println!("{} at {strength}: {quiet} within noise, {unnamed} left unnamed, {named} named", kind(1.0).name());
        }
    }
    std::fs::write(folder.join("outside.csv"), csv)?;
    Ok(())
}
