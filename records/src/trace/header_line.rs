//! Finds the header and the units line of a trace file.

use super::fields::texts;
use super::lines::Line;
use crate::format::Separator;
use crate::units::Quantity;

/// The header: the line with most of the wanted names, or the last line before the numbers with enough names. Among lines with
/// equally many wanted names, such as a channel list above the header, it is the last with as many names as rows have fields.
pub fn header<'l>(
    before: &[&'l Line],
    rows: &[&'l Line],
    split: &dyn Fn(&str) -> Vec<String>,
    wanted: &[&str],
    fields: usize,
    is_comment: impl Fn(&str) -> bool,
) -> Option<&'l Line> {
    let wanted: Vec<&str> = wanted.iter().map(|name| name.trim_start_matches('#').trim()).collect();
    let hits = |line: &str| split(line).iter().filter(|name| wanted.contains(&name.as_str())).count();
    let fits = |names: &[String]| (fields..=fields + 1).contains(&names.len());
    let by_name = before.iter().map(|line| (hits(&line.1), fits(&split(&line.1)), *line));
    if let Some((1.., _, line)) = by_name.max_by_key(|(hits, fits, _)| (*hits, *fits)) {
        return Some(line);
    }
    if before.is_empty() && fields > 0 {
        return None;
    }
    let names_all = |line: &str| {
        let names = split(line);
        fits(&names) && !is_rule(line) && !is_units(&names)
    };
    let plain = || before.iter().rev().filter(|(_, line)| !is_comment(line));
    let commented = || before.iter().rev().filter(|(_, line)| is_comment(line));
    let found = plain().find(|(_, line)| names_all(line)).or_else(|| commented().find(|(_, line)| names_all(line)));
    // None has enough names: the line directly before the numbers, or the first line of a file without numbers.
    let last = if fields > 0 { plain().next() } else { rows.first().or(before.first()) };
    found.filter(|_| fields > 0).or(last).copied()
}

/// A header's names: split like the rows or, if that gives another number, like headers above blank-separated rows.
pub fn names(line: &str, comments: &[String], separator: Separator, fields: usize) -> Vec<String> {
    let line = line.trim_matches([' ', '\r']);
    let line = comments.iter().find_map(|begin| line.strip_prefix(begin.as_str())).unwrap_or(line);
    let cleaned = |names: Vec<&str>| {
        let clean = |name: &str| name.replace("\"\"", "\"").trim_start_matches('#').trim().to_owned();
        let mut names: Vec<String> = names.into_iter().map(clean).collect();
        while names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        names
    };
    if separator != Separator::Whitespace {
        return cleaned(texts(line, separator));
    }
    let commas = || cleaned(texts(line, Separator::Byte(b',')));
    let wide =
        || cleaned(line.split(['\t']).flat_map(|part| part.split("  ")).filter(|s| !s.trim().is_empty()).collect());
    let blanks = cleaned(texts(line, separator));
    // Some loggers separate the header by commas and the rows by blanks.
    if line.contains(',') && (fields == 0 || commas().len() == fields) {
        return commas();
    }
    if blanks.len() != fields && wide().len() == fields { wide() } else { blanks }
}

/// The units of a LabVIEW measurement's channels, from its header block; the first column is time.
pub fn labview_units(before: &[&Line], separator: Separator) -> Option<(usize, Vec<String>)> {
    let (number, line) = before.iter().find(|(_, line)| line.starts_with("Y_Unit_Label"))?;
    let mut units: Vec<String> = texts(line, separator).into_iter().map(str::to_owned).collect();
    units[0] = "s".to_owned();
    Some((*number, units))
}

/// A line of dashes or the like.
fn is_rule(line: &str) -> bool {
    line.chars().all(|c| "-=_*+|~ \t;,".contains(c))
}

/// Whether most names are units: in brackets, or spelled like one.
pub fn is_units(names: &[String]) -> bool {
    let filled = || names.iter().filter(|name| !name.is_empty());
    let bracketed = |text: &str| {
        let pairs = [('[', ']'), ('(', ')'), ('<', '>')];
        pairs.iter().any(|(open, close)| text.starts_with(*open) && text.ends_with(*close))
    };
    let known = |text: &str| Quantity::ALL.into_iter().any(|quantity| quantity.unit_spelled(text).is_some());
    let units =
        filled().filter(|name| bracketed(name) || known(name) || matches!(name.as_str(), "-" | "1" | "%")).count();
    units > 0 && 2 * units >= filled().count()
}
