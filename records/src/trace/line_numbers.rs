//! Line number of each row, stored at the rows where lines are not consecutive.

/// The line numbers of a record's rows; empty for a record without a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LineNumbers(Vec<(usize, usize)>);

impl LineNumbers {
    /// Appends the line of a row after all previous ones.
    #[inline]
    pub(super) fn push(&mut self, row: usize, line: usize) {
        if self.0.last().is_none_or(|(r, l)| l + (row - r) != line) {
            self.0.push((row, line));
        }
    }

    /// The line of a row, from 1.
    pub fn of(&self, row: usize) -> Option<usize> {
        let at = self.0.partition_point(|(first, _)| *first <= row);
        self.0.get(at.checked_sub(1)?).map(|(first, line)| line + (row - first))
    }

    /// Keeps the lines of the kept rows.
    pub fn retain(&mut self, keep: &[bool]) {
        if !self.0.is_empty() {
            *self = (0..keep.len()).filter(|row| keep[*row]).filter_map(|row| self.of(row)).collect();
        }
    }
}

impl FromIterator<usize> for LineNumbers {
    /// From the line of the first row, of the second, and so on.
    fn from_iter<I: IntoIterator<Item = usize>>(lines: I) -> Self {
        let mut out = Self::default();
        lines.into_iter().enumerate().for_each(|(row, line)| out.push(row, line));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_line_numbers_where_others_are_dropped() {
        let mut lines: LineNumbers = [2, 3, 5, 6].into_iter().collect();
        assert_eq!(lines.of(2), Some(5));
        lines.retain(&[true, false, true, true]);
        assert_eq!([0, 1, 2].map(|row| lines.of(row)), [Some(2), Some(5), Some(6)]);
        assert_eq!(LineNumbers::default().of(0), None);
    }
}
