//! The page of effects, from their cards.

use super::{MADE, table};
use chamber::card::{Card, ClosedForm, Fitted, Kind, Parameter, Plausible, Prior, Tried, Unit};
use chamber::{Gas, effects};
use report::number::shortest;
use std::fmt::Write;

fn page() -> String {
    let mut page = format!("{MADE}{HEAD}");
    page += &table(
        ["effect", "balance", "in short"],
        effects::all()
            .map(|(_, card)| [format!("[`{0}`](#{0})", card.name), card.balance.to_string(), card.doc.to_owned()]),
    );
    for (_, card) in effects::all() {
        page += &section(card);
    }
    page
}

/// The plausible values, where these are fewer than the bounds.
fn plausible(p: &Parameter) -> String {
    match p.plausible {
        Plausible::WithinBounds => String::new(),
        Plausible::Between(low, high) => format!("; plausible from {} to {}", shortest(low), shortest(high)),
        Plausible::From(_) => "; plausible from a value that depends on the geometry".to_owned(),
    }
}

/// Note on when a fit of the effect frees a parameter, if not always.
fn when_fitted(fitted: Fitted) -> &'static str {
    match fitted {
        Fitted::Always => "",
        Fitted::Secondary => " (keeps its neutral value in a fit unless freeing it is decisively better)",
        Fitted::Never => " (keeps its neutral value in a fit)",
    }
}

const HEAD: &str = "\
# Effects and their parameters

These are the effects that the paper's model neglects. An effect is off when each of its parameters has its neutral value. The
names are those of model files (`[effect.NAME]`) and studies (`effect.NAME.parameter`). *Typical* is a usual value; a fit scales
its start values to the rig.

*Scope* states what the parameters belong to: the rig, or one record of it. *Keeps the closed form* means that a study computes
a sealed chamber with this effect without an integrator. *A filter of the reading* acts on the pressure after it has been
computed.

";

fn section(card: &Card) -> String {
    let mut text = format!("\n## {}\n\n{}.\n\n```text\n{}\n```\n\n", card.name, card.doc, card.equation);
    let closed_form = match card.closed_form {
        ClosedForm::Kept => " Keeps the closed form.",
        ClosedForm::Filter => " A filter of the reading.",
        ClosedForm::Lost => "",
    };
    let by_itself = match card.tried {
        Tried::Always => "",
        Tried::BesideOthers => " `diagnose` tries it only beside other effects.",
        Tried::Never => " `diagnose` tries it only where no named effect fits.",
    };
    writeln!(
        text,
        "Balance: {}. Scope: {}.{closed_form}{by_itself} Source: {}.\n",
        card.balance,
        card.scope.name(),
        card.source
    )
    .expect("a String takes all");
    text += &table(
        ["parameter", "unit", "neutral", "typical", "bounds", ""],
        card.parameters.iter().filter(|p| !matches!(p.kind, Kind::ListEntry { index: 1.., .. })).map(|p| {
            let (name, fitted) = match p.kind {
                Kind::Number => (p.key(), when_fitted(p.fitted).to_owned()),
                Kind::Word(words) => (
                    p.key(),
                    format!(": {}", words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")),
                ),
                Kind::ListEntry { .. } => {
                    let entries = card.parameters.iter().filter(|q| q.name == p.name).count();
                    (p.name.to_owned(), format!(" (a list of 1 to {entries})"))
                }
            };
            [
                format!("`{name}`"),
                unit(p.unit),
                shortest(p.neutral),
                shortest(p.typical),
                format!("{} to {}", shortest(*p.bounds.start()), shortest(*p.bounds.end())),
                format!("{}{fitted}{}", p.doc, plausible(p)),
            ]
        }),
    );
    for (p, prior) in card.parameters.iter().filter_map(|p| Some((p, p.prior(&Gas::AIR)?))) {
        let gas = if matches!(p.prior, Prior::OfGas(_)) { " for air" } else { "" };
        let (mean, deviation) = (shortest(prior.mean), shortest(prior.standard_deviation));
        writeln!(text, "\nPrior{gas}: `{}` is {mean} with a standard deviation of {deviation}.", p.key())
            .expect("a String takes all");
    }
    for state in card.states {
        writeln!(text, "\nAdditional state: {}, {}.", state.doc, unit(state.unit)).expect("a String takes all");
    }
    text
}

fn unit(unit: Unit) -> String {
    match unit {
        Unit::One => "—".to_owned(),
        Unit::OfTable => "of the term or variable".to_owned(),
        unit => unit.symbol().to_owned(),
    }
}

#[test]
fn the_page_of_effects_is_what_the_cards_declare() {
    expect_test::expect_file!["../../book/src/reference/effects.md"].assert_eq(&page());
}
