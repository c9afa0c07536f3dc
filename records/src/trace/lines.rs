//! The lines of a text file with their numbers and fields: bounded in memory, hashed on the way.

use super::problem::TraceProblem;
use crate::layout::Separator;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::io::{self, BufRead, BufReader, Read};
use std::ops::Range;

/// The largest trace, bytes.
pub const MAX_BYTES: u64 = 512 << 20;
/// The longest line, bytes.
const MAX_LINE: u64 = 1 << 20;

/// Why no next line could be had.
pub enum Stop {
    /// The system's reason.
    Io(io::Error),
    /// The file's.
    Problem(TraceProblem),
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Stop::Io(error)
    }
}

impl From<TraceProblem> for Stop {
    fn from(problem: TraceProblem) -> Self {
        Stop::Problem(problem)
    }
}

/// A file read line by line.
pub struct Lines<R> {
    source: BufReader<R>,
    hash: Sha256,
    bytes: u64,
    /// Of the current line, from 1.
    number: usize,
    buffer: Vec<u8>,
}

impl<R: Read> Lines<R> {
    /// Begins at the first line.
    pub fn new(source: R) -> Self {
        Self {
            source: BufReader::with_capacity(1 << 16, source),
            hash: Sha256::new(),
            bytes: 0,
            number: 0,
            buffer: Vec::new(),
        }
    }

    /// The next line that is not blank, with its number and without its end; `None` after the last.
    pub fn next_filled(&mut self) -> Result<Option<(usize, &str)>, Stop> {
        loop {
            self.buffer.clear();
            let read = self.source.by_ref().take(MAX_LINE).read_until(b'\n', &mut self.buffer)? as u64;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            self.bytes += read;
            self.hash.update(&self.buffer);
            self.refuse_what_is_no_text(read)?;
            if self.buffer.iter().any(|byte| !byte.is_ascii_whitespace()) {
                break;
            }
        }
        let line = match self.number {
            1 => self.buffer.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&self.buffer),
            _ => &self.buffer,
        };
        let what = "bytes that are not UTF-8";
        let line = std::str::from_utf8(line).map_err(|_| TraceProblem::NotText { line: self.number, what })?;
        Ok(Some((self.number, line.trim_end_matches(['\n', '\r']))))
    }

    fn refuse_what_is_no_text(&self, read: u64) -> Result<(), TraceProblem> {
        let line = self.number;
        if self.bytes > MAX_BYTES {
            return Err(too_large(&format!("more than {} MB", MAX_BYTES >> 20)));
        }
        if line == 1 && (self.buffer.starts_with(b"\xff\xfe") || self.buffer.starts_with(b"\xfe\xff")) {
            return Err(TraceProblem::NotText { line, what: "text in UTF-16" });
        }
        if self.buffer.contains(&0) {
            return Err(TraceProblem::NotText { line, what: "binary data" });
        }
        if read == MAX_LINE && !self.buffer.ends_with(b"\n") {
            return Err(TraceProblem::NotText { line, what: "a line of more than a million bytes" });
        }
        Ok(())
    }

    /// SHA-256 of what was read so far, in hexadecimal digits.
    pub fn sha256(self) -> String {
        self.hash.finalize().iter().fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
    }
}

/// A file that is larger than a trace may be.
pub fn too_large(found: &str) -> TraceProblem {
    TraceProblem::TooLarge { found: found.to_owned(), limit: format!("{} MB", MAX_BYTES >> 20) }
}

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

    fn fields(line: &str, separator: Separator) -> Vec<&str> {
        let mut ranges = Vec::new();
        assert!(split(line, separator, &mut ranges), "{line}");
        ranges.into_iter().map(|range| &line[range]).collect()
    }

    #[test]
    fn fields_lose_blanks_and_quotes_but_not_what_is_in_them() {
        let comma = Separator::Byte(b',');
        assert_eq!(fields(r#"1, 2.5 ,"a, b", "c" ,"#, comma), ["1", "2.5", "a, b", "c", ""]);
        assert_eq!(fields("1\t\t3", Separator::Byte(b'\t')), ["1", "", "3"]);
        assert_eq!(fields("  0.00 4.1   -2\t7 ", Separator::Whitespace), ["0.00", "4.1", "-2", "7"]);
        assert_eq!(fields(r#""say ""x""";2"#, Separator::Byte(b';')), [r#"say ""x"""#, "2"]);
    }

    #[test]
    fn an_open_quote_is_seen() {
        assert!(!split("\"1,2", Separator::Byte(b','), &mut Vec::new()));
        assert!(!split("\"", Separator::Byte(b','), &mut Vec::new()));
    }

    #[test]
    fn the_hash_is_that_of_the_bytes() {
        let mut lines = Lines::new(&b"\xef\xbb\xbfa\r\n\r\n\nb\n"[..]);
        assert!(matches!(lines.next_filled(), Ok(Some((1, "a")))));
        assert!(matches!(lines.next_filled(), Ok(Some((4, "b")))));
        assert!(matches!(lines.next_filled(), Ok(None)));
        // printf '\xef\xbb\xbfa\r\n\r\n\nb\n' | sha256sum
        assert_eq!(lines.sha256(), HASH);
    }

    const HASH: &str = "691ca06aa362820289b1c12005afc55adadd714c011720d65666c82142579ec3";
}
