//! The page written by `diagnose --report`, for decision makers, in an engineer's words and units.

mod drawings;
mod meaning;
mod spectrum;

use super::quantities::{Quantity, lower, pressure, spaced};
use super::{file, record_table};
use chamber::effects;
use chamber::words::listed;
use identify::Diagnosed;
use identify::fit::covariance::Estimate;
use identify::outcome::diagnosis::Diagnosis;
use identify::outcome::empirical::Empirical;
use identify::outcome::estimates::Rmse;
use identify::outcome::recording::RecordFound;
use records::Verdict;
use report::Error;
use report::document::{Block, Section, Table};
use report::{digits, page};

/// Number of evidence rows shown on the page.
const SHOWN: usize = 16;

/// The result of a diagnosis as one self-contained HTML page with drawings.
///
/// # Errors
/// If a drawing fails.
pub fn html(rig: &records::Rig, found: &Diagnosed) -> Result<String, Error> {
    let d = &found.diagnosis;
    let mut sections = vec![verdict(d), parameters(d), recording(d)];
    if let Some(e) = &d.empirical {
        sections.push(empirical(rig, e)?);
    }
    if !d.missing.is_empty() {
        sections.push(missing(rig, d)?);
    }
    if !d.next_experiments.is_empty() {
        sections.push(next(d));
    }
    for number in 0..found.data.experiments.len() {
        let mut section = Section::new(&format!("Records of “{}”", found.data.experiments[number]));
        if number == 0 {
            section.note(
                "All repeats of the experiment. The residual is measured minus model; the grey band is ± two standard deviations of the noise.",
            );
        }
        section.blocks.push(Block::Charts(drawings::experiment(found, number)?));
        sections.push(section);
    }
    sections.push(residual(found)?);
    sections.push(evidence(d));
    sections.push(data(rig, d));
    sections.retain(|s| !s.blocks.is_empty());
    Ok(page::page("Diagnosis of a cylinder chamber", &rig.path.display().to_string(), &sections))
}

fn effect_names(names: &[&str]) -> String {
    listed(&names.iter().map(|n| format!("**{}**", spaced(n))).collect::<Vec<_>>())
}

/// The terms of a model, with descriptions of its effects in brackets.
fn terms(d: &Diagnosis) -> String {
    let term = |term: &str| match term.split_once(" (") {
        Some((name, whose)) => format!("**{}** ({whose}", spaced(name)),
        None => format!("**{}**", spaced(term)),
    };
    let terms = listed(&d.each_term().map(term).collect::<Vec<_>>());
    match documented(d.effects_of_model()) {
        effects if effects.is_empty() => terms,
        effects => format!("{terms} ({effects})"),
    }
}

fn documented(names: &[&str]) -> String {
    let docs = names.iter().filter_map(|e| effects::find(e)).map(|(_, card)| lower(card.doc));
    docs.collect::<Vec<_>>().join("; ")
}

fn verdict(d: &Diagnosis) -> Section {
    let mut section = Section::new("Verdict");
    section.blocks.push(Block::Verdict { kind: d.verdict.name(), text: verdict_text(d) });
    section.table(errors(d));
    section.note(
        "Errors are root mean squares. Each repeat is left out in turn; without repeats, records in turn; of a single record the last third, which is \
         simulated from its start. The initial pressure of a left-out record is fitted to one half of its rows and the other half is judged, and vice versa.",
    );
    if d.is_error_of_moves() {
        section.note(
            "Weighed: the square of each row counts with the share that noise has in the error expected there. In fast moves the positions leave \
             the pressures uncertain, and these rows get less weight.",
        );
    }
    if !d.probabilities.is_empty() {
        let each = d.probabilities.iter().map(|(name, p)| format!("{} {:.0} %", spaced(name), 100.0 * p));
        let each = each.collect::<Vec<_>>().join(", ");
        section.text(format!("Odds over all sets tried, {}: {each}.", d.meaning_of_probabilities()));
    }
    for group in &d.indistinguishable {
        let names: Vec<String> = group.iter().map(|n| format!("**{}**", spaced(n))).collect();
        section.text(format!("These records cannot distinguish: {}.", names.join(", ")));
    }
    section
}

/// The verdict and its meaning in this case.
fn verdict_text(d: &Diagnosis) -> String {
    match d.verdict {
        Verdict::Adequate => format!(
            "**Adequate.** The paper's chamber model{} describes these records: {}{}.",
            if d.terms().is_empty() { String::new() } else { format!(", with {},", spaced(d.terms())) },
            d.remainder,
            if d.remaining_pa > 0.0 {
                format!(" (a systematic misfit of {})", pressure(d.remaining_pa, 2))
            } else {
                String::new()
            }
        ),
        Verdict::Explained => format!(
            "**Explained.** The paper's chamber model does not describe these records. It lacks {} ({}). With that, what remains is noise, or little compared with what there was.",
            effect_names(&d.effects),
            documented(&d.effects)
        ),
        Verdict::Improved if d.has_curve() => format!(
            "**Improved.** The paper's chamber model does not describe these records. With {} it predicts left-out experiments decisively better. \
             The curve describes the records and names no cause; {}.",
            terms(d),
            d.remainder
        ),
        Verdict::Improved => format!(
            "**Improved.** The paper's chamber model does not describe these records. With {} it {} \
             {}. The model describes the records; its effects need not be the cause.",
            terms(d),
            d.gain(),
            d.remainder
        ),
        Verdict::Unexplained => format!(
            "**Unexplained.** The paper's chamber model does not describe these records, and no known effect predicts left-out records decisively better: \
             {}, and {}. No effect is added to the model.",
            d.remainder,
            d.pointed_at()
        ),
    }
}

/// The errors of the paper's model and of each step after it, and the noise.
fn errors(d: &Diagnosis) -> Table {
    let is_weighed = d.is_error_of_moves();
    let mut head = vec!["model", "error on fitted data", "error on left-out data"];
    if is_weighed {
        head.extend(["the same weighed", "on left-out data"]);
    }
    let mut table = Table::new(&head);
    let errors = |rmse: &Rmse| [pressure(rmse.fit, 3), rmse.held_out.map_or("–".to_owned(), |h| pressure(h, 3))];
    for step in &d.steps {
        let name = match step.terms.is_empty() {
            true => "before: the paper's model".to_owned(),
            false => format!("with {}", spaced(&step.terms)),
        };
        let shown = [Some(&step.rmse_pa), is_weighed.then_some(&step.weighed_pa)].into_iter().flatten();
        table.rows.push([name].into_iter().chain(shown.flat_map(errors)).collect());
    }
    let mut noise = vec!["noise of the recording".to_owned(), pressure(d.noise_pa, 3)];
    noise.resize(head.len(), String::new());
    table.rows.push(noise);
    table
}

fn interval(q: &Quantity, e: &Estimate) -> String {
    format!("{} … {}", q.number(e.ci95[0], 4), q.number(e.ci95[1], 4))
}

fn parameters(d: &Diagnosis) -> Section {
    let mut section = Section::new("Parameters");
    let mut table = Table::new(&["quantity", "before", "after", "95 % interval (after)"]);
    // The values of a curve are drawn in a separate section.
    for (name, e) in d.after.parameters.iter().filter(|(name, _)| !name.starts_with("empirical.values")) {
        let q = Quantity::of(name, &e.unit, e.value);
        let before = d.before.parameters.iter().find(|(n, _)| n == name);
        let before = before.map_or("–".to_owned(), |(_, b)| q.number(b.value, 4));
        table.row([q.headed(), before, q.number(e.value, 4), interval(&q, e)]);
    }
    section.table(table);
    let shares: Vec<String> = d
        .lambda0_budget
        .iter()
        .filter(|b| b.share > 0.005)
        .map(|b| format!("{} {:.0} %", Quantity::of(&b.source, "", 1.0).name, 100.0 * b.share))
        .collect();
    if !shares.is_empty() {
        section.text(format!("Variance of λ0 by source: {}.", shares.join(", ")));
    }
    for u in &d.undetermined {
        section.text(format!("Poorly determined by these records: {}.", u.words()));
    }
    for (_, card) in d.effects.iter().filter_map(|e| effects::find(e)) {
        section.note(format!("{}: `{}`. {}", spaced(card.name), card.equation, card.source));
    }
    section
}

fn recording(d: &Diagnosis) -> Section {
    let mut section = Section::new("The recording");
    let n = &d.noise;
    let mut parts = vec![format!("white noise of {}", pressure(n.white_pa, 3))];
    let coloured = pressure(n.coloured_pa, 3);
    let hum = n.hum_hz.map(|hz| digits(hz, 3));
    match hum {
        Some(hz) if n.correlation_s == 0.0 => parts.push(format!("a hum of {coloured} at {hz} Hz")),
        _ if n.coloured_pa > 0.0 => {
            let time = Quantity::of("", "s", n.correlation_s).text(n.correlation_s, 2);
            parts.push(format!("coloured noise of {coloured} with a correlation time of {time}"));
            parts.extend(hum.map(|hz| format!("in it a hum of {hz} Hz")));
        }
        _ => {}
    }
    if n.step_pa > 0.0 {
        parts.push(format!("steps of {} between readings", pressure(n.step_pa, 3)));
    }
    parts.extend(n.readout_hz.map(|hz| format!("a readout rate of {} Hz", digits(hz, 3))));
    match n.outliers {
        0 => (),
        1 => parts.push("one outlier, which is left out".to_owned()),
        count => parts.push(format!("{count} outliers, which are left out")),
    }
    section.text(format!("The pressure has {}.", parts.join(", ")));
    let cells = |r: &RecordFound| vec![file(&r.trace).to_owned(), digits(r.rmse_pa, 3)];
    let records: Vec<_> = d.records.iter().map(|r| (cells(r), &r.parameters)).collect();
    if !records.is_empty() {
        section.table(record_table::table(&["record", "error, Pa"], &records));
    }
    section
}

/// The missing term as a curve: accepted into the model or rejected.
fn empirical(rig: &records::Rig, e: &Empirical) -> Result<Section, Error> {
    let mut section = Section::new("The missing term as a curve");
    let errors = format!(
        "the error on left-out data {} {}, from {} without it",
        if e.fate.is_accepted() { "falls to" } else { "is then" },
        pressure(e.left_out_rmse_pa.with, 3),
        pressure(e.left_out_rmse_pa.without, 3)
    );
    section.text(if e.fate.is_accepted() {
        format!(
            "No named effect has the shape of the residual. A curve was fitted together with all other parameters and is now in the model, a {} over {}: {errors}. \
             It is linear between its knots and constant beyond them, where there are no data.",
            e.subject.quantity().0,
            e.subject.variable.name().0
        )
    } else {
        format!(
            "Neither a named effect nor a curve explains the residual. The best curve, a {} over {}, is not in the model, because {}; {errors}.",
            e.subject.quantity().0,
            e.subject.variable.name().0,
            e.fate.words()
        )
    });
    let caption = meaning::suggestion(e, rig.ambient.pressure_pa);
    section.blocks.push(Block::Charts(vec![drawings::empirical(e, caption)?]));
    section.note("Bars: 95 % intervals, with all other parameters fitted.");
    Ok(section)
}

fn missing(rig: &records::Rig, d: &Diagnosis) -> Result<Section, Error> {
    let mut section = Section::new("Curves that would explain the residual");
    section.text(
        "Each curve is a missing term as a free function of one variable, to first order. The curves that explain most of the residual beyond noise come first. Bars: ± two standard deviations.",
    );
    let drawings: Result<Vec<_>, Error> = d
        .missing
        .iter()
        .take(4)
        .map(|m| drawings::missing(m, meaning::suggestion(m, rig.ambient.pressure_pa)))
        .collect();
    section.blocks.push(Block::Charts(drawings?));
    Ok(section)
}

fn next(d: &Diagnosis) -> Section {
    let mut section = Section::new("What to measure next");
    let advice = d.next_experiments.iter().map(|n| {
        let [one, other] = n.separates.each_ref().map(|terms| spaced(terms));
        let by = digits(n.difference_over_noise, 2);
        format!("To distinguish **{one}** from **{other}**: {}. There the two differ by {by} times the noise.", n.test)
    });
    section.blocks.push(Block::List(advice.collect()));
    section
}

fn residual(found: &Diagnosed) -> Result<Section, Error> {
    let mut section = Section::new("The residual in detail");
    section.text(
        "All records. White noise has a flat spectrum; a peak or a rise towards low frequencies is coloured noise, or something that the model lacks. \
         Each point in the other plots is the mean of a block of rows; a flat cloud within the band is noise.",
    );
    section.blocks.push(Block::Charts(drawings::residuals(found)?));
    Ok(section)
}

fn evidence(d: &Diagnosis) -> Section {
    let mut section = Section::new("Evidence");
    section.text(
        "Each effect was added to the model, and all parameters were fitted again. ΔBIC is the evidence for it over the paper's model, with a penalty for each parameter. \
         An effect enters the model if the gain in BIC is above 10, plus the logarithm of the number of candidates, and if the error on left-out data falls too.",
    );
    let paper: Vec<&String> = d.before.parameters.iter().map(|(n, _)| n).collect();
    let mut table = Table::new(&["effect", "ΔBIC", "error on left-out data", "its parameters"]);
    for (i, c) in d.candidates.iter().take(SHOWN).enumerate() {
        let own = c.parameters.iter().filter(|(n, _)| !paper.contains(&n)).map(|(n, e)| {
            let q = Quantity::of(n, &e.unit, e.value);
            let words = q.name.split_once(": ").map_or(q.name.as_str(), |(_, words)| words);
            format!("{words} {}", q.text(e.value, 3))
        });
        let held_out = c.held_out_rmse_pa.map_or("–".to_owned(), |h| pressure(h, 3));
        let own: Vec<String> = own.collect();
        table.row([spaced(&c.effect), format!("{:.1}", c.delta_bic), held_out, own.join(", ")]);
        if c.effect == d.terms() {
            table.chosen = Some(i);
        }
    }
    section.table(table);
    if d.candidates.len() > SHOWN {
        section.note(format!("{} more are in the JSON.", d.candidates.len() - SHOWN));
    }
    section
}

fn data(rig: &records::Rig, d: &Diagnosis) -> Section {
    let mut section = Section::new("Data");
    if !d.assumptions.is_empty() {
        section.blocks.push(Block::List(d.assumptions.iter().map(|a| format!("{a}.")).collect()));
    }
    let mut table = Table::new(&["experiment", "record", "rows", "SHA-256"]);
    for e in &rig.experiments {
        for t in &e.traces {
            let file = t.path.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned());
            let sha256 = t.sha256.get(..12).unwrap_or("").to_owned();
            table.row([e.name.clone(), file, t.len().to_string(), sha256]);
        }
    }
    section.table(table);
    section.note(format!("pneutherm {}", env!("CARGO_PKG_VERSION")));
    section
}

#[cfg(test)]
mod tests {
    use super::*;
    use identify::synthetic::Recipe;

    #[test]
    fn the_page_holds_everything_and_asks_for_nothing_else() {
        let mut recipe = Recipe { repeats: 2, ..Recipe::from_seed(31) };
        recipe = recipe.clone().with("leakage", &[recipe.leak_of(1.0)]);
        let rig = recipe.rig();
        let found = identify::diagnose(&rig, &|_, _| ()).unwrap();
        let page = html(&rig, &found).unwrap();
        assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
        for words in [
            "<svg", "pressure, bar", "sonic conductance", "compress-3bar: the push", "pressure and position",
            "Spectrum of the residual",
        ] {
            assert!(page.contains(words), "{words}");
        }
        for words in ["http://", "https://", "NaN", "lambda0_w_per_m2_k"] {
            assert!(!page.contains(words), "{words}");
        }
    }
}
