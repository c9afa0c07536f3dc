//! A self-contained HTML page: light, printable, readable on a phone, no script, no network.

use crate::document::{Block, Drawing, Section, Table};

/// A self-contained HTML page: its title, a paragraph below it, and its sections.
pub fn page(title: &str, lead: &str, sections: &[Section]) -> String {
    let body: String = sections.iter().map(section).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{}</h1>\n<p class=\"lead\">{}</p>\n{body}</body>\n</html>\n",
        escaped(title),
        escaped(title),
        inline(lead),
    )
}

const STYLE: &str = "\
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 80rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.8rem; line-height: 1.2; overflow-wrap: anywhere; } h2 { font-size: 1.3rem; margin-top: 2.5rem; border-bottom: 1px solid #ccc; padding-bottom: .2rem; }
p, ul, figcaption { max-width: 50rem; } .lead { font-size: 1.1rem; color: #444; overflow-wrap: anywhere; } .note { color: #555; font-size: .9rem; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .25rem .7rem; text-align: left; border-bottom: 1px solid #ddd; }
th { border-bottom: 2px solid #888; vertical-align: bottom; } .n { text-align: right; } td.n { white-space: nowrap; }
tr { break-inside: avoid; } .chosen td { font-weight: 600; } .scroll { overflow-x: auto; }
.verdict { padding: .7rem 1rem; border-left: 5px solid #888; background: #f6f6f4; }
.explained, .improved { border-color: #0072b2; } .adequate { border-color: #2e7d32; } .unexplained { border-color: #c44e00; }
figure { margin: 1.5rem 0; max-width: 62rem; } figure svg { width: 100%; height: auto; display: block; } figcaption { color: #444; font-size: .92rem; }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(23rem, 100%), 1fr)); gap: 1rem; margin: 1rem 0; } .charts figure { margin: 0; }
code { background: #f3f3f3; padding: 0 .25em; border-radius: 3px; font-size: .92em; }
@media (max-width: 40rem) { body { margin: 1rem auto; } table { font-size: .82rem; } th, td { padding: .2rem .4rem; } td.n { white-space: normal; } .wide { overflow-x: auto; } .wide svg { width: 44rem; } }
@page { margin: 15mm; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } table { font-size: 7.5pt; } th, td { padding: .1rem .35rem; } figure { break-inside: avoid; } h2 { break-after: avoid; } p { orphans: 3; widows: 3; } .scroll { overflow: visible; } figcaption, .lead { font-size: 1em; } .charts { grid-template-columns: 1fr 1fr; gap: 4mm; } p:has(+ .charts) { break-after: avoid; } }
";

fn section(of: &Section) -> String {
    let mut out = format!("<section>\n<h2>{}</h2>\n", escaped(&of.title));
    for block in &of.blocks {
        match block {
            Block::Text(text) => out.push_str(&format!("<p>{}</p>\n", inline(text))),
            Block::Note(text) => out.push_str(&format!("<p class=\"note\">{}</p>\n", inline(text))),
            Block::Verdict { kind, text } => {
                out.push_str(&format!("<p class=\"verdict {kind}\">{}</p>\n", inline(text)));
            }
            Block::List(points) => {
                let points: String = points.iter().map(|p| format!("<li>{}</li>\n", inline(p))).collect();
                out.push_str(&format!("<ul>\n{points}</ul>\n"));
            }
            Block::Table(table) => out.push_str(&html_table(table)),
            Block::Figure { file, svg, caption } => out.push_str(&format!(
                "<figure role=\"img\" aria-label=\"{}\">\n<div class=\"wide\">{}</div>\n<figcaption>{} (<code>{file}</code>)</figcaption>\n</figure>\n",
                escaped(caption),
                scalable(svg),
                inline(caption),
            )),
            Block::Charts(drawings) => {
                let drawings: String = drawings.iter().map(drawing).collect();
                out.push_str(&format!("<div class=\"charts\">\n{drawings}</div>\n"));
            }
        }
    }
    out.push_str("</section>\n");
    out
}

fn drawing(of: &Drawing) -> String {
    let caption = match of.caption.as_str() {
        "" => String::new(),
        caption => format!("<figcaption>{}</figcaption>", inline(caption)),
    };
    format!("<figure>{}{caption}</figure>\n", scalable(&of.svg).replace('\n', ""))
}

/// Whether a column is formatted as numbers: right-aligned, without line breaks. The first column names the row.
fn is_numeric(table: &Table, column: usize) -> bool {
    let begins_with_digit =
        |cell: &str| cell.trim_start_matches(['+', '-', '±', ' ']).starts_with(|c: char| c.is_ascii_digit());
    let numbers = table.rows.iter().filter(|row| begins_with_digit(&row[column])).count();
    column > 0 && 2 * numbers > table.rows.len()
}

fn html_table(table: &Table) -> String {
    let classes: Vec<&str> =
        (0..table.head.len()).map(|i| if is_numeric(table, i) { " class=\"n\"" } else { "" }).collect();
    let cells = |tag: &str, cells: &[String]| -> String {
        let set = cells.iter().zip(&classes);
        set.map(|(cell, class)| format!("<{tag}{class}>{}</{tag}>", inline(cell))).collect()
    };
    let row = |(i, cells_of): (usize, &Vec<String>)| {
        let class = if table.chosen == Some(i) { " class=\"chosen\"" } else { "" };
        format!("<tr{class}>{}</tr>\n", cells("td", cells_of))
    };
    let rows: String = table.rows.iter().enumerate().map(row).collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        cells("th", &table.head)
    )
}

/// An SVG for embedding in HTML, scaled to the page width.
fn scalable(svg: &str) -> String {
    let Some(begin) = svg.find("<svg") else { return svg.to_owned() };
    let svg = &svg[begin..];
    let (head, rest) = svg.split_at(svg.find('>').unwrap_or(0));
    let kept: Vec<&str> = head
        .split(' ')
        .filter(|part| !["width=", "height=", "xmlns="].iter().any(|dropped| part.starts_with(dropped)))
        .collect();
    format!("{}{rest}", kept.join(" "))
}

fn inline(text: &str) -> String {
    let mut out = String::new();
    for (i, part) in text.split('`').enumerate() {
        match i % 2 {
            0 => out.push_str(&emphasised(part)),
            _ => out.push_str(&format!("<code>{}</code>", escaped(part))),
        }
    }
    out
}

fn emphasised(text: &str) -> String {
    let parts = text.split("**").enumerate();
    parts.map(|(i, part)| if i % 2 == 0 { escaped(part) } else { format!("<b>{}</b>", escaped(part)) }).collect()
}

/// Text escaped for HTML or XML, also as an attribute value, with control characters replaced.
pub fn escaped(text: &str) -> String {
    without_control(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Text with `\u{fffd}` in place of each character forbidden in XML and HTML.
pub(crate) fn without_control(text: &str) -> String {
    let is_forbidden =
        |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r') || matches!(c, '\u{fffe}' | '\u{ffff}');
    text.replace(is_forbidden, "\u{fffd}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_do_not_get_into_a_page() {
        assert_eq!(inline("a\u{1}b \u{1b}[1m\tc\n"), "a\u{fffd}b \u{fffd}[1m\tc\n");
        let svg = crate::chart::sheet("a\u{0}b\u{b}", &[], 1);
        assert!(svg.is_ok_and(|svg| !svg.contains(['\u{0}', '\u{b}'])));
    }

    #[test]
    fn characters_that_xml_forbids_are_replaced() {
        assert_eq!(escaped("a\u{1}<b>\u{1b}\t\"\u{ffff}"), "a\u{fffd}&lt;b&gt;\u{fffd}\t&quot;\u{fffd}");
    }

    #[test]
    fn text_is_escaped_backticks_are_code_and_asterisks_emphasis() {
        assert_eq!(inline("a < `b & c`, **d**"), "a &lt; <code>b &amp; c</code>, <b>d</b>");
    }

    #[test]
    fn numbers_stand_to_the_right_and_a_chosen_row_stands_out() {
        let mut table = Table::new(&["a", "b in m"]);
        table.row(["x|y".into(), "1".into()]);
        table.chosen = Some(0);
        assert!(html_table(&table).contains("<tr class=\"chosen\"><td>x|y</td><td class=\"n\">1</td></tr>"));
    }

    #[test]
    fn an_inlined_drawing_scales_with_the_page() {
        let svg = scalable("<?xml?>\n<svg width=\"9\" height=\"5\" viewBox=\"0 0 9 5\" xmlns=\"x\">\n<g/></svg>");
        assert_eq!(svg, "<svg viewBox=\"0 0 9 5\">\n<g/></svg>");
    }
}
