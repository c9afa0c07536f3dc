//! The first rows of a trace file, before its columns are identified.

use super::clock;
use super::content::Content;
use super::dialect::Dialect;
use super::fields::{is_no_reading, number, texts};
use super::lines::Line;
use super::read::{dialect, with_lines};
use crate::error::Error;
use crate::format::Encoding;
use crate::layout::{Layout, Quantity};
use crate::names::nearest;
use std::path::Path;

/// Contents of the columns in a file's first rows.
#[derive(Clone, Debug, Default)]
pub struct Sample {
    /// The numbers of each column, without other text and marks of missing readings.
    pub numbers: Vec<Vec<f64>>,
    /// Whether a column holds clock times or dates.
    pub moments: Vec<bool>,
}

impl Sample {
    /// Reads a file's first lines.
    pub fn of<'l>(dialect: &Dialect, head: impl IntoIterator<Item = &'l Line>) -> Self {
        let count = dialect.names.len();
        let (mut numbers, mut moments) = (vec![Vec::new(); count], vec![0_usize; count]);
        let rows = head.into_iter().filter(|(line, text)| *line >= dialect.first_row && !dialect.is_comment(text));
        for (_, text) in rows {
            for (k, field) in texts(text, dialect.separator).into_iter().enumerate().take(count) {
                match number(field, dialect.decimal) {
                    Some(number) if is_no_reading(number) => {}
                    Some(number) => numbers[k].push(number),
                    None => moments[k] += usize::from(clock::is_moment(field)),
                }
            }
        }
        let moments = moments.iter().zip(&numbers).map(|(moments, numbers)| *moments > numbers.len()).collect();
        Self { numbers, moments }
    }

    /// Whether no row holds a number or a moment.
    pub fn is_empty(&self) -> bool {
        self.numbers.iter().all(Vec::is_empty) && !self.moments.contains(&true)
    }
}

/// The column with the name nearest to that of a missing quantity, and the name wanted.
pub fn near_column(path: &Path, layout: &Layout, quantity: Quantity) -> Option<(String, String)> {
    let (dialect, _, _) = sample(path, &Content::File, layout).ok()?;
    let wanted = &layout.column(quantity).name;
    let others = layout.columns.iter().map(|column| column.name.as_str());
    let free = dialect.names.iter().map(String::as_str).filter(|name| others.clone().all(|other| other != *name));
    Some((nearest(wanted, free)?.to_owned(), wanted.clone()))
}

/// A file's text format and its first rows.
///
/// # Errors
/// An unreadable file, or one that is not text.
pub fn sample(path: &Path, content: &Content, layout: &Layout) -> Result<(Dialect, Encoding, Sample), Error> {
    with_lines(path, content, layout, |lines| {
        let dialect = dialect(lines, layout)?;
        let sample = Sample::of(&dialect, lines.head()?);
        Ok((dialect, lines.encoding(), sample))
    })
}
