//! The guide's reference pages, made from the declarations in the code; each test holds one page up to date.
//!
//! `UPDATE_EXPECT=1 cargo test reference` writes the pages anew.

mod columns;
mod command_line;
mod effects;
mod fmu;

use std::fmt::Write;

/// First line of every page that is made here.
const MADE: &str =
    "<!-- Made by `UPDATE_EXPECT=1 cargo test reference`; change the declaration, not this page. -->\n\n";

/// A Markdown table with that heading; `|` in cells is escaped.
fn table<const N: usize>(heading: [&str; N], rows: impl IntoIterator<Item = [String; N]>) -> String {
    let mut text = format!("| {} |\n|{}\n", heading.join(" | "), "---|".repeat(N));
    for row in rows {
        writeln!(text, "| {} |", row.map(|cell| cell.replace('|', "\\|")).join(" | ")).expect("a String takes all");
    }
    text
}
