//! The corner at which a piston leaves a hold abruptly, or is stopped.
//!
//! A curve through the rows that meets the hold with the hold's own speed rounds such a corner off, by up to a tenth of the
//! travel from row to row, and dead volumes and lags make up for it. The rows beside a move's end are compared with two curves
//! that begin at an unknown time between rows: u (v + a u + b u² + …), a corner, and u² (a + b u + c u² + …), a gentle start; u
//! is the time since then. There is a corner if the first fits the rows to within their noise and the second, with as many
//! coefficients, clearly does not.
//! Positions in m, times in s.

use super::smoothed::Held;
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;
use std::ops::Range;

/// The piston is in motion from this many successive rows on that are all off the hold by this many standard deviations.
const IN_MOTION: (usize, f64) = (2, 5.0);
/// Numbers of rows in motion that are tried: the largest that a curve with a corner follows is taken.
const ROWS: [usize; 10] = [384, 192, 96, 64, 48, 32, 24, 16, 12, 8];
/// Numbers of coefficients of a curve that are tried: no more than the rows require.
const COEFFICIENTS: std::ops::RangeInclusive<usize> = 3..=MOST;
const MOST: usize = 6;
/// Least number of rows in motion in excess of the coefficients.
const SPARE: usize = 3;
/// Most rows before those in motion that are included in the fit.
const BEFORE: usize = 1000;
/// Largest excess of a curve's squares for the rows in motion over those of noise, in standard deviations of the latter.
const DEVIATIONS: f64 = 1.0;
/// There is a corner if a gentle start leaves squares larger by this: once in two million by chance.
const CLEAR: f64 = 25.0;
/// Time from a corner to the first row that a curve uses, in rows: the noise of a row right behind it would shake the speed.
const BEHIND: f64 = 0.5;

/// The hold that a move leaves, extended to the corner if it leaves abruptly. The move's rows then begin with the corner, and the
/// first ones are put on the curve, since each of them alone is off by the noise.
pub fn at_begin(held: Held, time_s: &mut Vec<f64>, position_m: &mut Vec<f64>, noise_m: f64) -> Held {
    let off: Vec<f64> = time_s.iter().zip(position_m.iter()).map(|(t, x)| x - held.at(*t)).collect();
    let begin = corner(time_s, &off, noise_m).map(|corner| {
        let row_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
        let first = time_s.partition_point(|t| *t < corner.time_s + BEHIND * row_s);
        for row in first..corner.followed {
            position_m[row] = held.at(time_s[row]) + corner.off_at(time_s[row]);
        }
        let speed = held.speed + corner.speed();
        (first, Held { time_s: corner.time_s, position_m: held.at(corner.time_s), speed, at_once: true })
    });
    let (rows, held) = begin.unwrap_or((0, held));
    time_s.splice(..rows, [held.time_s]);
    position_m.splice(..rows, [held.position_m]);
    held
}

/// The same for the hold in which a move ends, and the move's end.
pub fn at_end(held: Held, time_s: &mut Vec<f64>, position_m: &mut Vec<f64>, noise_m: f64) -> Held {
    let turned = |held: Held| Held { time_s: -held.time_s, speed: -held.speed, ..held };
    let turn = |time_s: &mut Vec<f64>, position_m: &mut Vec<f64>| {
        time_s.reverse();
        time_s.iter_mut().for_each(|t| *t = -*t);
        position_m.reverse();
    };
    turn(time_s, position_m);
    let held = turned(at_begin(turned(held), time_s, position_m, noise_m));
    turn(time_s, position_m);
    held
}

/// Where a move begins abruptly, and its course from the hold.
struct Corner {
    /// Time, s.
    time_s: f64,
    /// Coefficients of the distance from the hold by powers of the time since then, from m/s on.
    powers: [f64; MOST],
    /// One past the last row that is certain to lie on this curve.
    followed: usize,
}

impl Corner {
    /// Speed there relative to the hold, m/s.
    fn speed(&self) -> f64 {
        self.powers[0]
    }

    fn off_at(&self, time_s: f64) -> f64 {
        let u = time_s - self.time_s;
        u * self.powers.iter().rev().fold(0.0, |sum, power| sum * u + power)
    }
}

/// The corner between a hold and a move, if there is one, from the move's rows, whose times increase from the hold on, and their
/// distances from the extended hold, m.
fn corner(time_s: &[f64], off_m: &[f64], noise_m: f64) -> Option<Corner> {
    let is_off = |rows: &[f64]| rows.iter().all(|off| off.abs() > IN_MOTION.1 * noise_m);
    let begun = off_m.windows(IN_MOTION.0).position(is_off).filter(|begun| *begun > 0)?;
    let before = begun.saturating_sub(BEFORE);
    let moments = time_s[before]..time_s[begun];
    let beside = |rows_in_motion: usize| {
        let near = before..begun + rows_in_motion;
        Rows { time_s: &time_s[near.clone()], off_m: &off_m[near], noise_m }
    };
    let numbers = ROWS.into_iter().filter(|rows_in_motion| begun + rows_in_motion <= time_s.len());
    let tried = numbers.flat_map(|rows_in_motion| {
        let coefficients = COEFFICIENTS.take_while(move |count| count + SPARE <= rows_in_motion);
        coefficients.map(move |coefficients| (rows_in_motion, Form { lowest: 1, coefficients }))
    });
    let (rows_in_motion, at_once, curve) = { tried }.find_map(|(rows_in_motion, at_once)| {
        let curve = beside(rows_in_motion).nearest(at_once, moments.clone());
        curve.is_within_noise(at_once.coefficients).then_some((rows_in_motion, at_once, curve))
    })?;
    let gentle = beside(rows_in_motion).nearest(Form { lowest: 2, ..at_once }, moments);
    let is_corner = curve.powers[0] * off_m[begun] > 0.0 && gentle.squares > curve.squares + CLEAR;
    let followed = begun + rows_in_motion / 2;
    is_corner.then_some(Corner { time_s: curve.begin_s, powers: curve.powers, followed })
}

/// Rows beside the end of a hold.
struct Rows<'a> {
    time_s: &'a [f64],
    off_m: &'a [f64],
    noise_m: f64,
}

/// Powers of the time since its start that a curve consists of.
#[derive(Clone, Copy)]
struct Form {
    lowest: usize,
    coefficients: usize,
}

/// A curve that leaves the hold.
struct Curve {
    begin_s: f64,
    /// Its coefficients, from the lowest power on, with time in s.
    powers: [f64; MOST],
    /// Rows behind its start.
    rows_in_motion: usize,
    /// Squares of their distances from it, over their noise, ...
    squares_in_motion: f64,
    /// ...and those of all rows, from the hold before it.
    squares: f64,
}

impl Curve {
    /// Whether the rows in motion are as near to it as noise allows, for this number of coefficients.
    fn is_within_noise(&self, coefficients: usize) -> bool {
        let free = self.rows_in_motion.saturating_sub(coefficients + 1).max(1) as f64;
        self.squares_in_motion < free + DEVIATIONS * (2.0 * free).sqrt()
    }
}

impl Rows<'_> {
    /// The curve of this form nearest to the rows among those that begin between two times.
    fn nearest(&self, form: Form, moments: Range<f64>) -> Curve {
        const PARTS: usize = 40;
        const HALVINGS: usize = 12;
        let step = (moments.end - moments.start) / PARTS as f64;
        let curves = (0..PARTS).into_par_iter().map(|part| self.curve(form, moments.start + part as f64 * step));
        let nearer = |p: &Curve, q: &Curve| p.squares.total_cmp(&q.squares);
        let nearest = curves.min_by(nearer).expect("there are parts");
        (1..=HALVINGS).fold(nearest, |nearest, halving| {
            let step = step * 0.5f64.powi(halving as i32);
            let beside = [-step, step].map(|by| (nearest.begin_s + by).clamp(moments.start, moments.end));
            let beside = beside.map(|begin_s| self.curve(form, begin_s));
            beside.into_iter().chain([nearest]).min_by(nearer).expect("there are three")
        })
    }

    /// Fits the curve that begins at a given time.
    fn curve(&self, Form { lowest, coefficients }: Form, begin_s: f64) -> Curve {
        let first = self.time_s.partition_point(|t| *t <= begin_s);
        let scale = self.time_s[self.time_s.len() - 1] - begin_s;
        let powers = |t: f64| {
            let u = (t - begin_s) / scale;
            let powers = std::iter::successors(Some(u.powi(lowest as i32)), |power| Some(power * u));
            SVector::<f64, MOST>::from_iterator(
                powers.enumerate().map(|(k, power)| if k < coefficients { power } else { 0.0 }),
            )
        };
        let rows = || self.time_s[first..].iter().zip(&self.off_m[first..]);
        // Ones in place of unused powers.
        let unused = SMatrix::from_fn(|i, j| if i == j && i >= coefficients { 1.0 } else { 0.0 });
        let sums = (unused, SVector::<f64, MOST>::zeros());
        let (square, right) = rows().fold(sums, |(square, right), (t, off)| {
            let powers = powers(*t);
            (square + powers * powers.transpose(), right + powers * *off)
        });
        let curve = square.cholesky().map_or(SVector::zeros(), |factor| factor.solve(&right));
        let over_noise = |squares: f64| squares / (self.noise_m * self.noise_m);
        let held = over_noise(self.off_m[..first].iter().map(|off| off * off).sum());
        let squares_in_motion = over_noise(rows().map(|(t, off)| (off - curve.dot(&powers(*t))).powi(2)).sum());
        Curve {
            begin_s,
            powers: std::array::from_fn(|k| curve[k] / scale.powi((lowest + k) as i32)),
            rows_in_motion: self.time_s.len() - first,
            squares_in_motion,
            squares: held + squares_in_motion,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    const NOISE_M: f64 = 5e-6;

    fn found(row_s: f64, stroke: impl Fn(f64) -> f64, seed: u64) -> Option<Corner> {
        let mut random = Random::new(seed);
        let rows = (1.5 / row_s) as u32;
        let (time, off): (Vec<f64>, Vec<f64>) =
            (0..rows).map(|i| f64::from(i) * row_s).map(|t| (t, stroke(t) + NOISE_M * random.normal())).unzip();
        corner(&time, &off, NOISE_M)
    }

    #[test]
    fn a_piston_that_starts_at_full_speed_has_a_corner_between_two_rows() {
        for row_s in [0.02, 0.01, 0.004, 0.002, 2e-4] {
            for seed in 0..6 {
                let begin = 0.2 + row_s * (0.05 + 0.16 * seed as f64);
                let tends = |t: f64| 0.07 * (1.0 - (-(t - begin).max(0.0) / 0.12).exp());
                let found = found(row_s, tends, seed).expect("a corner");
                let speed = 0.07 / 0.12;
                let off_m = speed * (found.time_s - begin);
                let most_m = 0.01 * speed * row_s + 3.0 * NOISE_M;
                assert!(off_m.abs() < most_m && (found.speed() / speed - 1.0).abs() < 0.01, "{row_s} {seed}: {off_m}");
            }
        }
    }

    #[test]
    fn a_gentle_start_is_no_corner() {
        let smooth = |u: f64| u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
        let sine = |u: f64| 0.5 - 0.5 * (std::f64::consts::PI * u).cos();
        let forms: [&dyn Fn(f64) -> f64; 2] = [&smooth, &sine];
        for form in forms {
            for (row_s, length_s) in [(0.02, 0.6), (0.004, 0.3), (0.002, 1.2), (2e-4, 0.3), (2e-4, 1.2)] {
                for seed in 0..4 {
                    let stroke = |t: f64| 0.07 * form(((t - 0.2013) / length_s).clamp(0.0, 1.0));
                    assert!(found(row_s, stroke, seed).is_none(), "{row_s} {length_s} {seed}");
                }
            }
        }
    }
}
