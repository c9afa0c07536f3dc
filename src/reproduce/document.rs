//! A small document: sections of text, tables and figures, written as Markdown or as one self-contained HTML page.
//!
//! Text may hold `code` in backticks; everything else is taken literally.

/// A titled part.
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What follows it.
    pub blocks: Vec<Block>,
}

/// A part of a section.
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Rows below a header.
    Table(Table),
    /// A drawing.
    Figure {
        /// Its file beside the report.
        file: &'static str,
        /// The drawing itself.
        svg: String,
        /// What it shows, in words.
        caption: String,
    },
}

/// Rows below a header; cells are text.
#[derive(Clone)]
pub struct Table {
    /// Column names with units.
    pub head: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(|h| (*h).to_owned()).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.into());
    }
}

impl Section {
    /// A section without content.
    pub fn new(title: &str) -> Self {
        Self { title: title.to_owned(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn text(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Text(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// As Markdown, with a heading of the first level.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n", self.title);
        for block in &self.blocks {
            out.push('\n');
            match block {
                Block::Text(text) => out.push_str(&format!("{text}\n")),
                Block::Table(table) => out.push_str(&markdown_table(table)),
                Block::Figure { file, caption, .. } => out.push_str(&format!("![{caption}]({file})\n\n{caption}\n")),
            }
        }
        out
    }

    fn html(&self) -> String {
        let mut out = format!("<section>\n<h2>{}</h2>\n", escaped(&self.title));
        for block in &self.blocks {
            match block {
                Block::Text(text) => out.push_str(&format!("<p>{}</p>\n", inline(text))),
                Block::Table(table) => out.push_str(&html_table(table)),
                Block::Figure { file, svg, caption } => out.push_str(&format!(
                    "<figure role=\"img\" aria-label=\"{}\">\n{}\n<figcaption>{} (<code>{file}</code>)</figcaption>\n</figure>\n",
                    escaped(caption),
                    scalable(svg),
                    inline(caption),
                )),
            }
        }
        out.push_str("</section>\n");
        out
    }
}

/// One page with everything in it: light, printable, no script, no network.
pub fn page(title: &str, lead: &str, sections: &[Section]) -> String {
    let body: String = sections.iter().map(Section::html).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p class=\"lead\">{lead}</p>\n{body}</body>\n</html>\n",
        title = escaped(title),
        lead = inline(lead),
    )
}

const STYLE: &str = "\
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.8rem; line-height: 1.2; } h2 { font-size: 1.3rem; margin-top: 2.5rem; border-bottom: 1px solid #ccc; padding-bottom: .2rem; }
.lead { font-size: 1.1rem; color: #444; }
table { border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .25rem .7rem; text-align: left; border-bottom: 1px solid #ddd; }
th { border-bottom: 2px solid #888; vertical-align: bottom; } .n { text-align: right; } td.n { white-space: nowrap; }
tr { break-inside: avoid; } .scroll { overflow-x: auto; }
figure { margin: 1.5rem 0; } figure svg { width: 100%; height: auto; } figcaption { color: #444; font-size: .92rem; }
code { background: #f3f3f3; padding: 0 .25em; border-radius: 3px; font-size: .92em; }
@page { margin: 15mm; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } table { font-size: 7.5pt; } th, td { padding: .1rem .35rem; } figure { break-inside: avoid; } h2 { break-after: avoid; } p { orphans: 3; widows: 3; } .scroll { overflow: visible; } figcaption, .lead { font-size: 1em; } }
";

fn markdown_table(table: &Table) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<String> = (0..table.head.len()).map(|i| if i == 0 { "---" } else { "---:" }.to_owned()).collect();
    let rows: String = table.rows.iter().map(|r| line(r)).collect();
    format!("{}|{}|\n{rows}", line(&table.head), rule.join("|"))
}

/// Whether a column is set as numbers are: to the right, in one line. The first names its row.
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
    let rows: String = table.rows.iter().map(|r| format!("<tr>{}</tr>\n", cells("td", r))).collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        cells("th", &table.head)
    )
}

/// An SVG whose size follows the page's width.
fn scalable(svg: &str) -> String {
    let Some(begin) = svg.find("<svg") else { return svg.to_owned() };
    let svg = &svg[begin..];
    let (head, rest) = svg.split_at(svg.find('>').unwrap_or(0));
    let kept: Vec<&str> =
        head.split(' ').filter(|part| !part.starts_with("width=") && !part.starts_with("height=")).collect();
    format!("{}{rest}", kept.join(" "))
}

fn inline(text: &str) -> String {
    let mut out = String::new();
    for (i, part) in text.split('`').enumerate() {
        match i % 2 {
            0 => out.push_str(&escaped(part)),
            _ => out.push_str(&format!("<code>{}</code>", escaped(part))),
        }
    }
    out
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number with that many significant digits, with an exponent where it is very large or small.
pub fn digits(value: f64, significant: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&exponent) {
        return format!("{value:.*e}", significant.saturating_sub(1));
    }
    format!("{value:.*}", (significant as i32 - 1 - exponent).max(0) as usize)
}

/// A ratio as a percentage with that many decimals and its sign.
pub fn signed_percent(ratio: f64, decimals: usize) -> String {
    format!("{:+.decimals$}\u{a0}%", 100.0 * ratio)
}

/// A ratio as a percentage with that many decimals.
pub fn percent(ratio: f64, decimals: usize) -> String {
    format!("{:.decimals$}\u{a0}%", 100.0 * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_backticks_are_code() {
        assert_eq!(inline("a < `b & c`"), "a &lt; <code>b &amp; c</code>");
    }

    #[test]
    fn numbers_keep_their_significant_digits() {
        for (value, text) in
            [(26.116_87, "26.12"), (4.0800e-3, "0.004080"), (3.92e-5, "3.920e-5"), (-202_241.0, "-202241")]
        {
            assert_eq!(digits(value, 4), text);
        }
        assert_eq!(signed_percent(0.0667, 1), "+6.7\u{a0}%");
    }

    #[test]
    fn a_table_has_as_many_columns_in_each_row() {
        let mut table = Table::new(&["a", "b in m"]);
        table.row(["x|y".into(), "1".into()]);
        let text = markdown_table(&table);
        assert_eq!(text, "| a | b in m |\n|---|---:|\n| x\\|y | 1 |\n");
        assert!(html_table(&table).contains("<td>x|y</td><td class=\"n\">1</td>"));
    }

    #[test]
    fn an_inlined_drawing_scales_with_the_page() {
        let svg = scalable("<?xml?>\n<svg width=\"9\" height=\"5\" viewBox=\"0 0 9 5\" xmlns=\"x\">\n<g/></svg>");
        assert_eq!(svg, "<svg viewBox=\"0 0 9 5\" xmlns=\"x\">\n<g/></svg>");
    }
}
