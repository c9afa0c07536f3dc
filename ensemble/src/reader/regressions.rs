//! The paper's step 1 on the samples of traced records.

use super::answers::RowAnswer;
use super::traces::{Cut, Job, Memory, Trace, Traces};
use crate::lanes::{Lanes, WIDTH};
use crate::query::Question;
use crate::regression::samples::{self, POINTS, SAMPLE_RATE_HZ, Samples};
use crate::regression::{Guess, RecordPart, Regression};
use pulp::Arch;

impl Traces<'_> {
    /// Number of the first sample of each record: the larger of those beside the peak.
    fn first_samples(&mut self, arch: Arch, answers: &[Option<RowAnswer>]) -> Vec<Option<f64>> {
        let mut jobs = core::mem::take(&mut self.memory.jobs);
        jobs.clear();
        let mut firsts: Vec<Option<f64>> = Vec::with_capacity(answers.len());
        for (row, answer) in answers.iter().enumerate() {
            let push_end = samples::from(self.rows[row].scenario.push_time_s);
            let after = answer.map(|answer| samples::from(answer.peak_time).max(push_end));
            firsts.push(after);
            let Some(after) = after.filter(|after| *after > push_end) else { continue };
            for number in [after - 1.0, after] {
                let time = number / SAMPLE_RATE_HZ;
                let pieces = self.pieces_of(row);
                let holds = |&index: &usize| {
                    let piece = &self.memory.pieces[index];
                    time <= self.record_time(piece.segment, piece.times[1])
                };
                let index = pieces.clone().find(holds).unwrap_or(pieces.end - 1);
                let piece = &self.memory.pieces[index];
                let time = (time - self.record_time(piece.segment, 0.0)).clamp(piece.times[0], piece.times[1]);
                jobs.push(Job::new(index, [time; POINTS]));
            }
        }
        self.memory.jobs = jobs;
        self.work(arch, Question::Pressures);
        for pair in self.memory.jobs.chunks_exact(2) {
            let row = self.memory.segments[self.memory.pieces[pair[0].piece].segment as usize].row as usize;
            let sign = self.rows[row].sign();
            if let Some(first) = &mut firsts[row]
                && sign * pair[0].answer[0] > sign * pair[1].answer[0]
            {
                *first -= 1.0;
            }
        }
        firsts
    }

    /// Collects the samples up to the start of the pieces, where a delayed record shows the gas before the test.
    fn samples_before(&self, row: usize, mut first: f64, to: &mut Vec<RecordPart>) {
        to.clear();
        let Cut { all, begin: at_begin, .. } = &self.memory.cut[row];
        let Some(piece) = self.memory.pieces[all.clone()].first() else { return };
        let begin = self.record_time(piece.segment, piece.times[0]);
        let Trace { sensor, bends, .. } = &self.rows[row];
        // Parts of so few samples are their own nodes, whatever the curve.
        let most = if bends.is_none() { f64::INFINITY } else { POINTS as f64 };
        while samples::after(begin) > first {
            let samples = Samples { first, count: (samples::after(begin) - first).min(most) };
            let reading = |number: f64| at_begin + sensor.drift * (number / SAMPLE_RATE_HZ - begin);
            let pressure = samples.nodes().numbers.map(|number| bends.shown(reading(number)));
            to.push(RecordPart { samples, pressure });
            first += samples.count;
        }
    }

    /// The paper's step 1 on the samples of each record from its peak on, given guesses of τ, s.
    pub fn regressions(
        &mut self,
        arch: Arch,
        answers: &[Option<RowAnswer>],
        guess: impl Fn(usize) -> f64,
    ) -> Vec<Option<Regression>> {
        let firsts = self.first_samples(arch, answers);
        self.memory.jobs.clear();
        // Per job: the samples in its piece.
        let mut held: Vec<Samples> = Vec::new();
        let mut befores: Vec<Vec<RecordPart>> = vec![Vec::new(); answers.len()];
        for row in 0..answers.len() {
            let Some(first) = firsts[row] else { continue };
            self.samples_before(row, first, &mut befores[row]);
            let mut first = first + befores[row].iter().map(|part| part.samples.count).sum::<f64>();
            let end = samples::after(self.rows[row].scenario.duration_s);
            for index in self.pieces_of(row) {
                let piece = &self.memory.pieces[index];
                let elapsed = self.record_time(piece.segment, 0.0);
                let next = samples::after(elapsed + piece.times[1]).min(end);
                let samples = Samples { first, count: next - first };
                if samples.count > 0.0 {
                    let numbers = samples.nodes().numbers.map(|number| number / SAMPLE_RATE_HZ - elapsed);
                    self.memory.jobs.push(Job::new(index, numbers));
                    held.push(samples);
                    first = next;
                }
            }
        }
        self.work(arch, Question::Pressures);
        let mut out = vec![None; answers.len()];
        let Memory { pieces, segments, jobs, records, .. } = &mut *self.memory;
        let row_of = |job: &Job| segments[pieces[job.piece].segment as usize].row as usize;
        let mut jobs = jobs.iter().zip(held).peekable();
        for base in (0..answers.len()).step_by(WIDTH) {
            records.clear();
            let group = base..answers.len().min(base + WIDTH);
            for row in group.clone() {
                for part in &befores[row] {
                    records.add(row - base, *part);
                }
                while let Some((job, samples)) = jobs.next_if(|(job, _)| row_of(job) == row) {
                    records.add(row - base, RecordPart { samples, pressure: job.answer });
                }
            }
            let last = group.end - 1;
            let found = records.fit(arch, Guess::TimeConstant(Lanes::from_fn(|lane| guess((base + lane).min(last)))));
            for row in group {
                out[row] = firsts[row].and(found.lane(row - base));
            }
        }
        out
    }
}
