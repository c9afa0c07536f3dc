//! Numbered lines of a text file: decoded to UTF-8, with bounded memory, hashing the file's bytes on the way.

use crate::error::trace::TraceProblem;
use crate::format::Encoding;
use encoding_rs::{UTF_16BE, UTF_16LE, WINDOWS_1252};
use encoding_rs_io::DecodeReaderBytesBuilder;
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::rc::Rc;

/// Size limit of a trace, bytes.
pub const MAX_BYTES: u64 = 512 << 20;
/// Length limit of a line, bytes of UTF-8.
const MAX_LINE: u64 = 1 << 20;
/// Part of a file used to detect its encoding, bytes.
const FIRST_BYTES: u64 = 4096;
/// Part of a file used to detect its columns, lines ...
const HEAD_LINES: usize = 300;
/// ... and bytes of UTF-8.
const HEAD_BYTES: usize = 1 << 18;

/// First bytes of spreadsheet files, and what they are.
const BINARY: [(&[u8], &str); 2] = [
    (b"PK\x03\x04", "a ZIP archive, as XLSX and ODS files are"),
    (b"\xd0\xcf\x11\xe0", "an old Office file, as XLS files are"),
];

/// Why reading the next line failed.
pub enum Stop {
    /// The system's error.
    Io(io::Error),
    /// The file cannot be a trace.
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

/// A line that is not blank, with its number.
pub type Line = (usize, String);

/// A file read line by line.
pub struct Lines<'a> {
    source: BufReader<Box<dyn Read + 'a>>,
    hashed: Rc<RefCell<Hashed>>,
    encoding: Encoding,
    /// No encoding is stated: a line that is not UTF-8 is read as Latin-1.
    free: bool,
    /// Line terminator: a lone carriage return in files of old Macintosh programs.
    end: u8,
    /// Number of the current line, from 1.
    number: usize,
    buffer: Vec<u8>,
    text: String,
    /// Lines read ahead and not yet returned.
    head: VecDeque<Line>,
}

impl<'a> Lines<'a> {
    /// Starts at the first line. Without a stated encoding, detects it from the file's first bytes.
    pub fn new(source: impl Read + 'a, stated: Option<Encoding>) -> Result<Self, Stop> {
        let hashed = Rc::new(RefCell::new(Hashed { hash: Sha256::new(), bytes: 0 }));
        let mut source = Hashing { source, hashed: Rc::clone(&hashed) };
        let mut first = Vec::new();
        source.by_ref().take(FIRST_BYTES).read_to_end(&mut first)?;
        if let Some((_, what)) = BINARY.iter().find(|(begin, _)| first.starts_with(begin)) {
            return Err(TraceProblem::NotText { line: 1, what }.into());
        }
        let encoding = stated.map_or_else(|| guessed(&first), |stated| among_utf16(stated, &first));
        let mark: &[u8] = match encoding {
            Encoding::Utf8 => b"\xef\xbb\xbf",
            Encoding::Utf16Le => b"\xff\xfe",
            Encoding::Utf16Be => b"\xfe\xff",
            Encoding::Latin1 => b"",
        };
        let end = if first.contains(&b'\r') && !first.contains(&b'\n') { b'\r' } else { b'\n' };
        let begin = if first.starts_with(mark) { mark.len() as u64 } else { 0 };
        let mut whole = Cursor::new(first).chain(source);
        whole.get_mut().0.set_position(begin);
        let source: Box<dyn Read + 'a> = match encoding {
            Encoding::Utf8 => Box::new(whole),
            Encoding::Latin1 => decoded(WINDOWS_1252, whole),
            Encoding::Utf16Le => decoded(UTF_16LE, whole),
            Encoding::Utf16Be => decoded(UTF_16BE, whole),
        };
        Ok(Self {
            source: BufReader::with_capacity(1 << 16, source),
            hashed,
            encoding,
            free: stated.is_none(),
            end,
            number: 0,
            buffer: Vec::new(),
            text: String::new(),
            head: VecDeque::new(),
        })
    }

    /// Skips that many lines.
    pub fn skip(&mut self, lines: usize) -> Result<(), Stop> {
        while self.number < lines && self.read_line()? {}
        Ok(())
    }

    /// The next lines, enough to detect the layout; [`Lines::next_filled`] returns them again.
    pub fn head(&mut self) -> Result<&VecDeque<Line>, Stop> {
        let (mut head, mut bytes) = (std::mem::take(&mut self.head), 0);
        while head.len() < HEAD_LINES && bytes < HEAD_BYTES {
            let Some((number, line)) = self.next_filled()? else { break };
            bytes += line.len();
            head.push_back((number, line.to_owned()));
        }
        self.head = head;
        Ok(&self.head)
    }

    /// The next line that is not blank, with its number and without its terminator; `None` after the last.
    #[inline]
    pub fn next_filled(&mut self) -> Result<Option<(usize, &str)>, Stop> {
        if let Some((number, line)) = self.head.pop_front() {
            self.text = line;
            return Ok(Some((number, &self.text)));
        }
        loop {
            if !self.read_line()? {
                return Ok(None);
            }
            if self.buffer.iter().any(|byte| !byte.is_ascii_whitespace()) {
                break;
            }
        }
        let number = self.number;
        let line = self.decode()?;
        Ok(Some((number, line.trim_end_matches(['\n', '\r']))))
    }

    /// Reads the next line; `false` after the last.
    fn read_line(&mut self) -> Result<bool, Stop> {
        self.buffer.clear();
        let read = self.source.by_ref().take(MAX_LINE).read_until(self.end, &mut self.buffer)? as u64;
        self.number += usize::from(read > 0);
        let line = self.number;
        if self.hashed.borrow().bytes > MAX_BYTES {
            return Err(too_large(&format!("more than {} MB", MAX_BYTES >> 20)).into());
        }
        if self.buffer.contains(&0) || (line == 1 && self.buffer.iter().any(is_control)) {
            return Err(TraceProblem::NotText { line, what: "binary data" }.into());
        }
        if read == MAX_LINE && !self.buffer.ends_with(&[self.end]) {
            return Err(TraceProblem::NotText { line, what: "a line of more than a million bytes" }.into());
        }
        Ok(read > 0)
    }

    fn decode(&mut self) -> Result<&str, TraceProblem> {
        if std::str::from_utf8(&self.buffer).is_err() {
            if !self.free {
                return Err(TraceProblem::NotText { line: self.number, what: "bytes that are not UTF-8" });
            }
            self.encoding = Encoding::Latin1;
            let line = WINDOWS_1252.decode_without_bom_handling(&self.buffer).0.into_owned();
            self.buffer = line.into_bytes();
        }
        // Checked or re-encoded above, so never empty because of invalid UTF-8.
        Ok(std::str::from_utf8(&self.buffer).unwrap_or_default())
    }

    /// Number of lines read.
    pub fn number(&self) -> usize {
        self.number
    }

    /// The encoding, as far as the lines returned so far show it.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// SHA-256 of the bytes read so far, in hexadecimal digits.
    pub fn sha256(&self) -> String {
        let hash = self.hashed.borrow().hash.clone().finalize();
        hash.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn decoded<'a>(encoding: &'static encoding_rs::Encoding, source: impl Read + 'a) -> Box<dyn Read + 'a> {
    Box::new(DecodeReaderBytesBuilder::new().encoding(Some(encoding)).build(source))
}

/// A byte that does not occur in text.
fn is_control(byte: &u8) -> bool {
    *byte < 0x20 && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x1a | 0x1b)
}

/// The encoding suggested by a file's first bytes: a byte order mark, or zeros in every other byte.
fn guessed(first: &[u8]) -> Encoding {
    match first {
        [0xff, 0xfe, ..] => return Encoding::Utf16Le,
        [0xfe, 0xff, ..] => return Encoding::Utf16Be,
        _ => {}
    }
    let zeros = |begin| first.iter().skip(begin).step_by(2).filter(|byte| **byte == 0).count();
    let (even, odd, most) = (zeros(0), zeros(1), first.len() * 2 / 5);
    match (even, odd) {
        (0, odd) if odd > most => Encoding::Utf16Le,
        (even, 0) if even > most => Encoding::Utf16Be,
        _ => Encoding::Utf8,
    }
}

/// Where UTF-16 is stated, the file's own mark decides the byte order.
fn among_utf16(stated: Encoding, first: &[u8]) -> Encoding {
    match (stated, guessed(first)) {
        (Encoding::Utf16Le, Encoding::Utf16Be) => Encoding::Utf16Be,
        (stated, _) => stated,
    }
}

struct Hashed {
    hash: Sha256,
    bytes: u64,
}

/// Hashes and counts the bytes read through it.
struct Hashing<R> {
    source: R,
    hashed: Rc<RefCell<Hashed>>,
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read(into)?;
        let mut hashed = self.hashed.borrow_mut();
        hashed.hash.update(&into[..read]);
        hashed.bytes += read as u64;
        Ok(read)
    }
}

/// An error for a file larger than a trace may be.
pub fn too_large(found: &str) -> TraceProblem {
    TraceProblem::TooLarge { found: found.to_owned(), limit: format!("{} MB", MAX_BYTES >> 20) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8], stated: Option<Encoding>) -> (Vec<Line>, Encoding, String) {
        let mut lines = Lines::new(bytes, stated).ok().unwrap();
        let mut all = Vec::new();
        while let Some((number, line)) = lines.next_filled().ok().unwrap() {
            all.push((number, line.to_owned()));
        }
        (all, lines.encoding(), lines.sha256())
    }

    #[test]
    fn the_hash_is_that_of_the_bytes() {
        let (all, encoding, hash) = lines(b"\xef\xbb\xbfa\r\n\r\n\nb\n", None);
        assert_eq!((all, encoding), (vec![(1, "a".to_owned()), (4, "b".to_owned())], Encoding::Utf8));
        // printf '\xef\xbb\xbfa\r\n\r\n\nb\n' | sha256sum
        assert_eq!(hash, "691ca06aa362820289b1c12005afc55adadd714c011720d65666c82142579ec3");
    }

    #[test]
    fn the_head_is_given_again() {
        let mut lines = Lines::new(&b"a\nb\n\nc\n"[..], None).ok().unwrap();
        lines.skip(1).ok().unwrap();
        assert_eq!(lines.head().ok().unwrap().len(), 2);
        assert!(matches!(lines.next_filled(), Ok(Some((2, "b")))));
        assert!(matches!(lines.next_filled(), Ok(Some((4, "c")))));
        assert!(matches!(lines.next_filled(), Ok(None)));
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "Druck [°C]\r\n1,5\r\n";
        let bytes = |unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect::<Vec<u8>>();
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let (little, big) = (bytes(u16::to_le_bytes), bytes(u16::to_be_bytes));
        let marked = [b"\xff\xfe", &little[..]].concat();
        for (bytes, encoding) in [
            (text.as_bytes(), Encoding::Utf8),
            (&latin, Encoding::Latin1),
            (&little, Encoding::Utf16Le),
            (&marked, Encoding::Utf16Le),
            (&big, Encoding::Utf16Be),
        ] {
            for stated in [None, Some(encoding)] {
                let (all, found, _) = lines(bytes, stated);
                let expected = vec![(1, "Druck [°C]".to_owned()), (2, "1,5".to_owned())];
                assert_eq!((all, found), (expected, encoding), "{encoding:?} {stated:?}");
            }
        }
    }
}
