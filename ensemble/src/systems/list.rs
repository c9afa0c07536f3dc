//! Lists of rows, each with its method of solution.

use crate::batch::Batch;
use crate::outcome::Outcome;

/// A method of solution for the rows of a list, with working memory that is kept from one chunk to the next.
pub trait Method {
    /// Solves rows whose numbers are checked. Those that it cannot solve are added to `left`.
    fn solve(&mut self, batch: Batch, rows: &mut [u32], left: &mut Vec<u32>, out: &mut [Outcome]);
}

/// A chunk's rows of one kind, and their method of solution.
#[derive(Default)]
pub struct List<M: ?Sized> {
    pub rows: Vec<u32>,
    left: Vec<u32>,
    method: M,
}

impl<M: Method + ?Sized> List<M> {
    /// Solves the rows of the list and empties it. Returns those that are left unsolved.
    pub fn solve(&mut self, batch: Batch, out: &mut [Outcome]) -> std::vec::Drain<'_, u32> {
        let Self { rows, left, method } = self;
        if !rows.is_empty() {
            method.solve(batch, rows, left, out);
            rows.clear();
        }
        left.drain(..)
    }
}
