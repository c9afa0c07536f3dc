//! One row's record, looked into through the dense output of its steps: extremes, settling, samples for the regression.

use super::advance::{Loadable, Log, Steps};
use super::fit::{self, SAMPLE_RATE_HZ};
use super::step::{LaneSystem, dense, within};
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// What can be seen of a system.
pub trait Observe<const N: usize>: LaneSystem<N> + Loadable {
    /// What the record shows, Pa, and the gas's temperature, K, a time `t` into the stretch, `elapsed` since the start.
    fn observe(&self, t: Lanes, y: &[Lanes; N], elapsed: Lanes) -> [Lanes; 2];
}

/// One accepted step.
#[derive(Clone, Copy, Debug)]
pub struct Piece<const N: usize> {
    /// Which constants belong to it: see [`Loadable`].
    system: usize,
    /// Begin of its stretch, s of the gas.
    stretch_begin: f64,
    /// Its begin in the stretch, s.
    from: f64,
    /// Its length, s.
    length: f64,
    terms: [[f64; N]; 8],
}

impl<const N: usize> Piece<N> {
    fn begin(&self) -> f64 {
        self.stretch_begin + self.from
    }
    fn end(&self) -> f64 {
        self.stretch_begin + self.from + self.length
    }
}

/// What a row's record is asked for. Times in s; of the record, which is `delay` behind the gas.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// End of the push.
    pub push_end: f64,
    /// End of the test.
    pub duration: f64,
    /// How far the record is behind the gas.
    pub delay: f64,
    /// Whether the peak is the smallest value.
    pub expands: bool,
    /// What the record shows of the gas before the test, Pa, less any drift, and the drift, Pa/s.
    pub before: [f64; 2],
    /// τ to start the regression from, where it is asked for.
    pub guess: Option<f64>,
}

/// The answers. Pressures of the record, temperatures of the gas.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Peak from the end of the push on, Pa.
    pub pressure_peak: f64,
    /// At the end, Pa.
    pub pressure_final: f64,
    /// Peak from the end of the push on, K.
    pub temperature_peak: f64,
    /// At the end, K.
    pub temperature_final: f64,
    /// From the end of the push until within 1 % for good, s.
    pub settling: f64,
    /// Pf, ΔP and τ.
    pub regression: Option<[f64; 3]>,
}

/// A row's accepted steps, to be looked into.
pub struct Record<'a, const N: usize, S> {
    system: S,
    loaded: [usize; WIDTH],
    pieces: &'a mut Vec<Piece<N>>,
    delay: f64,
}

impl<'a, const N: usize, S: Observe<N>> Record<'a, N, S> {
    /// Without steps yet; `pieces` is memory to use.
    pub fn new(system: S, pieces: &'a mut Vec<Piece<N>>, delay: f64) -> Self {
        pieces.clear();
        Self { system, loaded: [usize::MAX; WIDTH], pieces, delay }
    }

    fn load(&mut self, lane: usize, system: usize) {
        if self.loaded[lane] != system {
            self.system.load(lane, system);
            self.loaded[lane] = system;
        }
    }

    /// Adds the accepted steps of a problem, the inside of eight at once.
    pub fn add(&mut self, arch: Arch, log: &Log<N>, steps: Steps, constants: usize, stretch_begin: f64) {
        for lane in 0..WIDTH {
            self.load(lane, constants);
        }
        let column = steps.lane as usize;
        let mut index = steps.from as usize;
        let entries = &log[steps.group as usize];
        while index < steps.to as usize {
            let (mut from, mut length) = (Lanes::ZERO, Lanes::ZERO);
            let (mut begin, mut end, mut slopes) = ([Lanes::ONE; N], [Lanes::ONE; N], [[Lanes::ZERO; N]; 13]);
            let mut count = 0;
            while index < steps.to as usize && count < WIDTH {
                let entry = &entries[index];
                index += 1;
                if entry.accepted[column] <= 0.0 {
                    continue;
                }
                from[count] = entry.from[column];
                length[count] = entry.length[column];
                for i in 0..N {
                    begin[i][count] = entry.begin[i][column];
                    end[i][count] = entry.end[i][column];
                    for (slope, of_entry) in slopes.iter_mut().zip(&entry.slopes) {
                        slope[i][count] = of_entry[i][column];
                    }
                }
                count += 1;
            }
            let system = &self.system;
            let terms = arch.dispatch(Dense { system, from, length, begin: &begin, end: &end, slopes: &slopes });
            for lane in 0..count {
                let mut piece = Piece {
                    system: constants,
                    stretch_begin,
                    from: from[lane],
                    length: length[lane],
                    terms: [[0.0; N]; 8],
                };
                for (to, of_all) in piece.terms.iter_mut().zip(&terms) {
                    for i in 0..N {
                        to[i] = of_all[i][lane];
                    }
                }
                self.pieces.push(piece);
            }
        }
    }

    /// Record and gas temperature at up to eight places: (piece, share of its length).
    fn look(&mut self, places: &[(usize, f64); WIDTH]) -> [Lanes; 2] {
        let mut x = Lanes::ZERO;
        let (mut t, mut elapsed) = (Lanes::ZERO, Lanes::ZERO);
        let mut terms = [[Lanes::ZERO; 8]; N];
        for lane in 0..WIDTH {
            let (index, share) = places[lane];
            let piece = self.pieces[index];
            self.load(lane, piece.system);
            x[lane] = share;
            t[lane] = piece.from + share * piece.length;
            elapsed[lane] = piece.stretch_begin + t[lane] + self.delay;
            for (k, term) in piece.terms.iter().enumerate() {
                for i in 0..N {
                    terms[i][k][lane] = term[i];
                }
            }
        }
        let mut y = [Lanes::ZERO; N];
        for i in 0..N {
            y[i] = within(&terms[i], x);
        }
        self.system.observe(t, &y, elapsed)
    }

    /// The piece and share of a time of the gas, s.
    fn place(&self, time: f64) -> (usize, f64) {
        let index = self.pieces.partition_point(|p| p.end() < time).min(self.pieces.len() - 1);
        let piece = &self.pieces[index];
        (index, ((time - piece.begin()) / piece.length).clamp(0.0, 1.0))
    }

    /// Record and gas temperature at one place.
    fn at(&mut self, place: (usize, f64)) -> [f64; 2] {
        let [p, t] = self.look(&[place; WIDTH]);
        [p[0], t[0]]
    }

    /// Answers; the pieces must cover the test from the end of the push on, and from `delay` before it.
    pub fn answer(&mut self, arch: Arch, q: &Question) -> Option<Answer> {
        let last = self.pieces.len().checked_sub(1)?;
        let sign = if q.expands { -1.0 } else { 1.0 };
        let shown_end = q.duration - q.delay;
        // Samples at quarters of each step, and at the end.
        let mut samples: Vec<([f64; 2], (usize, f64))> = Vec::with_capacity(4 * self.pieces.len() + 1);
        for first in (0..self.pieces.len()).step_by(2) {
            let place = |lane: usize| ((first + lane / 4).min(last), (lane % 4) as f64 * 0.25);
            let places = core::array::from_fn(place);
            let [p, t] = self.look(&places);
            for (lane, place) in places.iter().enumerate().take(4 * (last + 1 - first)) {
                samples.push(([p[lane], t[lane]], *place));
            }
        }
        let end = self.at((last, 1.0));
        samples.push((end, (last, 1.0)));
        let time =
            |place: (usize, f64), pieces: &[Piece<N>]| pieces[place.0].begin() + place.1 * pieces[place.0].length;

        let tiny = 1e-12 * q.duration;
        let mut peaks = [f64::NEG_INFINITY; 2];
        let mut peak_time = q.push_end;
        for quantity in 0..2 {
            let (from, to) = if quantity == 0 {
                (q.push_end - q.delay - tiny, shown_end + tiny)
            } else {
                (q.push_end - tiny, f64::INFINITY)
            };
            let inside = |k: usize, pieces: &[Piece<N>]| {
                samples.get(k).is_some_and(|s| (from..=to).contains(&time(s.1, pieces)))
            };
            let mut best = usize::MAX;
            for (k, sample) in samples.iter().enumerate() {
                if inside(k, self.pieces) && sign * sample.0[quantity] > peaks[quantity] {
                    (peaks[quantity], best) = (sign * sample.0[quantity], k);
                }
            }
            if best == usize::MAX {
                continue;
            }
            let mut when = time(samples[best].1, self.pieces);
            if best > 0 && inside(best - 1, self.pieces) && inside(best + 1, self.pieces) {
                let bracket = [best - 1, best + 1].map(|k| time(samples[k].1, self.pieces));
                let (top, at) = self.summit(bracket, quantity, sign);
                if top > peaks[quantity] {
                    (peaks[quantity], when) = (top, at);
                }
            }
            if quantity == 0 {
                peak_time = when + q.delay;
            }
        }
        if q.push_end < q.delay {
            // The record still shows the gas before the test.
            let shown = sign * (q.before[0] + q.before[1] * q.push_end);
            if shown > peaks[0] {
                (peaks[0], peak_time) = (shown, q.push_end);
            }
        }
        let pressure_final = if shown_end > 0.0 {
            let place = self.place(shown_end);
            self.at(place)[0]
        } else {
            q.before[0] + q.before[1] * q.duration
        };
        peaks[0] = peaks[0].max(sign * pressure_final);
        let pressure_peak = sign * peaks[0];

        let settling = self.settled_from(&samples, q, pressure_final, 0.01 * (pressure_peak - pressure_final).abs());
        let regression = q.guess.and_then(|guess| self.regression(arch, q, sign, peak_time, guess));
        Some(Answer {
            pressure_peak,
            pressure_final,
            temperature_peak: sign * peaks[1],
            temperature_final: end[1],
            settling: (settling - q.push_end).max(0.0),
            regression,
        })
    }

    /// Largest `sign` × quantity between two times of the gas with one summit between them, and where: golden section.
    fn summit(&mut self, bracket: [f64; 2], quantity: usize, sign: f64) -> (f64, f64) {
        let [mut a, mut b] = bracket;
        let mut best = (f64::NEG_INFINITY, a);
        // Seven inner points a round leave a quarter of the bracket.
        for _ in 0..14 {
            let times: [f64; WIDTH] = core::array::from_fn(|k| a + (b - a) * (k as f64 + 0.5) / WIDTH as f64);
            let places = times.map(|t| self.place(t));
            let values = self.look(&places)[quantity];
            let k = (0..WIDTH).fold(0, |k, j| if sign * values[j] > sign * values[k] { j } else { k });
            if sign * values[k] > best.0 {
                best = (sign * values[k], times[k]);
            }
            let width = (b - a) / WIDTH as f64;
            (a, b) = ((times[k] - width).max(a), (times[k] + width).min(b));
        }
        best
    }

    /// Time of the record from which it stays within `band` of the final pressure, s.
    fn settled_from(
        &mut self,
        samples: &[([f64; 2], (usize, f64))],
        q: &Question,
        pressure_final: f64,
        band: f64,
    ) -> f64 {
        let time =
            |place: (usize, f64), pieces: &[Piece<N>]| pieces[place.0].begin() + place.1 * pieces[place.0].length;
        let (first, end) = (q.push_end - q.delay, q.duration - q.delay);
        let mut later = end;
        let tiny = 1e-12 * q.duration;
        let mut found = None;
        for sample in samples.iter().rev() {
            let t = time(sample.1, self.pieces);
            if t > end {
                continue;
            }
            if t < first - tiny {
                break;
            }
            if (sample.0[0] - pressure_final).abs() > band {
                found = Some(t);
                break;
            }
            later = t;
        }
        let Some(mut outside) = found else { return q.push_end };
        for _ in 0..18 {
            let times: [f64; WIDTH] =
                core::array::from_fn(|k| outside + (later - outside) * (k + 1) as f64 / (WIDTH + 1) as f64);
            let places = times.map(|t| self.place(t));
            let shown = self.look(&places)[0];
            match (0..WIDTH).rev().find(|&k| (shown[k] - pressure_final).abs() > band) {
                Some(k) => {
                    if k + 1 < WIDTH {
                        later = times[k + 1];
                    }
                    outside = times[k];
                }
                None => later = times[0],
            }
        }
        0.5 * (outside + later) + q.delay
    }

    /// Step 1 of the paper on the record's samples from the peak on: Pf, ΔP, τ.
    fn regression(&mut self, arch: Arch, q: &Question, sign: f64, peak_time: f64, guess: f64) -> Option<[f64; 3]> {
        let number = |time: f64| time * SAMPLE_RATE_HZ;
        let last = (number(q.duration) + 1e-9).floor();
        let after = (number(peak_time) - 1e-9).ceil().max((number(q.push_end) - 1e-9).ceil());
        let before = (after - 1.0).max((number(q.push_end) - 1e-9).ceil());
        let gas = |sample: f64| (sample / SAMPLE_RATE_HZ - q.delay).clamp(0.0, q.duration - q.delay);
        let places: [_; WIDTH] = core::array::from_fn(|k| self.place(gas(if k == 0 { before } else { after })));
        let shown = self.look(&places)[0];
        let first = if sign * shown[0] > sign * shown[1] { before } else { after };
        if last - first < 4.0 {
            return None;
        }
        let sum = fit::Samples::new(last - first);
        let mut nodes = fit::Nodes::default();
        // Single samples first: all of them, or those that the ends of the integral call for.
        for chunk in sum.single().chunks(WIDTH) {
            let place = |k: usize| self.place(gas(first + chunk[k.min(chunk.len() - 1)].0));
            let places: [_; WIDTH] = core::array::from_fn(place);
            let pressure = self.look(&places)[0];
            for (lane, (number, weight)) in chunk.iter().enumerate() {
                nodes.push(number / SAMPLE_RATE_HZ, pressure[lane], *weight);
            }
        }
        if let Some(begin) = sum.integral() {
            let (origin, from, to) = (gas(first), gas(first + begin), gas(last));
            let mut pending = [((0, 0.0), 0.0, 0.0); WIDTH];
            let mut count = 0;
            for index in 0..self.pieces.len() {
                let piece = &self.pieces[index];
                let (begin, length) = (piece.begin(), piece.length);
                let (a, b) = (begin.max(from), piece.end().min(to));
                if b <= a {
                    continue;
                }
                for (node, weight) in fit::GAUSS {
                    let t = 0.5 * (a + b) + 0.5 * (b - a) * node;
                    pending[count] =
                        ((index, (t - begin) / length), t - origin, 0.5 * (b - a) * weight * SAMPLE_RATE_HZ);
                    count += 1;
                    if count == WIDTH {
                        self.take(&pending, count, &mut nodes);
                        count = 0;
                    }
                }
            }
            self.take(&pending, count, &mut nodes);
        }
        nodes.exponential(arch, guess)
    }

    /// Adds looked-up pressures to the nodes.
    fn take(&mut self, pending: &[((usize, f64), f64, f64); WIDTH], count: usize, nodes: &mut fit::Nodes) {
        let places = pending.map(|p| p.0);
        let pressure = self.look(&places)[0];
        for (lane, (_, time, weight)) in pending.iter().enumerate().take(count) {
            nodes.push(*time, pressure[lane], *weight);
        }
    }
}

/// [`dense`] on the machine's widest instructions.
pub struct Dense<'a, const N: usize, S> {
    /// The eight systems.
    pub system: &'a S,
    /// Begin of each one's step, s.
    pub from: Lanes,
    /// Its length, s.
    pub length: Lanes,
    /// States at its begin.
    pub begin: &'a [Lanes; N],
    /// States at its end.
    pub end: &'a [Lanes; N],
    /// dy/dt of its stages.
    pub slopes: &'a [[Lanes; N]; 13],
}

impl<const N: usize, S: LaneSystem<N>> WithSimd for Dense<'_, N, S> {
    type Output = [[Lanes; N]; 8];

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Self::Output {
        let Self { system, from, length, begin, end, slopes } = self;
        if I::IS_SCALAR {
            dense::<N, false, S>(system, from, length, begin, end, slopes)
        } else {
            dense::<N, true, S>(system, from, length, begin, end, slopes)
        }
    }
}
