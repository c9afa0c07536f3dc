//! Text format of a trace file, detected from its first lines: separator, decimal sign, header, units line.
//!
//! Statements of a rig file take precedence. Otherwise the format is chosen that turns most fields of most lines into numbers;
//! the header is the line with the wanted names or, if there is none, the last line before the numbers with as many fields.

use super::clock;
use super::fields::{number, texts};
use super::header_line::{header, is_units, labview_units, names};
use super::lines::Line;
use crate::format::{Decimal, Format, Separator};
use std::collections::HashMap;

/// Default prefixes of comments.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Text format of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Dialect {
    /// Separator between columns.
    pub separator: Separator,
    /// Decimal sign.
    pub decimal: Decimal,
    /// Prefixes of comments.
    pub comments: Vec<String>,
    /// Line of the header; `None` if the file begins with numbers.
    pub header: Option<usize>,
    /// Names of the columns; `column 1` and so on where there is no header.
    pub names: Vec<String>,
    /// The units line and its text for each column.
    pub units: Option<(usize, Vec<String>)>,
    /// Line of the first row.
    pub first_row: usize,
    /// Minimum number of fields in a row.
    pub fields: usize,
}

impl Dialect {
    /// Detects it from the file's first lines; `wanted` are names expected in the header.
    pub fn find<'l>(head: impl IntoIterator<Item = &'l Line>, format: &Format, wanted: &[&str]) -> Self {
        let comments: Vec<String> = match &format.comment {
            Some(comment) => vec![comment.clone()],
            None => COMMENTS.map(str::to_owned).to_vec(),
        };
        let is_comment = |line: &str| comments.iter().any(|begin| line.trim_start().starts_with(begin));
        let all: Vec<&Line> = head.into_iter().collect();
        let rows: Vec<&Line> = all.iter().copied().filter(|(_, line)| !is_comment(line)).collect();
        let Body { separator, decimal, fields, first } = Body::find(&rows, format, wanted);
        let first_numbers = first.map_or(usize::MAX, |index| rows[index].0);
        // Lines before the numbers, including comments, as some loggers write the header as one.
        let before: Vec<&Line> = all.iter().copied().filter(|(number, _)| *number < first_numbers).collect();
        let split = |line: &str| names(line, &comments, separator, fields);
        let header = header(&before, &rows, &split, wanted, fields, is_comment);
        let Some(header) = header else {
            let names = (1..=fields).map(|k| format!("column {k}")).collect();
            return Self {
                separator,
                decimal,
                comments,
                header: None,
                names,
                units: None,
                first_row: first_numbers,
                fields,
            };
        };
        let numbers = |line: &str| texts(line, separator).into_iter().any(|text| is_number(text, decimal));
        let after = rows.iter().filter(|(number, _)| *number > header.0);
        let mut between = after.clone().take_while(|(number, line)| *number < first_numbers && !numbers(line));
        let units = between.find(|(_, line)| is_units(&split(line))).map(|(number, line)| (*number, split(line)));
        let units = units.or_else(|| labview_units(&before, separator));
        // In a file without numbers, the units line is not a row either.
        let last = header.0.max(units.as_ref().map_or(0, |(line, _)| *line));
        let first_row = after.clone().find(|(_, line)| numbers(line)).or(after.clone().find(|(line, _)| *line > last));
        let names = split(&header.1);
        Self {
            separator,
            decimal,
            comments,
            header: Some(header.0),
            units,
            first_row: first_row.map_or(last + 1, |(number, _)| *number),
            fields: if fields == 0 { names.len() } else { fields.min(names.len()) },
            names,
        }
    }

    /// Whether a line is a comment.
    #[inline]
    pub fn is_comment(&self, line: &str) -> bool {
        let line = line.trim_start();
        !line.starts_with(|c: char| c.is_ascii_digit() || c == '-')
            && self.comments.iter().any(|begin| line.starts_with(begin))
    }

    /// Index of the column with that name, or of `column 3`, and of the second one if two have it.
    pub fn find_column(&self, name: &str) -> (Option<usize>, Option<usize>) {
        // A `#` before the header is not part of the first name, whether or not the rig file writes it.
        let wanted = name.trim_start_matches('#').trim();
        let mut indices = self.names.iter().enumerate().filter(|(_, name)| *name == wanted).map(|(index, _)| index);
        match (indices.next(), indices.next()) {
            (None, _) => {
                let number = wanted.strip_prefix("column ").and_then(|number| number.parse::<usize>().ok());
                (number.filter(|k| (1..=self.names.len()).contains(k)).map(|k| k - 1), None)
            }
            found => found,
        }
    }
}

/// The part of a file that contains its numbers.
struct Body {
    separator: Separator,
    decimal: Decimal,
    /// Fields of a typical row, without trailing empty ones; 0 if no line has numbers.
    fields: usize,
    /// Index of its first line.
    first: Option<usize>,
}

impl Body {
    fn find(rows: &[&Line], format: &Format, wanted: &[&str]) -> Self {
        let mut best: (f64, Option<Body>) = (0.0, None);
        for (_, separator) in Separator::ALL {
            for (_, decimal) in Decimal::ALL {
                let stated = format.separator.is_none_or(|s| s == separator)
                    && format.decimal.is_none_or(|d| d == decimal)
                    && (separator, decimal) != (Separator::Byte(b','), Decimal::Comma);
                if !stated {
                    continue;
                }
                if let Some((score, body)) = Self::read_as(rows, separator, decimal)
                    && score > best.0
                {
                    best = (score, Some(body));
                }
            }
        }
        best.1.unwrap_or_else(|| {
            // No numbers: the line with most of the wanted names, or the first.
            let hits = |line: &str| wanted.iter().filter(|name| line.contains(**name)).count();
            let line = rows.iter().rev().max_by_key(|(_, line)| hits(line)).map_or("", |(_, line)| line.as_str());
            let in_line = |(_, separator): &(_, Separator)| match separator {
                Separator::Byte(byte) => line.as_bytes().contains(byte),
                Separator::Whitespace => false,
            };
            let found = Separator::ALL.iter().find(|s| in_line(s)).map_or(Separator::Whitespace, |s| s.1);
            let decimal = format.decimal.unwrap_or(Decimal::Point);
            Self { separator: format.separator.unwrap_or(found), decimal, fields: 0, first: None }
        })
    }

    /// Interprets the rows with this separator and decimal sign: a score of the fit, and where they begin.
    fn read_as(rows: &[&Line], separator: Separator, decimal: Decimal) -> Option<(f64, Self)> {
        let shape = |line: &str| -> Vec<bool> {
            let mut fields = texts(line, separator);
            while fields.last().is_some_and(|field| field.is_empty()) {
                fields.pop();
            }
            fields.into_iter().map(|text| is_number(text, decimal)).collect()
        };
        let shapes: Vec<Vec<bool>> = rows.iter().map(|(_, line)| shape(line)).collect();
        let numbers = |shape: &[bool]| shape.iter().filter(|is| **is).count();
        let mut counts: HashMap<&[bool], usize> = HashMap::new();
        for shape in shapes.iter().filter(|shape| numbers(shape) >= 2) {
            *counts.entry(shape).or_default() += 1;
        }
        // The most frequent shape; among equals the one with more numbers, then the longer one.
        let (usual, count) = counts.into_iter().max_by_key(|(shape, count)| (*count, numbers(shape), shape.len()))?;
        let mut first = shapes.iter().position(|shape| shape == usual)?;
        // Preceding lines that lack a number or two are rows as well.
        let alike = |shape: &[bool]| shape.len() == usual.len() && 2 * numbers(shape) >= numbers(usual);
        while first > 0 && alike(&shapes[first - 1]) {
            first -= 1;
        }
        let score = count as f64 * numbers(usual) as f64 / usual.len() as f64;
        Some((score, Self { separator, decimal, fields: usual.len(), first: Some(first) }))
    }
}

fn is_number(text: &str, decimal: Decimal) -> bool {
    number(text, decimal).is_some() || clock::is_moment(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find(text: &str, wanted: &[&str]) -> Dialect {
        let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        let lines: Vec<Line> = lines.map(|(i, line)| (i + 1, line.to_owned())).collect();
        Dialect::find(&lines, &Format::default(), wanted)
    }

    #[track_caller]
    fn assert_found(
        text: &str,
        separator: &str,
        decimal: Decimal,
        header: Option<usize>,
        first_row: usize,
        names: &[&str],
    ) {
        let found = find(text, &[]);
        let seen = (found.separator.name(), found.decimal, found.header, found.first_row);
        assert_eq!(seen, (separator, decimal, header, first_row), "{text}");
        assert_eq!(found.names, names, "{text}");
    }

    #[test]
    fn separator_and_decimal_sign_are_those_that_make_numbers() {
        let names = ["t", "p", "x"];
        assert_found("t,p,x\n0.0,1e5,0.1\n0.1,1e5,0.1\n", ",", Decimal::Point, Some(1), 2, &names);
        assert_found("t;p;x\n0,0;1e5;0,1\n0,1;1e5;0,1\n", ";", Decimal::Comma, Some(1), 2, &names);
        assert_found("t\tp\tx\n0,0\t1\t0,1\n0,1\t1\t0,1\n", "tab", Decimal::Comma, Some(1), 2, &names);
        assert_found("t p x\n0.0 1e5   0.1\n0.1 1e5 0.1\n", "whitespace", Decimal::Point, Some(1), 2, &names);
        assert_found("t, p, x\n0, 100, 1\n1, 100, 1\n", ",", Decimal::Point, Some(1), 2, &names);
        assert_found("t;p;x\n0;1;1\n1;1;1\n", ";", Decimal::Point, Some(1), 2, &names);
        assert_found("t;p;x\n12:00:00,1;1,5;1\n12:00:00,2;2,5;1\n", ";", Decimal::Comma, Some(1), 2, &names);
    }

    #[test]
    fn header_blocks_units_lines_and_comments_are_passed_over() {
        let names = ["t", "p", "x"];
        let block = "Logger 7;Version 2\nChannels;2\nStart;22.11.2026\n\nt;p;x\n[s];[bar];[mm]\n0;1;1\n1;1;1\n2;2;2\n";
        assert_found(block, ";", Decimal::Point, Some(5), 7, &names);
        assert_eq!(find(block, &[]).units, Some((6, ["[s]", "[bar]", "[mm]"].map(str::to_owned).to_vec())));
        assert_found(
            "# made by a person\n# twice\nt,p,x\n0,1,2\n# later\n1,1,2\n",
            ",",
            Decimal::Point,
            Some(3),
            4,
            &names,
        );
        assert_found("% t p x\n0 1 2\n1 1 2\n", "whitespace", Decimal::Point, Some(1), 2, &names);
        assert_found("t  p  x\n-- -- --\n0 1 2\n1 1 2\n", "whitespace", Decimal::Point, Some(1), 3, &names);
        let spaced = ["Time (s)", "P (bar)", "Pos (mm)"];
        assert_found("Time (s)  P (bar)   Pos (mm)\n0 1 2\n1 1 2\n", "whitespace", Decimal::Point, Some(1), 2, &spaced);
    }

    #[test]
    fn a_labview_measurement_is_read_behind_its_two_headers() {
        let text = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\n\
                    ***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t3\t3\t\nDate\t2026/11/22\t2026/11/22\n\
                    X0\t0,0\t0,0\nDelta_X\t0,1\t0,1\n***End_of_Header***\t\t\t\n\
                    X_Value\tP\tPos\tComment\n0,0\t1,5\t2,0\n0,1\t1,5\t2,0\n0,2\t1,5\t2,0\n";
        assert_found(text, "tab", Decimal::Comma, Some(13), 14, &["X_Value", "P", "Pos", "Comment"]);
        assert_eq!(find(text, &[]).fields, 3);
    }

    #[test]
    fn a_file_that_begins_with_numbers_has_numbered_columns() {
        assert_found("0 1 2\n1 1 2\n", "whitespace", Decimal::Point, None, 1, &["column 1", "column 2", "column 3"]);
        assert_eq!(find("a b\n0 1\n1 1\n", &[]).find_column("column 2"), (Some(1), None));
    }

    #[test]
    fn a_list_of_channels_above_the_header_is_not_the_header() {
        let text = "Title\tRun 12\nNI_ChannelName\tt\tp\tx\n\nt\tp\tx\ns\tbar\tmm\n0\t1\t2\n1\t1\t2\n";
        let found = find(text, &["t", "p", "x"]);
        assert_eq!(
            (found.header, found.first_row, &found.names[..]),
            (Some(4), 6, &["t", "p", "x"].map(str::to_owned)[..])
        );
        assert_eq!(found.units, Some((5, ["s", "bar", "mm"].map(str::to_owned).to_vec())));
    }

    #[test]
    fn the_wanted_names_identify_the_header_in_any_line() {
        let text = "a,b,c\nt,p,x\nseconds passed,pressure seen,way\n0,1,2\n1,1,2\n";
        let found = find(text, &["t", "x"]);
        assert_eq!((found.header, found.first_row), (Some(2), 4));
    }
}
