//! The fields of a line, and the numbers in them.
//!
//! A row of a trace is a line: a stray quote spoils that row and no more, which is why this is no CSV parser's work.

use crate::format::{Decimal, Separator};
use std::ops::Range;

/// Splits a line into fields, blanks and quotes around them taken off. `false` when a quote is not closed.
///
/// Quotes follow RFC 4180, but that a field never goes on in the next line and a doubled quote stays doubled.
pub fn split(line: &str, separator: Separator, fields: &mut Vec<Range<usize>>) -> bool {
    fields.clear();
    match separator {
        Separator::Whitespace => split_at_blanks(line, fields),
        Separator::Byte(byte) => return split_at(line, byte, fields),
    }
    true
}

/// The fields of a line as texts, blanks and quotes around them taken off; what follows an open quote is left out.
pub fn texts(line: &str, separator: Separator) -> Vec<&str> {
    let mut fields = Vec::new();
    split(line, separator, &mut fields);
    fields.into_iter().map(|field| &line[field]).collect()
}

/// The number in a field.
#[inline]
pub fn number(text: &str, decimal: Decimal) -> Option<f64> {
    match decimal {
        Decimal::Point => text.parse().ok(),
        Decimal::Comma => with_point(text)?.as_str()?.parse().ok(),
    }
}

/// A number's text with a point in place of its comma, on the stack.
struct Pointed([u8; 40], usize);

impl Pointed {
    fn as_str(&self) -> Option<&str> {
        std::str::from_utf8(&self.0[..self.1]).ok()
    }
}

fn with_point(text: &str) -> Option<Pointed> {
    let mut pointed = Pointed([0; 40], text.len());
    let bytes = pointed.0.get_mut(..text.len())?;
    bytes.copy_from_slice(text.as_bytes());
    // A point beside a decimal comma would separate thousands, or be a decimal point after all.
    if bytes.contains(&b'.') {
        return None;
    }
    if let Some(comma) = bytes.iter().position(|byte| *byte == b',') {
        bytes[comma] = b'.';
    }
    Some(pointed)
}

fn split_at_blanks(line: &str, fields: &mut Vec<Range<usize>>) {
    let mut begin = None;
    for (i, byte) in line.bytes().enumerate() {
        match (byte.is_ascii_whitespace(), begin) {
            (false, None) => begin = Some(i),
            (true, Some(from)) => {
                fields.push(from..i);
                begin = None;
            }
            _ => {}
        }
    }
    fields.extend(begin.map(|from| from..line.len()));
}

fn split_at(line: &str, separator: u8, fields: &mut Vec<Range<usize>>) -> bool {
    let bytes = line.as_bytes();
    let mut from = 0;
    loop {
        let content = from + bytes[from..].iter().take_while(|byte| **byte == b' ').count();
        let quoted = bytes.get(content) == Some(&b'"');
        let end = if quoted { closing_quote(bytes, content + 1) } else { Some(content) };
        let Some(end) = end else { return false };
        let next = bytes[end..].iter().position(|byte| *byte == separator).map(|i| end + i);
        let field = if quoted { content + 1..end } else { from..next.unwrap_or(bytes.len()) };
        fields.push(trimmed(line, field));
        match next {
            Some(next) => from = next + 1,
            None => return true,
        }
    }
}

/// Where the quote that ends a field stands, a doubled one being part of the field.
fn closing_quote(bytes: &[u8], mut at: usize) -> Option<usize> {
    loop {
        at += bytes[at..].iter().position(|byte| *byte == b'"')?;
        if bytes.get(at + 1) != Some(&b'"') {
            return Some(at);
        }
        at += 2;
    }
}

fn trimmed(line: &str, field: Range<usize>) -> Range<usize> {
    let text = &line[field.clone()];
    let begin = field.start + (text.len() - text.trim_start().len());
    begin..begin + text.trim().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_lose_blanks_and_quotes_but_not_what_is_in_them() {
        let comma = Separator::Byte(b',');
        assert_eq!(texts(r#"1, 2.5 ,"a, b", "c" ,"#, comma), ["1", "2.5", "a, b", "c", ""]);
        assert_eq!(texts("1\t\t3", Separator::Byte(b'\t')), ["1", "", "3"]);
        assert_eq!(texts("  0.00 4.1   -2\t7 ", Separator::Whitespace), ["0.00", "4.1", "-2", "7"]);
        assert_eq!(texts(r#""say ""x""";2"#, Separator::Byte(b';')), [r#"say ""x"""#, "2"]);
    }

    #[test]
    fn an_open_quote_is_seen() {
        assert!(!split("\"1,2", Separator::Byte(b','), &mut Vec::new()));
        assert!(!split("\"", Separator::Byte(b','), &mut Vec::new()));
    }

    #[test]
    fn a_decimal_comma_reads_as_the_same_number() {
        assert_eq!(number("-1,25e-3", Decimal::Comma), number("-1.25e-3", Decimal::Point));
        assert_eq!(number("101325", Decimal::Comma), Some(101325.0));
        for not in ["1,2,3", "1.000,5", "1.5", "", "a", &"1".repeat(50)] {
            assert_eq!(number(not, Decimal::Comma), None, "{not}");
        }
    }
}
