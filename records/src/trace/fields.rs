//! The fields of a line, and the numbers in them.
//!
//! A row of a trace is one line, so that a stray quote spoils only that row: hence no CSV parser.

use crate::format::{Decimal, Separator};
use std::ops::Range;

/// Splits a line into fields without surrounding blanks and quotes. Returns `false` if a quote is not closed.
///
/// Quotes follow RFC 4180, except that a field never continues on the next line and a doubled quote stays doubled.
pub fn split(line: &str, separator: Separator, fields: &mut Vec<Range<usize>>) -> bool {
    fields.clear();
    match separator {
        Separator::Whitespace => split_at_blanks(line, fields),
        Separator::Byte(byte) => return split_at(line, byte, fields),
    }
    true
}

/// The fields of a line as texts, without surrounding blanks and quotes; text after an unclosed quote is dropped.
pub fn texts(line: &str, separator: Separator) -> Vec<&str> {
    let mut fields = Vec::new();
    split(line, separator, &mut fields);
    fields.into_iter().map(|field| &line[field]).collect()
}

/// Whether a number is an instrument's mark for a missing reading: SCPI writes 9.9E37 for an overload, -9.9E37 for an underrange
/// and 9.91E37 for NaN, mostly in single precision, which may round down.
#[inline]
pub fn is_no_reading(number: f64) -> bool {
    const MARK: f64 = 9.9e37 * (1.0 - 1e-6);
    number.abs() >= MARK
}

/// The number in a field.
#[inline]
pub fn number(text: &str, decimal: Decimal) -> Option<f64> {
    let plain = match decimal {
        Decimal::Point => text.parse().ok(),
        Decimal::Comma => with_point(text).and_then(|text| text.as_str()?.parse().ok()),
    };
    plain.or_else(|| grouped(text, decimal))
}

/// Parses a number with grouped thousands, such as `101'325.0`, `101 325,0` and `101.325,0`. A point or comma separates thousands
/// only if the other one follows: alone it would be a decimal sign.
#[cold]
fn grouped(text: &str, decimal: Decimal) -> Option<f64> {
    const MARKS: [char; 6] = ['\'', '’', ' ', '\u{a0}', '\u{202f}', '\u{2009}'];
    let (sign, other) = match decimal {
        Decimal::Point => ('.', ','),
        Decimal::Comma => (',', '.'),
    };
    let (whole, decimals) = text.split_once(sign).map_or((text, None), |(whole, decimals)| (whole, Some(decimals)));
    let digits = whole.trim_start_matches(['-', '+']);
    let mark = digits.chars().find(|c| !c.is_ascii_digit())?;
    let sets_apart = MARKS.contains(&mark) || (mark == other && decimals.is_some());
    let are_digits = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let (first, rest) = digits.split_once(mark)?;
    let are_groups =
        (1..=3).contains(&first.len()) && rest.split(mark).all(|group| group.len() == 3 && are_digits(group));
    if !(sets_apart && are_groups) {
        return None;
    }
    format!("{}.{}", whole.replace(mark, ""), decimals.unwrap_or("0")).parse().ok()
}

/// A number's text with its decimal comma replaced by a point, on the stack.
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
    // A point beside a decimal comma separates thousands, or is a decimal point after all.
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

/// Position of the quote that ends a field; doubled quotes are part of the field.
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
    fn marks_of_no_reading_are_known_also_in_single_precision() {
        for mark in [9.9e37, -9.9e37, 9.91e37, f64::from(9.9e37_f32), 1e38] {
            assert!(is_no_reading(mark), "{mark}");
        }
        assert!(!is_no_reading(9.8e37) && !is_no_reading(1e9));
    }

    #[test]
    fn an_open_quote_is_seen() {
        assert!(!split("\"1,2", Separator::Byte(b','), &mut Vec::new()));
        assert!(!split("\"", Separator::Byte(b','), &mut Vec::new()));
    }

    #[test]
    fn thousands_may_be_set_apart_where_that_is_no_decimal_sign() {
        for text in ["101.325,5", "101'325,5", "101 325,5", "101\u{a0}325,5", "101\u{202f}325,5"] {
            assert_eq!(number(text, Decimal::Comma), Some(101_325.5), "{text}");
        }
        assert_eq!(number("-1,101,325.5e-3", Decimal::Point), Some(-1101.3255));
        assert_eq!(number("1'101’325", Decimal::Point), None);
        assert_eq!(number("1'101'325", Decimal::Point), Some(1_101_325.0));
        for not in ["101,325", "1,01,325.5", "1013,255.5", ",325.5", "1,325,.5", "1 2", "12:000.5", "1,325.5.5"] {
            assert_eq!(number(not, Decimal::Point), None, "{not}");
        }
        assert_eq!(number("101.325", Decimal::Comma), None);
    }

    #[test]
    fn a_decimal_comma_reads_as_the_same_number() {
        assert_eq!(number("-1,25e-3", Decimal::Comma), number("-1.25e-3", Decimal::Point));
        assert_eq!(number("101325", Decimal::Comma), Some(101325.0));
        for not in ["1,2,3", "1.00,5", "1.5", "", "a", &"1".repeat(50)] {
            assert_eq!(number(not, Decimal::Comma), None, "{not}");
        }
    }
}
