//! Readings left out as far off, in a sentence that gives their lines and times.

use records::LineNumbers;
use std::path::Path;

/// Most readings that are named.
const NAMED: usize = 5;

/// States what is left out of a record, if anything: `rows`, with their lines if it comes from a file, and their times, s.
pub fn sentence(path: &Path, rows: &[usize], lines: &LineNumbers, time_s: &[f64]) -> Option<String> {
    let readings = match rows.len() {
        0 => return None,
        1 => "one reading far off is left out".to_owned(),
        count => format!("{count} readings far off are left out"),
    };
    Some(format!("{}: {readings} ({} after the first row)", path.display(), named(rows, lines, time_s)))
}

/// The first few items for a sentence, and its ending if there are more.
pub fn first_few<T>(all: &[T]) -> (&[T], &'static str) {
    if all.len() > NAMED { (&all[..NAMED], ", …") } else { (all, "") }
}

/// The first few rows: their lines, if the record comes from a file, and their times from the first row, s.
pub fn named(rows: &[usize], lines: &LineNumbers, time_s: &[f64]) -> String {
    let (named, more) = first_few(rows);
    let times: Vec<String> = named.iter().map(|&row| format!("{:.3} s", time_s[row] - time_s[0])).collect();
    let times = format!("{}{more}", times.join(", "));
    let lines: Vec<String> = named.iter().filter_map(|&row| Some(lines.of(row)?.to_string())).collect();
    match lines.len() {
        0 => times,
        1 => format!("line {}, {times}", lines[0]),
        _ => format!("lines {}{more}; {times}", lines.join(", ")),
    }
}

/// From one row to another: their lines, if the record comes from a file, and their times, s.
pub fn from_to([from, to]: [usize; 2], lines: &LineNumbers, time_s: &[f64]) -> String {
    let times = format!("{:.3} s to {:.3} s", time_s[from], time_s[to]);
    match [from, to].map(|row| lines.of(row)) {
        [Some(from), Some(to)] => format!("lines {from} to {to}, {times}"),
        _ => times,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_left_out_are_named_by_their_lines_and_times() {
        let time_s = [5.0, 5.1, 5.2, 5.3];
        let lines: LineNumbers = [2, 3, 7, 8].into_iter().collect();
        let said = |rows: &[usize], lines: &LineNumbers| sentence(Path::new("a.csv"), rows, lines, &time_s);
        assert_eq!(said(&[], &lines), None);
        let one = "a.csv: one reading far off is left out (line 2, 0.000 s after the first row)";
        assert_eq!(said(&[0], &lines).as_deref(), Some(one));
        let two = "a.csv: 2 readings far off are left out (lines 3, 7; 0.100 s, 0.200 s after the first row)";
        assert_eq!(said(&[1, 2], &lines).as_deref(), Some(two));
        assert!(said(&[1], &LineNumbers::default()).unwrap().ends_with("left out (0.100 s after the first row)"));
    }
}
