//! The guide's reference pages, generated from declarations in the code; each test keeps one page up to date.
//!
//! `UPDATE_EXPECT=1 cargo test reference` rewrites the pages.

mod columns;
mod command_line;
mod effects;
mod fmu;

use std::fmt::Write;

/// First line of every generated page.
const MADE: &str =
    "<!-- Made by `UPDATE_EXPECT=1 cargo test reference`; change the declaration, not this page. -->\n\n";

/// A Markdown table with this heading; `|` in cells is escaped.
fn table<const N: usize>(heading: [&str; N], rows: impl IntoIterator<Item = [String; N]>) -> String {
    let mut text = format!("| {} |\n|{}\n", heading.join(" | "), "---|".repeat(N));
    for row in rows {
        writeln!(text, "| {} |", row.map(|cell| cell.replace('|', "\\|")).join(" | ")).expect("a String takes all");
    }
    text
}
