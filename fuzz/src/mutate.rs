//! Mutations that formats stumble over: bytes flipped, parts cut, doubled, swapped between files, words and numbers put in.

use fastrand::Rng;
use std::path::PathBuf;

/// Words no format likes.
const NASTY: [&str; 40] = [
    "", "0", "-0", "-1", "1e400", "-1e400", "1e-400", "NaN", "nan", "inf", "-inf", "1,5", "1.5.5", "0x10", "1_000",
    "١", "−1", "1e", "+", ".", "\"", "'", "\"\"\"", "[", "]", "[[", "{", "}", "=", "#", "\n", "\r", "\r\n", "\t", "\0",
    "\u{feff}", "\u{202e}", "9223372036854775808", "99999999999999999999999999", "5e-324",
];
/// Numbers no format likes, as eight bytes.
const NASTY_REALS: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    0.5,
    1e-300,
    5e-324,
    f64::MAX,
    f64::MIN,
    1e18,
    -1e18,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::EPSILON,
];
/// The longest input that is made, bytes.
const LONGEST: usize = 64 << 10;

/// A file of the corpus with one to eight mutations.
pub fn mutated(random: &mut Rng, files: &[(PathBuf, Vec<u8>)], dictionary: &[&str]) -> Vec<u8> {
    let mut bytes = files[random.usize(..files.len())].1.clone();
    for _ in 0..random.usize(1..=8) {
        mutate(random, &mut bytes, files, dictionary);
        bytes.truncate(LONGEST);
    }
    bytes
}

fn mutate(random: &mut Rng, bytes: &mut Vec<u8>, files: &[(PathBuf, Vec<u8>)], dictionary: &[&str]) {
    let part = part(random, bytes.len());
    match random.u8(..10) {
        0 => {
            if let Some(byte) = random.choice(bytes.iter_mut()) {
                *byte ^= 1 << random.u8(..8);
            }
        }
        1 => drop(bytes.drain(part)),
        2 => {
            let copy = bytes[part.clone()].repeat(random.usize(1..4));
            bytes.splice(part.end..part.end, copy);
        }
        3 => {
            let other = &files[random.usize(..files.len())].1;
            let piece = self::part(random, other.len());
            bytes.splice(part, other[piece].iter().copied());
        }
        4 => bytes.truncate(part.start),
        5 => put(random, bytes, &NASTY),
        6 if !dictionary.is_empty() => put(random, bytes, dictionary),
        7 => replace_number(random, bytes),
        8 => replace_real(random, bytes),
        _ => {
            let line = line_at(bytes, part.start);
            let copy = bytes[line.clone()].to_vec();
            let to = line_at(bytes, self::part(random, bytes.len()).start).start;
            bytes.splice(to..to, copy);
        }
    }
}

/// A word at a random place, or in place of the field that is there.
fn put(random: &mut Rng, bytes: &mut Vec<u8>, words: &[&str]) {
    let word = words[random.usize(..words.len())];
    let at = random.usize(..=bytes.len());
    let in_field = |byte: &u8| !b",;=\n\t ".contains(byte);
    let end = if random.bool() { at } else { at + bytes[at..].iter().take_while(|b| in_field(b)).count() };
    bytes.splice(at..end, word.bytes());
}

/// Another number for one that is there.
fn replace_number(random: &mut Rng, bytes: &mut Vec<u8>) {
    let digit = |byte: &u8| byte.is_ascii_digit() || b".eE+-".contains(byte);
    let from = random.usize(..=bytes.len());
    let Some(at) = bytes[from..].iter().position(u8::is_ascii_digit).map(|i| from + i) else { return };
    let end = at + bytes[at..].iter().take_while(|b| digit(b)).count();
    let magnitude = 10_f64.powi(random.i32(-320..309));
    let value = (random.f64() * 2.0 - 1.0) * magnitude;
    let text = if random.bool() { format!("{value:e}") } else { format!("{}", random.i64(-3..100)) };
    bytes.splice(at..end, text.bytes());
}

/// Eight bytes that may be a little-endian number become another number: a nasty one, or one not far from what was there.
fn replace_real(random: &mut Rng, bytes: &mut [u8]) {
    let Some(places) = (bytes.len() / 8).checked_sub(1) else { return };
    let at = 8 * random.usize(..=places);
    let Some(eight) = bytes[at..].first_chunk_mut::<8>() else { return };
    let near = f64::from_le_bytes(*eight) * 10_f64.powf(6.0 * random.f64() - 3.0);
    let nasty = NASTY_REALS[random.usize(..NASTY_REALS.len())];
    *eight = if random.bool() { near } else { nasty }.to_le_bytes();
}

/// A random part, more often short than long.
fn part(random: &mut Rng, length: usize) -> core::ops::Range<usize> {
    let begin = random.usize(..=length);
    let longest = (length - begin).min(1 << random.u32(..14));
    begin..begin + random.usize(..=longest)
}

fn line_at(bytes: &[u8], at: usize) -> core::ops::Range<usize> {
    let begin = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i + 1);
    begin..end
}
