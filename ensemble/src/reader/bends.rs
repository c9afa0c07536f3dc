//! Records of sensors that make a bent curve of their reading: cut where the reading turns round and where it comes to a bend,
//! so that over each piece the record is a straight line over the reading, and one-way.

use super::{Job, Memory, TracePiece, Traces};
use crate::look::Question;
use crate::regression::samples::POINTS;
use chamber::effects::{self, EffectSet, EffectValues, OWN_STATES};
use pulp::Arch;

/// What a sensor makes of its reading at last.
#[derive(Clone, Copy, Debug)]
pub struct Bends<'a> {
    /// Effects that bend it.
    set: EffectSet,
    values: &'a EffectValues,
}

impl<'a> Bends<'a> {
    /// By the active effects of a chamber.
    pub fn new(active: EffectSet, values: &'a EffectValues) -> Self {
        let all = Self { set: active.intersection(effects::WITH_READING_KINKS), values };
        let any = all.between(f64::MIN, f64::MAX).next().is_some();
        if any { all } else { Self { set: EffectSet::NONE, values } }
    }

    /// Whether the record is the reading as it is.
    pub fn is_none(&self) -> bool {
        self.set.is_empty()
    }

    /// What the record shows of a reading, Pa.
    pub fn shown(&self, reading: f64) -> f64 {
        self.values.reading(self.set, &[0.0; OWN_STATES], reading, 0.0)
    }

    /// How much more it shows of a reading than of one that is less `by` so much, Pa.
    pub fn change(&self, reading: f64, by: f64) -> f64 {
        if self.is_none() { by } else { self.shown(reading) - self.shown(reading - by) }
    }

    /// Readings on the way from one to another at which the record bends, Pa.
    pub fn between(&self, from: f64, to: f64) -> impl Iterator<Item = f64> + use<'a> {
        let Self { set, values } = *self;
        let next = move |from: f64| Some(values.reading_kink(set, from, to)).filter(|reading| *reading != to);
        std::iter::successors(next(from), move |from| next(*from))
    }
}

/// What a record shows of the reading over a piece: `level` + `gain` × reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Straight {
    /// Pa.
    pub(super) level: f64,
    pub(super) gain: f64,
}

impl Straight {
    /// The reading as it is.
    pub(super) const READING: Self = Self { level: 0.0, gain: 1.0 };

    /// Through two readings and what is shown of them.
    fn through(readings: [f64; 2], shown: [f64; 2]) -> Self {
        let way = readings[1] - readings[0];
        let gain = if way == 0.0 { 0.0 } else { (shown[1] - shown[0]) / way };
        Self { level: shown[0] - gain * readings[0], gain }
    }
}

/// A place inside a piece at which it is cut.
#[derive(Clone, Copy, Debug)]
struct CutPlace {
    piece: usize,
    /// Time from the segment's start, s; not a number where it is being looked for.
    time: f64,
    reading: f64,
}

impl Traces<'_> {
    /// Makes the records of the readings: cuts pieces of sensors that bend theirs.
    pub(super) fn bend(&mut self, arch: Arch) {
        let bent: Vec<usize> = (0..self.rows.len()).filter(|&row| !self.rows[row].bends.is_none()).collect();
        if bent.is_empty() {
            return;
        }
        // Where the readings turn round, also before what is shown: a sample may stand at its very start.
        let Memory { pieces, cut, jobs, .. } = &mut *self.memory;
        jobs.clear();
        for index in bent.iter().flat_map(|&row| cut[row].all.clone()) {
            if pieces[index].slopes[0] * pieces[index].slopes[1] < 0.0 {
                jobs.push(Job::new(index, [0.0; POINTS]));
            }
        }
        self.work(arch, |_| Question::Turn);
        // From each such place to the next, the bends.
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

    /// Cuts pieces at places in the order of the pieces and of their times, the end of each piece among them.
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
                    // One way, or none.
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
