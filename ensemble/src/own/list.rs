//! Lists of rows, each with the way in which its rows are solved.

use crate::batch::Batch;
use crate::outcome::Outcome;

/// A way of solving the rows of a list, with working memory that is kept from one chunk to the next.
pub trait Way {
    /// Solves rows whose numbers are checked. Some may be left, to be solved in another way.
    fn solve(&mut self, batch: Batch, rows: &mut [u32], left: &mut Vec<u32>, out: &mut [Outcome]);
}

/// A chunk's rows of one kind, and the way in which they are solved.
#[derive(Default)]
pub struct List<W: ?Sized> {
    pub rows: Vec<u32>,
    left: Vec<u32>,
    way: W,
}

impl<W: Way + ?Sized> List<W> {
    /// Solves what is in the list. Answers which rows it has left.
    pub fn solve(&mut self, batch: Batch, out: &mut [Outcome]) -> std::vec::Drain<'_, u32> {
        let Self { rows, left, way } = self;
        if !rows.is_empty() {
            way.solve(batch, rows, left, out);
            rows.clear();
        }
        left.drain(..)
    }
}
