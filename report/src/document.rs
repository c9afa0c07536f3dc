//! A small document: sections of text, tables and figures, rendered as Markdown here and as HTML in [`page`](crate::page).
//!
//! Text may contain `code` in backticks and **words** between double asterisks; everything else is literal.

/// A section with a title.
pub struct Section {
    /// Heading of the section.
    pub title: String,
    /// Paragraphs, tables and figures in the order in which they appear.
    pub blocks: Vec<Block>,
}

/// A part of a section.
pub enum Block {
    /// A paragraph of plain text.
    Text(String),
    /// A paragraph in small print.
    Note(String),
    /// A highlighted paragraph; `kind` is the class of its frame.
    Verdict {
        /// The kind, as one word.
        kind: &'static str,
        /// One or more sentences beside it.
        text: String,
    },
    /// Items of a list.
    List(Vec<String>),
    /// Rows below a header.
    Table(Table),
    /// A drawing as wide as the page.
    Figure {
        /// File name, in the report's folder.
        file: &'static str,
        /// The drawing itself.
        svg: String,
        /// Description.
        caption: String,
    },
    /// Small drawings, in rows as wide as the page.
    Charts(Vec<Drawing>),
}

/// A small drawing.
pub struct Drawing {
    /// The drawing itself.
    pub svg: String,
    /// Description; empty if the title suffices.
    pub caption: String,
}

/// Rows below a header; cells are text.
#[derive(Clone)]
pub struct Table {
    /// Column names with units.
    pub head: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<String>>,
    /// Index of the highlighted row.
    pub chosen: Option<usize>,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(|h| (*h).to_owned()).collect(), rows: Vec::new(), chosen: None }
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

    /// Adds a paragraph in small print.
    pub fn note(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Note(text.into()));
    }

    /// Adds a table.
    pub fn table(&mut self, table: Table) {
        self.blocks.push(Block::Table(table));
    }

    /// The section as Markdown, with a first-level heading. Small drawings have no file and are omitted.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n", self.title);
        for block in &self.blocks {
            out.push('\n');
            match block {
                Block::Text(text) | Block::Note(text) | Block::Verdict { text, .. } => {
                    out.push_str(&format!("{text}\n"));
                }
                Block::List(points) => points.iter().for_each(|p| out.push_str(&format!("- {p}\n"))),
                Block::Table(table) => out.push_str(&markdown_table(table)),
                Block::Figure { file, caption, .. } => out.push_str(&format!("![{caption}]({file})\n\n{caption}\n")),
                Block::Charts(_) => {}
            }
        }
        out
    }
}

fn markdown_table(table: &Table) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<String> = (0..table.head.len()).map(|i| if i == 0 { "---" } else { "---:" }.to_owned()).collect();
    let rows: String = table.rows.iter().map(|r| line(r)).collect();
    format!("{}|{}|\n{rows}", line(&table.head), rule.join("|"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_as_many_columns_in_each_row() {
        let mut table = Table::new(&["a", "b in m"]);
        table.row(["x|y".into(), "1".into()]);
        assert_eq!(markdown_table(&table), "| a | b in m |\n|---|---:|\n| x\\|y | 1 |\n");
    }
}
