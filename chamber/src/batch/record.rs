//! One row's record, piece by piece, and what is asked of it: extremes, settling, samples for the regression.

use super::regression::{Part, Records};
use super::samples::{self, SAMPLE_RATE_HZ, Samples};
use crate::lanes::{Lanes, WIDTH};
use crate::real::Real;
use pulp::{Arch, Simd, WithSimd};

/// Even places of a piece at which it is known, its ends included.
pub const NODES: usize = 8;
const INTERVALS: f64 = (NODES - 1) as f64;

/// The record during one step of the integrator.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Its begin, s of the gas.
    pub begin: f64,
    /// Its length, s.
    pub length: f64,
    /// What the record shows at the nodes, Pa.
    pub pressure: [f64; NODES],
    /// Its forward differences from the first node on, Pa.
    pub differences: [f64; NODES],
    /// Temperature of the gas at the nodes, K.
    pub temperature: [f64; NODES],
}

impl Piece {
    #[inline(always)]
    fn end(&self) -> f64 {
        self.begin + self.length
    }
    /// Time of a node, s of the gas.
    #[inline(always)]
    fn time(&self, node: usize) -> f64 {
        self.begin + self.length * (node as f64 / INTERVALS)
    }
    /// Pressure at a time of the gas, s.
    #[inline(always)]
    fn pressure_at(&self, time: f64) -> f64 {
        newton(&self.differences, (time - self.begin) / self.length)
    }
}

/// Newton's forward polynomial at the share `x` of a piece.
#[inline(always)]
fn newton<R: Real>(differences: &[R; NODES], x: R) -> R {
    let s = x * INTERVALS;
    let mut sum = differences[NODES - 1];
    for k in (0..NODES - 1).rev() {
        sum = differences[k] + sum * ((s - k as f64) * (1.0 / (k + 1) as f64));
    }
    sum
}

/// Differences for [`newton`], the same in all lanes.
#[inline(always)]
fn differences(values: &[f64; NODES]) -> [Lanes; NODES] {
    let mut d = *values;
    for order in 1..NODES {
        for k in (order..NODES).rev() {
            d[k] -= d[k - 1];
        }
    }
    let mut out = [Lanes::ZERO; NODES];
    for k in 0..NODES {
        out[k] = d[k].into();
    }
    out
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
    /// When it shows the peak, s.
    pub peak_time: f64,
}

/// Answers from a row's pieces; they must cover the test from the end of the push on, and from the delay before it.
pub fn answer(arch: Arch, pieces: &[Piece], question: &Question) -> Option<Answer> {
    arch.dispatch(Answering { pieces, q: question })
}

/// Adds what the regression needs of a row's record, from its peak on, to the records in a lane.
pub fn add_to(records: &mut Records, lane: usize, pieces: &[Piece], question: &Question, peak_time: f64) {
    let q = question;
    let all = Answering { pieces, q };
    let sign = if q.expands { -1.0 } else { 1.0 };
    let after = samples::from(peak_time).max(samples::from(q.push_end));
    let before = (after - 1.0).max(samples::from(q.push_end));
    let gas = |sample: f64| (sample / SAMPLE_RATE_HZ - q.delay).clamp(0.0, q.duration - q.delay);
    let shown = [before, after].map(|sample| pieces[all.piece_at(gas(sample))].pressure_at(gas(sample)));
    let mut first = if sign * shown[0] > sign * shown[1] { before } else { after };
    let end = samples::after(q.duration);
    let mut add = |next: f64, pressure: &dyn Fn(f64) -> f64| {
        let samples = Samples { first, count: next.min(end) - first };
        if samples.count > 0.0 {
            let pressure = samples.nodes().0.map(|number| pressure(number / SAMPLE_RATE_HZ - q.delay));
            records.add(lane, Part { samples, pressure });
            first = next;
        }
    };
    // What the record shows before the pieces, if only at their begin.
    let begin = pieces[0].begin;
    add(samples::after(begin + q.delay), &|_| pieces[0].pressure_at(begin));
    for piece in pieces {
        add(samples::after(piece.end() + q.delay), &|time| piece.pressure_at(time));
    }
}

struct Answering<'a> {
    pieces: &'a [Piece],
    q: &'a Question,
}

/// A largest value and the time of the gas at which it stands, s.
#[derive(Clone, Copy)]
struct Peak {
    value: f64,
    time: f64,
}

impl WithSimd for Answering<'_> {
    type Output = Option<Answer>;

    #[inline(always)]
    fn with_simd<I: Simd>(self, _: I) -> Option<Answer> {
        let q = self.q;
        let last = self.pieces.last()?;
        let sign = if q.expands { -1.0 } else { 1.0 };
        let tiny = 1e-12 * q.duration;
        let shown_end = q.duration - q.delay;
        let mut pressure = self.peak(|p| &p.pressure, sign, [q.push_end - q.delay - tiny, shown_end + tiny]);
        pressure.time += q.delay;
        if q.push_end < q.delay {
            // The record still shows the gas before the test.
            let shown = sign * (q.before[0] + q.before[1] * q.push_end);
            if shown > pressure.value {
                pressure = Peak { value: shown, time: q.push_end };
            }
        }
        let temperature = self.peak(|p| &p.temperature, sign, [q.push_end - tiny, f64::INFINITY]);
        let pressure_final = if shown_end > 0.0 {
            self.pieces[self.piece_at(shown_end)].pressure_at(shown_end.min(last.end()))
        } else {
            q.before[0] + q.before[1] * q.duration
        };
        let pressure_peak = sign * pressure.value.max(sign * pressure_final);
        let band = 0.01 * (pressure_peak - pressure_final).abs();
        let settling = self.settled_from(pressure_final, band) - q.push_end;
        Some(Answer {
            pressure_peak,
            pressure_final,
            temperature_peak: sign * temperature.value,
            temperature_final: last.temperature[NODES - 1],
            settling: if settling > 0.0 { settling } else { 0.0 },
            peak_time: pressure.time,
        })
    }
}

impl Answering<'_> {
    /// The piece that a time of the gas, s, falls into.
    #[inline(always)]
    fn piece_at(&self, time: f64) -> usize {
        let mut index = 0;
        while index + 1 < self.pieces.len() && self.pieces[index].end() < time {
            index += 1;
        }
        index
    }

    /// Largest `sign` × quantity between two times of the gas: at a node, or at a summit beside the best one.
    #[inline(always)]
    fn peak(&self, quantity: impl Fn(&Piece) -> &[f64; NODES], sign: f64, [from, to]: [f64; 2]) -> Peak {
        let mut best = Peak { value: f64::NEG_INFINITY, time: self.q.push_end };
        let (mut index, mut node) = (0, 0);
        for (i, piece) in self.pieces.iter().enumerate() {
            if piece.end() < from || piece.begin > to {
                continue;
            }
            let values = quantity(piece);
            for k in 0..NODES {
                let time = piece.time(k);
                if sign * values[k] > best.value && time >= from && time <= to {
                    best = Peak { value: sign * values[k], time };
                    (index, node) = (i, k);
                }
            }
        }
        // Within a piece the summit stands on either side of its node; at a seam, in the piece before or after.
        let k = node as f64;
        let beside = [
            (Some(index), [(k - 1.0).max(0.0), (k + 1.0).min(INTERVALS)]),
            (index.checked_sub(1).filter(|_| node == 0), [INTERVALS - 1.0, INTERVALS]),
            (Some(index + 1).filter(|_| node == NODES - 1), [0.0, 1.0]),
        ];
        // A first sample that is followed by smaller ones is the peak: nothing before it counts.
        let first = best.time - from <= 2e-12 * self.q.duration;
        for (index, bracket) in beside {
            let Some(piece) = index.and_then(|i| self.pieces.get(i)) else { continue };
            let [begin, end] = bracket.map(|k| piece.begin + piece.length * k / INTERVALS);
            if !first && begin >= from && end <= to {
                let summit = summit(piece, quantity(piece), sign, bracket.map(|k| k / INTERVALS));
                if summit.value > best.value {
                    best = summit;
                }
            }
        }
        best
    }

    /// Time of the record from which it stays within `band` of the final pressure, s.
    #[inline(always)]
    fn settled_from(&self, pressure_final: f64, band: f64) -> f64 {
        let q = self.q;
        let (first, end) = (q.push_end - q.delay, q.duration - q.delay);
        let tiny = 1e-12 * q.duration;
        for piece in self.pieces.iter().rev() {
            for node in (0..NODES).rev() {
                let time = piece.time(node);
                if time > end {
                    continue;
                }
                if time < first - tiny {
                    return q.push_end;
                }
                if (piece.pressure[node] - pressure_final).abs() > band {
                    let later = if node + 1 < NODES { piece.time(node + 1).min(end) } else { time };
                    return leaves_band(piece, pressure_final, band, [time, later]) + q.delay;
                }
            }
        }
        q.push_end
    }
}

/// Each round looks at a lane's width of places in a bracket and keeps the two parts beside the best.
const SUMMIT_ROUNDS: usize = 10;

/// Largest `sign` × value in a part of a piece with one summit.
#[inline(always)]
fn summit(piece: &Piece, values: &[f64; NODES], sign: f64, [mut a, mut b]: [f64; 2]) -> Peak {
    let d = differences(values);
    let mut best = Peak { value: f64::NEG_INFINITY, time: piece.begin };
    for _ in 0..SUMMIT_ROUNDS {
        let step = (b - a) / WIDTH as f64;
        let x = Lanes::from_fn(|k| a + step * (k as f64 + 0.5));
        let value = newton(&d, x) * sign;
        let mut k = 0;
        for j in 1..WIDTH {
            if value[j] > value[k] {
                k = j;
            }
        }
        if value[k] > best.value {
            best = Peak { value: value[k], time: piece.begin + piece.length * x[k] };
        }
        (a, b) = ((x[k] - step).max(a), (x[k] + step).min(b));
    }
    best
}

/// Rounds, each of which keeps one of nine parts or more, before the last bit is taken for straight.
const BAND_ROUNDS: usize = 4;

/// When the pressure comes within the band for good, in a part of a piece at whose begin it is outside: time of the gas, s.
#[inline(always)]
fn leaves_band(piece: &Piece, pressure_final: f64, band: f64, [mut outside, mut later]: [f64; 2]) -> f64 {
    let d = differences(&piece.pressure);
    let beyond = |time: f64| (piece.pressure_at(time) - pressure_final).abs() - band;
    let (mut at_outside, mut at_later) = (beyond(outside), beyond(later));
    for _ in 0..BAND_ROUNDS {
        let step = (later - outside) / (WIDTH + 1) as f64;
        let times = Lanes::from_fn(|k| outside + step * (k + 1) as f64);
        let x = (times - piece.begin) * (1.0 / piece.length);
        let beyond = (newton(&d, x) - pressure_final).abs() - band;
        // The last place outside, and the place after it.
        let (mut last, mut values) = (outside, [at_outside, beyond[0]]);
        let mut next = times[0];
        for k in 0..WIDTH {
            if beyond[k] > 0.0 {
                let end = k + 1 == WIDTH;
                (last, next) = (times[k], if end { later } else { times[k + 1] });
                values = [beyond[k], if end { at_later } else { beyond[k + 1] }];
            }
        }
        (outside, later) = (last, next);
        [at_outside, at_later] = values;
    }
    let share = at_outside / (at_outside - at_later);
    outside + (later - outside) * if (0.0..=1.0).contains(&share) { share } else { 0.5 }
}
