//! The records along pieces as curves, one per lane: of instantaneous sensors and of lagging ones.

use super::interpolant::{Interpolant, Stencils};
use super::traces::{Job, LaggedPiece, PRESSURE, Trace, Traces};
use crate::filter::{Lagged, ToPowers, decay_factor};
use crate::lanes::{Lanes, WIDTH};
use crate::numerics::root::Curve;
use crate::query::{Query, Question, Reading};
use crate::regression::samples::POINTS;
use chamber::real::Real;
use pulp::{Arch, Simd, WithSimd};

impl Traces<'_> {
    /// Computes the readings of lagging sensors, piece by piece.
    pub(super) fn follow_lags(&mut self, arch: Arch) {
        if self.rows.iter().all(|row| row.sensor.lag == 0.0) {
            return;
        }
        let mut lags = core::mem::take(&mut self.memory.lags);
        lags.clear();
        let lagging: Vec<usize> = (0..self.rows.len())
            .filter(|&row| self.rows[row].sensor.lag > 0.0)
            .flat_map(|row| self.pieces_of(row))
            .collect();
        for group in lagging.chunks(WIDTH) {
            let piece = |lane: usize| &self.memory.pieces[group[lane.min(group.len() - 1)]];
            let inside = self.stencils(PRESSURE, |lane| (piece(lane).segment, piece(lane).knot));
            let from = Lanes::from_fn(|lane| piece(lane).times[0]);
            let length = Lanes::from_fn(|lane| piece(lane).times[1] - piece(lane).times[0]);
            let lag = Lanes::from_fn(|lane| self.of_segment(piece(lane).segment).0.sensor.lag);
            let found = arch.dispatch(Follow { inside, to_powers: &self.memory.to_powers, from, length, lag });
            for (lane, &index) in group.iter().enumerate() {
                let LaggedPiece { pressure, from, length, decay, fed, .. } = found;
                let pressure = pressure.map(|term| term[lane]);
                self.memory.pieces[index].lag = lags.len() as u32;
                let [from, length, decay, fed] = [from, length, decay, fed].map(|of| of[lane]);
                lags.push(LaggedPiece { pressure, from, length, decay, fed, begin: 0.0 });
            }
        }
        for row in 0..self.rows.len() {
            let Trace { scenario, plan, sensor, .. } = self.rows[row];
            if sensor.lag == 0.0 {
                continue;
            }
            let mut reading = scenario.initial_pressure_pa;
            for index in self.pieces_of(row) {
                let segment = &self.memory.segments[self.memory.pieces[index].segment as usize];
                let elapsed = plan.spans[segment.span as usize].elapsed;
                let piece = &mut self.memory.pieces[index];
                let LaggedPiece { pressure, decay, fed, begin, .. } = &mut lags[piece.lag as usize];
                *begin = reading;
                let gas = [pressure[0], pressure.iter().sum()];
                let readings = [reading, reading * *decay + *fed];
                for end in 0..2 {
                    piece.shown[end] = sensor.shown(readings[end], elapsed + piece.times[end]);
                    piece.slopes[end] = (gas[end] - readings[end]) / sensor.lag + sensor.drift;
                }
                reading = readings[1];
            }
        }
        self.memory.lags = lags;
    }

    /// Answers the jobs, one per lane; those of lagging sensors separately.
    pub(super) fn work(&mut self, arch: Arch, question: fn([Lanes; POINTS]) -> Question) {
        let mut jobs = core::mem::take(&mut self.memory.jobs);
        let lags = |job: &Job| self.of_segment(self.memory.pieces[job.piece].segment).0.sensor.lag > 0.0;
        let (mut prompt, mut lagging): (Vec<u32>, Vec<u32>) =
            (0..jobs.len() as u32).partition(|&job| !lags(&jobs[job as usize]));
        for (list, lagging) in [(&mut prompt, false), (&mut lagging, true)] {
            for group in list.chunks(WIDTH) {
                let job = |lane: usize| &jobs[group[lane.min(group.len() - 1)] as usize];
                let piece = |lane: usize| &self.memory.pieces[job(lane).piece];
                let numbers = core::array::from_fn(|k| Lanes::from_fn(|lane| job(lane).numbers[k]));
                let times = [0, 1].map(|end| Lanes::from_fn(|lane| piece(lane).times[end]));
                let sensor = |lane: usize| self.of_segment(piece(lane).segment).0.sensor;
                let elapsed = |lane: usize| self.of_segment(piece(lane).segment).1.elapsed;
                let gain = Lanes::from_fn(|lane| piece(lane).straight.gain);
                let level = Lanes::from_fn(|lane| piece(lane).straight.level);
                let offset = level + gain * Lanes::from_fn(|lane| sensor(lane).shown(0.0, elapsed(lane)));
                let drift = gain * Lanes::from_fn(|lane| sensor(lane).drift);
                let question = question(numbers);
                let answer = if lagging {
                    let lag = |lane: usize| &self.memory.lags[piece(lane).lag as usize];
                    let pressure = core::array::from_fn(|k| Lanes::from_fn(|lane| lag(lane).pressure[k]));
                    let length = Lanes::from_fn(|lane| lag(lane).length);
                    let stiffness = length / Lanes::from_fn(|lane| sensor(lane).lag);
                    let begin = Lanes::from_fn(|lane| lag(lane).begin);
                    let lagged = Lagged { pressure, begin, stiffness };
                    let from = Lanes::from_fn(|lane| lag(lane).from);
                    let reading = Lagging { lagged, from, per_length: length.recip(), gain, offset, drift };
                    Query { reading, times, question }.answer(arch)
                } else {
                    let inside = self.stencils(PRESSURE, |lane| (piece(lane).segment, piece(lane).knot));
                    Query { reading: Prompt { inside, gain, offset, drift }, times, question }.answer(arch)
                };
                for (lane, &job) in group.iter().enumerate() {
                    jobs[job as usize].answer = answer.map(|answer| answer[lane]);
                }
            }
        }
        self.memory.jobs = jobs;
    }
}

/// Computes the [`LaggedPiece`] of each lane.
struct Follow<'a> {
    inside: Stencils,
    to_powers: &'a ToPowers,
    from: Lanes,
    length: Lanes,
    lag: Lanes,
}

impl WithSimd for Follow<'_> {
    type Output = LaggedPiece<Lanes>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { inside, to_powers, from, length, lag } = self;
        let pressure = to_powers.of(&Interpolant::new(&inside), from, length);
        let stiffness = length / lag;
        let fed = Lagged { pressure, begin: Lanes::ZERO, stiffness }.at(Lanes::ONE);
        LaggedPiece { pressure, from, length, decay: decay_factor(stiffness), fed, begin: Lanes::ZERO }
    }
}

/// The record of an instantaneous sensor; `I` is stencils at first, then interpolants.
pub(super) struct Prompt<I> {
    pub(super) inside: I,
    /// Its derivative by the pressure.
    pub(super) gain: Lanes,
    /// Offset at the segment's start, Pa, and drift, Pa/s.
    pub(super) offset: Lanes,
    pub(super) drift: Lanes,
}

impl Reading for Prompt<Stencils> {
    type Curve = Prompt<Interpolant>;

    #[inline(always)]
    fn curve(self) -> Self::Curve {
        let Self { inside, gain, offset, drift } = self;
        Prompt { inside: Interpolant::new(&inside), gain, offset, drift }
    }
}

impl Curve for Prompt<Interpolant> {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.inside.at(time) * self.gain + (self.offset + self.drift * time)
    }
}

/// The record of a lagging sensor.
struct Lagging {
    lagged: Lagged<Lanes>,
    from: Lanes,
    per_length: Lanes,
    gain: Lanes,
    offset: Lanes,
    drift: Lanes,
}

impl Curve for Lagging {
    #[inline(always)]
    fn at(&self, time: Lanes) -> Lanes {
        self.lagged.at((time - self.from) * self.per_length) * self.gain + (self.offset + self.drift * time)
    }
}
