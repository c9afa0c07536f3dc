//! Cuts the records of sensors with a curve of their reading at the reading's turns and at the bends of the curve, so that along each
//! piece the record is linear in the reading, and monotone.

use super::bends::Straight;
use super::traces::{Job, Memory, TracePiece, Traces};
use crate::query::Question;
use crate::regression::samples::POINTS;
use pulp::Arch;

/// A place at which a piece is cut.
#[derive(Clone, Copy, Debug)]
struct CutPlace {
    piece: usize,
    /// Time from the segment's start, s; NaN until it is found.
    time: f64,
    reading: f64,
}

impl Traces<'_> {
    /// Turns readings into records: cuts the pieces of sensors with a curve.
    pub(super) fn bend(&mut self, arch: Arch) {
        let bent: Vec<usize> = (0..self.rows.len()).filter(|&row| !self.rows[row].bends.is_none()).collect();
        if bent.is_empty() {
            return;
        }
        // The turns of the readings, also before the window: a sample may lie exactly at its start.
        let Memory { pieces, cut, jobs, .. } = &mut *self.memory;
        jobs.clear();
        for index in bent.iter().flat_map(|&row| cut[row].all.clone()) {
            if pieces[index].slopes[0] * pieces[index].slopes[1] < 0.0 {
                jobs.push(Job::new(index, [0.0; POINTS]));
            }
        }
        self.work(arch, |_| Question::Turn);
        // The bends from each corner to the next.
        let turns = core::mem::take(&mut self.memory.jobs);
        let (mut turned, mut places) = (turns.iter().peekable(), Vec::new());
        for &row in &bent {
            for index in self.pieces_of(row) {
                let TracePiece { times, shown, .. } = self.memory.pieces[index];
                let turn = turned.next_if(|turn| turn.piece == index).map(|turn| (turn.answer[0], turn.answer[1]));
                let mut begin = (times[0], shown[0]);
                for end in turn.into_iter().chain([(times[1], shown[1])]) {
                    for reading in self.rows[row].bends.between(begin.1, end.1) {
                        places.push(CutPlace { piece: index, time: f64::NAN, reading });
                        let numbers = [begin.0, end.0, end.1, (end.1 - reading).abs()];
                        self.memory.jobs.push(Job::new(index, numbers));
                    }
                    places.push(CutPlace { piece: index, time: end.0, reading: end.1 });
                    begin = end;
                }
            }
        }
        self.work(arch, |[begin, end, value, band]| Question::Enter { between: [begin, end], value, band });
        for (place, job) in places.iter_mut().filter(|place| place.time.is_nan()).zip(&self.memory.jobs) {
            place.time = job.answer[0];
        }
        self.cut_at(&places);
    }

    /// Cuts pieces at the given places, ordered by piece and time; the end of each piece is one of them.
    fn cut_at(&mut self, places: &[CutPlace]) {
        let pieces = core::mem::take(&mut self.memory.pieces);
        let mut places = places.iter().peekable();
        let out = &mut self.memory.pieces;
        for (row, cut) in self.rows.iter().zip(&mut self.memory.cut) {
            let (old, first) = (cut.clone(), out.len());
            cut.shown = first..first;
            for index in old.all {
                let from = out.len();
                if row.bends.is_none() {
                    out.push(pieces[index]);
                }
                let mut rest = pieces[index];
                while let Some(place) = places.next_if(|place| place.piece == index) {
                    let time = place.time.max(rest.times[0]).min(rest.times[1]);
                    let readings = [rest.shown[0], place.reading];
                    let shown = readings.map(|reading| row.bends.shown(reading));
                    // Monotone, so that the record does not turn.
                    let slopes = [shown[1] - shown[0]; 2];
                    let straight = Straight::through(readings, shown);
                    out.push(TracePiece { times: [rest.times[0], time], shown, slopes, straight, ..rest });
                    (rest.times[0], rest.shown[0]) = (time, place.reading);
                }
                if old.shown.contains(&index) {
                    cut.shown = if cut.shown.is_empty() { from } else { cut.shown.start }..out.len();
                }
            }
            cut.all = first..out.len();
        }
    }
}
